//! What of the sheet may come near a surface before either has moved far.

use nalgebra::Vector3;
use parry3d_f64::bounding_volume::BoundingVolume;

use super::detect::CAP;
use super::{Point, Surface, box_around};
use crate::contact::layers::{point_to_face, segment_to_segment};
use crate::contact::nearby::Nearby;
use crate::sheet::Mesh;

/// A part of the sheet with what it may come near to, in a list of [`Candidates`].
#[derive(Clone, Debug)]
pub struct Row<const N: usize> {
    /// Index of the vertex, edge or face.
    pub feature: u32,
    /// Where its vertices stand among the vertices of [`Nearby`].
    pub slots: [u32; N],
    pub range: [u32; 2],
}

impl<const N: usize> Row<N> {
    fn new(feature: u32, before: usize, after: usize) -> Self {
        Self {
            feature,
            slots: [0; N],
            range: [before as u32, after as u32],
        }
    }

    /// What it may come near to.
    pub fn of<'a>(&self, list: &'a [u32]) -> &'a [u32] {
        &list[self.range[0] as usize..self.range[1] as usize]
    }
}

/// Parts of the sheet and of a surface that may come near to each other.
#[derive(Clone, Debug, Default)]
pub struct Candidates {
    /// Vertices with triangles, edges with edges that stand out, faces with vertices that stand out.
    pub vertices: Vec<Row<1>>,
    pub edges: Vec<Row<2>>,
    pub faces: Vec<Row<3>>,
    pub triangles: Vec<u32>,
    pub ridges: Vec<u32>,
    pub tips: Vec<u32>,
    /// Whether the sheet may be deep inside: then nothing is listed for the parts above, and all of the surface counts.
    pub deep: bool,
}

/// A sheet in the frame of a surface.
struct Sheet<'a> {
    mesh: &'a Mesh,
    local: &'a [Point],
}

impl Sheet<'_> {
    fn at<const N: usize>(&self, nodes: [u32; N]) -> [Point; N] {
        nodes.map(|v| self.local[v as usize])
    }
}

/// Fractions of an edge at which it is looked at where it may be deep inside.
pub const STATIONS: [f64; 3] = [0.25, 0.5, 0.75];

/// Collects what may come nearer than `reach` before anything has moved by `margin` against the surface. With `deep` the
/// sheet may be anywhere inside.
pub fn find(
    mesh: &Mesh,
    local: &[Vector3<f64>],
    surface: &Surface,
    (reach, margin, deep): (f64, f64, bool),
) -> Nearby {
    let sheet = Sheet { mesh, local };
    let candidates = match deep {
        true => inside(&sheet, surface, reach + margin),
        false => beside(&sheet, surface, reach + CAP + margin),
    };
    numbered(mesh, candidates)
}

fn beside(sheet: &Sheet, surface: &Surface, radius: f64) -> Candidates {
    let (mesh, body) = (sheet.mesh, &*surface.0);
    let mut found = Candidates::default();
    let mut looked_at = [
        vec![false; mesh.material.len()],
        vec![false; mesh.edges.len()],
    ];
    let mut near: Vec<u32> = vec![];
    let whole = body.tree.root_aabb();
    for (f, corners) in mesh.faces.iter().enumerate() {
        let places = sheet.at(*corners);
        let around = box_around(&places, radius);
        if !whole.intersects(&around) {
            continue;
        }
        near.clear();
        near.extend(body.tree.intersect_aabb(&around));
        if near.is_empty() {
            continue;
        }
        near.sort_unstable();
        for &v in corners {
            if !std::mem::replace(&mut looked_at[0][v as usize], true) {
                found.vertex(sheet, surface, (v, radius), &near);
            }
        }
        let mut ridges: Vec<u32> = near.iter().flat_map(|&t| body.sides[t as usize]).collect();
        ridges.retain(|&e| body.stands_out(e));
        ridges.sort_unstable();
        ridges.dedup();
        for e in mesh.face_edges[f] {
            if !std::mem::replace(&mut looked_at[1][e as usize], true) {
                found.edge(sheet, surface, (e, radius), &ridges);
            }
        }
        let mut tips: Vec<u32> = ridges
            .iter()
            .flat_map(|&e| body.edges[e as usize])
            .collect();
        tips.sort_unstable();
        tips.dedup();
        found.face(sheet, surface, (f as u32, radius), &tips);
    }
    found
}

impl Candidates {
    fn vertex(&mut self, sheet: &Sheet, surface: &Surface, (v, radius): (u32, f64), near: &[u32]) {
        let before = self.triangles.len();
        let [p] = sheet.at([v]);
        let close = |t: &&u32| (surface.nearest_of(**t, &p).1 - p).norm() < radius;
        self.triangles.extend(near.iter().filter(close));
        if self.triangles.len() > before {
            self.vertices
                .push(Row::new(v, before, self.triangles.len()));
        }
    }

    fn edge(&mut self, sheet: &Sheet, surface: &Surface, (e, radius): (u32, f64), near: &[u32]) {
        let (before, body) = (self.ridges.len(), &*surface.0);
        let [a, b] = sheet.at(sheet.mesh.edges[e as usize]);
        let close = |ridge: &&u32| {
            let [c, d] = body.edges[**ridge as usize].map(|v| &body.vertices[v as usize]);
            let [s, t] = segment_to_segment(&a, &b, c, d);
            (a + (b - a) * s - c - (d - c) * t).norm() < radius
        };
        self.ridges.extend(near.iter().filter(close));
        if self.ridges.len() > before {
            self.edges.push(Row::new(e, before, self.ridges.len()));
        }
    }

    fn face(&mut self, sheet: &Sheet, surface: &Surface, (f, radius): (u32, f64), near: &[u32]) {
        let before = self.tips.len();
        let [a, b, c] = sheet.at(sheet.mesh.faces[f as usize]);
        let close = |tip: &&u32| {
            let p = &surface.0.vertices[**tip as usize];
            let [u, v, w] = point_to_face(p, [&a, &b, &c]);
            (a * u + b * v + c * w - p).norm() < radius
        };
        self.tips.extend(near.iter().filter(close));
        if self.tips.len() > before {
            self.faces.push(Row::new(f, before, self.tips.len()));
        }
    }
}

/// All that is nearer than `reach`, or deeper, of a sheet that may be deep inside.
fn inside(sheet: &Sheet, surface: &Surface, reach: f64) -> Candidates {
    let mut found = Candidates {
        deep: true,
        ..Candidates::default()
    };
    each_station(sheet, surface, reach.max(0.0), |kind, feature, value| {
        let known = match kind {
            1 => found.edges.last().is_some_and(|row| row.feature == feature),
            _ => false,
        };
        if value >= reach || known {
            return;
        }
        match kind {
            0 => found.vertices.push(Row::new(feature, 0, 0)),
            1 => found.edges.push(Row::new(feature, 0, 0)),
            _ => found.faces.push(Row::new(feature, 0, 0)),
        }
    });
    found
}

/// How deep the middle of a sheet is inside a closed surface \[m\], not negative.
pub fn depth_inside(mesh: &Mesh, local: &[Vector3<f64>], surface: &Surface) -> f64 {
    let mut deepest: f64 = 0.0;
    let sheet = Sheet { mesh, local };
    each_station(&sheet, surface, 0.0, |_, _, value| {
        deepest = deepest.max(-value)
    });
    deepest
}

/// Distances of vertices, points of edges and middles of faces that are no farther than `reach` from the box around the
/// surface.
fn each_station(sheet: &Sheet, surface: &Surface, reach: f64, mut see: impl FnMut(u32, u32, f64)) {
    let whole = surface.0.tree.root_aabb();
    let mut look = |kind: u32, feature: usize, p: &Point| {
        if whole.intersects(&box_around([p], reach)) {
            see(kind, feature as u32, surface.distance(p).value);
        }
    };
    for (v, p) in sheet.local.iter().enumerate() {
        look(0, v, p);
    }
    for (e, ends) in sheet.mesh.edges.iter().enumerate() {
        let [a, b] = sheet.at(*ends);
        for t in STATIONS {
            look(1, e, &(a + (b - a) * t));
        }
    }
    for (f, corners) in sheet.mesh.faces.iter().enumerate() {
        let [a, b, c] = sheet.at(*corners);
        look(2, f, &((a + b + c) / 3.0));
    }
}

/// Puts candidates in order, and lists their vertices.
fn numbered(mesh: &Mesh, mut found: Candidates) -> Nearby {
    found.vertices.sort_unstable_by_key(|row| row.feature);
    found.edges.sort_unstable_by_key(|row| row.feature);
    let of_edges = found
        .edges
        .iter()
        .flat_map(|row| mesh.edges[row.feature as usize]);
    let of_faces = found
        .faces
        .iter()
        .flat_map(|row| mesh.faces[row.feature as usize]);
    let own = found.vertices.iter().map(|row| row.feature);
    let mut vertices: Vec<u32> = own.chain(of_edges).chain(of_faces).collect();
    vertices.sort_unstable();
    vertices.dedup();
    let slot = |v: u32| vertices.binary_search(&v).expect("every corner is listed") as u32;
    for row in &mut found.vertices {
        row.slots = [slot(row.feature)];
    }
    for row in &mut found.edges {
        row.slots = mesh.edges[row.feature as usize].map(slot);
    }
    for row in &mut found.faces {
        row.slots = mesh.faces[row.feature as usize].map(slot);
    }
    Nearby::of_surface(mesh.material.len(), vertices, found)
}
