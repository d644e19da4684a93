//! The sheet: a flat triangle mesh in material coordinates, its metric and its curvature.

mod generate;
mod mesh;

pub use generate::{MeshOptions, Outline, generate};
pub use mesh::{Mesh, NO_FACE};
