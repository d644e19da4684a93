//! Stretch and bend forces in one pass over the faces, for schemes that need nothing else.
//!
//! The same energies as `physics::stretch` and `physics::bend` (a test holds them together), laid out for speed:
//! four faces stand side by side, so each line below is a few vector instructions.

mod order;
mod pass;

use nalgebra::{Matrix2, Matrix3, Vector2};
use pulp::Simd;
#[cfg(target_arch = "x86_64")]
use pulp::x86::{V3, V4};

use super::lanes::Lanes;
use super::model::Model;
use super::wide::Plain;
use crate::physics::Potential;
use order::pack;
pub use order::{along, order};
use pass::Pass;

/// Constants of the faces.
#[derive(Default)]
pub struct Kernel {
    faces: Vec<Faces>,
    unit: Unit,
}

/// The vector unit that there is.
#[derive(Clone, Copy)]
enum Unit {
    /// AVX2's instructions on twice the registers: the same bits, and nothing is put aside.
    #[cfg(target_arch = "x86_64")]
    Avx512(V4),
    #[cfg(target_arch = "x86_64")]
    Avx2(V3),
    Plain,
}

impl Default for Unit {
    fn default() -> Self {
        #[cfg(target_arch = "x86_64")]
        if let Some(unit) = V4::try_new() {
            return Self::Avx512(unit);
        }
        #[cfg(target_arch = "x86_64")]
        if let Some(unit) = V3::try_new() {
            return Self::Avx2(unit);
        }
        Self::Plain
    }
}

/// With d_1 and d_2 the sides from corner 0 to corners 1 and 2, the membrane energy is 1/2 E Q E by the strains
/// E = (d_1·d_1 - l_1²)/2, (d_2·d_2 - l_2²)/2, d_1·d_2 - l_12.
///
/// With g_k the gradient of corner k's shape function, Morley's curvature is the sum over the sides of 2 |g_k| t_k n_k n_k,
/// where n_k = -g_k/|g_k| and t_k (with the side's sign) is the slope less n_k · ∇r: how much the slope on the side
/// differs from that of the flat triangle, whose ∇r is d_1 g_1 + d_2 g_2.
struct Face {
    nodes: [u32; 6],
    /// l_1², l_2², l_12 \[m²\].
    rest: [f64; 3],
    /// Q 11, 22, 12 by 12, 11 22, 22 by 12, 11 by 12 \[N/m³\].
    membrane: [f64; 6],
    /// By side: what of d_1 and d_2 is taken off the slope \[1/m\].
    flat: [[f64; 2]; 3],
    /// Bending energy by t_0, t_1, t_2: second derivatives 00, 11, 22, 12, 02, 01 \[N·m\].
    bending: [f64; 6],
}

impl Face {
    fn new(model: &Model, f: usize, local: impl Fn(u32) -> u32) -> Self {
        let mesh = &model.mesh;
        let shape = mesh.shape_gradients(f);
        let [_, g1, g2] = shape;
        let flat = [0, 1, 2].map(|k| {
            let outward = -shape[k].normalize();
            let normal = mesh.edge_normal(mesh.face_edges[f][k] as usize);
            let tilt = shape[k].norm() * normal.dot(&outward).signum();
            [g1, g2].map(|g| -shape[k].dot(&g) / tilt)
        });
        let by_slopes = model.bend.matrix(f);
        let pairs = [(0, 0), (1, 1), (2, 2), (1, 2), (0, 2), (0, 1)];
        Self {
            nodes: model.bend.nodes(f).map(local),
            rest: rest(&g1, &g2),
            membrane: membrane(model, f, &g1, &g2),
            flat,
            bending: pairs.map(|(k, l)| by_slopes[(3 + k, 3 + l)]),
        }
    }
}

/// Squares and product of the sides in the flat sheet, whose gradients are dual to them.
fn rest(g1: &Vector2<f64>, g2: &Vector2<f64>) -> [f64; 3] {
    let sides = Matrix2::from_columns(&[*g1, *g2]).transpose();
    let sides = sides.try_inverse().unwrap_or_default();
    let metric = sides.transpose() * sides;
    [metric.m11, metric.m22, metric.m12]
}

/// Q of [`Face`]: the law's matrix for the strains along the sides, from those along warp and weft.
fn membrane(model: &Model, f: usize, g1: &Vector2<f64>, g2: &Vector2<f64>) -> [f64; 6] {
    let c = model.fabric.membrane();
    let law = Matrix3::new(c.c11, c.c12, 0.0, c.c12, c.c22, 0.0, 0.0, 0.0, c.c66);
    let strain = Matrix3::new(
        g1.x * g1.x,
        g2.x * g2.x,
        g1.x * g2.x,
        g1.y * g1.y,
        g2.y * g2.y,
        g1.y * g2.y,
        2.0 * g1.x * g1.y,
        2.0 * g2.x * g2.y,
        g1.x * g2.y + g2.x * g1.y,
    );
    let q = strain.transpose() * law * strain * model.mesh.face_areas[f];
    [q.m11, q.m22, q.m33, q.m12, q.m23, q.m13]
}

/// Four faces, number by number. Where there are fewer, the others have no constants and so no forces.
#[derive(Default)]
#[repr(align(64))]
struct Faces {
    nodes: [[u32; 4]; 6],
    rest: [[f64; 4]; 3],
    membrane: [[f64; 4]; 6],
    flat: [[[f64; 4]; 2]; 3],
    bending: [[f64; 4]; 6],
}

impl Faces {
    fn set(&mut self, i: usize, face: &Face) {
        (0..6).for_each(|k| self.nodes[k][i] = face.nodes[k]);
        (0..3).for_each(|k| self.rest[k][i] = face.rest[k]);
        (0..6).for_each(|k| self.membrane[k][i] = face.membrane[k]);
        (0..3).for_each(|k| (0..2).for_each(|d| self.flat[k][d][i] = face.flat[k][d]));
        (0..6).for_each(|k| self.bending[k][i] = face.bending[k]);
    }
}

impl Kernel {
    /// Lays out a model's faces.
    pub fn new(model: &Model) -> Self {
        Self::of(model, &order(model), |node| node)
    }

    /// Lays out some faces, in their [`order`], on nodes that `local` numbers anew. Forces on a node come to the same bits
    /// as from all faces, if all of the node's are there.
    pub fn of(model: &Model, faces: &[usize], local: impl Fn(u32) -> u32) -> Self {
        let faces: Vec<Face> = faces.iter().map(|&f| Face::new(model, f, &local)).collect();
        let fours = pack(faces.iter().map(|face| face.nodes));
        let mut laid = Self::default();
        for (face, (four, place)) in faces.iter().zip(fours) {
            if laid.faces.len() <= four {
                laid.faces.resize_with(four + 1, Faces::default);
            }
            laid.faces[four].set(place, face);
        }
        laid
    }

    /// Subtracts the energies' derivative at `nodes` from `forces` \[N, N·m\].
    pub fn add_forces(&self, nodes: &[Lanes], forces: &mut [Lanes]) {
        let faces = &self.faces;
        match self.unit {
            #[cfg(target_arch = "x86_64")]
            Unit::Avx512(unit) => Simd::vectorize(unit, Pass::new(*unit, faces, nodes, forces)),
            #[cfg(target_arch = "x86_64")]
            Unit::Avx2(unit) => Simd::vectorize(unit, Pass::new(unit, faces, nodes, forces)),
            Unit::Plain => pulp::Arch::new().dispatch(Pass::new(Plain, faces, nodes, forces)),
        }
    }
}
