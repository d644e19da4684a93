//! The recorder: a thread that encodes each instant once and hands the bytes to every carrier.

use std::sync::mpsc::{Receiver, SyncSender, sync_channel};
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
    carry(&mut carriers, &encoder.preamble(model, obstacles)?)?;
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
        };
        carry(&mut carriers, &packets)?;
    }
    carriers.iter_mut().try_for_each(|carrier| carrier.close())
}

fn carry(carriers: &mut [Box<dyn Carrier>], packets: &[Packet]) -> Result<(), NodeError> {
    for carrier in carriers {
        packets
            .iter()
            .try_for_each(|packet| carrier.publish(packet))?;
        carrier.commit()?;
    }
    Ok(())
}
