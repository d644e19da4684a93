//! The integration tests: one binary, a module per subject.

mod charts;
mod cli;
mod messages;
mod pictures;
mod recording;
mod refusal;
mod scene;
mod tidy;
