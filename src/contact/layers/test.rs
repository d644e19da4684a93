use nalgebra::{Rotation3, Vector2, Vector3};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;

use super::closest::between;
use super::features::{distance, features, nodes};
use super::fit::Fit;
use super::hunt::Fits;
use super::sweep::advance;
use super::{Candidates, Pair, Sweep, Tiles, crosses, crossings, safe_share};
use crate::sheet::{Mesh, MeshOptions, Outline, generate};

type Point = Vector3<f64>;

pub(super) const THICKNESS: f64 = 0.5e-3;

pub(super) fn mesh(outline: Outline, edge: f64) -> Mesh {
    generate(
        &outline,
        &MeshOptions {
            edge,
            jitter: 0.1,
            seed: 3,
            warp_angle: 0.4,
        },
    )
}

pub(super) fn square(edge: f64) -> Mesh {
    let (length, width) = (0.06, 0.05);
    mesh(Outline::Rectangle { length, width }, edge)
}

/// A search takes or leaves a group whole, by its patches: on meshes of few tiles these are the finest tiles.
#[test]
fn near_features_of_a_group_are_of_its_patches() {
    for edge in [1.3e-3, 6e-3] {
        let tiles = Tiles::new(&square(edge), THICKNESS);
        assert!(!tiles.near.is_empty());
        for near in &tiles.near {
            for &(edges, pair) in &near.pairs {
                let [a, b] = tiles.patches_of(edges, pair);
                assert!(near.patches == [a, b] || near.patches == [b, a], "{pair:?}");
            }
        }
    }
}

/// A crumpled place: waves of random direction and phase, of an amplitude \[m\], along the normal and in the plane.
pub(super) fn crumple(mesh: &Mesh, amplitude: f64, seed: u64) -> Vec<Point> {
    let mut random = Pcg64::seed_from_u64(seed);
    let mut draw = || random.random::<f64>() - 0.5;
    let waves: Vec<(Vector2<f64>, f64, Point)> = (0..12)
        .map(|_| {
            let number = Vector2::new(draw(), draw()) * 600.0;
            (
                number,
                10.0 * draw(),
                Point::new(draw(), draw(), 2.0 * draw()),
            )
        })
        .collect();
    let place = |p: &Vector2<f64>| {
        let wave = |(k, phase, way): &(Vector2<f64>, f64, Point)| way * (k.dot(p) + phase).cos();
        p.push(0.0) + waves.iter().map(wave).sum::<Point>() * amplitude
    };
    mesh.material.iter().map(place).collect()
}

/// The sheet folded over a bar of a radius \[m\] along a line askew to the mesh: two layers, twice the radius apart.
pub(super) fn folded(mesh: &Mesh, radius: f64) -> Vec<Point> {
    let turn = Rotation3::from_axis_angle(&Vector3::z_axis(), 0.7);
    let arc = std::f64::consts::PI * radius;
    let place = |p: &Vector2<f64>| {
        let q = turn * p.push(0.0);
        let (x, z) = match q.x {
            x if x < 0.0 => (x, 0.0),
            x if x < arc => (
                radius * (x / radius).sin(),
                radius * (1.0 - (x / radius).cos()),
            ),
            x => (arc - x, 2.0 * radius),
        };
        Point::new(x, q.y, z)
    };
    mesh.material.iter().map(place).collect()
}

fn states(mesh: &Mesh) -> Vec<(String, Vec<Point>)> {
    let mut states = vec![(
        "flat".to_string(),
        mesh.material.iter().map(|p| p.push(0.0)).collect(),
    )];
    for radius in [0.2e-3, 0.24e-3, 0.4e-3, 1e-3, 4e-3] {
        states.push((format!("folded over {radius}"), folded(mesh, radius)));
    }
    for (seed, amplitude) in [(1, 1e-3), (2, 3e-3), (3, 1e-2), (4, 3e-2)] {
        states.push((
            format!("crumpled by {amplitude}"),
            crumple(mesh, amplitude, seed),
        ));
    }
    states
}

/// All pairs of features that share no vertex and are not excluded, closer than a reach.
pub(super) fn brute(
    tiles: &Tiles,
    mesh: &Mesh,
    positions: &[Point],
    reach: f64,
) -> [Vec<[u32; 2]>; 2] {
    let mut found = [vec![], vec![]];
    let counts = [
        (mesh.material.len(), mesh.faces.len()),
        (mesh.edges.len(), mesh.edges.len()),
    ];
    for (kind, (first, second)) in counts.into_iter().enumerate() {
        for a in 0..first as u32 {
            let from = if kind == 1 { a + 1 } else { 0 };
            for b in from..second as u32 {
                let n = nodes(mesh, kind == 1, [a, b]);
                let split = 1 + kind;
                let shared = n[..split].iter().any(|v| n[split..].contains(v));
                let near = || distance(mesh, positions, kind == 1, [a, b]) < reach;
                if !shared && near() && !tiles.excludes(kind == 1, [a, b]) {
                    found[kind].push([a, b]);
                }
            }
        }
    }
    found
}

/// What the tiles skip is skipped rightly: every pair that a look at all pairs finds is found, in every state.
#[test]
fn no_near_pair_is_missed() {
    let disc = Outline::Disc { diameter: 0.05 };
    let ring = Outline::Annulus {
        outer: 0.05,
        inner: 0.02,
    };
    let slit = Outline::Sector {
        outer: 0.05,
        inner: 0.02,
        angle: 350.0,
    };
    // The finest mesh has edges shorter than the cloth is thick.
    let cases = [
        (square(4e-3), 1.0),
        (mesh(disc, 3e-3), 1.0),
        (mesh(ring, 3e-3), 1.0),
        (mesh(slit, 3e-3), 1.0),
        (
            mesh(
                Outline::Rectangle {
                    length: 8e-3,
                    width: 7e-3,
                },
                0.35e-3,
            ),
            0.15,
        ),
    ];
    for (mesh, scale) in cases {
        let tiles = Tiles::new(&mesh, THICKNESS);
        let mut touched = 0;
        for (name, positions) in states(&mesh) {
            for margin in [0.0, 0.3e-3, 0.6 * tiles.span() - THICKNESS] {
                let mut candidates = Candidates::default();
                candidates.collect(&tiles, &mesh, &positions, margin);
                let wanted = brute(&tiles, &mesh, &positions, THICKNESS + margin);
                assert_eq!(
                    candidates.found(),
                    wanted,
                    "{name}, margin {margin}, scale {scale}"
                );
                touched += candidates.len();
            }
        }
        assert!(touched > 1000, "{touched}: the states test nothing");
    }
}

/// The certificate skips: a flat or gently folded sheet needs no look at any pair of faces.
#[test]
fn the_certificate_skips_what_is_far_from_touching() {
    let mesh = square(1.5e-3);
    let tiles = Tiles::new(&mesh, THICKNESS);
    let visits = |positions: &[Point]| {
        let mut fit = Fit::default();
        fit.over(&tiles, &mesh, positions);
        let mut count = 0;
        Fits([&mut fit]).near_faces((&tiles, &mesh), THICKNESS, |_, _| count += 1);
        count
    };
    let states = states(&mesh);
    assert_eq!(visits(&states[0].1), 0, "flat");
    assert_eq!(visits(&folded(&mesh, 20e-3)), 0, "gently folded");
    assert!(visits(&states[1].1) > 100, "touching");
}

/// Sum over the pairs of a point with a patch of faces.
fn potential(tiles: &Tiles, mesh: &Mesh, positions: &[Point]) -> (f64, Vec<Pair>) {
    let mut candidates = Candidates::default();
    candidates.collect(tiles, mesh, positions, 0.0);
    let mut pairs = vec![];
    candidates.pairs(tiles, mesh, positions, &mut pairs);
    pairs.retain(|pair| !pair.of_edges());
    let gap = |pair: &Pair| pair.share * (THICKNESS - pair.distance).powi(3) / THICKNESS.powi(3);
    (pairs.iter().map(gap).sum(), pairs)
}

/// Two sheets, one over the other, as one mesh: the upper is a single small triangle that is drawn over the lower, which
/// is flat or has a ridge or a valley. Over flat cloth each vertex counts once, wherever it is; nowhere is there a jump.
#[test]
fn every_point_counts_once_and_nothing_jumps() {
    for (name, slope) in [("flat", 0.0), ("ridge", -0.4), ("valley", 0.4)] {
        let lower = mesh(
            Outline::Rectangle {
                length: 0.02,
                width: 0.02,
            },
            2e-3,
        );
        let mut material = lower.material.clone();
        let mut faces = lower.faces.clone();
        let first = material.len() as u32;
        material.extend([[0.1, 0.1], [0.101, 0.1], [0.1, 0.101]].map(Vector2::from));
        faces.push([first, first + 1, first + 2]);
        let both = Mesh::new(material.clone(), material.clone(), faces);
        let tiles = Tiles::new(&both, THICKNESS);
        let bent = |p: &Vector2<f64>| Point::new(p.x, p.y, slope * p.x.abs());
        let mut positions: Vec<Point> = material.iter().map(bent).collect();
        let (mut last, steps) = (None, 4000);
        for k in 0..steps {
            let x = -4e-3 + 8e-3 * f64::from(k) / f64::from(steps);
            let (y, z) = (0.7e-3 * (900.0 * x).sin(), slope * x.abs() + 0.4e-3);
            let tip = Point::new(x, y, z);
            let away = Point::new(0.0, 0.0, 1e-2);
            for (n, place) in [tip, tip + away, tip + away * 1.2].into_iter().enumerate() {
                positions[first as usize + n] = place;
            }
            let (sum, pairs) = potential(&tiles, &both, &positions);
            if slope == 0.0 {
                let count: f64 = pairs
                    .iter()
                    .filter(|p| p.nodes[0] == first)
                    .map(|p| p.share)
                    .sum();
                assert_eq!(count, 1.0, "{name} at {x}: {pairs:?}");
            }
            assert!(sum > 1e-4, "{name} at {x}: {sum}");
            if let Some(last) = last {
                let jump: f64 = sum - last;
                assert!(
                    jump.abs() < 0.01,
                    "{name} at {x}: a jump of {jump} to {sum}"
                );
            }
            last = Some(sum);
        }
    }
}

/// A segment through a triangle, beside it, in its plane, ending on it: only the first crosses.
#[test]
fn crossing_is_exact() {
    let v = Vector3::new;
    let [a, b, c] = [v(0.0, 0.0, 0.0), v(1.0, 0.0, 0.0), v(0.0, 1.0, 0.0)];
    let crossing = |p: Point, q: Point| crosses([&p, &q], [&a, &b, &c]);
    assert!(crossing(v(0.2, 0.2, -1.0), v(0.3, 0.3, 1e-300)));
    assert!(!crossing(v(0.2, 0.2, -1.0), v(0.3, 0.3, 0.0)));
    assert!(!crossing(v(0.7, 0.7, -1.0), v(0.7, 0.7, 1.0)));
    assert!(!crossing(v(0.2, 0.2, 0.0), v(0.9, 0.2, 0.0)));
    assert!(!crossing(v(0.2, 0.2, 1.0), v(0.3, 0.3, 2.0)));
}

/// Crossings among the near faces of the tiles are those of all pairs of faces.
#[test]
fn crossings_are_all_found() {
    let mesh = square(4e-3);
    let tiles = Tiles::new(&mesh, THICKNESS);
    let mut most = 0;
    for (name, positions) in states(&mesh) {
        let mut candidates = Candidates::default();
        candidates.collect(&tiles, &mesh, &positions, 0.0);
        let mut near = vec![];
        candidates.near_faces((&tiles, &mesh), &mut near);
        let count = mesh.faces.len() as u32;
        let all = (0..count).flat_map(|f| (f + 1..count).map(move |g| [f, g]));
        let wanted = crossings(&mesh, &positions, all);
        let found = crossings(&mesh, &positions, near.into_iter());
        assert_eq!(found, wanted, "{name}");
        most = most.max(found.len());
    }
    assert!(most > 20, "{most}: no state crosses itself");
}

/// A safe motion crosses nothing, an unsafe one is cut before it does.
#[test]
fn a_safe_share_of_a_motion_crosses_nothing() {
    let mesh = square(4e-3);
    let tiles = Tiles::new(&mesh, THICKNESS);
    let count = mesh.faces.len() as u32;
    let all = || (0..count).flat_map(|f| (f + 1..count).map(move |g| [f, g]));
    let from = folded(&mesh, 1e-3);
    let mut cut = 0;
    for (seed, amplitude) in [(1, 1e-4), (2, 1e-3), (3, 4e-3), (4, 2e-2)] {
        let flat = mesh.material.iter().map(|p| p.push(0.0));
        let crumpled = crumple(&mesh, amplitude, seed);
        let places = from.iter().zip(crumpled.iter().zip(flat));
        let to: Vec<Point> = places.map(|(p, (q, o))| p + q - o).collect();
        let share = safe_share(&mut Sweep::default(), (&tiles, &mesh), &from, &to);
        let moved: Vec<Point> = from
            .iter()
            .zip(&to)
            .map(|(p, q)| p + (q - p) * share)
            .collect();
        assert!(
            share > 0.0 && crossings(&mesh, &moved, all()).is_empty(),
            "{amplitude}"
        );
        let crosses = !crossings(&mesh, &to, all()).is_empty();
        assert!(
            !crosses || share < 1.0,
            "{amplitude}: crosses, yet share {share}"
        );
        cut += u32::from(share < 1.0);
    }
    assert!((1..4).contains(&cut), "{cut} of 4 motions are cut");
}

/// A vertex that falls through a face and an edge through an edge: cut just before they meet.
#[test]
fn advancement_stops_short_of_the_meeting() {
    let v = Vector3::new;
    let face = [
        v(0.1, 0.1, 1.0),
        v(-1.0, -1.0, 0.0),
        v(1.0, -1.0, 0.0),
        v(0.0, 1.0, 0.0),
    ];
    let edges = [
        v(-1.0, 0.0, 1.0),
        v(1.0, 0.1, 1.0),
        v(0.0, -1.0, 0.0),
        v(0.1, 1.0, 0.0),
    ];
    for (of_edges, x, moving) in [(false, face, 1), (true, edges, 2)] {
        let drop = std::array::from_fn(|n| {
            if n < moving {
                v(0.0, 0.0, -4.0)
            } else {
                Point::zeros()
            }
        });
        let share = advance(of_edges, x, drop, 1.0);
        assert!(share > 0.2 && share < 0.25, "{share}");
        let there: [Point; 4] = std::array::from_fn(|n| x[n] + drop[n] * share);
        assert!(between(of_edges, &there) > 0.05);
        assert_eq!(advance(of_edges, x, drop, 0.2), 0.2);
        assert_eq!(advance(of_edges, x, drop.map(|d: Point| -d), 1.0), 1.0);
    }
}

/// Every pair of features of the mesh has exactly one pair of faces that answers for it.
#[test]
fn features_are_met_once() {
    let mesh = mesh(Outline::Disc { diameter: 0.02 }, 3e-3);
    let tiles = Tiles::new(&mesh, THICKNESS);
    let count = mesh.faces.len() as u32;
    let mut met = [vec![], vec![]];
    for f in 0..count {
        for g in f + 1..count {
            features(&tiles, &mesh, [f, g], |edges, pair| {
                met[usize::from(edges)].push(pair)
            });
        }
    }
    let flat: Vec<Point> = mesh.material.iter().map(|p| p.push(0.0)).collect();
    let wanted = brute(&tiles, &mesh, &flat, f64::INFINITY);
    met.iter_mut().for_each(|list| list.sort_unstable());
    for kind in 0..2 {
        let kept: Vec<_> = met[kind]
            .iter()
            .filter(|p| !tiles.excludes(kind == 1, **p))
            .copied()
            .collect();
        assert_eq!(kept, wanted[kind]);
    }
}
