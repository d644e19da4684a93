//! The simulation: a constant model, a state, and the only two ways to change it.

mod admit;
mod air;
mod apply;
mod assembly;
mod carry;
mod command;
mod contacts;
mod digest;
mod dofs;
mod equilibrium;
mod implicit;
mod integrate;
mod kernel;
mod measure;
mod model;
mod overlap;
mod report;
mod resume;
mod simulation;
mod slopes;
mod start;
mod state;
mod step;
mod touch;
mod travel;

pub use air::Air;
pub use command::{AirRegion, Airflow, Command, Rejected};
pub use contacts::ContactPoint;
pub use dofs::Dofs;
pub use equilibrium::Equilibrium;
pub use model::{Model, Reading};
pub use report::{Energies, StepReport, Work};
pub use resume::Mismatch;
pub use simulation::{Refused, Simulation};
pub use state::{History, Ledger, Memory, State};
pub use step::Diverged;
