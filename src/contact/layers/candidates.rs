//! What may touch while the sheet moves a little.

use nalgebra::Vector3;

use super::detect::{Scratch, edge_pair, vertex_pairs};
use super::fit::{Fit, closer, features, nodes};
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

/// Pairs of features closer than a reach when they were collected, in a fixed order.
#[derive(Clone, Debug, Default)]
pub struct Candidates {
    fit: Fit,
    found: [Vec<[u32; 2]>; 2],
    faces: Vec<u32>,
    /// Each with the travel at which it may touch.
    features: Vec<(f64, Feature)>,
    scratch: Scratch,
    /// Bound on how much two points have come nearer since the collection \[m\].
    travel: f64,
    margin: f64,
    /// Least distance of what was looked at last, at most the thickness \[m\].
    nearest: f64,
}

impl Candidates {
    /// Collects what is closer than the thickness and a margin.
    pub fn collect(&mut self, tiles: &Tiles, mesh: &Mesh, positions: &[Point], margin: f64) {
        let reach = tiles.thickness() + margin;
        self.fit.over(tiles, mesh, &[positions]);
        let [vertices, edges] = &mut self.found;
        vertices.clear();
        edges.clear();
        let mut look = |of_edges: bool, pair: [u32; 2]| {
            let near = closer(mesh, positions, (of_edges, pair), reach).is_some();
            if near && !tiles.excludes(of_edges, pair) {
                let list = if of_edges {
                    &mut *edges
                } else {
                    &mut *vertices
                };
                list.push(pair);
            }
        };
        self.fit.near_faces(tiles, reach, |f, g| {
            features(tiles, mesh, [f, g], &mut look)
        });
        for (kind, list) in tiles.near.iter().enumerate() {
            list.iter().for_each(|&pair| look(kind == 1, pair));
        }
        for list in &mut self.found {
            list.sort_unstable();
            list.dedup();
        }
        self.group();
        self.travel = 0.0;
        self.margin = margin;
        self.nearest = tiles.thickness();
    }

    fn group(&mut self) {
        self.faces.clear();
        self.features.clear();
        for group in self.found[0].chunk_by(|a, b| a[0] == b[0]) {
            let start = self.faces.len() as u32;
            self.faces.extend(group.iter().map(|pair| pair[1]));
            let range = [start, self.faces.len() as u32];
            self.features
                .push((0.0, Feature::Vertex(group[0][0], range)));
        }
        let edges = self.found[1].iter();
        self.features
            .extend(edges.map(|&pair| (0.0, Feature::Edges(pair))));
    }

    /// Lets points come nearer to each other by at most `approach` \[m\]; false if the collection does not hold for that.
    pub fn move_by(&mut self, approach: f64) -> bool {
        self.travel += approach;
        self.travel <= self.margin
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
            list.iter().map(move |&pair| nodes(mesh, kind == 1, pair))
        })
    }

    /// Whether nothing may touch before the next collection.
    pub fn is_empty(&self) -> bool {
        self.features.is_empty()
    }

    /// How many pairs of features there are.
    pub fn len(&self) -> usize {
        self.found[0].len() + self.found[1].len()
    }

    /// Pairs of a vertex and a face, then of two edges.
    pub fn found(&self) -> &[Vec<[u32; 2]>; 2] {
        &self.found
    }

    /// Least distance of the features looked at last, at most the thickness \[m\].
    pub fn nearest(&self) -> f64 {
        self.nearest
    }

    /// Pairs of faces closer than the thickness, as the tiles tell, after a collection.
    pub fn near_faces(&self, tiles: &Tiles, found: &mut Vec<[u32; 2]>) {
        let add = |f: u32, g: u32| found.push([f, g]);
        self.fit.near_faces(tiles, tiles.thickness(), add);
    }
}
