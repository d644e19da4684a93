//! How fine a mesh is, and where it is finer than elsewhere.

use nalgebra::Vector2;
use serde::{Deserialize, Serialize};

use super::spec::{Region, Scene};
use crate::sheet::Outline;

/// Part of the sheet with a finer mesh, where folds or supports bend it sharply; from there on edges grow by a quarter
/// of the way.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Refine {
    /// The part.
    pub region: Region,
    /// Edge length within it over that far from it, 0.02 to 1 \[-\].
    pub factor: f64,
}

impl Refine {
    /// Growth of the edges over the distance from the region \[-\].
    const GROWTH: f64 = 0.25;

    /// Edge length wanted at a point of a sheet whose longest edges are given \[m\].
    pub fn size(&self, outline: &Outline, longest: f64, at: &Vector2<f64>) -> f64 {
        let grown = self.factor * longest + Self::GROWTH * self.region.distance(outline, at);
        grown.min(longest)
    }
}

impl Scene {
    /// Triangles that it asks for, directly or about by their edge length.
    pub fn triangles(&self) -> usize {
        let equilateral = 3f64.sqrt() / 4.0 * self.sheet.edge_length().powi(2);
        let by_edge = (self.sheet.outline.area() / equilateral).round() as usize;
        self.sheet.triangles.unwrap_or(by_edge)
    }

    /// The same on a mesh of so many triangles.
    pub fn on_mesh(&self, triangles: usize) -> Self {
        let mut scene = self.clone();
        scene.sheet.triangles = Some(triangles);
        scene.sheet.edge = None;
        scene
    }
}

impl Region {
    /// Distance of a point of a sheet from the region, zero within \[m\].
    pub fn distance(&self, outline: &Outline, at: &Vector2<f64>) -> f64 {
        let half = outline.half_extent();
        let distance = match *self {
            Region::XMin => at.x + half.x,
            Region::XMax => half.x - at.x,
            Region::YMin => at.y + half.y,
            Region::YMax => half.y - at.y,
            Region::Boundary => outline.depth(at),
            Region::Box { min, max } => {
                let beyond = |k: usize| (min[k] - at[k]).max(at[k] - max[k]).max(0.0);
                beyond(0).hypot(beyond(1))
            }
            Region::Disc { diameter } => at.norm() - 0.5 * diameter,
            Region::Ring { outer, inner } => (at.norm() - 0.5 * outer).max(0.5 * inner - at.norm()),
            Region::Point { at: point } => (at - Vector2::from(point)).norm(),
        };
        distance.max(0.0)
    }
}
