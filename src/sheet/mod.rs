//! The sheet: a flat triangle mesh in material coordinates, its metric and its curvature.

mod mesh;
mod outline;

pub use mesh::Mesh;
pub use outline::Outline;
