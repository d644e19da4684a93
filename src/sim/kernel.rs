//! Stretch and bend forces in one pass over the faces, for schemes that need nothing else.
//!
//! The same energies as `physics::stretch` and `physics::bend` (a test holds them together), laid out for speed:
//! a node is four lanes (x, y, z and a zero), so each line below is one vector instruction.

use super::lanes::{Four, Lanes, Plain};
use super::model::Model;
use crate::math::sparse::NO_SLOT;
use crate::physics::Potential;

/// Constants of the faces.
pub struct Kernel {
    faces: Vec<Face>,
    /// C11, C22, C12, C66 \[N/m\].
    membrane: [f64; 4],
    #[cfg(target_arch = "x86_64")]
    avx: Option<pulp::x86::V3>,
}

/// With g_k the gradient of corner k's shape function, Morley's curvature is the sum over the sides of
/// 2 t_k n_k n_k, where n_k = -g_k/|g_k| and t_k is the slope times |g_k| (with the side's sign) plus g_k · ∇r:
/// how much the slope on the side differs from that of the flat triangle.
struct Face {
    nodes: [u32; 6],
    area: f64,
    /// g_1 and g_2 \[1/m\].
    shape: [[f64; 2]; 2],
    /// |g_k| with the sign of the side's normal \[1/m\].
    tilt: [f64; 3],
    /// Bending energy by t_0, t_1, t_2: second derivatives 00, 11, 22, 12, 02, 01 \[N·m³\].
    bending: [f64; 6],
}

impl Face {
    fn new(model: &Model, f: usize) -> Self {
        let mesh = &model.mesh;
        let shape = mesh.shape_gradients(f);
        let tilt = [0, 1, 2].map(|k| {
            let outward = -shape[k].normalize();
            let normal = mesh.edge_normal(mesh.face_edges[f][k] as usize);
            shape[k].norm() * normal.dot(&outward).signum()
        });
        let by_slopes = model.bend.matrix(f);
        let pairs = [(0, 0), (1, 1), (2, 2), (1, 2), (0, 2), (0, 1)];
        let bending = pairs.map(|(k, l)| by_slopes[(3 + k, 3 + l)] / (tilt[k] * tilt[l]));
        Self {
            nodes: model.bend.nodes(f),
            area: mesh.face_areas[f],
            shape: [shape[1].into(), shape[2].into()],
            tilt,
            bending,
        }
    }
}

impl Kernel {
    /// Lays out a model's faces.
    pub fn new(model: &Model) -> Self {
        let c = model.fabric.membrane();
        let moves = moving(model);
        let faces = (0..model.mesh.faces.len()).filter(|&f| {
            let nodes = model.bend.nodes(f);
            nodes.iter().any(|&node| moves[node as usize])
        });
        Self {
            faces: faces.map(|f| Face::new(model, f)).collect(),
            membrane: [c.c11, c.c22, c.c12, c.c66],
            #[cfg(target_arch = "x86_64")]
            avx: pulp::x86::V3::try_new(),
        }
    }

    /// Subtracts the energies' derivative at `nodes` from `forces` \[N, N·m\].
    pub fn add_forces(&self, nodes: &[Lanes], forces: &mut [Lanes]) {
        #[cfg(target_arch = "x86_64")]
        if let Some(four) = self.avx {
            let pass = Pass {
                four,
                kernel: self,
                nodes,
                forces,
            };
            return pulp::Simd::vectorize(four, pass);
        }
        pulp::Arch::new().dispatch(Pass {
            four: Plain,
            kernel: self,
            nodes,
            forces,
        });
    }
}

/// Nodes that are free, or that a support moves; a face without one never changes, and its forces act on supports that do
/// no work.
fn moving(model: &Model) -> Vec<bool> {
    let free = |index: &[u32; 3]| *index != [NO_SLOT; 3];
    let mut moves: Vec<bool> = model.dofs.index.iter().map(free).collect();
    for (node, _) in model.carried.iter().flat_map(|carried| carried.held()) {
        moves[node] = true;
    }
    moves
}

/// One pass over the faces.
struct Pass<'a, F> {
    four: F,
    kernel: &'a Kernel,
    nodes: &'a [Lanes],
    forces: &'a mut [Lanes],
}

// No closures below: the compiler would not give them the vector unit's instructions.
impl<F: Four> pulp::WithSimd for Pass<'_, F> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: pulp::Simd>(self, _: S) {
        let (u, x, forces) = (self.four, self.nodes, self.forces);
        for face in &self.kernel.faces {
            let [a, b, c, d, e, f] = face.nodes;
            let [a, b, c] = [a as usize, b as usize, c as usize];
            let [d, e, f] = [d as usize, e as usize, f as usize];
            let [g1, g2] = &face.shape;
            let origin = u.load(&x[a]);
            let (d1, d2) = (u.sub(u.load(&x[b]), origin), u.sub(u.load(&x[c]), origin));
            let r1 = u.plus(d2, g2[0], u.scale(d1, g1[0]));
            let r2 = u.plus(d2, g2[1], u.scale(d1, g1[1]));
            let slopes = [u.load(&x[d]), u.load(&x[e]), u.load(&x[f])];
            let [m0, m1, m2] = moments(u, face, r1, r2, slopes);
            let (p1, p2) = (u.sub(m1, m0), u.sub(m2, m0));
            let [s11, s22, s12] = stress(u, &self.kernel.membrane, face.area, r1, r2);
            let membrane = u.plus(r2, s12, u.scale(r1, s11));
            let across_warp = u.plus(p2, g2[0], u.plus(p1, g1[0], membrane));
            let membrane = u.plus(r2, s22, u.scale(r1, s12));
            let across_weft = u.plus(p2, g2[1], u.plus(p1, g1[1], membrane));
            let f1 = u.plus(across_weft, g1[1], u.scale(across_warp, g1[0]));
            let f2 = u.plus(across_weft, g2[1], u.scale(across_warp, g2[0]));
            forces[a] = u.store(u.add(u.load(&forces[a]), u.add(f1, f2)));
            forces[b] = u.store(u.sub(u.load(&forces[b]), f1));
            forces[c] = u.store(u.sub(u.load(&forces[c]), f2));
            forces[d] = u.store(u.sub(u.load(&forces[d]), u.scale(m0, face.tilt[0])));
            forces[e] = u.store(u.sub(u.load(&forces[e]), u.scale(m1, face.tilt[1])));
            forces[f] = u.store(u.sub(u.load(&forces[f]), u.scale(m2, face.tilt[2])));
        }
    }
}

/// Membrane stress 11, 22, 12 times the area \[N·m\].
#[inline(always)]
fn stress<F: Four>(u: F, c: &[f64; 4], area: f64, r1: F::Vector, r2: F::Vector) -> [f64; 3] {
    let half = 0.5 * area;
    let (e11, e22) = (half * (u.dot(r1, r1) - 1.0), half * (u.dot(r2, r2) - 1.0));
    [
        c[0] * e11 + c[2] * e22,
        c[1] * e22 + c[2] * e11,
        c[3] * area * u.dot(r1, r2),
    ]
}

/// Derivative of the bending energy by t_0, t_1, t_2.
#[inline(always)]
fn moments<F: Four>(
    u: F,
    face: &Face,
    r1: F::Vector,
    r2: F::Vector,
    slopes: [F::Vector; 3],
) -> [F::Vector; 3] {
    let [g1, g2] = &face.shape;
    let a1 = u.plus(r2, g1[1], u.scale(r1, g1[0]));
    let a2 = u.plus(r2, g2[1], u.scale(r1, g2[0]));
    let t0 = u.sub(u.scale(slopes[0], face.tilt[0]), u.add(a1, a2));
    let t1 = u.plus(slopes[1], face.tilt[1], a1);
    let t2 = u.plus(slopes[2], face.tilt[2], a2);
    let [w00, w11, w22, w12, w02, w01] = face.bending;
    [
        u.plus(t2, w02, u.plus(t1, w01, u.scale(t0, w00))),
        u.plus(t2, w12, u.plus(t1, w11, u.scale(t0, w01))),
        u.plus(t2, w22, u.plus(t1, w12, u.scale(t0, w02))),
    ]
}
