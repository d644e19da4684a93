//! A scene: one TOML document that says everything about a run.

mod spec;

pub use spec::*;
