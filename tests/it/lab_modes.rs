//! Small vibrations of strips against closed forms: eigenvalues of the stiffness at rest over the lumped masses.

use std::f64::consts::TAU;

use crate::lab::{Table, scene, simulation};
use nalgebra::{Cholesky, DMatrix, DVector};
use toile::math::sparse::NO_SLOT;
use toile::physics::Potential;
use toile::sim::Simulation;

const FREE: &str = include_str!("../references/strip_frequencies.csv");
const HANGING: &str = include_str!("../references/hanging_strip_modes.csv");

/// Stiffness of one world axis on vertices and slopes \[N/m\]: at rest it does not couple with the other axes.
fn stiffness(simulation: &Simulation, axis: usize) -> DMatrix<f64> {
    let (model, nodes) = (simulation.model(), simulation.state().nodes());
    let mut matrix = DMatrix::zeros(nodes.len(), nodes.len());
    for s in 0..model.stretch.count() {
        let stencil = model.stretch.nodes(s);
        let hessian = model
            .stretch
            .hessian(s, &stencil.map(|n| nodes[n as usize]));
        for (i, a) in stencil.iter().enumerate() {
            for (j, b) in stencil.iter().enumerate() {
                matrix[(*a as usize, *b as usize)] += hessian[i][j][(axis, axis)];
            }
        }
    }
    for s in 0..model.bend.count() {
        let stencil = model.bend.nodes(s);
        for (i, a) in stencil.iter().enumerate() {
            for (j, b) in stencil.iter().enumerate() {
                matrix[(*a as usize, *b as usize)] += model.bend.matrix(s)[(i, j)];
            }
        }
    }
    matrix
}

/// Angular frequencies of bending along `axis` \[rad/s\], lowest first; those of torsion left out.
fn frequencies(simulation: &Simulation, axis: usize) -> Vec<f64> {
    let model = simulation.model();
    let free = |n: &usize| model.dofs.index[*n][axis] != NO_SLOT;
    let vertices: Vec<usize> = (0..model.masses.len()).filter(free).collect();
    let slopes: Vec<usize> = (model.masses.len()..model.dofs.index.len())
        .filter(free)
        .collect();
    let all = stiffness(simulation, axis);
    let part = |rows: &[usize], columns: &[usize]| {
        DMatrix::from_fn(rows.len(), columns.len(), |i, j| all[(rows[i], columns[j])])
    };
    // Slopes carry no mass: they follow.
    let coupling = part(&slopes, &vertices);
    let inner = Cholesky::new(part(&slopes, &slopes)).expect("slopes are stiff");
    let condensed = part(&vertices, &vertices) - coupling.transpose() * inner.solve(&coupling);
    let root = DVector::from_iterator(
        vertices.len(),
        vertices.iter().map(|&v| model.masses[v].sqrt()),
    );
    let scaled = DMatrix::from_fn(vertices.len(), vertices.len(), |i, j| {
        condensed[(i, j)] / (root[i] * root[j])
    });
    let eigen = scaled.symmetric_eigen();
    let far = model
        .mesh
        .outline
        .iter()
        .fold(0.0, |far: f64, p| far.max(p.x));
    let end: Vec<usize> = (0..vertices.len())
        .filter(|&i| model.mesh.outline[vertices[i]].x > far - 1e-9)
        .collect();
    let bends = |mode: usize| {
        let shape: Vec<f64> = end
            .iter()
            .map(|&i| eigen.eigenvectors[(i, mode)] / root[i])
            .collect();
        let mean = shape.iter().sum::<f64>() / shape.len() as f64;
        shape.iter().all(|x| (x - mean).abs() < 0.5 * mean.abs())
    };
    let modes = (0..vertices.len()).filter(|&mode| bends(mode));
    let mut found: Vec<f64> = modes
        .map(|mode| eigen.eigenvalues[mode].max(0.0).sqrt())
        .collect();
    found.sort_by(f64::total_cmp);
    found
}

fn strip(fabric: &str, length: f64, angle: f64, gravity: f64, pitch: f64) -> Simulation {
    let text = format!(
        "name = \"strip\"\ndescription = \"A clamped strip\"\nduration = 1.0\ngravity = [0.0, 0.0, {gravity:?}]\n\
         sheet = {{ outline = {{ kind = \"rectangle\", length = {length:?}, width = {:?} }}, edge = {:?}, \
         warp_angle = {angle:?}, rotation = [0.0, {pitch:?}, 0.0] }}\n\
         [fabric]\nname = \"{fabric}\"\n\
         [support]\nclamp = {{ kind = \"clamp\", region = {{ kind = \"x-min\" }} }}\n",
        0.12 * length,
        length / 32.0
    );
    simulation(&scene(&text))
}

/// Tolerances grow with the mode: a wave of the second is 1.3 lengths, 43 edges, of the third 0.8.
#[test]
fn verify_frequencies_of_a_clamped_strip() {
    let table = Table::new(FREE);
    for (fabric, direction, angle) in [
        ("F1", "warp", 0.0),
        ("F1", "weft", 90.0),
        ("F9", "warp", 0.0),
    ] {
        let wanted = [
            ("fabric", fabric),
            ("direction", direction),
            ("L_mm", "50.0"),
        ];
        let row = table.rows(&wanted).next().unwrap();
        let found = frequencies(&strip(fabric, 0.05, angle, 0.0, 0.0), 2);
        for (k, tolerance) in [(0, 5e-3), (1, 5e-3), (2, 1e-2)] {
            let exact = row.get(&format!("f{}_Hz", k + 1));
            let off = found[k] / TAU / exact - 1.0;
            println!(
                "{fabric} {direction}, mode {}: {:.4} Hz, off {:.2} %",
                k + 1,
                found[k] / TAU,
                1e2 * off
            );
            assert!(off.abs() < tolerance, "mode {}: {off}", k + 1);
        }
    }
}

/// The weight of what hangs below stiffens a strip: pendulum and beam at once.
#[test]
fn verify_modes_of_a_hanging_strip() {
    let table = Table::new(HANGING);
    let fabric = toile::fabric::find("F1").unwrap();
    let weight = fabric.areal_density * 9.81;
    for gamma in ["3", "10", "50"] {
        let row = table.rows(&[("Gamma", gamma)]).next().unwrap();
        let length = (gamma.parse::<f64>().unwrap() * fabric.rigidity_warp / weight).cbrt();
        let mut strip = strip("F1", length, 0.0, -9.81, 90.0);
        strip.settle(1e-8).unwrap();
        let scale = (fabric.rigidity_warp / fabric.areal_density).sqrt() / (length * length);
        let found = frequencies(&strip, 0);
        for (k, tolerance) in [(0, 5e-3), (1, 5e-3), (2, 1e-2)] {
            let exact = row.get(&format!("sqrt_lambda{}", k + 1));
            let off = found[k] / scale / exact - 1.0;
            println!(
                "Gamma {gamma}, mode {}: {:.4}, off {:.2} %",
                k + 1,
                found[k] / scale,
                1e2 * off
            );
            assert!(
                off.abs() < tolerance,
                "Gamma {gamma}, mode {}: {off}",
                k + 1
            );
        }
    }
}
