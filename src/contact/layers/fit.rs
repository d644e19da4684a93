//! The tiles over the sheet as it lies, or as it moves from one place to another: boxes and deformation gradients.

use nalgebra::Vector3;

use super::bounds::{Bounds, Spread, max};
use super::features::{closer, features};
use super::tiles::{Level, Near, Tiles};
use crate::sheet::Mesh;

type Point = Vector3<f64>;

/// Boxes and spreads of all tiles for given positions.
#[derive(Clone, Debug, Default)]
pub struct Fit {
    faces: Vec<Bounds>,
    bounds: Vec<Vec<Bounds>>,
    spreads: Vec<Vec<Option<Spread>>>,
    gradients: Vec<[Point; 2]>,
    /// Which faces have been laid out.
    laid: Vec<bool>,
}

impl Fit {
    /// Lays the tiles over the sheet while it moves straight through the given positions, one or two lists.
    pub fn over(&mut self, tiles: &Tiles, mesh: &Mesh, moments: &[&[Point]]) {
        self.lay(
            tiles,
            mesh,
            moments,
            (tiles.levels.len(), &|_| (true, true)),
        );
    }

    /// Lays the boxes of some patches over the sheet, and the spreads of some.
    pub(super) fn over_patches(
        &mut self,
        tiles: &Tiles,
        mesh: &Mesh,
        positions: &[Point],
        [boxes, spreads]: [&[bool]; 2],
    ) {
        let levels = tiles.patch_level + 1;
        let wanted = |patch: usize| (boxes[patch], spreads[patch]);
        self.lay(tiles, mesh, &[positions], (levels, &wanted));
    }

    fn lay(
        &mut self,
        tiles: &Tiles,
        mesh: &Mesh,
        moments: &[&[Point]],
        (levels, wanted): (usize, &dyn Fn(usize) -> (bool, bool)),
    ) {
        let nowhere = [Point::zeros(); 2];
        self.faces.resize(mesh.faces.len(), Bounds::EMPTY);
        self.gradients
            .resize(mesh.faces.len() * moments.len(), nowhere);
        self.laid.clear();
        self.laid.resize(mesh.faces.len(), false);
        self.bounds.resize(tiles.levels.len(), vec![]);
        self.spreads.resize(tiles.levels.len(), vec![]);
        for level in 0..levels {
            let count = tiles.levels[level].len();
            self.bounds[level].resize(count, Bounds::EMPTY);
            self.spreads[level].resize(count, None);
            for t in 0..count {
                let (bounds, spread) = match level <= tiles.patch_level {
                    true => wanted(tiles.patch_of_tile(level, t)),
                    false => (true, true),
                };
                match level {
                    0 if bounds || spread => self.finest(tiles, mesh, moments, (t, spread)),
                    0 => {}
                    _ if bounds || spread => self.coarser(tiles, level, t),
                    _ => {}
                }
            }
        }
    }

    fn face(&mut self, tiles: &Tiles, mesh: &Mesh, moments: &[&[Point]], f: usize) {
        let mut bounds = Bounds::EMPTY;
        let shape = &tiles.shape[f];
        for (m, positions) in moments.iter().enumerate() {
            let [a, b, c] = mesh.faces[f].map(|v| positions[v as usize]);
            [a, b, c].iter().for_each(|p| bounds.add(p));
            let (u, v) = (b - a, c - a);
            self.gradients[f * moments.len() + m] =
                [0, 1].map(|k| u * shape[1][k] + v * shape[2][k]);
        }
        self.faces[f] = bounds;
        self.laid[f] = true;
    }

    fn finest(
        &mut self,
        tiles: &Tiles,
        mesh: &Mesh,
        moments: &[&[Point]],
        (t, spread): (usize, bool),
    ) {
        let covering = &tiles.covering[t];
        let faces = if spread { covering } else { &tiles.owned[t] };
        for &f in faces {
            if !self.laid[f as usize] {
                self.face(tiles, mesh, moments, f as usize);
            }
        }
        let mut of_tile = Bounds::EMPTY;
        for &f in &tiles.owned[t] {
            of_tile.join(&self.faces[f as usize]);
        }
        self.bounds[0][t] = of_tile;
        if !spread {
            return;
        }
        let count = moments.len();
        let gradients = || {
            covering.iter().flat_map(|&f| {
                let first = f as usize * count;
                &self.gradients[first..first + count]
            })
        };
        let sum = gradients().fold([Point::zeros(); 2], |s, g| [s[0] + g[0], s[1] + g[1]]);
        let mean = sum.map(|s| s / ((covering.len() * count) as f64).max(1.0));
        let square =
            |g: &[Point; 2]| (g[0] - mean[0]).norm_squared() + (g[1] - mean[1]).norm_squared();
        // What covers nothing must not count in a mean.
        let radius = match covering.is_empty() {
            true => f64::NEG_INFINITY,
            false => gradients().map(square).fold(0.0, max).sqrt(),
        };
        self.spreads[0][t] = tiles.convex[t].then_some(Spread { mean, radius });
    }

    fn coarser(&mut self, tiles: &Tiles, level: usize, t: usize) {
        let (fine, coarse) = (tiles.levels[level - 1], tiles.levels[level]);
        let tile = [t % coarse.columns, t / coarse.columns];
        let mut bounds = Bounds::EMPTY;
        let mut parts = [Spread::NOTHING; 4];
        let (mut count, mut convex) = (0, true);
        for child in children(fine, tile) {
            let child = fine.index(child);
            bounds.join(&self.bounds[level - 1][child]);
            match self.spreads[level - 1][child] {
                Some(spread) if spread.radius >= 0.0 => {
                    parts[count] = spread;
                    count += 1;
                }
                Some(_) => {}
                None => convex = false,
            }
        }
        self.bounds[level][t] = bounds;
        let joined = match count {
            0 => Spread::NOTHING,
            _ => Spread::join(&parts[..count]),
        };
        self.spreads[level][t] = convex.then_some(joined);
    }

    /// Calls `leaf` with every pair of faces that may come within `reach` of each other, unless they are nearer than
    /// the span in the flat sheet. The first face is in the tile of smaller number; order is fixed.
    pub fn near_faces(&self, tiles: &Tiles, reach: f64, mut leaf: impl FnMut(u32, u32)) {
        let top = tiles.levels.len() - 1;
        self.visit(tiles, (top, reach, true), [[0, 0]; 2], &mut leaf);
    }

    /// The same for two tiles of a level alone. Returns how near what it does not call with may be, at least \[m\].
    pub(super) fn near_faces_of(
        &self,
        tiles: &Tiles,
        (level, two): (usize, [u32; 2]),
        reach: f64,
        mut leaf: impl FnMut(u32, u32),
    ) -> f64 {
        let grid = tiles.levels[level];
        let [a, b] = two.map(|t| [t as usize % grid.columns, t as usize / grid.columns]);
        let [first, second] = two.map(|t| &self.bounds[level][t as usize]);
        let gap = first.gap(second);
        if gap >= reach {
            return gap;
        }
        self.visit(tiles, (level, reach, true), [a, b], &mut leaf);
        reach
    }

    fn visit(
        &self,
        tiles: &Tiles,
        (level, reach, certify): (usize, f64, bool),
        [a, b]: [[usize; 2]; 2],
        leaf: &mut impl FnMut(u32, u32),
    ) {
        let grid = tiles.levels[level];
        let (first, second) = (grid.index(a), grid.index(b));
        let bounds = &self.bounds[level];
        if bounds[first].apart(&bounds[second], reach) {
            return;
        }
        let beside = a[0].abs_diff(b[0]) <= 1 && a[1].abs_diff(b[1]) <= 1;
        if certify && beside && self.least(level, grid, [a, b]) * tiles.span() >= reach {
            return;
        }
        if level == 0 {
            self.leaf(tiles, [first, second], reach, leaf);
            return;
        }
        let fine = tiles.levels[level - 1];
        for child in children(fine, a) {
            for other in children(fine, b) {
                if a != b || fine.index(child) <= fine.index(other) {
                    let below = (level - 1, reach, certify);
                    self.visit(tiles, below, [child, other], leaf);
                }
            }
        }
    }

    /// Least stretch over the rectangle that holds the tiles of features that are near in the flat sheet; negative if
    /// nothing is known.
    pub(super) fn stretch(&self, tiles: &Tiles, near: &Near) -> f64 {
        let level = tiles.near_level();
        let (grid, two) = (tiles.levels[level], near.tiles.map(|t| t as usize));
        match grid.beside(two) {
            true => self.least(
                level,
                grid,
                two.map(|t| [t % grid.columns, t / grid.columns]),
            ),
            false => -1.0,
        }
    }

    /// Least stretch over the rectangle that holds two tiles that touch; negative if nothing is known.
    fn least(&self, level: usize, grid: Level, [a, b]: [[usize; 2]; 2]) -> f64 {
        let mut parts = [Spread::NOTHING; 4];
        let mut count = 0;
        for j in a[1].min(b[1])..=a[1].max(b[1]) {
            for i in a[0].min(b[0])..=a[0].max(b[0]) {
                match self.spreads[level][grid.index([i, j])] {
                    None => return -1.0,
                    Some(spread) if spread.radius >= 0.0 => {
                        parts[count] = spread;
                        count += 1;
                    }
                    Some(_) => {}
                }
            }
        }
        if count == 0 {
            -1.0
        } else {
            Spread::join(&parts[..count]).least()
        }
    }

    fn leaf(
        &self,
        tiles: &Tiles,
        [first, second]: [usize; 2],
        reach: f64,
        leaf: &mut impl FnMut(u32, u32),
    ) {
        for (n, &f) in tiles.owned[first].iter().enumerate() {
            let bounds = &self.faces[f as usize];
            if bounds.apart(&self.bounds[0][second], reach) {
                continue;
            }
            let others = match first == second {
                true => &tiles.owned[second][n + 1..],
                false => &tiles.owned[second][..],
            };
            for &g in others {
                if !bounds.apart(&self.faces[g as usize], reach) {
                    leaf(f, g);
                }
            }
        }
    }

    /// Pairs of a vertex and a face, and of two edges, closer than `reach`, with their distances; no certificate.
    pub(super) fn flat_pairs(
        &self,
        tiles: &Tiles,
        mesh: &Mesh,
        positions: &[Point],
        reach: f64,
    ) -> [Vec<([u32; 2], f64)>; 2] {
        let mut found = [vec![], vec![]];
        let top = tiles.levels.len() - 1;
        let mut leaf = |f: u32, g: u32| {
            features(tiles, mesh, [f, g], |edges, pair| {
                if let Some(distance) = closer(mesh, positions, (edges, pair), reach) {
                    found[usize::from(edges)].push((pair, distance));
                }
            });
        };
        self.visit(tiles, (top, reach, false), [[0, 0]; 2], &mut leaf);
        for list in &mut found {
            list.sort_unstable_by_key(|(pair, _)| *pair);
        }
        found
    }
}

fn children(fine: Level, [i, j]: [usize; 2]) -> impl Iterator<Item = [usize; 2]> {
    let columns = 2 * i..(2 * i + 2).min(fine.columns);
    let rows = 2 * j..(2 * j + 2).min(fine.rows);
    rows.flat_map(move |j| columns.clone().map(move |i| [i, j]))
}
