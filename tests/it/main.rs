//! The integration tests: one binary, a module per subject.

mod architecture;
mod charts;
mod cli;
mod damage;
mod encoding;
mod messages;
mod needs;
mod pictures;
mod recording;
mod refusal;
mod scene;
mod schema_reader;
mod tidy;
mod views;
