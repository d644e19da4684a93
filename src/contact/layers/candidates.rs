//! What may touch while the sheet moves a little.

use nalgebra::Vector3;

use super::detect::{Scratch, edge_pair, vertex_pairs};
use super::features::{closer, features, nodes};
use super::fit::Fit;
use super::hunt::Fits;
use super::plane::separated;
use super::rooms::Rooms;
use super::{Pair, Tiles};
use crate::sheet::Mesh;

type Point = Vector3<f64>;

/// A vertex with the faces that it may touch, or two edges.
#[derive(Clone, Copy, Debug)]
pub enum Feature {
    /// A vertex and its faces in [`Candidates`].
    Vertex(u32, [u32; 2]),
    /// Two edges.
    Edges([u32; 2]),
}

/// Part of the margin that two patches keep, or are searched again.
const KEPT: f64 = 0.3;

/// A pair of features, with the travel before which it does not touch.
type Found = ([u32; 2], f64);

/// Pairs of features closer than a reach when they were collected, in a fixed order.
#[derive(Clone, Debug, Default)]
pub struct Candidates {
    fit: Fit,
    rooms: Rooms,
    found: [Vec<Found>; 2],
    faces: Vec<u32>,
    /// Each with the travel at which it may touch.
    features: Vec<(f64, Feature)>,
    scratch: Scratch,
    /// Bound on how much two points have come nearer since the collection \[m\].
    travel: f64,
    /// Travel for which the collection holds \[m\].
    limit: f64,
    /// Least distance of what was looked at last, at most the thickness \[m\].
    nearest: f64,
}

impl Candidates {
    /// Collects what is closer than the thickness and a margin.
    pub fn collect(&mut self, tiles: &Tiles, mesh: &Mesh, positions: &[Point], margin: f64) {
        self.rooms.reset(tiles, positions);
        self.found.iter_mut().for_each(Vec::clear);
        self.travel = 0.0;
        self.limit = margin;
        self.nearest = tiles.thickness();
        self.fit.over(tiles, mesh, positions);
        self.search(tiles, mesh, positions, margin);
    }

    /// Makes a collection that holds no longer hold again: patches that have come too near to each other since they
    /// were searched are searched at `positions`. Returns how many pairs that gave, if there were such patches.
    pub fn renew(
        &mut self,
        tiles: &Tiles,
        mesh: &Mesh,
        positions: &[Point],
        margin: f64,
    ) -> Option<usize> {
        let (stale, least) = self.rooms.judge(tiles, positions, KEPT * margin);
        if stale == 0 {
            self.limit = self.travel + least;
            return None;
        }
        self.keep_wakes();
        let rooms = &self.rooms;
        for (kind, list) in self.found.iter_mut().enumerate() {
            list.retain(|(pair, _)| !rooms.is_stale(tiles.patches_of(kind == 1, *pair)));
        }
        let kept = self.len();
        self.rooms.begin();
        let stale = self.rooms.stale_patches(tiles);
        self.fit.over_patches(tiles, mesh, positions, &stale);
        self.search(tiles, mesh, positions, margin);
        self.limit = self.travel + least.min(margin);
        Some(self.len() - kept)
    }

    /// Searches the patches that need it and adds what is closer than the thickness and a margin.
    fn search(&mut self, tiles: &Tiles, mesh: &Mesh, positions: &[Point], margin: f64) {
        let (thickness, travel) = (tiles.thickness(), self.travel);
        let reach = thickness + margin;
        let [vertices, edges] = &mut self.found;
        let mut look = |of_edges: bool, pair: [u32; 2]| {
            let Some(distance) = closer(mesh, positions, (of_edges, pair), reach) else {
                return;
            };
            if !tiles.excludes(of_edges, pair) {
                let list = if of_edges {
                    &mut *edges
                } else {
                    &mut *vertices
                };
                list.push((pair, travel + distance - thickness));
            }
        };
        let mut fits = Fits([&mut self.fit]);
        for b in 0..tiles.patches.len() as u32 {
            for a in 0..=b {
                if !self.rooms.is_stale([a, b]) {
                    continue;
                }
                let two = (tiles.patch_level, [a, b]);
                let clear = fits.near_faces_of((tiles, mesh), two, reach, |f, g| {
                    if !separated(mesh, positions, [f, g], reach) {
                        features(tiles, mesh, [f, g], &mut look);
                    }
                });
                self.rooms.enter([a, b], clear - thickness);
            }
        }
        let stale = tiles
            .near
            .iter()
            .filter(|near| self.rooms.is_stale(near.patches));
        for &(edges, pair) in stale.flat_map(|near| &near.pairs) {
            look(edges, pair);
        }
        for list in &mut self.found {
            // Stable: that is quick where what was kept, in order, is followed by little.
            list.sort_by_key(|(pair, _)| *pair);
            list.dedup_by_key(|(pair, _)| *pair);
        }
        self.group();
    }

    /// Hands what is known of the features back to their pairs.
    fn keep_wakes(&mut self) {
        let [vertices, edges] = &mut self.found;
        let mut edges = edges.iter_mut();
        for (wake, feature) in &self.features {
            let pairs = match feature {
                Feature::Vertex(_, [start, end]) => &mut vertices[*start as usize..*end as usize],
                Feature::Edges(_) => edges.next().map_or(&mut [][..], std::slice::from_mut),
            };
            for (_, of_pair) in pairs {
                *of_pair = of_pair.max(*wake);
            }
        }
    }

    fn group(&mut self) {
        self.faces.clear();
        self.features.clear();
        for group in self.found[0].chunk_by(|(a, _), (b, _)| a[0] == b[0]) {
            let start = self.faces.len() as u32;
            self.faces.extend(group.iter().map(|(pair, _)| pair[1]));
            let range = [start, self.faces.len() as u32];
            let first = |wake: f64, other: &Found| if other.1 < wake { other.1 } else { wake };
            let wake = group.iter().fold(f64::INFINITY, first);
            self.features
                .push((wake, Feature::Vertex(group[0].0[0], range)));
        }
        let edges = self.found[1].iter();
        self.features
            .extend(edges.map(|&(pair, wake)| (wake, Feature::Edges(pair))));
    }

    /// Lets points come nearer to each other by at most `approach` \[m\]; false if the collection does not hold for that.
    pub fn move_by(&mut self, approach: f64) -> bool {
        self.travel += approach;
        self.travel <= self.limit
    }

    /// Appends the pairs that touch.
    pub fn pairs(
        &mut self,
        tiles: &Tiles,
        mesh: &Mesh,
        positions: &[Point],
        found: &mut Vec<Pair>,
    ) {
        let reach = tiles.thickness();
        self.nearest = reach;
        for (wake, feature) in &mut self.features {
            if *wake > self.travel {
                continue;
            }
            let distance = match *feature {
                Feature::Vertex(v, [start, end]) => {
                    let faces = &self.faces[start as usize..end as usize];
                    let scratch = &mut self.scratch;
                    vertex_pairs((tiles, mesh), positions, (v, faces), reach, scratch, found)
                }
                Feature::Edges(pair) => {
                    let (distance, pair) = edge_pair(mesh, positions, pair, reach);
                    found.extend(pair);
                    distance
                }
            };
            *wake = self.travel + distance - reach;
            self.nearest = self.nearest.min(distance);
        }
    }

    /// Forgets how far apart the features were when they were last looked at.
    pub fn look_at_all(&mut self) {
        self.travel = 0.0;
        self.features.iter_mut().for_each(|(wake, _)| *wake = 0.0);
    }

    /// The vertices of each pair of features.
    pub fn nodes(&self, mesh: &Mesh) -> impl Iterator<Item = [u32; 4]> {
        let kinds = self.found.iter().enumerate();
        kinds.flat_map(move |(kind, list)| {
            list.iter()
                .map(move |&(pair, _)| nodes(mesh, kind == 1, pair))
        })
    }

    /// Whether nothing may touch while the collection holds.
    pub fn is_empty(&self) -> bool {
        self.features.is_empty()
    }

    /// How many pairs of features there are.
    pub fn len(&self) -> usize {
        self.found[0].len() + self.found[1].len()
    }

    /// Pairs of a vertex and a face, then of two edges.
    #[cfg(test)]
    pub fn found(&self) -> [Vec<[u32; 2]>; 2] {
        [0, 1].map(|kind: usize| self.found[kind].iter().map(|(pair, _)| *pair).collect())
    }

    /// Least distance of the features looked at last, at most the thickness \[m\].
    pub fn nearest(&self) -> f64 {
        self.nearest
    }

    /// Pairs of faces closer than the thickness, as the tiles tell, after a collection.
    pub fn near_faces(&mut self, (tiles, mesh): (&Tiles, &Mesh), found: &mut Vec<[u32; 2]>) {
        let add = |f: u32, g: u32| found.push([f, g]);
        Fits([&mut self.fit]).near_faces((tiles, mesh), tiles.thickness(), add);
    }
}
