//! The stable limit of the explicit scheme: 2/omega_max (Courant, Friedrichs, Lewy) of the actual mesh.

use nalgebra::{DMatrix, Vector3};

use crate::contact::{Nearby, Obstacle, Shape};
use crate::physics::contact::ContactLaw;
use crate::physics::{Hessian, Potential};
use crate::sim::assembly::pick;
use crate::sim::model::Model;
use crate::sim::state::State;

/// Substep over the stable limit when the user leaves it open: below sqrt(3)/2, where three substeps make a period of
/// the stiffest mode, and a sheet without damping gains energy by resonance until it is lost (Schlick, Mandziuk,
/// Skeel, Srinivas 1998, J. Comput. Phys. 140:1).
pub const SAFETY: f64 = 0.85;
/// The same over the limit with what the sheet may touch: a bound that is not met, and contacts ring for moments only.
pub const TOUCHING: f64 = 0.95;
/// How far the sheet may move against an obstacle before the features near it are collected anew \[m\].
pub const MARGIN: f64 = 1e-3;
/// Iterations of Lanczos; the limit is then good to 0.1 %.
const ITERATIONS: usize = 50;
/// Coupling to the next vector, over the diagonal, at which all modes are there.
const SPENT: f64 = 1e-10;

/// Slope inertia over m h² that nothing notices: what it adds to a wave of length w is of relative size (h/w)² of this.
/// Twenty times as much would let a coarse strip swing otherwise.
const UNNOTICED: f64 = 1e-3;
/// Edges over the bending length that folds need: shorter ones may have as much inertia as these.
const RESOLVED: f64 = 0.25;
/// Of the earth, for the bending length \[m/s²\].
const GRAVITY: f64 = 9.81;

/// The most that a slope's inertia may be \[kg·m²\]: what nothing notices, or what a solid sheet of the fabric's
/// thickness has, rho t²/12 for every turn of its normal. A slope knows one direction of two, and an edge stands for a
/// third of the mass m around it, so that is m t²/18.
pub fn most_inertia(model: &Model, edge: usize) -> f64 {
    let ends = model.mesh.edges[edge].iter();
    let mass = 0.5 * ends.map(|&v| model.masses[v as usize]).sum::<f64>();
    let solid = model.fabric.thickness.powi(2) / 18.0;
    let resolved = RESOLVED * model.fabric.bending_length(GRAVITY);
    let length = model.mesh.edge_length(edge).max(resolved);
    mass * solid.max(UNNOTICED * length.powi(2))
}

/// Bound on the stiffness of each slope in the bending matrix \[N·m\]: the absolute row sum.
pub fn slope_stiffness(model: &Model) -> Vec<f64> {
    let mut sums = vec![0.0; model.mesh.edges.len()];
    for (f, edges) in model.mesh.face_edges.iter().enumerate() {
        let matrix = model.bend.matrix(f);
        for (k, &e) in edges.iter().enumerate() {
            sums[e as usize] += (3..6).map(|j| matrix[(3 + k, j)].abs()).sum::<f64>();
        }
    }
    sums
}

/// How much faster than at rest a stretched sheet vibrates at most, at least 1: along a Green strain e the stiffness
/// is C ((1 + 2e) + e), of the law and of the tension.
pub fn stiffening(model: &Model, positions: &[Vector3<f64>]) -> f64 {
    let stretch = &model.stretch;
    let stretched = |f: usize| stretch.strain(f, &pick(positions, &stretch.nodes(f)));
    let largest = |e: Vector3<f64>| 0.5 * (e.x + e.y) + (0.5 * (e.x - e.y)).hypot(e.z);
    let strains = (0..stretch.count()).map(|f| largest(stretched(f)));
    (1.0 + 3.0 * strains.fold(0.0, f64::max)).sqrt()
}

/// Largest stiffness over mass of contacts on vertices that can touch obstacles before `span` seconds are over \[1/s²\].
pub fn contact_rate(model: &Model, state: &State, span: f64) -> f64 {
    let Some(law) = &model.contact else {
        return 0.0;
    };
    let speeds = state.velocities.iter().map(|v| v.norm_squared());
    let fastest = speeds.fold(0.0, f64::max).sqrt();
    let near = |body: &Obstacle| {
        let margin = MARGIN + (fastest + quickest(model, body, &state.positions)) * span;
        if let Shape::Mesh(_) = body.shape {
            return by_distance(model, law, body, &state.positions, margin);
        }
        let near = Nearby::find(&model.mesh, &state.positions, body, law.offset, margin);
        near.vertices().to_vec()
    };
    rate_of(model, law, state.obstacles.iter().flat_map(near))
}

/// Vertices of edges and faces that may be within `margin` of touching, at least. For triangle meshes: all pairs of parts
/// so far from each other would be many.
fn by_distance(
    model: &Model,
    law: &ContactLaw,
    body: &Obstacle,
    positions: &[Vector3<f64>],
    margin: f64,
) -> Vec<u32> {
    let reach = law.offset + model.longest_edge + margin;
    let near = (0..).zip(positions);
    near.filter(|(_, x)| body.distance(x).value < reach)
        .map(|(v, _)| v)
        .collect()
}

/// Largest stiffness over mass with a contact at each of these vertices, stacked where one comes again \[1/s²\]. With omega²
/// of the sheet alone it bounds that of the sheet in contact (Weyl).
pub fn rate_of(model: &Model, law: &ContactLaw, vertices: impl Iterator<Item = u32>) -> f64 {
    let mut counts = vec![0u32; model.masses.len()];
    for v in vertices {
        counts[v as usize] += 1;
    }
    let rates = counts.iter().zip(&model.masses);
    let rates = rates.map(|(count, mass)| f64::from(*count) * law.stiffness / mass);
    rates.fold(0.0, f64::max)
}

/// Bound on the speed of an obstacle's surface wherever it can meet the sheet, as long as no command changes it
/// \[m/s\].
pub fn quickest(model: &Model, body: &Obstacle, positions: &[Vector3<f64>]) -> f64 {
    let motion = model.motions.get(&body.name).filter(|_| body.scripted);
    let (linear, turn) = match motion {
        Some(motion) => motion.fastest(),
        None => (body.velocity.linear.norm(), body.velocity.angular.norm()),
    };
    let linear = linear + body.overlap.rate();
    if turn == 0.0 {
        return linear;
    }
    let origin = body.pose.translation.vector;
    let away = positions.iter().map(|p| (p - origin).norm_squared());
    linear + turn * away.fold(0.0, f64::max).sqrt()
}

/// omega_max \[rad/s\] of M^-1 K at `nodes`, for as many nodes as have an inertia, without contact: the largest Ritz value of
/// Lanczos' iteration, without reorthogonalisation, which the extreme one does not need (Golub and Van Loan, Matrix
/// Computations, 4th ed., 10.3).
pub fn largest_frequency(model: &Model, nodes: &[Vector3<f64>], inertia: &[f64]) -> f64 {
    let stencils = 0..model.mesh.faces.len();
    let membrane = |f: usize| (model.stretch).hessian(f, &pick(nodes, &model.stretch.nodes(f)));
    let membrane: Vec<Hessian<3>> = stencils.map(membrane).collect();
    let roots: Vec<f64> = inertia.iter().map(|m| m.sqrt()).collect();
    // In coordinates scaled by the root of the inertia the matrix is symmetric.
    let times = |mode: &[Vector3<f64>]| -> Vec<Vector3<f64>> {
        let mut unscaled = vec![Vector3::zeros(); nodes.len()];
        let scaled = unscaled.iter_mut().zip(mode).zip(&roots);
        scaled.for_each(|((x, y), root)| *x = y / *root);
        let force = stiffness_times(model, &membrane, &unscaled);
        let roots = roots.iter().enumerate();
        roots
            .map(|(n, root)| model.dofs.free(n, force[n] / *root))
            .collect()
    };
    // Any vector that no mode is orthogonal to will do; this one has all wavelengths.
    let wave = |n: usize| {
        let phase = (n as f64 * 0.754_877_666) % 1.0;
        let wave = Vector3::new(phase - 0.5, 0.5 - phase * phase, phase * 0.7 - 0.3);
        model.dofs.free(n, wave)
    };
    let mut mode: Vec<Vector3<f64>> = (0..inertia.len()).map(wave).collect();
    let mut last = vec![Vector3::zeros(); mode.len()];
    let mut coupling = norm(&mode);
    let (mut diagonal, mut beside) = (vec![], vec![]);
    mode.iter_mut().for_each(|x| *x /= coupling);
    while diagonal.len() < ITERATIONS {
        let mut next = times(&mode);
        let before = beside.last().copied().unwrap_or(0.0);
        let along: f64 = next.iter().zip(&mode).map(|(a, b)| a.dot(b)).sum();
        for ((next, mode), last) in next.iter_mut().zip(&mode).zip(&last) {
            *next -= mode * along + last * before;
        }
        diagonal.push(along);
        coupling = norm(&next);
        if coupling <= SPENT * along {
            break;
        }
        beside.push(coupling);
        last = std::mem::replace(&mut mode, next);
        mode.iter_mut().for_each(|x| *x /= coupling);
    }
    let ritz = DMatrix::from_fn(diagonal.len(), diagonal.len(), |i, j| match i.abs_diff(j) {
        0 => diagonal[i],
        1 => beside[i.min(j)],
        _ => 0.0,
    });
    ritz.symmetric_eigenvalues().max().sqrt()
}

fn norm(mode: &[Vector3<f64>]) -> f64 {
    mode.iter().map(|x| x.norm_squared()).sum::<f64>().sqrt()
}

fn stiffness_times(
    model: &Model,
    membrane: &[Hessian<3>],
    mode: &[Vector3<f64>],
) -> Vec<Vector3<f64>> {
    let mut force = vec![Vector3::zeros(); mode.len()];
    for (f, hessian) in membrane.iter().enumerate() {
        let stencil = model.bend.nodes(f);
        let d = pick(mode, &stencil);
        let mut sum = model.bend.gradient(f, &d);
        for i in 0..3 {
            for j in 0..3 {
                sum[i] += hessian[i][j] * d[j];
            }
        }
        for (n, s) in stencil.iter().zip(sum) {
            force[*n as usize] += s;
        }
    }
    force
}
