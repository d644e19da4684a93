use nalgebra::Vector3;

use super::{LayerBond, LayerFriction, LayerLaw, Layers, combine};
use crate::contact::layers::{Pair, point_to_face, segment_to_segment};
use crate::physics::suite::{self, Chance};
use crate::physics::{Nodes, Potential};

/// Millimetre cloth, so that nearest points lie well inside their features.
const LAW: LayerLaw = LayerLaw {
    thickness: 1e-3,
    load: 0.1,
    friction: 0.3,
};

/// The pair of a vertex and a face, or of two edges.
fn pair(edges: bool, x: &Nodes<4>) -> Pair {
    let weights = if edges {
        let [s, t] = segment_to_segment(&x[0], &x[1], &x[2], &x[3]);
        [1.0 - s, s, t - 1.0, -t]
    } else {
        let [u, v, w] = point_to_face(&x[0], [&x[1], &x[2], &x[3]]);
        [1.0, -u, -v, -w]
    };
    let offset = combine(&weights, x);
    Pair {
        key: 0,
        nodes: [0, 1, 2, 3],
        weights,
        share: 0.7,
        distance: offset.norm(),
        normal: offset.normalize(),
    }
}

/// A vertex over the inside, a side and a corner of a face, and two edges across each other.
fn cases() -> Vec<(&'static str, bool, Nodes<4>)> {
    let v = Vector3::new;
    let face = [v(0.0, 0.0, 0.0), v(5e-3, 0.0, 3e-4), v(2e-3, 4e-3, -2e-4)];
    let over = |p: Vector3<f64>| [p, face[0], face[1], face[2]];
    let edge = [v(-2e-3, 0.3e-3, 0.7e-3), v(3e-3, -0.2e-3, 0.4e-3)];
    let other = [v(0.2e-3, -2e-3, 1e-4), v(-0.4e-3, 3e-3, -1e-4)];
    vec![
        ("inside", false, over(v(2e-3, 1.4e-3, 0.7e-3))),
        ("side", false, over(v(2e-3, -0.4e-3, 0.5e-3))),
        ("corner", false, over(v(-0.3e-3, -0.4e-3, 0.3e-3))),
        ("edges", true, [edge[0], edge[1], other[0], other[1]]),
    ]
}

#[test]
fn derivatives_hold_for_every_kind_of_pair() {
    for (name, edges, x) in cases() {
        let pairs = [pair(edges, &x)];
        assert!(pairs[0].distance < LAW.thickness, "{name}");
        let term = Layers {
            law: LAW,
            pairs: &pairs,
        };
        suite::derivatives(&term, 0, &x, 2e-4, name);
        suite::rigid_motion(&term, 0, &x, 4, name);
    }
}

/// The suite's rest: nothing at the thickness and beyond.
#[test]
fn layers_a_thickness_apart_do_not_feel_each_other() {
    for (name, edges, x) in cases() {
        let near = pair(edges, &x);
        let mut apart = x;
        let moved = if edges { 2 } else { 1 };
        for node in &mut apart[..moved] {
            *node += near.normal * (1.000_001 * LAW.thickness - near.distance);
        }
        let pairs = [pair(edges, &apart)];
        suite::rest(
            &Layers {
                law: LAW,
                pairs: &pairs,
            },
            0,
            &apart,
            &x,
            name,
        );
    }
}

/// Twice differentiable where it sets in and where it becomes a parabola; ever stiffer in between.
#[test]
fn the_law_is_smooth_and_stiffens() {
    let h = LAW.thickness;
    let mut last = [0.0; 3];
    for k in 0..2000 {
        let d = h * (1.001 - 0.0006 * f64::from(k));
        let [value, first, second] = LAW.psi(d);
        let step = 1e-6 * h;
        let [ahead, behind] = [LAW.psi(d + step), LAW.psi(d - step)];
        let slope = (ahead[0] - behind[0]) / (2.0 * step);
        let bend = (ahead[1] - behind[1]) / (2.0 * step);
        assert!(
            (slope - first).abs() <= 1e-5 * first.abs() + 1e-9 * LAW.load,
            "{d}: {slope} {first}"
        );
        assert!(
            (bend - second).abs() <= 1e-3 * second + 1e-5 * LAW.grip(),
            "{d}: {bend} {second}"
        );
        assert!(
            value >= last[0] && first <= last[1] && second >= last[2],
            "{d}"
        );
        last = [value, first, second];
    }
    assert!(last[0].is_finite() && last[0] > LAW.load * h);
}

/// Under 50 Pa two layers keep 95 % of their thickness, under 5 kPa 60 %.
#[test]
fn compression_is_that_of_textile_tests() {
    let law = LayerLaw::new(0.5e-3, 1e-5, 0.0);
    for (pressure, kept) in [(50.0, 0.95), (5e3, 0.6)] {
        let area = 0.25 * 1e-5;
        let force = -law.psi(kept * law.thickness)[1];
        let ratio = force / (pressure * area);
        assert!((0.5..2.0).contains(&ratio), "{pressure} Pa: {ratio}");
    }
}

#[test]
fn friction_holds_and_slips() {
    let mut chance = Chance::new(5);
    for (name, edges, x) in cases() {
        let near = pair(edges, &x);
        let across = near.normal.cross(&chance.vector(1.0)).normalize();
        for (state, size, length) in [("stick", 2e-7, 5e-7), ("slip", 1e-4, 2e-5)] {
            let offset = combine(&near.weights, &x);
            let bonds = [LayerBond {
                nodes: near.nodes,
                weights: near.weights,
                normal: near.normal,
                slack: offset - across * size,
                limit: 1e-4,
                stiffness: 100.0,
            }];
            let term = LayerFriction { bonds: &bonds };
            suite::derivatives(&term, 0, &x, length, &format!("{name}: {state}"));
            let sum: Vector3<f64> = term.gradient(0, &x).iter().sum();
            assert!(
                sum.norm() < 1e-12,
                "{name}: {state}: layers push each other, not the world"
            );
        }
    }
}
