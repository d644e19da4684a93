//! The tiles over the sheet as it lies: boxes, and what its deformation gradients tell.

use nalgebra::Vector3;

use super::bounds::Bounds;
use super::spread::{Gradient, Spread};
use super::tiles::{Level, Tiles};
use crate::sheet::Mesh;

type Point = Vector3<f64>;

/// The tiles over given positions.
#[derive(Clone, Debug, Default)]
pub struct Fit {
    positions: Vec<Point>,
    /// Whether it is laid over the whole sheet.
    whole: bool,
    pub(super) faces: Vec<Bounds>,
    pub(super) bounds: Vec<Vec<Bounds>>,
    /// Of faces and tiles that were asked for.
    gradients: Vec<Option<Gradient>>,
    covers: Vec<Vec<Option<Cover>>>,
}

/// What is known of the cloth that covers a tile.
#[derive(Clone, Copy, Debug)]
enum Cover {
    /// There is none.
    Empty,
    /// It has holes or no plane.
    Unknown,
    Cloth(Spread),
}

impl Fit {
    /// Lays the tiles over the sheet, unless they lie there.
    pub fn over(&mut self, tiles: &Tiles, mesh: &Mesh, positions: &[Point]) {
        if self.lies_over(positions) {
            return;
        }
        self.lay(tiles, mesh, positions, tiles.levels.len(), |_| true);
        self.whole = true;
    }

    /// Whether they lie over the whole sheet there.
    pub fn lies_over(&self, positions: &[Point]) -> bool {
        self.whole && self.positions == positions
    }

    /// Lays the tiles of some patches over the sheet.
    pub fn over_patches(
        &mut self,
        tiles: &Tiles,
        mesh: &Mesh,
        positions: &[Point],
        patches: &[bool],
    ) {
        let levels = tiles.patch_level + 1;
        self.lay(tiles, mesh, positions, levels, |patch| patches[patch]);
    }

    fn lay(
        &mut self,
        tiles: &Tiles,
        mesh: &Mesh,
        positions: &[Point],
        levels: usize,
        wanted: impl Fn(usize) -> bool,
    ) {
        self.whole = false;
        self.positions.clear();
        self.positions.extend_from_slice(positions);
        self.gradients.clear();
        self.gradients.resize(mesh.faces.len(), None);
        self.covers.resize(tiles.coverings.len(), vec![]);
        for (covers, tiles) in self.covers.iter_mut().zip(&tiles.coverings) {
            covers.clear();
            covers.resize(tiles.len(), None);
        }
        self.faces.resize(mesh.faces.len(), Bounds::EMPTY);
        self.bounds.resize(tiles.levels.len(), vec![]);
        for level in 0..levels {
            let count = tiles.levels[level].len();
            self.bounds[level].resize(count, Bounds::EMPTY);
            for t in 0..count {
                if level > tiles.patch_level || wanted(tiles.patch_of_tile(level, t)) {
                    self.bounds[level][t] = match level {
                        0 => self.finest(mesh, &tiles.owned[t]),
                        _ => self.coarser([tiles.levels[level - 1], tiles.levels[level]], level, t),
                    };
                }
            }
        }
    }

    fn finest(&mut self, mesh: &Mesh, owned: &[u32]) -> Bounds {
        let mut of_tile = Bounds::EMPTY;
        for &f in owned {
            let mut of_face = Bounds::EMPTY;
            for v in mesh.faces[f as usize] {
                of_face.add(&self.positions[v as usize]);
            }
            self.faces[f as usize] = of_face;
            of_tile.join(&of_face);
        }
        of_tile
    }

    fn coarser(&self, [fine, coarse]: [Level; 2], level: usize, t: usize) -> Bounds {
        let mut bounds = Bounds::EMPTY;
        for child in children(fine, [t % coarse.columns, t / coarse.columns]) {
            bounds.join(&self.bounds[level - 1][fine.index(child)]);
        }
        bounds
    }

    /// Finds out about the cloth that covers a tile of a level that has coverings.
    pub(super) fn see(&mut self, tiles: &Tiles, mesh: &Mesh, level: usize, tile: usize) {
        if self.covers[level][tile].is_some() {
            return;
        }
        let covering = &tiles.coverings[level][tile];
        let mut sum = [Point::zeros(); 2];
        for &f in &covering.faces {
            let [u, v] = self.gradient(tiles, mesh, f as usize);
            sum = [sum[0] + u, sum[1] + v];
        }
        let gradients = || {
            let faces = covering.faces.iter();
            faces.filter_map(|&f| self.gradients[f as usize].as_ref())
        };
        let cover = match covering.faces.len() {
            _ if !covering.convex => Cover::Unknown,
            0 => Cover::Empty,
            count => Spread::of(sum.map(|s| s / count as f64), gradients())
                .map_or(Cover::Unknown, Cover::Cloth),
        };
        self.covers[level][tile] = Some(cover);
    }

    fn gradient(&mut self, tiles: &Tiles, mesh: &Mesh, f: usize) -> Gradient {
        let (positions, shape) = (&self.positions, &tiles.shape[f]);
        *self.gradients[f].get_or_insert_with(|| {
            let [a, b, c] = mesh.faces[f].map(|v| positions[v as usize]);
            let (u, v) = (b - a, c - a);
            [0, 1].map(|k| u * shape[1][k] + v * shape[2][k])
        })
    }

    /// Adds what was found out about a tile.
    pub(super) fn add_to<'a>(&'a self, parts: &mut Parts<'a>, level: usize, tile: usize) {
        match &self.covers[level][tile] {
            None | Some(Cover::Unknown) => parts.unknown = true,
            Some(Cover::Empty) => {}
            Some(Cover::Cloth(spread)) => {
                parts.spreads[parts.count] = Some(spread);
                parts.count += 1;
            }
        }
    }
}

/// Spreads of up to four tiles, at one moment or at two.
#[derive(Default)]
pub(super) struct Parts<'a> {
    spreads: [Option<&'a Spread>; 8],
    count: usize,
    unknown: bool,
}

impl<'a> Parts<'a> {
    /// Nothing if one of them is not known.
    pub fn list(&self) -> Option<&[Option<&'a Spread>]> {
        (!self.unknown).then(|| &self.spreads[..self.count])
    }
}

pub(super) fn children(fine: Level, [i, j]: [usize; 2]) -> impl Iterator<Item = [usize; 2]> {
    let columns = 2 * i..(2 * i + 2).min(fine.columns);
    let rows = 2 * j..(2 * j + 2).min(fine.rows);
    rows.flat_map(move |j| columns.clone().map(move |i| [i, j]))
}
