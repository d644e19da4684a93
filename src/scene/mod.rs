//! A scene: one TOML document that says everything about a run.
//!
//! [`parse`] turns text and overrides into a checked [`Scene`]; [`library`] holds the built-in ones. Every
//! refusal is one [`SceneError`] that names key, value, what is allowed, and where it was written.

mod ablation;
mod check;
mod cross;
mod error;
mod fabric;
mod keys;
mod layers;
pub mod library;
mod load;
mod meshes;
mod method;
mod motion;
mod needs;
mod overrides;
mod parse;
mod quantity;
pub mod ranges;
mod refine;
mod sleep;
mod spec;
mod spelling;
mod tree;
mod warning;

pub use ablation::{Ablation, ablations};
pub use error::{Origin, Problem, SceneError};
pub use fabric::FabricError;
pub use layers::{LayerContact, LayersSpec};
pub use load::LoadSpec;
pub use meshes::Reader;
pub use method::{Method, MethodSpec, OutputSpec, Scheme, Solver, StableLimit};
pub use motion::{ObstacleMotion, OverlapRule, OverlapSpec, SupportMotion};
pub use needs::{Reason, Term, needs};
pub use overrides::Override;
pub use parse::{parse, parse_with};
pub use refine::Refine;
pub use sleep::SleepSpec;
pub use spec::*;
pub use warning::Warning;

pub use crate::sheet::Outline;
