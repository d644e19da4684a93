//! The sheet: a flat triangle mesh in material coordinates, its metric and its curvature.

mod generate;
mod interpolate;
mod mesh;
mod outline;
mod shape;
#[cfg(test)]
mod test;

pub use generate::{MeshOptions, generate, generate_graded};
pub use interpolate::interpolate;
pub use mesh::{Mesh, NO_FACE};
pub use outline::Outline;
