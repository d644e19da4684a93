//! Verification in statics: squares on three edges, Sze's cantilevers, the standing strip.

use std::f64::consts::TAU;

use crate::lab::{Table, built_in, node_forces, reading, scene, simulation};
use nalgebra::Vector3;
use toile::sim::{Simulation, State};

const THREE_EDGES: &str = include_str!("../references/square_three_edges.json");
const END_SHEAR: &str = include_str!("../references/sze31_cantilever_end_shear.csv");
const END_MOMENT: &str = include_str!("../references/sze32_cantilever_end_moment.csv");
const SLIT_ANNULUS: &str = include_str!("../references/sze33_slit_annulus.csv");

/// Sag in the middle of the free edge and in the centre, free edge along the warp and along the weft.
///
/// Asked for: pinned 0.5 %, clamped 1 %. A clamp's boundary layer of sqrt(D/tension), some 3 mm, takes a fine mesh.
#[test]
fn verify_square_on_three_edges() {
    let cases: Vec<serde_json::Value> = serde_json::from_str(THREE_EDGES).unwrap();
    for case in &cases {
        let clamped = case["bc"] == "clamp";
        let (triangles, tolerance) = if clamped { (5750, 1e-2) } else { (1500, 5e-3) };
        let mut set = vec![format!("sheet.triangles={triangles}")];
        if case["free_edge"] == "x1" {
            // The same square with its yarns exchanged.
            set.push("sheet.warp_angle=90".into());
        }
        for side in ["left", "right", "back"] {
            let kind = if clamped { "clamp" } else { "pin" };
            set.push(format!("support.{side}.kind={kind}"));
        }
        let set: Vec<&str> = set.iter().map(String::as_str).collect();
        let mut simulation = simulation(&built_in("three-edges", &set));
        simulation.settle(1e-7).unwrap();
        for (name, key) in [
            ("free_edge", "free_edge_mid_sag_mm"),
            ("centre", "center_sag_mm"),
        ] {
            let sag = -1e3 * reading(&simulation, name);
            let exact = case[key].as_f64().unwrap();
            let off = sag / exact - 1.0;
            println!(
                "three edges, {} {}, {name}: {sag:.4} mm, exact {exact:.4}, off {:.2} %",
                case["bc"],
                case["free_edge"],
                100.0 * off
            );
            assert!(off.abs() < tolerance, "{name}: {sag} mm, not {exact}");
        }
    }
}

/// A strip of Sze's material, E = 1.2e6, nu = 0, 0.1 thick, 1 wide, held at x = 0; the other end as `held` says.
fn cantilever(length: f64, held: &str) -> Simulation {
    let text = format!(
        "name = \"sze\"\ndescription = \"Cantilever plate\"\nduration = 1.0\ngravity = [0.0, 0.0, 0.0]\n\
         sheet = {{ outline = {{ kind = \"rectangle\", length = {length:?}, width = 1.0 }}, edge = 0.33, \
         position = [{:?}, 0.0, 0.0] }}\n\
         [fabric]\nname = \"isotropic\"\nareal_density = 0.01\nthickness = 0.1\nyoung_warp = 1.2e6\n\
         young_weft = 1.2e6\nshear_modulus = 6e5\nrigidity_warp = 100.0\nrigidity_weft = 100.0\n\
         [support]\nroot = {{ kind = \"clamp\", region = {{ kind = \"x-min\" }} }}\n\
         end = {{ {held}, region = {{ kind = \"x-max\" }} }}\n",
        0.5 * length
    );
    simulation(&scene(&text))
}

/// Vertices of the far end.
fn end(simulation: &Simulation) -> Vec<usize> {
    let outline = &simulation.model().mesh.outline;
    let far = outline.iter().fold(0.0, |far: f64, p| far.max(p.x));
    (0..outline.len())
        .filter(|&v| outline[v].x > far - 1e-6)
        .collect()
}

fn mean(simulation: &Simulation, vertices: &[usize]) -> Vector3<f64> {
    let positions = &simulation.state().positions;
    vertices.iter().map(|&v| positions[v]).sum::<Vector3<f64>>() / vertices.len() as f64
}

/// Goes on from a changed state to rest.
fn settle(simulation: &mut Simulation, change: impl FnOnce(&mut State)) {
    let mut state = simulation.state().clone();
    change(&mut state);
    simulation.resume(state).unwrap();
    simulation.settle(1e-6).unwrap();
}

/// Sze, Liu, Lo 2004, 3.1: a transverse force at the end. The end's height is prescribed and the force read, row by
/// row; the table has three decimals, which is 1 % of the force in its first row.
#[test]
fn verify_sze_cantilever_under_end_shear() {
    let table = Table::new(END_SHEAR);
    let mut simulation = cantilever(10.0, "kind = \"pin\", axes = \"z\"");
    let end = end(&simulation);
    for row in table.rows(&[]) {
        let [part, shortening, height] =
            ["P_over_Pmax", "minus_U_tip", "W_tip"].map(|name| row.get(name));
        let lifted = mean(&simulation, &end).z;
        settle(&mut simulation, |state| {
            for p in &mut state.positions {
                let s = p.x / 10.0;
                // The linear cantilever's shape at first, then the shape before, stretched upwards.
                p.z = match lifted == 0.0 {
                    true => height * 0.5 * s * s * (3.0 - s),
                    false => p.z * height / lifted,
                };
            }
        });
        let forces = node_forces(&simulation);
        let force: f64 = end.iter().map(|&v| forces[v].z).sum();
        let moved = 10.0 - mean(&simulation, &end).x;
        println!(
            "end shear {part}: force {:.4}, U {moved:.4}, table {shortening}",
            force / 4.0
        );
        // 0.5 % of the length was asked for.
        assert!(
            (moved - shortening).abs() < 0.05,
            "U {moved}, not {shortening}"
        );
        assert!(
            (force / 4.0 / part - 1.0).abs() < 0.015,
            "force {} for {part}",
            force / 4.0
        );
    }
}

/// Sze, Liu, Lo 2004, 3.2: a moment at the end winds the strip up to a full circle. The end's slope is prescribed,
/// its place is not, and the moment is read.
#[test]
fn verify_sze_cantilever_under_end_moment() {
    let table = Table::new(END_MOMENT);
    let mut simulation = cantilever(12.0, "kind = \"clamp\", axes = \"y\"");
    let end = end(&simulation);
    let held = simulation.model().supports[0].edges.clone();
    let normals: Vec<f64> = held
        .iter()
        .map(|&e| simulation.model().mesh.edge_normal(e as usize).x)
        .collect();
    assert!(held.len() > 1 && normals.iter().all(|n| n.abs() > 0.999));
    let vertices = simulation.model().masses.len();
    for row in table.rows(&[]) {
        let part = row.get("M_over_Mmax");
        let (sin, cos) = (TAU * part).sin_cos();
        settle(&mut simulation, |state| {
            for (&e, n) in held.iter().zip(&normals) {
                state.slopes[e as usize] = Vector3::new(cos, 0.0, sin) * *n;
            }
        });
        let forces = node_forces(&simulation);
        let turning = Vector3::new(-sin, 0.0, cos);
        let moment: f64 = held
            .iter()
            .zip(&normals)
            .map(|(&e, n)| forces[vertices + e as usize].dot(&turning) * n)
            .sum();
        let tip = mean(&simulation, &end);
        let off = [
            12.0 - tip.x - row.get("minus_U_tip_exact"),
            tip.z - row.get("W_tip_exact"),
        ];
        let moment = moment / (100.0 * TAU / 12.0);
        println!("end moment {part}: moment {moment:.4}, off {off:.4?}");
        // 1 % of the length was asked for.
        assert!(off[0].hypot(off[1]) < 0.12, "at {part}: off by {off:?}");
        assert!(
            (moment / part - 1.0).abs() < 0.01,
            "moment {moment} for {part}"
        );
    }
}

/// A strip of F1 stands on its clamp, disturbed by 0.1 mm: sideways place of its upper end over its length, at rest.
fn standing(over_critical: f64) -> f64 {
    let fabric = toile::fabric::find("F1").unwrap();
    let bending_length = (fabric.rigidity_warp / (fabric.areal_density * 9.81)).cbrt();
    let length = over_critical * 1.98635 * bending_length;
    let text = format!(
        "name = \"standing\"\ndescription = \"A strip stands\"\nduration = 1.0\n\
         perturbation = {{ amplitude = 1e-4 }}\n\
         sheet = {{ outline = {{ kind = \"rectangle\", length = {length:?}, width = {:?} }}, edge = {:?}, \
         rotation = [0.0, -90.0, 0.0] }}\n\
         [fabric]\nname = \"F1\"\n\
         [support]\nfoot = {{ kind = \"clamp\", region = {{ kind = \"x-min\" }} }}\n",
        0.2 * length,
        length / 25.0
    );
    let mut simulation = simulation(&scene(&text));
    simulation.settle(1e-8).unwrap();
    let end = end(&simulation);
    let foot = simulation.model().supports[0].vertices[0] as usize;
    let across = mean(&simulation, &end) - simulation.state().positions[foot];
    across.x.abs() / length
}

/// Greenhill: the highest strip that stands has L = 1.98635 l.
#[test]
fn verify_a_strip_stands_up_to_its_critical_length() {
    let (low, high) = (standing(0.97), standing(1.03));
    println!(
        "standing strip: {low:.1e} L aside at 0.97 of the critical length, {high:.3} L at 1.03"
    );
    assert!(low < 1e-3, "it does not stand: {low}");
    assert!(high > 0.2, "it does not fall: {high}");
}

/// A ribbon on its edge, clamped at one end: whether it stays upright under its own weight, whose ratio to its bending
/// stiffness is `gamma` = rho g L^3 / D.
fn stays_on_edge(gamma: f64) -> bool {
    let (rigidity, weight) = (25e-6_f64, 0.2 * 9.81);
    let length = (gamma * rigidity / weight).cbrt();
    let text = format!(
        "name = \"ribbon\"\ndescription = \"A ribbon on its edge\"\nduration = 1.0\n\
         sheet = {{ outline = {{ kind = \"rectangle\", length = {length:?}, width = {:?} }}, edge = {:?}, \
         rotation = [90.0, 0.0, 0.0] }}\n\
         [fabric]\nname = \"ribbon\"\nareal_density = 0.2\nthickness = 0.5e-3\nyoung_warp = 1e8\nyoung_weft = 1e8\n\
         shear_modulus = 5e7\nrigidity_warp = {rigidity:?}\nrigidity_weft = {rigidity:?}\n\
         [support]\nroot = {{ kind = \"clamp\", region = {{ kind = \"x-min\" }} }}\n",
        0.04 * length,
        0.01 * length
    );
    let mut simulation = simulation(&scene(&text));
    simulation.settle(1e-6).unwrap().saddles == 0
}

/// Lateral buckling of a cantilever under its own weight (Timoshenko): q L^3 / sqrt(EI C) = 12.8538, where the twisting
/// stiffness C = 4 D66 W is 2 D W, so that rho g L^3 / D = 12.8538 sqrt(2).
#[test]
fn verify_lateral_buckling_of_a_ribbon_on_its_edge() {
    let (mut low, mut high) = (0.9, 1.1);
    let exact = 12.8538 * 2f64.sqrt();
    assert!(stays_on_edge(low * exact) && !stays_on_edge(high * exact));
    while high - low > 0.015 {
        let middle = 0.5 * (low + high);
        match stays_on_edge(middle * exact) {
            true => low = middle,
            false => high = middle,
        }
    }
    println!("a ribbon buckles at {low:.3} to {high:.3} of Timoshenko's load");
    // Asked for: 3 %. The clamp keeps the root from warping, which a ribbon of no width would not feel: one twice as wide
    // buckles at 1.04.
    assert!(low > 0.98 && high < 1.03, "{low} to {high}");
}

/// Sze, Liu, Lo 2004, 3.3: a ring, slit along a radius, is clamped on one side of the slit and lifted by a line load on
/// the other. A gap of a tenth of a degree stands for the slit.
#[test]
fn verify_sze_slit_annulus() {
    let table = Table::new(SLIT_ANNULUS);
    // E = 21e6, nu = 0, 0.03 thick, radii 6 and 10, at most 0.8 per length.
    let scene_of = |part: f64| {
        format!(
            "name = \"slit\"\ndescription = \"Slit annulus\"\nduration = 1.0\ngravity = [0.0, 0.0, 0.0]\n\
             sheet = {{ outline = {{ kind = \"sector\", outer = 20.0, inner = 12.0, angle = 359.9 }}, triangles = 3000 }}\n\
             [fabric]\nname = \"isotropic\"\nareal_density = 0.01\nthickness = 0.03\nyoung_warp = 21e6\n\
             young_weft = 21e6\nshear_modulus = 10.5e6\nrigidity_warp = 47.25\nrigidity_weft = 47.25\n\
             [support.slit]\nkind = \"clamp\"\nregion = {{ kind = \"box\", min = [5.9, -1e-6], max = [10.1, 1e-6] }}\n\
             [load.slit]\nregion = {{ kind = \"box\", min = [5.9, -0.02], max = [10.1, -1e-3] }}\n\
             force = [0.0, 0.0, {:?}]\n",
            3.2 * part
        )
    };
    let mut before: Option<State> = None;
    for row in table.rows(&[]) {
        let [part, inner, outer] = ["P_over_Pmax", "W_A", "W_B"].map(|name| row.get(name));
        if ![0.1, 0.25, 0.5, 1.0].contains(&part) {
            continue;
        }
        let mut simulation = simulation(&scene(&scene_of(part)));
        if let Some(state) = before.take() {
            simulation.resume(state).unwrap();
        }
        // Of the load; rounding alone, a stiffness of 6e5 N/m over 20 m, leaves 1e-5 of it.
        simulation.settle(1e-4).unwrap();
        let lifted = |radius: f64| {
            let outline = &simulation.model().mesh.outline;
            let at = |v: &usize| outline[*v].y < -1e-3 && outline[*v].y > -0.02;
            let vertex =
                (0..outline.len()).find(|v| at(v) && (outline[*v].norm() - radius).abs() < 1e-6);
            simulation.state().positions[vertex.unwrap()].z
        };
        let found = [lifted(6.0), lifted(10.0)];
        println!("slit annulus {part}: {found:.3?}, table {inner} {outer}");
        // 0.2 is 1.2 % of the largest displacement; the reference is itself a mesh of 10 x 80.
        assert!((found[0] - inner).abs() < 0.2, "{found:?}, not {inner}");
        assert!((found[1] - outer).abs() < 0.2, "{found:?}, not {outer}");
        before = Some(simulation.state().clone());
    }
}
