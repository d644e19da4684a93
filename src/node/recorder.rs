//! The recorder: a thread that encodes each instant once and hands the bytes to every carrier.

use std::collections::BTreeMap;
use std::sync::mpsc::{Receiver, Sender, SyncSender, sync_channel};
use std::thread::JoinHandle;

use super::{Carrier, NodeError};
use crate::contact::Obstacle;
use crate::sim::{Model, State, StepReport};
use crate::wire::{self, Packet};

/// Instants that may wait to be written. When they are all taken the step waits too: nothing is dropped.
const QUEUE: usize = 4;

/// One instant to be published.
pub(super) struct Instant {
    pub state: State,
    pub report: StepReport,
    pub extras: wire::Extras,
}

/// What the loop says.
pub(super) enum Said {
    /// A state, to be encoded here.
    Instant(Box<Instant>),
    /// What is encoded already.
    Packets(Vec<Packet>),
    /// An answer that somebody waits for; it follows all that was said before.
    Answer(Sender<Vec<u8>>, Vec<u8>),
}

/// The sending end, and the thread.
pub(super) struct Recorder {
    sender: SyncSender<Said>,
    thread: JoinHandle<Result<(), NodeError>>,
}

impl Recorder {
    /// Starts the thread and has it publish what is said once.
    pub fn start(
        model: Model,
        obstacles: Vec<Obstacle>,
        carriers: Vec<Box<dyn Carrier>>,
    ) -> Result<Self, NodeError> {
        let (sender, receiver) = sync_channel(QUEUE);
        let thread = std::thread::Builder::new()
            .name("recorder".to_string())
            .spawn(move || record(&model, &obstacles, carriers, &receiver))
            .map_err(NodeError::file("start", "the recorder thread".as_ref()))?;
        Ok(Self { sender, thread })
    }

    /// Hands something over; false if the thread has ended, which [`finish`](Self::finish) explains.
    pub fn publish(&self, said: Said) -> bool {
        self.sender.send(said).is_ok()
    }

    /// Waits until all is written and closed.
    pub fn finish(self) -> Result<(), NodeError> {
        drop(self.sender);
        self.thread.join().map_err(|_| NodeError::RecorderLost)?
    }
}

fn record(
    model: &Model,
    obstacles: &[Obstacle],
    mut carriers: Vec<Box<dyn Carrier>>,
    receiver: &Receiver<Said>,
) -> Result<(), NodeError> {
    let mut encoder = wire::Encoder::default();
    let mut numbers = Numbers::default();
    carry(
        &mut carriers,
        numbers.number(encoder.preamble(model, obstacles)?),
    )?;
    for said in receiver {
        let packets = match said {
            Said::Packets(packets) => packets,
            Said::Instant(instant) => {
                let Instant {
                    state,
                    report,
                    extras,
                } = *instant;
                encoder.instant(model, &state, &report, extras)?
            }
            Said::Answer(reply, bytes) => {
                // Who no longer waits does not mind.
                let _ = reply.send(bytes);
                continue;
            }
        };
        carry(&mut carriers, numbers.number(packets))?;
    }
    carriers.iter_mut().try_for_each(|carrier| carrier.close())
}

/// Counts the messages of each topic, before any carrier can lose one: who misses some can tell.
#[derive(Default)]
struct Numbers(BTreeMap<String, u64>);

impl Numbers {
    fn number(&mut self, mut packets: Vec<Packet>) -> Vec<Packet> {
        for packet in &mut packets {
            let next = self.0.entry(packet.topic().into_owned()).or_default();
            packet.sequence = *next;
            *next += 1;
        }
        packets
    }
}

fn carry(carriers: &mut [Box<dyn Carrier>], packets: Vec<Packet>) -> Result<(), NodeError> {
    for carrier in carriers {
        packets
            .iter()
            .try_for_each(|packet| carrier.publish(packet))?;
        carrier.commit()?;
    }
    Ok(())
}
