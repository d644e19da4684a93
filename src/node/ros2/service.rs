//! Services over DDS: two topics, and the identity of the request that ties a response to it.

use std::time::{Duration, Instant};

use ros2_client::dds::rustdds::SequenceNumber;
use ros2_client::dds::rustdds::rpc::SampleIdentity;

use super::dds::{Participant, Reader, Sample, Writer};
use super::discovery::{requests, responses, type_name};
use super::raw::Body;
use super::{Ros2Error, ServiceMapping};
use crate::wire::MessageType;
use crate::wire::channels::Qos;

/// Header of a request and its response in [`ServiceMapping::Cyclone`]: the client and the number of the
/// request, 8 bytes each, in the byte order of the message.
const HEADER: usize = 16;
/// Encapsulation header of a message \[bytes\].
const ENCAPSULATION: usize = 4;

/// Which request a response answers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum RequestId {
    /// Goes beside the response.
    Beside(SampleIdentity),
    /// Goes in front of it, little-endian.
    InFront([u8; HEADER]),
}

/// The server's ends of a service.
pub fn server(
    participant: &mut Participant,
    service: &str,
    request: &MessageType,
    response: &MessageType,
) -> Result<(Reader, Writer), Ros2Error> {
    let reader = participant.reader(&requests(service), &type_name(request.name), Qos::Reliable)?;
    let writer = participant.writer(
        &responses(service),
        &type_name(response.name),
        Qos::Reliable,
    )?;
    Ok((reader, writer))
}

/// Takes a request apart: which it is, and the message with its encapsulation header. None if it is too short.
pub fn open(mapping: ServiceMapping, sample: Sample) -> Option<(RequestId, Vec<u8>)> {
    match mapping {
        ServiceMapping::Enhanced => {
            let mut identity = sample.related.unwrap_or(sample.identity);
            // Fast DDS names the client and leaves the number to the sample itself.
            if identity.sequence_number == SequenceNumber::UNKNOWN {
                identity.sequence_number = sample.identity.sequence_number;
            }
            Some((RequestId::Beside(identity), sample.bytes))
        }
        ServiceMapping::Cyclone => {
            let (header, message) = split(&sample.bytes)?;
            Some((RequestId::InFront(header), message))
        }
    }
}

/// The header in front of a message, little-endian, and the message without it.
fn split(bytes: &[u8]) -> Option<([u8; HEADER], Vec<u8>)> {
    let (encapsulation, rest) = bytes.split_at_checked(ENCAPSULATION)?;
    let (mut header, body) = rest
        .split_first_chunk::<HEADER>()
        .map(|(header, body)| (*header, body))?;
    let little_endian = encapsulation[1] & 1 == 1;
    if !little_endian {
        header[..8].reverse();
        header[8..].reverse();
    }
    Some((header, [encapsulation, body].concat()))
}

/// Answers; false if the response was dropped.
pub fn respond(writer: &Writer, id: &RequestId, response: &[u8]) -> bool {
    match id {
        RequestId::Beside(identity) => {
            Body::of(response).is_some_and(|body| writer.send(body, Some(*identity)))
        }
        RequestId::InFront(header) => {
            Body::behind(header, response).is_some_and(|body| writer.send(body, None))
        }
    }
}

/// The client's ends of a service.
pub struct ServiceClient {
    requests: Writer,
    responses: Reader,
    mapping: ServiceMapping,
    sent: u64,
}

impl ServiceClient {
    /// Of a service with its resolved name.
    pub fn new(
        participant: &mut Participant,
        mapping: ServiceMapping,
        service: &str,
        request: &MessageType,
        response: &MessageType,
    ) -> Result<Self, Ros2Error> {
        let kind = type_name(request.name);
        let requests = participant.writer(&requests(service), &kind, Qos::Reliable)?;
        let kind = type_name(response.name);
        let responses = participant.reader(&responses(service), &kind, Qos::Reliable)?;
        Ok(Self {
            requests,
            responses,
            mapping,
            sent: 0,
        })
    }

    /// Whether a server takes requests and its answers would arrive.
    pub fn connected(&mut self) -> bool {
        self.requests.subscriptions() > 0 && self.responses.publishers() > 0
    }

    /// Sends a request; none if it was dropped.
    pub fn send(&mut self, request: &[u8]) -> Option<RequestId> {
        self.sent += 1;
        match self.mapping {
            ServiceMapping::Enhanced => {
                let body = Body::of(request)?;
                self.requests.identified(body, None).map(RequestId::Beside)
            }
            ServiceMapping::Cyclone => {
                let mut header = [0; HEADER];
                header[..8].copy_from_slice(&self.requests.guid().to_bytes()[8..]);
                header[8..].copy_from_slice(&self.sent.to_le_bytes());
                let body = Body::behind(&header, request)?;
                let sent = self.requests.send(body, None);
                sent.then_some(RequestId::InFront(header))
            }
        }
    }

    /// The response to a request; none if it has not come by then.
    pub fn receive(&mut self, id: &RequestId, until: Instant) -> Option<Vec<u8>> {
        loop {
            while let Some(sample) = self.responses.take() {
                if let Some(response) = self.answering(id, sample) {
                    return Some(response);
                }
            }
            if Instant::now() > until {
                return None;
            }
            std::thread::sleep(Duration::from_millis(1));
        }
    }

    fn answering(&self, id: &RequestId, sample: Sample) -> Option<Vec<u8>> {
        match self.mapping {
            ServiceMapping::Enhanced => {
                let related = sample.related.map(RequestId::Beside);
                (related.as_ref() == Some(id)).then_some(sample.bytes)
            }
            ServiceMapping::Cyclone => {
                let (header, message) = split(&sample.bytes)?;
                (RequestId::InFront(header) == *id).then_some(message)
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn headers_in_front_are_read_in_either_byte_order() {
        let header: Vec<u8> = (1..=16).collect();
        let body = [42, 43];
        let little = [&[0, 1, 0, 0][..], &header, &body].concat();
        let (found, message) = split(&little).unwrap();
        assert_eq!(found.to_vec(), header);
        assert_eq!(message, [0, 1, 0, 0, 42, 43]);
        let turned: Vec<u8> = header[..8]
            .iter()
            .rev()
            .chain(header[8..].iter().rev())
            .copied()
            .collect();
        let big = [&[0, 0, 0, 0][..], &turned, &body].concat();
        let (found, message) = split(&big).unwrap();
        assert_eq!(found.to_vec(), header);
        assert_eq!(message, [0, 0, 0, 0, 42, 43]);
        assert!(split(&little[..19]).is_none());
        assert!(split(&[]).is_none());
    }
}
