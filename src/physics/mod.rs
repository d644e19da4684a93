//! The terms of the equation of motion, a folder each.

pub mod bend;
pub mod contact;
pub mod damping;
pub mod drag;
pub mod friction;
pub mod gravity;
pub mod layers;
mod stencil;
pub mod stretch;
#[cfg(test)]
mod suite;
pub mod support;

pub use stencil::{Block, Gradient, Hessian, Load, Nodes, Potential};
