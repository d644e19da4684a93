//! The sheet as a surface to draw: refined for smooth light, with normals and its hem.

use std::collections::BTreeMap;

use nalgebra::{Vector2, Vector3};

/// What a surface is, as far as its paint goes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    /// The sheet: two colours, warp and weft lines.
    Cloth,
    /// An obstacle.
    Solid,
    /// A plane; fades out to paper white.
    Ground,
    /// The imagined floor that only takes shadows.
    Floor,
}

/// Triangles with normals and lines, in the world frame.
#[derive(Clone, Debug)]
pub(super) struct Surface {
    /// Paint.
    pub kind: Kind,
    /// Vertices \[m\].
    pub points: Vec<Vector3<f64>>,
    /// Unit vertex normals, on the side from which faces are counter-clockwise.
    pub normals: Vec<Vector3<f64>>,
    /// Vertices of each triangle.
    pub faces: Vec<[u32; 3]>,
    /// Warp and weft coordinates \[m\] of each vertex, or nothing.
    pub material: Vec<Vector2<f64>>,
    /// Share of the paint at each vertex, the rest is paper white; empty means 1.
    pub cover: Vec<f64>,
    /// Edges drawn as lines \[m\].
    pub lines: Vec<[Vector3<f64>; 2]>,
}

/// Refines the sheet until its edges are shorter than `edge`, two times at most.
pub(super) fn cloth(
    faces: &[[u32; 3]],
    positions: &[Vector3<f64>],
    material: &[Vector2<f64>],
    edge: f64,
) -> Surface {
    let mut surface = Surface {
        kind: Kind::Cloth,
        points: positions.to_vec(),
        normals: normals(positions, faces),
        faces: faces.to_vec(),
        material: material.to_vec(),
        cover: vec![],
        lines: vec![],
    };
    surface.lines = hem(&surface);
    for _ in 0..2 {
        if mean_edge(&surface) < edge {
            break;
        }
        refine(&mut surface);
    }
    surface
}

/// Area-weighted vertex normals.
pub(super) fn normals(points: &[Vector3<f64>], faces: &[[u32; 3]]) -> Vec<Vector3<f64>> {
    let mut normals = vec![Vector3::zeros(); points.len()];
    for face in faces {
        let [a, b, c] = face.map(|v| points[v as usize]);
        let n = (b - a).cross(&(c - a));
        for v in face {
            normals[*v as usize] += n;
        }
    }
    normals
        .iter()
        .map(|n| n.try_normalize(0.0).unwrap_or_else(Vector3::z))
        .collect()
}

fn mean_edge(surface: &Surface) -> f64 {
    let total: f64 = surface
        .faces
        .iter()
        .map(|f| (surface.points[f[0] as usize] - surface.points[f[1] as usize]).norm())
        .sum();
    total / surface.faces.len().max(1) as f64
}

/// Edges with one face.
fn hem(surface: &Surface) -> Vec<[Vector3<f64>; 2]> {
    let mut uses: BTreeMap<[u32; 2], u32> = BTreeMap::new();
    for f in &surface.faces {
        for k in 0..3 {
            let (a, b) = (f[k], f[(k + 1) % 3]);
            *uses.entry([a.min(b), a.max(b)]).or_default() += 1;
        }
    }
    let single = uses.iter().filter(|(_, n)| **n == 1);
    single
        .map(|(e, _)| e.map(|v| surface.points[v as usize]))
        .collect()
}

/// Splits every triangle into four; the shape stays, only light is evaluated on more points.
fn refine(surface: &mut Surface) {
    let mut middles: BTreeMap<[u32; 2], u32> = BTreeMap::new();
    let mut faces = Vec::with_capacity(4 * surface.faces.len());
    for f in std::mem::take(&mut surface.faces) {
        let m = [0, 1, 2].map(|k| {
            let (a, b) = (f[k], f[(k + 1) % 3]);
            *middles
                .entry([a.min(b), a.max(b)])
                .or_insert_with(|| split(surface, a, b))
        });
        faces.push([f[0], m[0], m[2]]);
        faces.push([m[0], f[1], m[1]]);
        faces.push([m[2], m[1], f[2]]);
        faces.push(m);
    }
    surface.faces = faces;
}

fn split(surface: &mut Surface, a: u32, b: u32) -> u32 {
    let (a, b) = (a as usize, b as usize);
    surface
        .points
        .push(0.5 * (surface.points[a] + surface.points[b]));
    let normal = surface.normals[a] + surface.normals[b];
    surface
        .normals
        .push(normal.try_normalize(1e-9).unwrap_or(surface.normals[a]));
    if !surface.material.is_empty() {
        surface
            .material
            .push(0.5 * (surface.material[a] + surface.material[b]));
    }
    surface.points.len() as u32 - 1
}
