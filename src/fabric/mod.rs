//! Woven fabric as material constants: the law, the paper's catalogue, and the only place for textile units.

mod catalogue;
pub mod identify;
mod law;
#[cfg(test)]
mod test;
pub mod units;

pub use catalogue::{catalogue, find};
pub use law::{Fabric, Orthotropic, PoissonCoupling, TwistRigidity, Unphysical};
