//! The simulation: a constant model, a state, and the only two ways to change it.

mod assembly;
mod command;
mod dofs;
mod implicit;
mod integrate;
mod kernel;
mod measure;
mod model;
mod report;
mod simulation;
mod slopes;
mod state;
mod touch;

pub use command::{AirRegion, Airflow, Command, Rejected};
pub use dofs::Dofs;
pub use model::{Model, Reading};
pub use report::{Energies, StepReport, Work};
pub use simulation::{Diverged, Refused, Simulation};
pub use state::{History, Memory, State};
