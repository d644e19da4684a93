//! The integration tests: one binary, a module per subject.

mod messages;
mod pictures;
mod recording;
mod refusal;
mod scene;
