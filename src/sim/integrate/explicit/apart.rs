//! Whether layers stayed apart in a run of substeps, seen afterwards: a run in which they did needs no other look.
//!
//! A few moments of the run are kept. Between two of them the sheet is taken to have moved straight but for what the
//! moment midway departs from that, and half as much again. Where that is too much, or layers come within it, the two
//! halves are looked at, down to three moments in a row.

use nalgebra::Vector3;

use crate::contact::layers::{Sweep, may_meet};
use crate::sim::lanes::{Lanes, vector};
use crate::sim::model::Model;
use crate::sim::state::State;

/// Parts into which a run is cut, a power of two.
const PARTS: u64 = 16;
/// Fewest substeps of a run: a shorter one is cheaper to watch as it goes.
const FEWEST: u64 = 200;
/// What a vertex may be off the straight way, over what it is midway; two vertices are off by twice as much.
const ROUNDER: f64 = 1.5;
/// The most that two may be off together, over the thickness, for a way to be looked at whole.
const STRAIGHT: f64 = 3.0;

/// Moments of a run of substeps.
#[derive(Default)]
pub struct Apart {
    moments: Vec<Vec<Vector3<f64>>>,
    sweep: Sweep,
    looks: u64,
}

impl Apart {
    /// Whether a run of so many substeps is worth the moments.
    pub fn pays(count: u64) -> bool {
        count >= FEWEST
    }

    /// Whether layers would meet in `span` seconds if all vertices kept their velocities.
    pub fn ahead(&mut self, model: &Model, state: &State, span: f64) -> bool {
        let moving = state.positions.iter().zip(&state.velocities);
        let to: Vec<_> = moving.map(|(x, v)| x + v * span).collect();
        self.looks += 1;
        let (sheet, way) = ((&model.tiles, &model.mesh), [&state.positions[..], &to]);
        may_meet(&mut self.sweep, sheet, way, model.tiles.thickness())
    }

    /// Begins a run at `nodes`, whose first `vertices` are positions.
    pub fn begin(&mut self, nodes: &[Lanes], vertices: usize) {
        self.moments.clear();
        self.keep(nodes, vertices);
    }

    /// Whether `done` substeps of `count` lead to the next moment.
    pub fn is_moment(done: u64, count: u64) -> bool {
        done * PARTS / count > (done - 1) * PARTS / count
    }

    /// Keeps a moment.
    pub fn keep(&mut self, nodes: &[Lanes], vertices: usize) {
        self.moments
            .push(nodes[..vertices].iter().map(vector).collect());
    }

    /// Whether layers stayed farther apart than they are thick, throughout.
    pub fn held(&mut self, model: &Model) -> bool {
        self.held_between(model, 0, self.moments.len() - 1)
    }

    /// Begins a step.
    pub fn forget(&mut self) {
        self.looks = 0;
    }

    /// Times that a way was looked at in the step.
    pub fn looks(&self) -> u64 {
        self.looks
    }

    fn held_between(&mut self, model: &Model, first: usize, last: usize) -> bool {
        let middle = (first + last) / 2;
        let [from, midway, to] = [first, middle, last].map(|m| &self.moments[m][..]);
        let off = off_straight(from, midway, to);
        if !off.is_finite() {
            return false;
        }
        let thickness = model.tiles.thickness();
        let whole = last - first <= 2;
        let apart = (whole || off <= STRAIGHT * thickness) && {
            self.looks += 1;
            let sheet = (&model.tiles, &model.mesh);
            !may_meet(&mut self.sweep, sheet, [from, to], thickness + off)
        };
        apart
            || !whole
                && self.held_between(model, first, middle)
                && self.held_between(model, middle, last)
    }
}

/// How much two vertices may be nearer than if all moved straight \[m\]; not a number if one is lost.
fn off_straight(from: &[Vector3<f64>], midway: &[Vector3<f64>], to: &[Vector3<f64>]) -> f64 {
    let ways = from.iter().zip(midway).zip(to);
    let squares = ways.map(|((a, m), b)| (m - (a + b) * 0.5).norm_squared());
    // Bits of squares are in the order of the squares, and above them all where one is no number.
    let most = squares.map(f64::to_bits).max().unwrap_or_default();
    2.0 * ROUNDER * f64::from_bits(most).sqrt()
}
