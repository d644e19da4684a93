use nalgebra::Vector3;

use super::Drag;
use crate::physics::suite::{self, Chance};
use crate::physics::{Load, Nodes};

const FACE: [[u32; 3]; 1] = [[0, 1, 2]];
const C: f64 = 0.7;

fn air(velocities: Nodes<3>) -> Drag<'static> {
    Drag {
        faces: &FACE,
        fluid_damping: C,
        air: velocities.to_vec(),
    }
}

/// Random faces of about 5 mm, and one that is ten times as long as it is wide.
fn faces(chance: &mut Chance) -> Vec<Nodes<3>> {
    let mut faces: Vec<Nodes<3>> = (0..4).map(|_| chance.nodes(4e-3)).collect();
    let along = chance.vector(1.0).normalize() * 5e-3;
    let across = along.cross(&chance.vector(1.0)).normalize() * 5e-4;
    faces.push([Vector3::zeros(), along, along * 0.4 + across]);
    faces
}

#[test]
fn derivatives_hold() {
    let mut chance = Chance::new(21);
    for x in faces(&mut chance) {
        let (term, v) = (air(chance.nodes(3.0)), chance.nodes(2.0));
        let height = super::normal(&x).norm() / (x[1] - x[0]).norm();
        suite::load(&term, 0, (&x, &v), (height, 1.0), "drag");
    }
}

/// Turned and shifted with all that moves, the force turns along.
#[test]
fn it_does_not_depend_on_the_frame() {
    let mut chance = Chance::new(22);
    for x in faces(&mut chance) {
        let (u, v) = (chance.nodes(3.0), chance.nodes(2.0));
        let (turn, shift, drift) = (chance.rotation(), chance.vector(0.1), chance.vector(5.0));
        let force = air(u).force(0, &x, &v);
        let moved = air(u.map(|u| turn * u + drift)).force(
            0,
            &x.map(|x| turn * x + shift),
            &v.map(|v| turn * v + drift),
        );
        for k in 0..3 {
            let off = (turn * force[k] - moved[k]).norm();
            assert!(
                off < 1e-12 * force[k].norm(),
                "{off:e} of {}",
                force[k].norm()
            );
        }
    }
}

/// On a plate across the wind it is C A (u - v), whichever side is up; along the plate there is none.
#[test]
fn it_is_pressure_only() {
    let x = [[0.0, 0.0], [4e-3, 0.0], [1e-3, 3e-3]].map(|[x, y]| Vector3::new(x, y, 0.01));
    let area = 6e-6;
    let (u, v) = (Vector3::new(7.0, -3.0, 2.0), Vector3::new(-1.0, 5.0, 0.5));
    for x in [x, [x[1], x[0], x[2]]] {
        let total: Vector3<f64> = air([u; 3]).force(0, &x, &[v; 3]).iter().sum();
        let expected = Vector3::new(0.0, 0.0, C * area * 1.5);
        assert!((total - expected).norm() < 1e-20, "{total}");
    }
}

#[test]
fn there_is_none_on_a_sheet_that_moves_with_the_air() {
    let mut chance = Chance::new(23);
    for x in faces(&mut chance) {
        let v = chance.nodes(2.0);
        assert_eq!(air(v).force(0, &x, &v), [Vector3::zeros(); 3]);
    }
}

/// Air at rest takes energy out, whatever the motion; so the derivative by velocity is negative semidefinite.
#[test]
fn still_air_takes_energy_out() {
    let mut chance = Chance::new(24);
    let still = air([Vector3::zeros(); 3]);
    for x in faces(&mut chance) {
        for _ in 0..10 {
            let v: Nodes<3> = chance.nodes(2.0);
            let power: f64 = (0..3).map(|k| still.force(0, &x, &v)[k].dot(&v[k])).sum();
            assert!(power < 0.0, "{power}");
        }
        let matrix = suite::dense(&still.by_velocity(0, &x, &[Vector3::zeros(); 3]));
        let most = matrix.symmetric_eigenvalues().max();
        assert!(most <= 1e-14 * matrix.norm(), "{most:e}");
    }
}

/// A face that shrinks to a line or a point loses its force without a jump, and is never not a number.
#[test]
fn a_face_without_area_bears_no_force() {
    let mut chance = Chance::new(25);
    let (u, v) = (chance.nodes(3.0), chance.nodes(2.0));
    let [a, b, c] = chance.nodes(4e-3);
    let term = air(u);
    let line = [a, b, a * 0.5 + b * 0.5];
    for x in [[a; 3], [a, a, b], line] {
        let size: f64 = term.force(0, &x, &v).iter().map(|f| f.norm()).sum();
        assert!(size < 1e-17, "{size:e}");
        let derivative = suite::dense(&term.by_position(0, &x, &v));
        assert!(derivative.iter().all(|d| d.is_finite()));
    }
    let flat = |height: f64| {
        let x = [a, b, line[2] + (c - a) * height];
        suite::flat(&term.force(0, &x, &v)).norm()
    };
    let ratio = flat(1e-6) / flat(1e-3);
    assert!((ratio - 1e-3).abs() < 1e-5, "{ratio}");
}

/// Sums over the sheet are sums over its faces.
#[test]
fn forces_add_up() {
    let mut chance = Chance::new(26);
    let faces = [[0, 1, 2], [2, 1, 3]];
    let (x, v, u): (Nodes<4>, Nodes<4>, Nodes<4>) =
        (chance.nodes(4e-3), chance.nodes(2.0), chance.nodes(3.0));
    let term = Drag {
        faces: &faces,
        fluid_damping: C,
        air: u.to_vec(),
    };
    let mut sum = [Vector3::zeros(); 4];
    for (s, face) in faces.iter().enumerate() {
        let at = face.map(|n| n as usize);
        let force = term.force(s, &at.map(|n| x[n]), &at.map(|n| v[n]));
        for (n, f) in at.into_iter().zip(force) {
            sum[n] += f;
        }
    }
    assert_eq!(term.forces(&x, &v), sum);
}
