//! The simulation: a constant model, a state, and the only two ways to change it.

mod model;
mod report;
mod simulation;
mod state;

pub use model::Model;
pub use report::{Energies, StepReport, Work};
pub use simulation::{Diverged, Simulation};
pub use state::State;
