//! The seam between the node and everything that takes its messages.

use std::sync::{Arc, Mutex, PoisonError};

use super::NodeError;
use crate::wire::Packet;

/// Something that carries messages away: a recording, a middleware, a test. It lives on the recorder thread.
pub trait Carrier: Send {
    /// Takes one encoded message.
    fn publish(&mut self, packet: &Packet) -> Result<(), NodeError>;

    /// All messages of one instant have been published: make them lasting or visible.
    fn commit(&mut self) -> Result<(), NodeError>;

    /// The run is over.
    fn close(&mut self) -> Result<(), NodeError>;
}

/// Keeps all packets in memory, for tests; clones share them.
#[derive(Clone, Debug, Default)]
pub struct Memory {
    packets: Arc<Mutex<Vec<Packet>>>,
}

impl Memory {
    /// What has been published so far.
    pub fn packets(&self) -> Vec<Packet> {
        self.packets
            .lock()
            .unwrap_or_else(PoisonError::into_inner)
            .clone()
    }
}

impl Carrier for Memory {
    fn publish(&mut self, packet: &Packet) -> Result<(), NodeError> {
        let mut packets = self.packets.lock().unwrap_or_else(PoisonError::into_inner);
        packets.push(packet.clone());
        Ok(())
    }

    fn commit(&mut self) -> Result<(), NodeError> {
        Ok(())
    }

    fn close(&mut self) -> Result<(), NodeError> {
        Ok(())
    }
}
