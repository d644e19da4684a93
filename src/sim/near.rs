//! The sheet against itself while an implicit step is solved: candidates kept while iterates stay close, room for them in
//! the tangent, and how far an iterate may go.

use nalgebra::Vector3;

use super::assembly::Assembly;
use super::layers::LayerTouch;
use super::model::Model;
use super::state::Memory;
use crate::contact::layers::{Candidates, Sweep, may_meet, safe_share};
use crate::physics::layers::LayerLaw;

/// Margin of a collection: what the tiles tell apart well, over their span, less the thickness.
const REACH: f64 = 0.5;
/// Least margin over the thickness.
const LEAST_MARGIN: f64 = 0.5;

/// Layers near each other, for one solver.
#[derive(Default)]
pub struct Near {
    candidates: Candidates,
    sweep: Sweep,
    /// Where the candidates were collected \[m\]; empty if they were not.
    base: Vec<Vector3<f64>>,
    margin: f64,
    /// Vertices of the candidates, sorted.
    couples: Vec<[u32; 4]>,
    /// Searches of the sheet: collections, and looks at a way.
    pub looks: u64,
}

impl Near {
    /// Forgets what was collected.
    pub fn forget(&mut self) {
        self.base.clear();
    }

    /// Finds the layers that touch at `positions`, tied to where the step started.
    pub fn find(
        &mut self,
        model: &Model,
        law: &LayerLaw,
        positions: &[Vector3<f64>],
        (start, memory): (&[Vector3<f64>], &[Memory]),
        touch: &mut LayerTouch,
    ) {
        let apart = |(a, b): (&Vector3<f64>, &Vector3<f64>)| (a - b).norm_squared();
        let moved = self
            .base
            .iter()
            .zip(positions)
            .map(apart)
            .fold(0.0, f64::max);
        touch.pairs.clear();
        touch.bonds.clear();
        if !moved.is_finite() {
            return;
        }
        if self.base.is_empty() || 2.0 * moved.sqrt() > self.margin {
            self.collect(model, positions);
        }
        self.candidates.look_at_all();
        let (tiles, mesh) = (&model.tiles, &model.mesh);
        self.candidates
            .pairs(tiles, mesh, positions, &mut touch.pairs);
        touch.bind(law, start, memory);
    }

    fn collect(&mut self, model: &Model, positions: &[Vector3<f64>]) {
        let (tiles, mesh) = (&model.tiles, &model.mesh);
        let thickness = tiles.thickness();
        self.looks += 1;
        self.margin = (REACH * tiles.span() - thickness).max(LEAST_MARGIN * thickness);
        self.candidates.collect(tiles, mesh, positions, self.margin);
        self.base.clear();
        self.base.extend_from_slice(positions);
        self.couples.clear();
        self.couples
            .extend(self.candidates.nodes(mesh).map(|mut nodes| {
                nodes.sort_unstable();
                nodes
            }));
        self.couples.sort_unstable();
        self.couples.dedup();
    }

    /// Gives the tangent room for what is near at `positions`, and no more; says whether that changes it.
    pub fn fit(
        &mut self,
        model: &Model,
        positions: &[Vector3<f64>],
        assembly: &mut Assembly,
    ) -> bool {
        self.collect(model, positions);
        assembly.couple(model, &self.couples)
    }

    /// Gives the tangent room for all pairs that touch, besides what it has; says whether that changes it.
    pub fn widen(&self, model: &Model, touch: &LayerTouch, assembly: &mut Assembly) -> bool {
        let known = assembly.couples();
        let has = |mut nodes: [u32; 4]| {
            nodes.sort_unstable();
            known.binary_search(&nodes).is_ok()
        };
        if touch.pairs.iter().all(|pair| has(pair.nodes)) {
            return false;
        }
        let mut all = [known, &self.couples].concat();
        all.sort_unstable();
        all.dedup();
        assembly.couple(model, &all)
    }

    /// Whether layers may touch on the straight way between two configurations; never no where they do.
    pub fn meet(&mut self, model: &Model, from: &[Vector3<f64>], to: &[Vector3<f64>]) -> bool {
        self.looks += 1;
        let (sheet, reach) = ((&model.tiles, &model.mesh), model.tiles.thickness());
        may_meet(&mut self.sweep, sheet, [from, to], reach)
    }

    /// How much of the way between two configurations may be gone, 0 to 1, before layers meet.
    pub fn safe(&mut self, model: &Model, from: &[Vector3<f64>], to: &[Vector3<f64>]) -> f64 {
        self.looks += 1;
        safe_share(&mut self.sweep, (&model.tiles, &model.mesh), from, to)
    }
}
