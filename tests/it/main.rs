//! The integration tests: one binary, a module per subject.

mod charts;
mod cli;
mod consistency;
mod energy;
mod lab;
mod messages;
mod order;
mod pictures;
mod recording;
mod refusal;
mod scene;
mod tidy;
mod verify;
