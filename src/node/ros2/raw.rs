//! Messages as bytes: what the DDS library writes and reads without decoding.

use std::convert::Infallible;

use ros2_client::dds::rustdds::RepresentationIdentifier as Representation;
use ros2_client::dds::rustdds::bytes::Bytes;
use ros2_client::dds::rustdds::no_key::{
    Decode, DefaultDecoder, DeserializerAdapter, SerializerAdapter,
};

use crate::wire::cdr::ENCAPSULATION;

/// An encoded message with its encapsulation header.
pub struct Raw(pub Vec<u8>);

/// Hands the bytes of [`Raw`] to the library and back.
pub struct PassThrough;

impl SerializerAdapter<Body> for PassThrough {
    type Error = Infallible;

    fn output_encoding() -> Representation {
        Representation::CDR_LE
    }

    fn to_bytes(body: &Body) -> Result<Bytes, Infallible> {
        Ok(body.0.clone())
    }
}

/// A little-endian message without its header, which the library writes itself.
pub struct Body(Bytes);

impl Body {
    /// The body of a message as toile encodes it; nothing if it has another header.
    pub fn of(message: &[u8]) -> Option<Self> {
        let body = message.strip_prefix(&ENCAPSULATION)?;
        Some(Self(Bytes::copy_from_slice(body)))
    }

    /// The same behind a header of the service mapping.
    pub fn behind(header: &[u8], message: &[u8]) -> Option<Self> {
        let body = message.strip_prefix(&ENCAPSULATION)?;
        Some(Self([header, body].concat().into()))
    }
}

impl DeserializerAdapter<Raw> for PassThrough {
    type Error = Infallible;
    type Decoded = Raw;

    /// All that there are: what is not plain CDR is refused, and counted, where messages are decoded.
    fn supported_encodings() -> &'static [Representation] {
        &[
            Representation::CDR_LE,
            Representation::CDR_BE,
            Representation::PL_CDR_LE,
            Representation::PL_CDR_BE,
            Representation::CDR2_LE,
            Representation::CDR2_BE,
            Representation::PL_CDR2_LE,
            Representation::PL_CDR2_BE,
            Representation::D_CDR_LE,
            Representation::D_CDR_BE,
            Representation::XCDR2_LE,
            Representation::XCDR2_BE,
            Representation::D_CDR2_LE,
            Representation::D_CDR2_BE,
            Representation::PL_XCDR2_LE,
            Representation::PL_XCDR2_BE,
            Representation::XML,
        ]
    }

    fn transform_decoded(decoded: Raw) -> Raw {
        decoded
    }
}

impl DefaultDecoder<Raw> for PassThrough {
    type Decoder = Copying;
    const DECODER: Copying = Copying;
}

/// Copies the bytes out of the library's cache.
#[derive(Clone)]
pub struct Copying;

impl Decode<'_, Raw> for Copying {
    type Error = Infallible;

    fn decode_bytes(self, body: &[u8], encoding: Representation) -> Result<Raw, Infallible> {
        let [kind, order] = encoding.to_bytes();
        Ok(Raw([&[kind, order, 0, 0], body].concat()))
    }
}
