#![doc = include_str!("doc.md")]

#[cfg(test)]
mod test;

use nalgebra::{Vector2, Vector3};

use crate::sheet::Mesh;

/// A held part of the sheet.
#[derive(Clone, Debug, PartialEq)]
pub struct Support {
    /// Vertices held.
    pub vertices: Vec<u32>,
    /// Edges whose slope is held (clamps only).
    pub edges: Vec<u32>,
    /// World axes held at the vertices.
    pub axes: [bool; 3],
    /// Displacement from the start \[m\].
    pub displacement: Vector3<f64>,
}

impl Support {
    /// Holds the vertices that `inside` accepts (in the sheet's own x, y); with `clamp`, also the slope of
    /// every edge whose two ends are held.
    pub fn new(
        mesh: &Mesh,
        inside: impl Fn(&Vector2<f64>) -> bool,
        clamp: bool,
        axes: [bool; 3],
        displacement: Vector3<f64>,
    ) -> Self {
        let held: Vec<bool> = mesh.outline.iter().map(inside).collect();
        let vertices = (0..held.len() as u32)
            .filter(|&v| held[v as usize])
            .collect();
        let both = |e: &u32| mesh.edges[*e as usize].iter().all(|&v| held[v as usize]);
        let edges = (0..mesh.edges.len() as u32)
            .filter(|e| clamp && both(e))
            .collect();
        Self {
            vertices,
            edges,
            axes,
            displacement,
        }
    }
}
