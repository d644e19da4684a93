//! Refusals at the border: where, which key, which value, what is allowed.

use std::fmt;

use super::FabricError;
use crate::contact::SurfaceError;

/// Where a value was written.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Origin {
    /// Line of the document, from 1.
    Line(usize),
    /// An override as the user wrote it, such as `--set damping=0`.
    Override(String),
    /// The document as a whole, or a scene made by the program.
    Document,
}

impl fmt::Display for Origin {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Origin::Line(line) => write!(f, "line {line}: "),
            Origin::Override(text) => write!(f, "{text}: "),
            Origin::Document => Ok(()),
        }
    }
}

/// What is wrong with a key or its value.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum Problem {
    /// The text is not TOML.
    #[error("not TOML: {0}")]
    Syntax(String),
    /// The key means nothing here.
    #[error("unknown key{}; allowed here: {allowed}", suggest(.suggestion))]
    UnknownKey {
        /// Keys that mean something here.
        allowed: String,
        /// The allowed key that was probably meant.
        suggestion: Option<String>,
    },
    /// A key without default is absent.
    #[error("missing; needs {expected}")]
    Missing {
        /// What must be given.
        expected: String,
    },
    /// The value has the wrong type.
    #[error("must be {expected}, not {found}")]
    WrongType {
        /// What must be given.
        expected: String,
        /// The TOML type that was given.
        found: &'static str,
    },
    /// A number, length or count beyond its range.
    #[error("out of range: must be {expected}")]
    OutOfRange {
        /// What must be given.
        expected: String,
    },
    /// A word that is not among the choices.
    #[error("must be {expected}{}", suggest(.suggestion))]
    NotAChoice {
        /// The choices.
        expected: String,
        /// The choice that was probably meant.
        suggestion: Option<String>,
    },
    /// Each value is allowed alone, but not with the others.
    #[error("{0}")]
    Conflict(String),
    /// The triangles do not make an obstacle.
    #[error(transparent)]
    Surface(#[from] SurfaceError),
    /// The constants do not make a fabric.
    #[error(transparent)]
    Fabric(#[from] FabricError),
}

fn suggest(suggestion: &Option<String>) -> String {
    match suggestion {
        Some(word) => format!(" (did you mean `{word}`?)"),
        None => String::new(),
    }
}

/// Why a document is not a scene. One line of text.
#[derive(Clone, Debug, PartialEq)]
pub struct SceneError {
    /// Where the value was written.
    pub origin: Origin,
    /// Full dotted key; empty for a document that is not TOML.
    pub key: String,
    /// The value as written, if there is one.
    pub value: Option<String>,
    /// What is wrong with it.
    pub problem: Box<Problem>,
}

impl fmt::Display for SceneError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let subject = match (self.key.as_str(), &self.value) {
            ("", _) => String::new(),
            (key, None) => format!("{key}: "),
            (key, Some(value)) => format!("{key} = {value}: "),
        };
        // Keys and overrides are the user's text: a line break in them must not break the message.
        let message = format!("{}{subject}{}", self.origin, self.problem);
        message.chars().try_for_each(|c| match c.is_control() {
            true => write!(f, "{}", c.escape_default()),
            false => write!(f, "{c}"),
        })
    }
}

impl std::error::Error for SceneError {}
