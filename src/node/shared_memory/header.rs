//! What travels beside the bytes: fixed-size headers, laid out alike in Rust, C and Python's `ctypes`.

use iceoryx2::prelude::ZeroCopySend;

use crate::wire::Packet;

/// Version of all three layouts; it changes with any of them.
pub const ABI: u64 = 1;

/// Longest name of an inlet \[bytes\].
pub const INLET_BYTES: usize = 64;

/// Beside every published message.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ZeroCopySend)]
#[type_name("ToileHeader")]
pub struct Header {
    /// [`ABI`].
    pub abi: u64,
    /// Counts the messages of this topic from 0; a gap is what the reader missed.
    pub sequence: u64,
    /// Simulated time since the start of the run \[ns\].
    pub stamp: u64,
    /// Step of the state that the message speaks of.
    pub step: u64,
    /// Digest of that state.
    pub digest: u64,
    /// SHA-256 of the message type's definition: the ROS 2 type hash, RIHS01.
    pub schema: [u8; 32],
}

impl Header {
    /// Of a packet.
    pub(super) fn new(packet: &Packet) -> Self {
        Self {
            abi: ABI,
            sequence: packet.sequence,
            stamp: packet.stamp,
            step: packet.step,
            digest: packet.digest,
            schema: schema(packet.channel.message.hash),
        }
    }
}

/// The bytes of a hash written as `RIHS01_` and 64 hexadecimal digits.
pub fn schema(hash: &str) -> [u8; 32] {
    let digits = hash.rsplit('_').next().unwrap_or_default();
    let mut bytes = [0; 32];
    for (k, byte) in bytes.iter_mut().enumerate() {
        let pair = digits.get(2 * k..2 * k + 2).unwrap_or("00");
        *byte = u8::from_str_radix(pair, 16).unwrap_or(0);
    }
    bytes
}

/// Beside every request.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq, ZeroCopySend)]
#[type_name("ToileCall")]
pub struct CallHeader {
    /// [`ABI`].
    pub abi: u64,
    /// Name of the inlet in UTF-8, filled up with zeros.
    pub inlet: [u8; INLET_BYTES],
}

impl Default for CallHeader {
    fn default() -> Self {
        Self {
            abi: ABI,
            inlet: [0; INLET_BYTES],
        }
    }
}

impl CallHeader {
    /// For an inlet; none if the name is too long to exist.
    pub(super) fn new(inlet: &str) -> Option<Self> {
        let mut header = Self::default();
        let room = header.inlet.get_mut(..inlet.len())?;
        room.copy_from_slice(inlet.as_bytes());
        Some(header)
    }

    /// The inlet's name, if it is one.
    pub(super) fn inlet(&self) -> Option<&str> {
        let end = self.inlet.iter().position(|byte| *byte == 0);
        std::str::from_utf8(&self.inlet[..end.unwrap_or(INLET_BYTES)]).ok()
    }
}

/// Beside every response.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ZeroCopySend)]
#[type_name("ToileReply")]
pub struct ReplyHeader {
    /// [`ABI`].
    pub abi: u64,
    /// 0: the payload is the answer in CDR. Else a [`Refusal`], and the payload says in UTF-8 why.
    pub status: u64,
}

/// Why a request was not answered.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum Refusal {
    /// The request was made for another version of this interface.
    #[error("the request is of another version than {ABI}")]
    Version = 1,
    /// More bytes than [`MOST_BYTES`](super::MOST_BYTES).
    #[error("the request has more than {} bytes", super::MOST_BYTES)]
    TooLarge = 2,
    /// No inlet of this name.
    #[error("there is no such inlet")]
    UnknownInlet = 3,
    /// Too many requests wait for the next step.
    #[error("too many requests wait already")]
    Busy = 4,
    /// The simulation did not get to it in time; it may still.
    #[error("the simulation did not answer in time")]
    Late = 5,
    /// Taken, but there is no answer: the run ended, or the request was malformed.
    #[error("the simulation took the request and gave no answer")]
    NoAnswer = 6,
}

impl Refusal {
    /// All of them.
    pub const ALL: [Refusal; 6] = [
        Refusal::Version,
        Refusal::TooLarge,
        Refusal::UnknownInlet,
        Refusal::Busy,
        Refusal::Late,
        Refusal::NoAnswer,
    ];

    /// The number in a [`ReplyHeader`].
    pub fn status(self) -> u64 {
        self as u64
    }
}
