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
    /// Curvatures 11, 22, 12 by corners 1 and 2 (relative to corner 0) and the three slopes.
    curvature: [[f64; 5]; 3],
}

impl Kernel {
    /// Lays out a model's faces.
    pub fn new(model: &Model) -> Self {
        let face = |f: usize| {
            let shape = model.mesh.shape_gradients(f);
            let operator = curvature_operator(&model.mesh, f);
            Face {
                nodes: model.bend.nodes(f),
                area: model.mesh.face_areas[f],
                shape: [shape[1].into(), shape[2].into()],
                curvature: std::array::from_fn(|c| std::array::from_fn(|k| operator[(c, k + 1)])),
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
            let [f1, f2] = stretch(face, &self.kernel.membrane, d1, d2);
            let bend = bend(
                face,
                &self.kernel.bending,
                [d1, d2, nodes[d], nodes[e], nodes[f]],
            );
            let (f1, f2) = (add(f1, bend[0]), add(f2, bend[1]));
            forces[a] = add(forces[a], add(f1, f2));
            forces[b] = sub(forces[b], f1);
            forces[c] = sub(forces[c], f2);
            forces[d] = sub(forces[d], bend[2]);
            forces[e] = sub(forces[e], bend[3]);
            forces[f] = sub(forces[f], bend[4]);
        }
    }
}

/// Derivative of the membrane energy by corners 1 and 2.
#[inline(always)]
fn stretch(face: &Face, c: &[f64; 4], d1: Lanes, d2: Lanes) -> [Lanes; 2] {
    let [[n1x, n1y], [n2x, n2y]] = face.shape;
    let r1 = add(scale(d1, n1x), scale(d2, n2x));
    let r2 = add(scale(d1, n1y), scale(d2, n2y));
    let half = 0.5 * face.area;
    let (e11, e22) = (half * (dot(r1, r1) - 1.0), half * (dot(r2, r2) - 1.0));
    let s11 = c[0] * e11 + c[2] * e22;
    let s22 = c[1] * e22 + c[2] * e11;
    let s12 = c[3] * face.area * dot(r1, r2);
    let along_warp = add(scale(r1, s11), scale(r2, s12));
    let along_weft = add(scale(r1, s12), scale(r2, s22));
    [
        add(scale(along_warp, n1x), scale(along_weft, n1y)),
        add(scale(along_warp, n2x), scale(along_weft, n2y)),
    ]
}

/// Derivative of the bending energy by corners 1 and 2 and the three slopes.
#[inline(always)]
fn bend(face: &Face, d: &[f64; 4], x: [Lanes; 5]) -> [Lanes; 5] {
    let curvature = |row: &[f64; 5]| {
        let corners = add(scale(x[0], row[0]), scale(x[1], row[1]));
        let slopes = add(
            add(scale(x[2], row[2]), scale(x[3], row[3])),
            scale(x[4], row[4]),
        );
        scale(add(corners, slopes), face.area)
    };
    let [c11, c22, c12] = &face.curvature;
    let k = [curvature(c11), curvature(c22), curvature(c12)];
    let moments = [
        add(scale(k[0], d[0]), scale(k[1], d[2])),
        add(scale(k[1], d[1]), scale(k[0], d[2])),
        scale(k[2], d[3]),
    ];
    let force = |i: usize| {
        let both = add(scale(moments[0], c11[i]), scale(moments[1], c22[i]));
        add(both, scale(moments[2], c12[i]))
    };
    [force(0), force(1), force(2), force(3), force(4)]
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

#[inline(always)]
pub fn dot(a: Lanes, b: Lanes) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}
