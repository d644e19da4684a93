//! A heavy strip folded flat on itself, against the closed boundary value problem of zero thickness; and a towel.

use nalgebra::Vector3;
use toile::scene::Scene;
use toile::sim::Simulation;

use crate::lab::{scene, simulation};
use crate::layers::crossed;

/// Points of the loop from where it lifts off the table to where it touches down: x, z, angle over the bending length.
const PROFILE: &str = include_str!("../references/fold_loop_profile.csv");
/// Arc, height and line forces of the reference, in bending lengths and weights of one.
const ARC: f64 = 4.68347;
const HEIGHT: f64 = 0.906597;
const LIFT: f64 = 3.74501;
const LAND: f64 = 0.93847;

/// What lies flat below and above the loop \[bending lengths\].
const BELOW: f64 = 4.0;
const ABOVE: f64 = 3.0;

/// Both ends are held along the strip, or the fold would roll off at one of them.
fn strip(fabric: &str, thickness: f64) -> (Scene, f64) {
    let toml = |length: f64, edge: f64, back: f64| {
        format!(
            "name = \"fold\"\ndescription = \"A strip folded on itself\"\nduration = 1.0\n\
             [sheet]\noutline = {{ kind = \"rectangle\", length = {length}, width = {width} }}\nedge = {edge}\n\
             [fabric]\nname = \"{fabric}\"\n\
             [obstacle.table]\nshape = {{ kind = \"plane\" }}\n\
             [layers]\nthickness = {thickness}\n\
             [support.low]\nkind = \"pin\"\nregion = {{ kind = \"x-min\" }}\naxes = \"x\"\n\
             [support.high]\nkind = \"pin\"\nregion = {{ kind = \"x-max\" }}\naxes = \"x\"\n\
             displacement = [{back}, 0.0, 0.0]\n\
             [method]\nscheme = \"equilibrium\"\ndt = 1e-3\ntolerance = 1e-6\n",
            width = 1.5 * edge
        )
    };
    let first = scene(&toml(0.1, 0.05, 0.0));
    let fabric = first.fabric.resolve().unwrap();
    let l = (fabric.rigidity_warp / (fabric.areal_density * 9.81)).cbrt();
    let length = (BELOW + ARC + ABOVE) * l;
    let end = curve(length, l, 0.0, 0.0).0;
    (scene(&toml(length, 0.15 * l, end - length)), l)
}

/// Place and direction of the strip at an arc length from its lower end.
fn curve(s: f64, l: f64, low: f64, gap: f64) -> (f64, f64, f64) {
    let rows: Vec<[f64; 3]> = PROFILE
        .lines()
        .filter(|line| !line.starts_with('#'))
        .map(|line| {
            let cells: Vec<f64> = line.split(',').map(|c| c.parse().unwrap()).collect();
            [cells[0], cells[1], cells[2]]
        })
        .collect();
    let (last, t) = (rows[rows.len() - 1], s / l - BELOW);
    if t < 0.0 {
        return (s, low, 0.0);
    }
    let at = t / ARC * (rows.len() - 1) as f64;
    if t >= ARC {
        let x = (BELOW + last[0] - (t - ARC)) * l;
        return (x, low + gap, std::f64::consts::PI);
    }
    let (i, part) = (at.floor() as usize, at.fract());
    let mix = |k: usize| rows[i][k] + (rows[i + 1][k] - rows[i][k]) * part;
    // The reference lands on its own lower layer; here that is one thickness higher.
    (
        (BELOW + mix(0)) * l,
        low + gap * t / ARC + mix(1) * l,
        mix(2),
    )
}

/// The strip of a thickness at rest, started on the reference.
fn rest(fabric: &str, thickness: f64) -> (Simulation, f64) {
    let (scene, l) = strip(fabric, thickness);
    let mut simulation = simulation(&scene);
    let model = simulation.model();
    let half = 0.5 * model.fabric.thickness;
    let mut state = simulation.state().clone();
    let length = (BELOW + ARC + ABOVE) * l;
    let place = |p: &nalgebra::Vector2<f64>| {
        let (x, z, angle) = curve(p.x + 0.5 * length, l, half, thickness);
        (
            Vector3::new(x - 0.5 * length, p.y, z),
            Vector3::new(angle.cos(), 0.0, angle.sin()),
        )
    };
    let mesh = &model.mesh;
    for (position, p) in state.positions.iter_mut().zip(&mesh.outline) {
        *position = place(p).0;
    }
    for (e, slope) in state.slopes.iter_mut().enumerate() {
        let [a, b] = mesh.edges[e].map(|v| mesh.outline[v as usize]);
        let normal = mesh.edge_normal(e);
        *slope = place(&((a + b) * 0.5)).1 * normal.x + Vector3::y() * normal.y;
    }
    simulation.resume(state).unwrap();
    let found = simulation
        .settle(1e-5)
        .unwrap_or_else(|e| panic!("{fabric}, {thickness}: {e}"));
    assert!(found.residual < 1e-5);
    (simulation, l)
}

/// Arc of the loop, its height, and the line forces where it lifts off and lands, in bending lengths and weights of one.
fn measure(simulation: &Simulation, l: f64) -> [f64; 4] {
    let (model, state) = (simulation.model(), simulation.state());
    let mesh = &model.mesh;
    let length = (BELOW + ARC + ABOVE) * l;
    let width = mesh.area() / length;
    let weight = model.fabric.areal_density * 9.81 * width;
    let along = |v: u32| mesh.outline[v as usize].x + 0.5 * length;
    // Upward loads on the upper and on the lower part, by arc length from their free ends.
    let (mut upper, mut lower) = ([0.0; 2], [0.0; 2]);
    let middle = (BELOW + 0.5 * ARC) * l;
    let mut load = |v: u32, force: f64| {
        let s = along(v);
        let (sums, arm) = match s > middle {
            true => (&mut upper, length - s),
            false => (&mut lower, s),
        };
        sums[0] += force;
        sums[1] += force * arm;
    };
    for pair in simulation.layers() {
        for (v, w) in pair.vertices.into_iter().zip(pair.weights) {
            load(v, pair.force.z * w);
        }
    }
    for contact in simulation.contacts() {
        let corners = mesh.faces[contact.face as usize];
        // Contacts are at vertices here; which one tells the nearest.
        let near = corners.into_iter().min_by(|&a, &b| {
            let d = |v: u32| (state.positions[v as usize] - contact.point).norm();
            d(a).total_cmp(&d(b))
        });
        load(near.unwrap(), contact.force().z);
    }
    // A part of length a that bears its own weight q and a line force F at its end: S = q a + F, M = q a²/2 + F a.
    let ends = [lower, upper].map(|[sum, moment]| {
        let force = (sum * sum - 2.0 * weight * moment).sqrt();
        ((sum - force) / weight, force)
    });
    let height =
        state.positions.iter().map(|p| p.z).fold(0.0, f64::max) - 0.5 * model.fabric.thickness;
    let arc = length - ends[0].0 - ends[1].0;
    [
        arc / l,
        height / l,
        ends[0].1 / (weight * l),
        ends[1].1 / (weight * l),
    ]
}

/// Extrapolated over the thickness to none, the loop is that of the reference within 2 %.
#[test]
fn verify_the_fold_loop() {
    for fabric in ["F1", "F9"] {
        let measured: Vec<(f64, [f64; 4])> = [0.04, 0.02]
            .into_iter()
            .map(|ratio| {
                let (_, l) = strip(fabric, 1e-4);
                let (simulation, l) = rest(fabric, ratio * l);
                assert_eq!(crossed(&simulation), 0);
                (ratio, measure(&simulation, l))
            })
            .collect();
        for (k, (name, wanted)) in [
            ("arc", ARC),
            ("height", HEIGHT),
            ("lift", LIFT),
            ("landing", LAND),
        ]
        .into_iter()
        .enumerate()
        {
            let [(a, at_a), (b, at_b)] = [measured[0], measured[1]];
            let none = at_b[k] - (at_a[k] - at_b[k]) * b / (a - b);
            println!(
                "{fabric} {name}: {:.4} {:.4} -> {none:.4}, reference {wanted:.4}",
                at_a[k], at_b[k]
            );
            assert!(
                (none / wanted - 1.0).abs() < 0.02,
                "{fabric} {name}: {none}, not {wanted}"
            );
        }
    }
}

/// The jaw folds the towel flat: two layers, a loop of the height that the fabric makes, nothing crossed.
#[test]
fn a_towel_is_folded_flat() {
    for dt in [1.0 / 60.0, 1.0 / 240.0] {
        let set = [
            format!("method.dt={dt}"),
            "output.rate=50".into(),
            "sheet.edge=6e-3".into(),
        ];
        let set: Vec<&str> = set.iter().map(String::as_str).collect();
        let scene = crate::lab::built_in("towel-fold", &set);
        let mut simulation = simulation(&scene);
        let mut strain = 0.0f64;
        for step in 0..scene.steps() {
            let report = simulation.step().unwrap_or_else(|e| panic!("{e}"));
            strain = strain.max(report.largest_strain);
            assert_eq!(report.crossings, 0, "step {step}");
        }
        assert_eq!(crossed(&simulation), 0);
        let report = simulation.report();
        let top = simulation
            .state()
            .positions
            .iter()
            .map(|p| p.z)
            .fold(0.0, f64::max);
        println!(
            "towel at {dt}: {} contacts, loop {top}, strain {strain}",
            report.layer_contacts
        );
        assert!(report.layer_contacts > 0 && strain < 0.05, "{strain}");
        assert!((0.01..0.04).contains(&top), "{top}");
    }
}
