//! Which faces may come near to each other, as the tiles over the sheet tell.

use nalgebra::Vector3;

use super::bounds::apart;
use super::features::{closer, features};
use super::fit::{Fit, Parts, children};
use super::spread::Spread;
use super::tiles::{Near, Tiles};
use crate::sheet::Mesh;

type Point = Vector3<f64>;

/// The tiles over the sheet as it lies, or at both ends of a straight way.
pub(super) struct Fits<'a, const M: usize>(pub [&'a mut Fit; M]);

impl<const M: usize> Fits<'_, M> {
    /// Calls `leaf` with every pair of faces that may come within `reach` of each other, unless they are nearer than
    /// the span in the flat sheet. The first face is in the tile of smaller number; order is fixed.
    pub fn near_faces(
        &mut self,
        (tiles, mesh): (&Tiles, &Mesh),
        reach: f64,
        mut leaf: impl FnMut(u32, u32),
    ) {
        let top = tiles.levels.len() - 1;
        self.visit((tiles, mesh), (top, reach, true), [[0, 0]; 2], &mut leaf);
    }

    /// The same for two tiles of a level alone. Returns how near what it does not call with may be, at least \[m\].
    pub(super) fn near_faces_of(
        &mut self,
        (tiles, mesh): (&Tiles, &Mesh),
        (level, two): (usize, [u32; 2]),
        reach: f64,
        mut leaf: impl FnMut(u32, u32),
    ) -> f64 {
        let grid = tiles.levels[level];
        let [a, b] = two.map(|t| [t as usize % grid.columns, t as usize / grid.columns]);
        let [first, second] = two.map(|t| &self.0[0].bounds[level][t as usize]);
        let gap = first.gap(second);
        if gap >= reach {
            return gap;
        }
        self.visit((tiles, mesh), (level, reach, true), [a, b], &mut leaf);
        reach
    }

    fn visit(
        &mut self,
        (tiles, mesh): (&Tiles, &Mesh),
        (level, reach, certify): (usize, f64, bool),
        [a, b]: [[usize; 2]; 2],
        leaf: &mut impl FnMut(u32, u32),
    ) {
        let grid = tiles.levels[level];
        let (first, second) = (grid.index(a), grid.index(b));
        let boxes = std::array::from_fn(|m| {
            let bounds = &self.0[m].bounds[level];
            [&bounds[first], &bounds[second]]
        });
        if apart::<M>(boxes, reach) {
            return;
        }
        let known = certify && level < tiles.coverings.len();
        if known && self.least((tiles, mesh), level, [first, second]) * tiles.span() >= reach {
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
                    self.visit((tiles, mesh), below, [child, other], leaf);
                }
            }
        }
    }

    /// Whether cloth is stretched so little that features which are near in the flat sheet stay out of a reach.
    pub(super) fn tell(&mut self, sheet: (&Tiles, &Mesh), near: &Near, reach: f64) -> bool {
        let tiles = sheet.0;
        let enough = |level: usize| {
            let two = near
                .tiles
                .map(|t| tiles.above(tiles.near_level(), t as usize, level));
            self.least(sheet, level, two) * near.least >= reach
        };
        let levels = tiles.near_level()..tiles.coverings.len();
        levels.rev().any(enough)
    }

    /// Least stretch over the rectangle that holds two tiles that touch; negative if nothing is known.
    fn least(&mut self, (tiles, mesh): (&Tiles, &Mesh), level: usize, two: [usize; 2]) -> f64 {
        let grid = tiles.levels[level];
        let mut parts = Parts::default();
        for fit in &mut self.0 {
            for t in grid.around(two).into_iter().flatten() {
                fit.see(tiles, mesh, level, t);
            }
        }
        for fit in &self.0 {
            for t in grid.around(two).into_iter().flatten() {
                fit.add_to(&mut parts, level, t);
            }
        }
        match parts.list() {
            None | Some([]) => -1.0,
            Some(list) => Spread::least(list),
        }
    }

    fn leaf(
        &self,
        tiles: &Tiles,
        [first, second]: [usize; 2],
        reach: f64,
        leaf: &mut impl FnMut(u32, u32),
    ) {
        let fits = self.0.each_ref();
        let of_tile = fits.map(|fit| &fit.bounds[0][second]);
        for (n, &f) in tiles.owned[first].iter().enumerate() {
            let of_face = fits.map(|fit| &fit.faces[f as usize]);
            if apart::<M>(std::array::from_fn(|m| [of_face[m], of_tile[m]]), reach) {
                continue;
            }
            let others = match first == second {
                true => &tiles.owned[second][n + 1..],
                false => &tiles.owned[second][..],
            };
            for &g in others {
                let boxes = std::array::from_fn(|m| [of_face[m], &fits[m].faces[g as usize]]);
                if !apart::<M>(boxes, reach) {
                    leaf(f, g);
                }
            }
        }
    }

    /// Pairs of a vertex and a face, and of two edges, closer than `reach`, with their distances; no certificate.
    pub(super) fn flat_pairs(
        &mut self,
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
        self.visit((tiles, mesh), (top, reach, false), [[0, 0]; 2], &mut leaf);
        for list in &mut found {
            list.sort_unstable_by_key(|(pair, _)| *pair);
        }
        found
    }
}
