//! How far a straight motion may go before two parts of the sheet meet: additive conservative advancement (Li, Kaufman,
//! Jiang, Codimensional Incremental Potential Contact, 2021).

use nalgebra::Vector3;

use super::Tiles;
use super::bounds::max;
use super::closest::between;
use super::features::{features, nodes};
use super::fit::Fit;
use super::hunt::Fits;
use super::plane::{features_separated, separated_throughout};
use super::tiles::Near;
use crate::sheet::Mesh;

type Point = Vector3<f64>;

/// Share of their distance that two features keep.
const KEPT: f64 = 0.1;
/// Distance below which features count as crossed already \[m\]: no motion can be judged by it.
const CROSSED: f64 = 1e-10;
const MOST_ADVANCES: usize = 1000;
/// Share of a reach beyond it that is not told from it.
const SLACK: f64 = 0.05;

/// Work space of [`safe_share`] and [`may_meet`], for one sheet.
#[derive(Clone, Debug, Default)]
pub struct Sweep {
    from: Fit,
    to: Fit,
}

impl Sweep {
    /// Lays the tiles at both ends of a way. Many a way begins where the last one did, or ended.
    fn over(&mut self, tiles: &Tiles, mesh: &Mesh, [from, to]: [&[Point]; 2]) -> Fits<'_, 2> {
        if self.to.lies_over(from) {
            std::mem::swap(&mut self.from, &mut self.to);
        }
        self.from.over(tiles, mesh, from);
        self.to.over(tiles, mesh, to);
        Fits([&mut self.from, &mut self.to])
    }
}

/// The share of the motion `from` - `to` that brings no two features nearer than a tenth of their distance; 1 is all of it.
pub fn safe_share(
    sweep: &mut Sweep,
    (tiles, mesh): (&Tiles, &Mesh),
    from: &[Point],
    to: &[Point],
) -> f64 {
    let mut fits = sweep.over(tiles, mesh, [from, to]);
    let mut share: f64 = 1.0;
    let mut look = |edges: bool, pair: [u32; 2]| {
        if tiles.excludes(edges, pair) {
            return;
        }
        let stencil = nodes(mesh, edges, pair);
        let x = stencil.map(|v| from[v as usize]);
        let motion = stencil.map(|v| to[v as usize] - from[v as usize]);
        share = share.min(advance(edges, x, motion, share));
    };
    // What is certified has a distance at all times, however small.
    let reach = f64::MIN_POSITIVE;
    fits.near_faces((tiles, mesh), reach, |f, g| {
        features(tiles, mesh, [f, g], &mut look)
    });
    for &(edges, pair) in tiles.near.iter().flat_map(|near| &near.pairs) {
        look(edges, pair);
    }
    share
}

/// Whether two features of the sheet may come within `reach` of each other while it moves straight from one place to the
/// other; never no where they do.
pub fn may_meet(
    sweep: &mut Sweep,
    (tiles, mesh): (&Tiles, &Mesh),
    [from, to]: [&[Point]; 2],
    reach: f64,
) -> bool {
    let mut fits = sweep.over(tiles, mesh, [from, to]);
    let mut met = false;
    let mut look = |edges: bool, pair: [u32; 2]| {
        if met {
            return;
        }
        let stencil = nodes(mesh, edges, pair);
        let [x, end] = [from, to].map(|places| stencil.map(|v| places[v as usize]));
        if features_separated(edges, [&x, &end], reach) {
            return;
        }
        let motion = std::array::from_fn(|n| end[n] - x[n]);
        met = comes_within(edges, x, motion, reach) && !tiles.excludes(edges, pair);
    };
    let untold = |near: &&Near| !fits.tell((tiles, mesh), near, reach);
    let near = tiles.near.iter().filter(untold);
    for &(edges, pair) in near.flat_map(|near| &near.pairs) {
        look(edges, pair);
    }
    fits.near_faces((tiles, mesh), reach, |f, g| {
        if !separated_throughout(mesh, [from, to], [f, g], reach) {
            features(tiles, mesh, [f, g], &mut look);
        }
    });
    met
}

/// The same for one pair, by conservative advancement; a twentieth more than `reach` counts as within.
fn comes_within(edges: bool, mut x: [Point; 4], mut motion: [Point; 4], reach: f64) -> bool {
    let speed = part_ways(&mut motion, if edges { 2 } else { 1 });
    let mut share = 0.0;
    for _ in 0..MOST_ADVANCES {
        let distance = between(edges, &x);
        let ahead = (distance - reach) / speed;
        if share + ahead >= 1.0 {
            return false;
        }
        if distance < (1.0 + SLACK) * reach {
            return true;
        }
        for (x, m) in x.iter_mut().zip(&motion) {
            *x += m * ahead;
        }
        share += ahead;
    }
    true
}

/// The safe share of the motion of one pair, `most` if it is at least that.
pub(super) fn advance(edges: bool, mut x: [Point; 4], mut motion: [Point; 4], most: f64) -> f64 {
    // Apart along an axis throughout? That settles most pairs.
    let split = if edges { 2 } else { 1 };
    if separate(&x, &motion, split, most) {
        return most;
    }
    let speed = part_ways(&mut motion, split);
    let start = between(edges, &x);
    if start < CROSSED || start * (1.0 - KEPT) >= speed * most {
        return most;
    }
    let (mut distance, mut share) = (start, 0.0);
    for _ in 0..MOST_ADVANCES {
        let ahead = (1.0 - KEPT) * distance / speed;
        if share + ahead >= most {
            return most;
        }
        for (x, m) in x.iter_mut().zip(&motion) {
            *x += m * ahead;
        }
        distance = between(edges, &x);
        if share > 0.0 && distance < KEPT * start {
            return share;
        }
        share += ahead;
    }
    share
}

/// Takes off what two features move in common, and bounds how fast they come nearer \[m\].
fn part_ways(motion: &mut [Point; 4], split: usize) -> f64 {
    let mean = (motion[0] + motion[1] + motion[2] + motion[3]) * 0.25;
    motion.iter_mut().for_each(|m| *m -= mean);
    let square = |part: &[Point]| part.iter().map(Point::norm_squared).fold(0.0, max);
    square(&motion[..split]).sqrt() + square(&motion[split..]).sqrt()
}

fn separate(x: &[Point; 4], motion: &[Point; 4], split: usize, most: f64) -> bool {
    (0..3).any(|k| {
        let range = |part: std::ops::Range<usize>| {
            part.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), n| {
                let (a, b) = (x[n][k], x[n][k] + motion[n][k] * most);
                (low.min(a.min(b)), high.max(a.max(b)))
            })
        };
        let (a, b) = (range(0..split), range(split..4));
        a.0 > b.1 || b.0 > a.1
    })
}
