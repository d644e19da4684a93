use nalgebra::{Vector2, Vector3};

use super::{Bend, curvature_operator};
use crate::fabric::find;
use crate::physics::suite::{self, Chance};
use crate::physics::{Nodes, Potential};
use crate::sheet::{Mesh, MeshOptions, Outline, generate};

fn triangle(corners: [[f64; 2]; 3]) -> Mesh {
    let points = corners.map(Vector2::from);
    Mesh::new(points.into(), points.into(), vec![[0, 1, 2]])
}

/// A jittered mesh, the worst that the generator makes, with the yarns across its axes.
fn jittered() -> Mesh {
    let outline = Outline::Rectangle {
        length: 0.05,
        width: 0.03,
    };
    let options = MeshOptions {
        edge: 6e-3,
        jitter: 0.3,
        seed: 3,
        warp_angle: 0.4,
    };
    generate(&outline, &options)
}

/// Nodes of a face on the surface `r` with tangents `r,1` and `r,2`.
fn sampled(
    mesh: &Mesh,
    face: usize,
    r: impl Fn(&Vector2<f64>) -> Vector3<f64>,
    tangents: impl Fn(&Vector2<f64>) -> [Vector3<f64>; 2],
) -> Nodes<6> {
    let vertex = |k: usize| r(&mesh.material[mesh.faces[face][k] as usize]);
    // The mean slope over an edge is the slope at its middle, for a quadratic surface.
    let slope = |k: usize| {
        let e = mesh.face_edges[face][k] as usize;
        let [a, b] = mesh.edges[e].map(|v| mesh.material[v as usize]);
        let [r1, r2] = tangents(&((a + b) * 0.5));
        let n = mesh.edge_normal(e);
        r1 * n.x + r2 * n.y
    };
    [
        vertex(0),
        vertex(1),
        vertex(2),
        slope(0),
        slope(1),
        slope(2),
    ]
}

#[test]
fn derivatives_hold() {
    let mut chance = Chance::new(2);
    let shapes = [
        [[0.0, 0.0], [5e-3, 0.2e-3], [2.4e-3, 4.5e-3]],
        [[0.0, 0.0], [5e-3, 0.0], [4.9e-3, 0.1e-3]],
        [[0.0, 0.0], [10e-3, 0.0], [5e-3, 0.437e-3]],
    ];
    for corners in shapes {
        let mesh = triangle(corners);
        let term = Bend::new(&mesh, find("F1").unwrap().bending());
        let flat = sampled(
            &mesh,
            0,
            |p| Vector3::new(p.x, p.y, 0.0),
            |_| [Vector3::x(), Vector3::y()],
        );
        let mut x = flat.map(|p| p + chance.vector(1e-3));
        for slope in &mut x[3..] {
            *slope += chance.vector(0.3);
        }
        suite::derivatives(&term, 0, &x, 1e-3, "bend");
        suite::rigid_motion(&term, 0, &x, 3, "bend");
        let turn = chance.rotation();
        suite::rest(&term, 0, &flat.map(|p| turn * p), &x, "bend");
    }
}

/// Morley's triangle is exact for quadratic surfaces on any mesh: curvature and energy.
#[test]
fn quadratic_surfaces_are_exact_on_a_jittered_mesh() {
    let mesh = jittered();
    let stiffness = find("F1").unwrap().bending();
    let term = Bend::new(&mesh, stiffness);
    let mut chance = Chance::new(8);
    let [linear1, linear2, r11, r22, r12] = std::array::from_fn(|_| chance.vector(20.0));
    let r = |p: &Vector2<f64>| {
        let quadratic = r11 * (0.5 * p.x * p.x) + r22 * (0.5 * p.y * p.y) + r12 * (p.x * p.y);
        linear1 * p.x + linear2 * p.y + quadratic
    };
    let tangents = |p: &Vector2<f64>| {
        [
            linear1 + r11 * p.x + r12 * p.y,
            linear2 + r22 * p.y + r12 * p.x,
        ]
    };
    let mut energy = 0.0;
    for f in 0..mesh.faces.len() {
        let nodes = sampled(&mesh, f, r, tangents);
        let operator = curvature_operator(&mesh, f);
        for axis in 0..3 {
            let unknowns = nalgebra::SVector::<f64, 6>::from_fn(|i, _| nodes[i][axis]);
            let expected = Vector3::new(r11[axis], r22[axis], r12[axis]);
            let error = (operator * unknowns - expected).norm();
            assert!(error < 1e-9 * expected.norm(), "face {f}: {error:e}");
        }
        energy += term.value(f, &nodes);
    }
    let d = stiffness;
    let density = 0.5
        * (d.c11 * r11.norm_squared()
            + d.c22 * r22.norm_squared()
            + 4.0 * d.c66 * r12.norm_squared()
            + 2.0 * d.c12 * r11.dot(&r22));
    assert!((energy / (density * mesh.area()) - 1.0).abs() < 1e-10);
}
