//! Stretch and bend forces in one pass over the faces, for schemes that need nothing else.
//!
//! The same energies as `physics::stretch` and `physics::bend` (a test holds them together), laid out for speed:
//! a node is four lanes (x, y, z and a zero), so each line below is one vector instruction.

use nalgebra::Vector3;

use super::model::Model;
use crate::physics::Potential;
use crate::physics::bend::curvature_operator;

/// A node in four lanes; the last is zero.
pub type Lanes = [f64; 4];

const ZERO: Lanes = [0.0; 4];

/// Constants of the faces.
pub struct Kernel {
    faces: Vec<Face>,
    /// C11, C22, C12, C66 \[N/m\].
    membrane: [f64; 4],
    /// D11, D22, D12, 4 D66 \[N·m\].
    bending: [f64; 4],
    arch: pulp::Arch,
}

struct Face {
    nodes: [u32; 6],
    area: f64,
    /// Shape gradients of corners 1 and 2 \[1/m\].
    shape: [[f64; 2]; 2],
    /// Curvatures 11, 22, 12, times the root of the area, by corners 1 and 2 (relative to corner 0) and the three
    /// slopes.
    curvature: [[f64; 5]; 3],
}

impl Kernel {
    /// Lays out a model's faces.
    pub fn new(model: &Model) -> Self {
        let face = |f: usize| {
            let shape = model.mesh.shape_gradients(f);
            let operator = curvature_operator(&model.mesh, f);
            let root = model.mesh.face_areas[f].sqrt();
            Face {
                nodes: model.bend.nodes(f),
                area: model.mesh.face_areas[f],
                shape: [shape[1].into(), shape[2].into()],
                curvature: [0, 1, 2].map(|c| [1, 2, 3, 4, 5].map(|k| operator[(c, k)] * root)),
            }
        };
        let (c, d) = (model.fabric.membrane(), model.fabric.bending());
        Self {
            faces: (0..model.mesh.faces.len()).map(face).collect(),
            membrane: [c.c11, c.c22, c.c12, c.c66],
            bending: [d.c11, d.c22, d.c12, 4.0 * d.c66],
            arch: pulp::Arch::new(),
        }
    }

    /// Subtracts the energies' derivative at `nodes` from `forces` \[N, N·m\].
    pub fn add_forces(&self, nodes: &[Lanes], forces: &mut [Lanes]) {
        self.arch.dispatch(Pass {
            kernel: self,
            nodes,
            forces,
        });
    }
}

/// One pass over the faces, compiled for the vector unit that the processor has.
struct Pass<'a> {
    kernel: &'a Kernel,
    nodes: &'a [Lanes],
    forces: &'a mut [Lanes],
}

impl pulp::WithSimd for Pass<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: pulp::Simd>(self, _: S) {
        let (nodes, forces) = (self.nodes, self.forces);
        for face in &self.kernel.faces {
            let [a, b, c, d, e, f] = face.nodes;
            let [a, b, c] = [a as usize, b as usize, c as usize];
            let [d, e, f] = [d as usize, e as usize, f as usize];
            let (d1, d2) = (sub(nodes[b], nodes[a]), sub(nodes[c], nodes[a]));
            let stress = stretch(face, &self.kernel.membrane, d1, d2);
            let sides = [d1, d2, nodes[d], nodes[e], nodes[f]];
            let moments = bend(face, &self.kernel.bending, sides);
            let f1 = bent(face, &moments, 0, across(face, &stress, 0));
            let f2 = bent(face, &moments, 1, across(face, &stress, 1));
            forces[a] = add(forces[a], add(f1, f2));
            forces[b] = sub(forces[b], f1);
            forces[c] = sub(forces[c], f2);
            forces[d] = sub(forces[d], bent(face, &moments, 2, ZERO));
            forces[e] = sub(forces[e], bent(face, &moments, 3, ZERO));
            forces[f] = sub(forces[f], bent(face, &moments, 4, ZERO));
        }
    }
}

// No closures below: the compiler would not give them the vector unit's instructions.

/// Membrane force across the warp and across the weft, times the area.
#[inline(always)]
fn stretch(face: &Face, c: &[f64; 4], d1: Lanes, d2: Lanes) -> [Lanes; 2] {
    let [[n1x, n1y], [n2x, n2y]] = face.shape;
    let r1 = plus(d2, n2x, scale(d1, n1x));
    let r2 = plus(d2, n2y, scale(d1, n1y));
    let half = 0.5 * face.area;
    let (e11, e22) = (half * (dot(r1, r1) - 1.0), half * (dot(r2, r2) - 1.0));
    let s11 = c[0] * e11 + c[2] * e22;
    let s22 = c[1] * e22 + c[2] * e11;
    let s12 = c[3] * face.area * dot(r1, r2);
    [plus(r2, s12, scale(r1, s11)), plus(r2, s22, scale(r1, s12))]
}

/// Moments 11, 22, 12, times the root of the area, from corners 1 and 2 and the three slopes.
#[inline(always)]
fn bend(face: &Face, d: &[f64; 4], x: [Lanes; 5]) -> [Lanes; 3] {
    let k11 = curvature(&face.curvature[0], &x);
    let k22 = curvature(&face.curvature[1], &x);
    let k12 = curvature(&face.curvature[2], &x);
    [
        plus(k22, d[2], scale(k11, d[0])),
        plus(k11, d[2], scale(k22, d[1])),
        scale(k12, d[3]),
    ]
}

#[inline(always)]
fn curvature(row: &[f64; 5], x: &[Lanes; 5]) -> Lanes {
    let corners = plus(x[1], row[1], scale(x[0], row[0]));
    let slopes = plus(x[3], row[3], scale(x[2], row[2]));
    add(plus(x[4], row[4], corners), slopes)
}

/// What the membrane does to corner 1 or 2.
#[inline(always)]
fn across(face: &Face, stress: &[Lanes; 2], corner: usize) -> Lanes {
    let [along_warp, along_weft] = face.shape[corner];
    plus(stress[1], along_weft, scale(stress[0], along_warp))
}

/// A force with what the moments do to corner 1 or 2 or to a slope.
#[inline(always)]
fn bent(face: &Face, moments: &[Lanes; 3], node: usize, force: Lanes) -> Lanes {
    let [c11, c22, c12] = &face.curvature;
    let both = plus(moments[1], c22[node], plus(moments[0], c11[node], force));
    plus(moments[2], c12[node], both)
}

/// Three components in four lanes.
pub fn lanes(v: &Vector3<f64>) -> Lanes {
    [v.x, v.y, v.z, 0.0]
}

/// The three components of four lanes.
pub fn vector(v: &Lanes) -> Vector3<f64> {
    Vector3::new(v[0], v[1], v[2])
}

#[inline(always)]
pub fn add(a: Lanes, b: Lanes) -> Lanes {
    [a[0] + b[0], a[1] + b[1], a[2] + b[2], a[3] + b[3]]
}

#[inline(always)]
pub fn sub(a: Lanes, b: Lanes) -> Lanes {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2], a[3] - b[3]]
}

#[inline(always)]
pub fn scale(a: Lanes, s: f64) -> Lanes {
    [a[0] * s, a[1] * s, a[2] * s, a[3] * s]
}

/// a s + b.
#[inline(always)]
fn plus(a: Lanes, s: f64, b: Lanes) -> Lanes {
    add(scale(a, s), b)
}

#[inline(always)]
pub fn dot(a: Lanes, b: Lanes) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// Moves the nodes and returns the largest speed of a vertex \[m/s\].
pub fn drift(nodes: &mut [Lanes], rates: &[Lanes], dt: f64, vertices: usize) -> f64 {
    for (x, rate) in nodes.iter_mut().zip(rates) {
        *x = add(*x, scale(*rate, dt));
    }
    let mut fastest = 0.0;
    for rate in &rates[..vertices] {
        let square = dot(*rate, *rate);
        if square > fastest {
            fastest = square;
        }
    }
    fastest.sqrt()
}
