//! Tiles of the flat sheet, in a hierarchy, and the certificate that a part of it does not touch itself.
//!
//! On a convex patch whose gradients keep the points of every straight line m times as far apart as in the flat sheet
//! ([`super::spread`]), that holds for any two points of the patch, since the straight line between them stays in it. So
//! what is farther apart than `span` in the flat sheet stays out of a reach of `m span`. It takes the place of the normal
//! cone with its contour (Volino, Magnenat-Thalmann 1994), which tells crossing from not crossing, but knows no distance.

use std::collections::BTreeMap;

use nalgebra::{Vector2, Vector3};

use super::fit::{Fit, children};
use super::gaps::{inward_edges, leave_out_gaps};
use super::hunt::Fits;
use super::patches::Patch;
use crate::sheet::Mesh;

/// Side of a finest tile over the mean length of an edge.
const SIDE: f64 = 1.7;
/// Least span over the thickness, and over the mean length of an edge.
const LEAST_SPAN: f64 = 2.5;
const SPAN: f64 = 0.8;
/// Level of the tiles by which features that are near in the flat sheet are grouped, unless patches are smaller: of two by
/// two finest ones.
const NEAR_LEVEL: usize = 1;
/// The coarsest level on which what covers a tile is known: one that is much bent is of no use.
const MOST_COVERED: usize = 2;
/// Patches at most.
const MOST_PATCHES: usize = 128;

/// A rectangle of tiles.
#[derive(Clone, Copy, Debug)]
pub(super) struct Level {
    pub columns: usize,
    pub rows: usize,
}

impl Level {
    pub(super) fn index(self, [i, j]: [usize; 2]) -> usize {
        j * self.columns + i
    }

    /// The tiles of the rectangle that holds two tiles beside each other; nothing if they are not.
    pub(super) fn around(self, two: [usize; 2]) -> Option<impl Iterator<Item = usize>> {
        let [a, b] = two.map(|t| [t % self.columns, t / self.columns]);
        self.beside(two).then(|| {
            let columns = a[0].min(b[0])..=a[0].max(b[0]);
            let rows = a[1].min(b[1])..=a[1].max(b[1]);
            rows.flat_map(move |j| columns.clone().map(move |i| self.index([i, j])))
        })
    }

    /// Whether two tiles touch, or are one.
    pub(super) fn beside(self, two: [usize; 2]) -> bool {
        let [a, b] = two.map(|t| [t % self.columns, t / self.columns]);
        a[0].abs_diff(b[0]) <= 1 && a[1].abs_diff(b[1]) <= 1
    }

    pub(super) fn len(self) -> usize {
        self.columns * self.rows
    }
}

/// What covers a tile.
#[derive(Clone, Debug)]
pub(super) struct Covering {
    /// Faces that cover the convex hull of what the tile owns: those near enough to it.
    pub faces: Vec<u32>,
    /// Whether all of the tile is cloth or lies outside a convex outline.
    pub convex: bool,
}

/// Features of two tiles of [`Tiles::near_level`] that are near in the flat sheet.
#[derive(Clone, Debug)]
pub(super) struct Near {
    pub tiles: [u32; 2],
    pub patches: [u32; 2],
    /// Least distance of a pair in the flat sheet \[m\].
    pub least: f64,
    /// Of two edges (true), or of a vertex and a face.
    pub pairs: Vec<(bool, [u32; 2])>,
}

/// The flat sheet cut into tiles, and what of it is near in the flat state already.
#[derive(Clone, Debug)]
pub struct Tiles {
    /// Finest first; the last is one tile.
    pub(super) levels: Vec<Level>,
    /// Faces by finest tile, each once.
    pub(super) owned: Vec<Vec<u32>>,
    /// What covers the tiles of the finest levels.
    pub(super) coverings: Vec<Vec<Covering>>,
    pub(super) shape: Vec<[Vector2<f64>; 3]>,
    /// The face that answers for each vertex and edge.
    pub(super) vertex_keeper: Vec<u32>,
    pub(super) edge_keeper: Vec<u32>,
    /// The level whose tiles are patches, and these; the patch of each face.
    pub(super) patch_level: usize,
    pub(super) patches: Vec<Patch>,
    patch_of_face: Vec<u32>,
    /// Faces around each vertex; zero on the boundary.
    stars: Vec<u8>,
    /// Features closer than `span` in the flat sheet but for the excluded, by their tiles.
    pub(super) near: Vec<Near>,
    /// Pairs closer than an arc of half the thickness in radius is long: cloth does not fold so tightly.
    excluded: [Vec<[u32; 2]>; 2],
    span: f64,
    thickness: f64,
}

impl Tiles {
    /// Cuts up a mesh of cloth of a thickness \[m\].
    pub fn new(mesh: &Mesh, thickness: f64) -> Self {
        let lengths = (0..mesh.edges.len()).map(|e| mesh.edge_length(e));
        let mean = lengths.sum::<f64>() / mesh.edges.len() as f64;
        let span = (SPAN * mean).max(LEAST_SPAN * thickness);
        let mut tiles = Self::cut(mesh, SIDE * mean);
        tiles.span = span;
        tiles.thickness = thickness;
        let flat: Vec<Vector3<f64>> = mesh.material.iter().map(|p| p.push(0.0)).collect();
        let mut fit = Fit::default();
        fit.over(&tiles, mesh, &flat);
        let found = Fits([&mut fit]).flat_pairs(&tiles, mesh, &flat, span);
        let least = std::f64::consts::FRAC_PI_2 * thickness;
        let mut near: BTreeMap<[u32; 2], Near> = BTreeMap::new();
        let tile_of_face = tile_of_face(&tiles.levels, tiles.near_level(), &tiles.owned);
        for (kind, found) in found.into_iter().enumerate() {
            for (pair, distance) in found {
                if distance < least {
                    tiles.excluded[kind].push(pair);
                    continue;
                }
                let [a, b] = tiles
                    .keepers(kind == 1, pair)
                    .map(|f| tile_of_face[f as usize]);
                let two = [a.min(b), a.max(b)];
                let of_two = near.entry(two).or_insert(Near {
                    tiles: two,
                    patches: tiles.patches_of(kind == 1, pair),
                    least: distance,
                    pairs: vec![],
                });
                of_two.least = of_two.least.min(distance);
                of_two.pairs.push((kind == 1, pair));
            }
        }
        tiles.near = near.into_values().collect();
        tiles
    }

    fn cut(mesh: &Mesh, side: f64) -> Self {
        let all = mesh.material.iter();
        let low = all
            .clone()
            .fold(Vector2::repeat(f64::INFINITY), |m, p| m.inf(p));
        let high = all.fold(Vector2::repeat(f64::NEG_INFINITY), |m, p| m.sup(p));
        let cells = |length: f64| ((length / side).ceil() as usize).max(1);
        let finest = Level {
            columns: cells(high.x - low.x),
            rows: cells(high.y - low.y),
        };
        let place = |p: Vector2<f64>| {
            let cell = |x: f64, most: usize| ((x.max(0.0) / side) as usize).min(most - 1);
            [
                cell(p.x - low.x, finest.columns),
                cell(p.y - low.y, finest.rows),
            ]
        };
        let corners = |f: usize| mesh.faces[f].map(|v| mesh.material[v as usize]);
        let mut owned = vec![vec![]; finest.len()];
        // How far a face reaches out of the tile that owns it.
        let mut overhang = Vector2::zeros();
        for f in 0..mesh.faces.len() {
            let [a, b, c] = corners(f);
            let tile = place((a + b + c) / 3.0);
            owned[finest.index(tile)].push(f as u32);
            let start = low + Vector2::new(tile[0] as f64, tile[1] as f64) * side;
            let end = start + Vector2::repeat(side);
            overhang = overhang.sup(&(start - a.inf(&b).inf(&c)));
            overhang = overhang.sup(&(a.sup(&b).sup(&c) - end));
        }
        let mut covering = vec![vec![]; finest.len()];
        let inward = inward_edges(mesh);
        let mut convex = vec![true; finest.len()];
        for f in 0..mesh.faces.len() {
            let [a, b, c] = corners(f);
            let first = place(a.inf(&b).inf(&c) - overhang);
            let last = place(a.sup(&b).sup(&c) + overhang);
            let rim = mesh.face_edges[f].iter().any(|&e| inward[e as usize]);
            let columns = first[0]..=last[0];
            let tiles = (first[1]..=last[1]).flat_map(|j| columns.clone().map(move |i| [i, j]));
            for tile in tiles.map(|tile| finest.index(tile)) {
                covering[tile].push(f as u32);
                convex[tile] &= !rim;
            }
        }
        if inward.contains(&true) {
            leave_out_gaps(finest, &covering, &mut convex);
        }
        let mut levels = vec![finest];
        while levels[levels.len() - 1].len() > 1 {
            let below = levels[levels.len() - 1];
            levels.push(Level {
                columns: below.columns.div_ceil(2),
                rows: below.rows.div_ceil(2),
            });
        }
        let enough = |level: &Level| level.len() <= MOST_PATCHES;
        let patch_level = levels.iter().position(enough).unwrap_or_default();
        let (patches, patch_of_face) = patches(mesh, &levels, patch_level, &owned);
        let (keepers, stars) = (keepers(mesh), stars(mesh));
        let [vertex_keeper, edge_keeper] = keepers;
        let covered = &levels[..=patch_level.min(MOST_COVERED)];
        Self {
            coverings: coverings(covered, covering, convex),
            levels,
            owned,
            shape: (0..mesh.faces.len())
                .map(|f| mesh.shape_gradients(f))
                .collect(),
            vertex_keeper,
            edge_keeper,
            patch_level,
            patches,
            patch_of_face,
            stars,
            near: vec![],
            excluded: Default::default(),
            span: 0.0,
            thickness: 0.0,
        }
    }

    /// What two points are apart in the flat sheet, at least, to be told from their surroundings \[m\].
    pub fn span(&self) -> f64 {
        self.span
    }

    /// Distance below which two layers touch \[m\].
    pub fn thickness(&self) -> f64 {
        self.thickness
    }

    /// The patches of a vertex and a face, or of two edges.
    pub(super) fn patches_of(&self, edges: bool, pair: [u32; 2]) -> [u32; 2] {
        let faces = self.keepers(edges, pair);
        faces.map(|f| self.patch_of_face[f as usize])
    }

    /// The faces that answer for a vertex and a face, or for two edges.
    fn keepers(&self, edges: bool, [first, second]: [u32; 2]) -> [u32; 2] {
        match edges {
            true => [first, second].map(|e| self.edge_keeper[e as usize]),
            false => [self.vertex_keeper[first as usize], second],
        }
    }

    /// The level by whose tiles features that are near in the flat sheet are grouped: none of them is larger than a patch.
    pub(super) fn near_level(&self) -> usize {
        NEAR_LEVEL.min(self.patch_level)
    }

    /// The patch that a tile of a level not above that of the patches lies in.
    pub(super) fn patch_of_tile(&self, level: usize, tile: usize) -> usize {
        self.above(level, tile, self.patch_level)
    }

    /// The tile of a level in which one of a level not above it lies.
    pub(super) fn above(&self, level: usize, tile: usize, higher: usize) -> usize {
        let (grid, up) = (self.levels[level], higher - level);
        let (i, j) = (tile % grid.columns, tile / grid.columns);
        self.levels[higher].index([i >> up, j >> up])
    }

    /// How many faces a vertex has around it, all around; none on the boundary.
    pub fn star(&self, vertex: u32) -> usize {
        usize::from(self.stars[vertex as usize])
    }

    /// Whether a vertex and a face, or two edges, the smaller first, are too close in the flat sheet to touch.
    pub fn excludes(&self, edges: bool, pair: [u32; 2]) -> bool {
        let excluded = &self.excluded[usize::from(edges)];
        !excluded.is_empty() && excluded.binary_search(&pair).is_ok()
    }
}

/// What covers the tiles of some levels, given what covers the finest.
fn coverings(levels: &[Level], finest: Vec<Vec<u32>>, convex: Vec<bool>) -> Vec<Vec<Covering>> {
    let whole = finest.into_iter().zip(convex);
    let mut coverings: Vec<Vec<Covering>> = vec![
        whole
            .map(|(faces, convex)| Covering { faces, convex })
            .collect(),
    ];
    for (below, grid) in levels.iter().zip(&levels[1..]) {
        let fine = &coverings[coverings.len() - 1];
        let of_tile = |t: usize| {
            let mut whole = Covering {
                faces: vec![],
                convex: true,
            };
            for child in children(*below, [t % grid.columns, t / grid.columns]) {
                let part = &fine[below.index(child)];
                whole.faces.extend(&part.faces);
                whole.convex &= part.convex;
            }
            whole.faces.sort_unstable();
            whole.faces.dedup();
            whole
        };
        coverings.push((0..grid.len()).map(of_tile).collect());
    }
    coverings
}

/// The tiles of a level as patches, and the patch of each face.
fn patches(
    mesh: &Mesh,
    levels: &[Level],
    level: usize,
    owned: &[Vec<u32>],
) -> (Vec<Patch>, Vec<u32>) {
    let of_face = tile_of_face(levels, level, owned);
    let mut of_patch = vec![vec![]; levels[level].len()];
    for (f, &patch) in of_face.iter().enumerate() {
        of_patch[patch as usize].push(f as u32);
    }
    let patches = of_patch.iter().map(|faces| Patch::new(mesh, faces));
    (patches.collect(), of_face)
}

/// The tile of a level that each face is in, given what the finest own.
fn tile_of_face(levels: &[Level], level: usize, owned: &[Vec<u32>]) -> Vec<u32> {
    let (finest, grid) = (levels[0], levels[level]);
    let mut tiles = vec![0; owned.iter().map(Vec::len).sum()];
    for (t, faces) in owned.iter().enumerate() {
        let (i, j) = (t % finest.columns, t / finest.columns);
        for &f in faces {
            tiles[f as usize] = grid.index([i >> level, j >> level]) as u32;
        }
    }
    tiles
}

fn keepers(mesh: &Mesh) -> [Vec<u32>; 2] {
    let mut vertices = vec![0; mesh.material.len()];
    let mut edges = vec![0; mesh.edges.len()];
    for f in (0..mesh.faces.len()).rev() {
        for k in 0..3 {
            vertices[mesh.faces[f][k] as usize] = f as u32;
            edges[mesh.face_edges[f][k] as usize] = f as u32;
        }
    }
    [vertices, edges]
}

fn stars(mesh: &Mesh) -> Vec<u8> {
    let mut stars = vec![0u8; mesh.material.len()];
    for &v in mesh.faces.iter().flatten() {
        stars[v as usize] = stars[v as usize].saturating_add(1);
    }
    for e in (0..mesh.edges.len()).filter(|&e| mesh.is_boundary(e)) {
        for v in mesh.edges[e] {
            stars[v as usize] = 0;
        }
    }
    stars
}
