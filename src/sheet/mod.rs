//! The sheet: a flat triangle mesh in material coordinates, its metric and its curvature.

mod mesh;

pub use mesh::Mesh;
