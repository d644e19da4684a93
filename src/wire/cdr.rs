//! CDR, little endian, behind the 4-byte encapsulation header of RTPS: the only encoding there is.

use byteorder::{BigEndian, LittleEndian};

use super::Message;

/// Encapsulation header: plain CDR, little endian, no options (RTPS 2.5, 10.2).
pub const ENCAPSULATION: [u8; 4] = [0, 1, 0, 0];
/// The same, big endian; we read it and never write it.
const ENCAPSULATION_BIG_ENDIAN: [u8; 2] = [0, 0];
/// Bytes that may follow the last field: middlewares pad to their alignment.
const MOST_PADDING: usize = 7;

/// Why bytes are not the message that they should be, or the other way round.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum CdrError {
    /// The encapsulation header is missing or of another kind.
    #[error("{name}: encapsulation header {found:02x?} is not plain CDR")]
    Encapsulation {
        /// Type that was to be read.
        name: &'static str,
        /// The first bytes, at most 4.
        found: Vec<u8>,
    },
    /// The body does not hold the type's fields.
    #[error("{name}: {bytes} bytes do not decode: {reason}")]
    Body {
        /// Type that was to be read.
        name: &'static str,
        /// Length of the message \[bytes\].
        bytes: usize,
        /// What the decoder says.
        reason: String,
    },
    /// A value that CDR cannot hold.
    #[error("{name} does not encode: {reason}")]
    Encode {
        /// Type that was to be written.
        name: &'static str,
        /// What the encoder says.
        reason: String,
    },
}

/// Encodes a message, encapsulation header included.
pub fn encode<M: Message>(message: &M) -> Result<Vec<u8>, CdrError> {
    let body = cdr_encoding::to_vec::<M, LittleEndian>(message).map_err(|e| CdrError::Encode {
        name: M::TYPE.name,
        reason: e.to_string(),
    })?;
    let mut bytes = Vec::with_capacity(ENCAPSULATION.len() + body.len());
    bytes.extend_from_slice(&ENCAPSULATION);
    bytes.extend_from_slice(&body);
    Ok(bytes)
}

/// Decodes a message of either byte order.
pub fn decode<M: Message>(bytes: &[u8]) -> Result<M, CdrError> {
    let name = M::TYPE.name;
    let result = match bytes.split_first_chunk::<4>() {
        Some(([0, 1, ..], body)) => cdr_encoding::from_bytes::<M, LittleEndian>(body),
        Some((head, body)) if head[..2] == ENCAPSULATION_BIG_ENDIAN => {
            cdr_encoding::from_bytes::<M, BigEndian>(body)
        }
        _ => {
            let found = bytes.iter().take(4).copied().collect();
            return Err(CdrError::Encapsulation { name, found });
        }
    };
    let refused = |reason: String| CdrError::Body {
        name,
        bytes: bytes.len(),
        reason,
    };
    let (message, used) = result.map_err(|e| refused(e.to_string()))?;
    match bytes.len() - ENCAPSULATION.len() - used {
        0..=MOST_PADDING => Ok(message),
        left => Err(refused(format!("{left} bytes are left over"))),
    }
}

/// `uint8[]` as one block: the bytes on the wire are those of a sequence, written and read at once.
pub mod bytes {
    use serde::de::{Error, Visitor};
    use serde::{Deserializer, Serializer};

    /// Writes the block.
    pub fn serialize<S: Serializer>(bytes: &[u8], serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_bytes(bytes)
    }

    /// Reads the block.
    pub fn deserialize<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Vec<u8>, D::Error> {
        struct Block;
        impl Visitor<'_> for Block {
            type Value = Vec<u8>;

            fn expecting(&self, formatter: &mut std::fmt::Formatter) -> std::fmt::Result {
                formatter.write_str("a block of bytes")
            }

            fn visit_bytes<E: Error>(self, block: &[u8]) -> Result<Vec<u8>, E> {
                Ok(block.to_vec())
            }
        }
        deserializer.deserialize_bytes(Block)
    }
}
