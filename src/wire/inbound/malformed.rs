//! Why a request is not taken before the simulation has seen it.

use crate::wire::cdr::CdrError;

/// Longest value that a refusal quotes \[characters\].
const LONGEST: usize = 80;

/// A request that cannot be meant, or that toile cannot do. One line each.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum Malformed {
    /// Not the bytes of its type.
    #[error(transparent)]
    Bytes(#[from] CdrError),
    /// More bytes than any request has.
    #[error("{bytes} bytes are too many for a command: at most {most}")]
    TooLong {
        /// How many there are.
        bytes: usize,
        /// How many there may be.
        most: usize,
    },
    /// A field with a value out of its range.
    #[error("{field} = {value} is out of range: {range}")]
    OutOfRange {
        /// Path of the field in the message.
        field: String,
        /// Its value.
        value: String,
        /// What is allowed.
        range: String,
    },
    /// Something legal that toile does not do.
    #[error("{field} = {value} is not supported: {instead}")]
    Unsupported {
        /// Path of the field in the message.
        field: String,
        /// Its value.
        value: String,
        /// What is.
        instead: String,
    },
}

impl Malformed {
    /// Whether it is a field, or one within it, that was refused.
    pub(super) fn is_about(&self, path: &str) -> bool {
        match self {
            Malformed::OutOfRange { field, .. } | Malformed::Unsupported { field, .. } => field
                .strip_prefix(path)
                .is_some_and(|rest| rest.is_empty() || rest.starts_with(['.', '['])),
            Malformed::Bytes(_) | Malformed::TooLong { .. } => false,
        }
    }

    /// A value out of range, quoted at most in part and on one line.
    pub(in crate::wire) fn range(field: &str, value: impl std::fmt::Debug, range: &str) -> Self {
        Self::OutOfRange {
            field: field.to_string(),
            value: shortened(value),
            range: range.to_string(),
        }
    }

    /// A value that toile has no use for.
    pub(super) fn unsupported(field: &str, value: impl std::fmt::Debug, instead: &str) -> Self {
        Self::Unsupported {
            field: field.to_string(),
            value: shortened(value),
            instead: instead.to_string(),
        }
    }
}

fn shortened(value: impl std::fmt::Debug) -> String {
    let text = format!("{value:?}");
    match text.char_indices().nth(LONGEST) {
        None => text,
        Some((end, _)) => format!("{}...", &text[..end]),
    }
}
