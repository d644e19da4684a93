//! Sums of the terms over the sheet: forces, tangent, energies. Sums run in a fixed order whatever the threads.

use nalgebra::{SMatrix, Vector3};
use rayon::prelude::*;

use super::dofs::Dofs;
use super::model::Model;
use crate::math::sparse::{NO_SLOT, Pattern};
use crate::physics::{Gradient, Hessian, Nodes, Potential};

/// Entries of the lower triangle of a 9 x 9 face matrix.
const FACE_ENTRIES: usize = 45;

/// Where each face's entries go, and the part of the tangent that never changes.
pub struct Assembly {
    /// Slots of the lower triangle of each face's vertex block, shape \[faces\]\[45\].
    face_slots: Vec<[u32; FACE_ENTRIES]>,
    /// Bending part of the tangent.
    bending: Vec<f64>,
    /// Slots of the diagonal of each vertex, shape \[vertices\]\[3\].
    diagonal: Vec<[u32; 3]>,
    pattern: Pattern,
    /// Vertices of layers whose contact the pattern has room for, sorted.
    couples: Vec<[u32; 4]>,
    gradients: Vec<Gradient<6>>,
    matrices: Vec<[f64; FACE_ENTRIES]>,
    pool: Option<rayon::ThreadPool>,
}

/// Nodes of a stencil out of all nodes.
pub fn pick<const N: usize>(nodes: &[Vector3<f64>], stencil: &[u32; N]) -> Nodes<N> {
    stencil.map(|n| nodes[n as usize])
}

impl Assembly {
    /// Prepares the assembly of a model's tangent; `threads` above 1 share the work over faces.
    pub fn new(model: &Model, threads: usize) -> Self {
        let pattern = pattern(model, &[]);
        let pool = (threads > 1).then(|| {
            rayon::ThreadPoolBuilder::new()
                .num_threads(threads)
                .build()
                .expect("threads can be started")
        });
        Self {
            face_slots: face_slots(model, &pattern),
            bending: bending(model, &pattern),
            diagonal: diagonal(model, &pattern),
            pattern,
            couples: vec![],
            gradients: vec![[Vector3::zeros(); 6]; model.mesh.faces.len()],
            matrices: vec![[0.0; FACE_ENTRIES]; model.mesh.faces.len()],
            pool,
        }
    }

    /// The pattern of the tangent.
    pub fn pattern(&self) -> &Pattern {
        &self.pattern
    }

    /// Makes room for layers whose vertices are given, sorted, and for no others; says whether the pattern is another.
    pub fn couple(&mut self, model: &Model, couples: &[[u32; 4]]) -> bool {
        if couples == self.couples {
            return false;
        }
        self.couples.clear();
        self.couples.extend_from_slice(couples);
        self.pattern = pattern(model, couples);
        self.face_slots = face_slots(model, &self.pattern);
        self.bending = bending(model, &self.pattern);
        self.diagonal = diagonal(model, &self.pattern);
        true
    }

    /// Vertices of layers that the pattern has room for, sorted.
    pub fn couples(&self) -> &[[u32; 4]] {
        &self.couples
    }

    /// Adds a matrix on the vertices of two layers for which the pattern has room.
    pub fn add_pair(
        &self,
        dofs: &Dofs,
        nodes: &[u32; 4],
        hessian: &Hessian<4>,
        values: &mut [f64],
    ) {
        for row in 0..12 {
            for column in 0..=row {
                let value = hessian[row / 3][column / 3][(row % 3, column % 3)];
                let [i, j] = [row, column].map(|k| dofs.index[nodes[k / 3] as usize][k % 3]);
                let slot = self.pattern.slot(i, j);
                if slot != NO_SLOT {
                    values[slot as usize] += value;
                }
            }
        }
    }

    /// Adds the derivative of the internal energy (stretch and bend) by each node to `sum` \[N, N·m\].
    pub fn internal(&mut self, model: &Model, nodes: &[Vector3<f64>], sum: &mut [Vector3<f64>]) {
        let face = |f: usize, out: &mut Gradient<6>| {
            let x = pick(nodes, &model.bend.nodes(f));
            *out = model.bend.gradient(f, &x);
            let stretch = model.stretch.gradient(f, &[x[0], x[1], x[2]]);
            for k in 0..3 {
                out[k] += stretch[k];
            }
        };
        each(&self.pool, &mut self.gradients, face);
        for (f, gradient) in self.gradients.iter().enumerate() {
            for (node, g) in model.bend.nodes(f).iter().zip(gradient) {
                sum[*node as usize] += g;
            }
        }
    }

    /// Writes the tangent of inertia, damping, stretch and bend: the weights of masses and of damping, a stress for
    /// each face \[N/m\], the share of its compression that is left out.
    pub fn tangent(
        &mut self,
        model: &Model,
        nodes: &[Vector3<f64>],
        stresses: &[Vector3<f64>],
        weights: (f64, f64),
        projection: f64,
        values: &mut [f64],
    ) {
        values.copy_from_slice(&self.bending);
        let (alpha_a, alpha_v) = weights;
        for (v, slots) in self.diagonal.iter().enumerate() {
            let diagonal = alpha_a * model.masses[v] + alpha_v * model.damping.coefficients[v];
            for &slot in slots.iter().filter(|&&slot| slot != NO_SLOT) {
                values[slot as usize] += diagonal;
            }
        }
        let face = |f: usize, out: &mut [f64; FACE_ENTRIES]| {
            let x = pick(nodes, &model.stretch.nodes(f));
            let hessian = model.stretch.tangent(f, &x, &stresses[f], projection);
            lower(&hessian, out);
        };
        each(&self.pool, &mut self.matrices, face);
        for (slots, matrix) in self.face_slots.iter().zip(&self.matrices) {
            for (&slot, value) in slots.iter().zip(matrix) {
                if slot != NO_SLOT {
                    values[slot as usize] += value;
                }
            }
        }
    }

    /// Adds a matrix on the vertices of a face.
    pub fn add_face(&self, face: u32, hessian: &Hessian<3>, values: &mut [f64]) {
        let mut matrix = [0.0; FACE_ENTRIES];
        lower(hessian, &mut matrix);
        for (&slot, value) in self.face_slots[face as usize].iter().zip(matrix) {
            if slot != NO_SLOT {
                values[slot as usize] += value;
            }
        }
    }
}

/// Fills `out` by index, on the pool if there is one; the values do not depend on which thread makes them.
fn each<T: Send>(
    pool: &Option<rayon::ThreadPool>,
    out: &mut [T],
    make: impl Fn(usize, &mut T) + Sync,
) {
    match pool {
        None => out
            .iter_mut()
            .enumerate()
            .for_each(|(i, slot)| make(i, slot)),
        Some(pool) => pool.install(|| {
            out.par_iter_mut()
                .with_min_len(256)
                .enumerate()
                .for_each(|(i, slot)| make(i, slot));
        }),
    }
}

/// Row-wise lower triangle of a face matrix in the order of [`face_slots`].
fn lower(hessian: &Hessian<3>, out: &mut [f64; FACE_ENTRIES]) {
    let mut k = 0;
    for row in 0..9 {
        for column in 0..=row {
            out[k] = hessian[row / 3][column / 3][(row % 3, column % 3)];
            k += 1;
        }
    }
}

fn face_slots(model: &Model, pattern: &Pattern) -> Vec<[u32; FACE_ENTRIES]> {
    let stencils = (0..model.mesh.faces.len()).map(|f| model.stretch.nodes(f));
    stencils
        .map(|nodes| slots_of(pattern, &model.dofs, &nodes))
        .collect()
}

fn diagonal(model: &Model, pattern: &Pattern) -> Vec<[u32; 3]> {
    let index = model.dofs.index[..model.masses.len()].iter();
    index
        .map(|index| index.map(|i| pattern.slot(i, i)))
        .collect()
}

fn slots_of(pattern: &Pattern, dofs: &Dofs, vertices: &[u32; 3]) -> [u32; FACE_ENTRIES] {
    let index = |i: usize| dofs.index[vertices[i / 3] as usize][i % 3];
    let mut slots = [NO_SLOT; FACE_ENTRIES];
    let mut k = 0;
    for row in 0..9 {
        for column in 0..=row {
            slots[k] = pattern.slot(index(row), index(column));
            k += 1;
        }
    }
    slots
}

/// Membrane couples all components of a face's vertices, layers those of theirs; bending couples equal components of a
/// face's six nodes.
fn pattern(model: &Model, couples: &[[u32; 4]]) -> Pattern {
    let index = &model.dofs.index;
    let mut groups: Vec<Vec<u32>> = vec![];
    for f in 0..model.mesh.faces.len() {
        let nodes = model.bend.nodes(f);
        groups.push(nodes[..3].iter().flat_map(|&n| index[n as usize]).collect());
        for axis in 0..3 {
            groups.push(nodes.iter().map(|&n| index[n as usize][axis]).collect());
        }
    }
    for nodes in couples {
        groups.push(nodes.iter().flat_map(|&n| index[n as usize]).collect());
    }
    Pattern::from_groups(model.dofs.size, groups.iter().map(Vec::as_slice))
}

fn bending(model: &Model, pattern: &Pattern) -> Vec<f64> {
    let mut values = vec![0.0; pattern.entries()];
    for f in 0..model.mesh.faces.len() {
        let nodes = model.bend.nodes(f);
        let matrix: &SMatrix<f64, 6, 6> = model.bend.matrix(f);
        for i in 0..6 {
            for j in 0..=i {
                for axis in 0..3 {
                    let [a, b] = [nodes[i], nodes[j]].map(|n| model.dofs.index[n as usize][axis]);
                    let slot = pattern.slot(a, b);
                    if slot != NO_SLOT {
                        values[slot as usize] += matrix[(i, j)];
                    }
                }
            }
        }
    }
    values
}
