use nalgebra::{Rotation3, Vector3};

use super::test::{THICKNESS, brute, crumple, folded, square};
use super::{Candidates, Sweep, Tiles, may_meet};

type Point = Vector3<f64>;

/// While the sheet turns, is folded and crumples, what a renewed collection keeps holds what touches, at every step; and
/// most patches are not searched again.
#[test]
fn no_touching_pair_is_missed_in_motion() {
    let mesh = square(4e-3);
    let tiles = Tiles::new(&mesh, THICKNESS);
    assert!(tiles.patches.len() > 8, "{} patches", tiles.patches.len());
    let margin = 0.5 * tiles.span() - THICKNESS;
    let place = |time: f64| -> Vec<Point> {
        let (flat, crumpled) = (folded(&mesh, 1.2e-3 - 1e-3 * time), crumple(&mesh, 4e-3, 7));
        let turn = Rotation3::from_axis_angle(&Vector3::y_axis(), 3.0 * time);
        let waves = crumpled.iter().zip(&mesh.material);
        let waves = waves.map(|(p, q)| (p - q.push(0.0)) * time * time);
        flat.iter()
            .zip(waves)
            .map(|(p, w)| turn * (p + w))
            .collect()
    };
    let mut candidates = Candidates::default();
    let mut before = place(0.0);
    candidates.collect(&tiles, &mesh, &before, margin);
    let (mut touched, mut renewed, mut given) = (0, 0, 0);
    for step in 1..=300 {
        let positions = place(f64::from(step) / 300.0);
        let way = before.iter().zip(&positions).map(|(a, b)| (a - b).norm());
        let approach = 2.0 * way.fold(0.0, f64::max);
        if !candidates.move_by(approach)
            && let Some(found) = candidates.renew(&tiles, &mesh, &positions, margin)
        {
            (renewed, given) = (renewed + 1, given + found);
        }
        if step % 10 == 0 {
            let found = candidates.found();
            let touching = brute(&tiles, &mesh, &positions, THICKNESS);
            for kind in 0..2 {
                touched += touching[kind].len();
                let missed = touching[kind]
                    .iter()
                    .find(|pair| !found[kind].contains(pair));
                assert_eq!(missed, None, "kind {kind}, step {step}");
            }
            let (mut kept, mut fresh) = (vec![], vec![]);
            candidates.pairs(&tiles, &mesh, &positions, &mut kept);
            let mut again = Candidates::default();
            again.collect(&tiles, &mesh, &positions, 0.0);
            again.pairs(&tiles, &mesh, &positions, &mut fresh);
            assert_eq!(kept, fresh, "step {step}");
        }
        before = positions;
    }
    assert!(touched > 1000 && renewed > 5, "{touched} {renewed}");
    assert!(given > 0, "the searches find nothing");
}

/// Layers that come within a reach of each other on a straight way, as a look at all pairs at moments of it shows, are
/// never said not to; those that turn together, far from touching, are.
#[test]
fn no_meeting_on_the_way_is_missed() {
    let mesh = square(4e-3);
    let tiles = Tiles::new(&mesh, THICKNESS);
    let flat: Vec<Point> = mesh.material.iter().map(|p| p.push(0.0)).collect();
    let open = folded(&mesh, 20e-3);
    let turned = |sheet: &[Point], angle: f64| -> Vec<Point> {
        let turn = Rotation3::from_axis_angle(&Vector3::x_axis(), angle);
        sheet
            .iter()
            .map(|p| turn * p + Point::repeat(angle))
            .collect()
    };
    let ways = [
        ("turns", flat.clone(), turned(&flat, 0.5)),
        ("turns, bent", open.clone(), turned(&open, 0.3)),
        ("closes", folded(&mesh, 5e-3), folded(&mesh, 0.2e-3)),
        (
            "closes a little",
            folded(&mesh, 3e-3),
            folded(&mesh, 1.5e-3),
        ),
        ("crumples", flat.clone(), crumple(&mesh, 4e-3, 7)),
        ("crumples less", flat, crumple(&mesh, 0.5e-3, 7)),
        ("passes", crumple(&mesh, 4e-3, 7), crumple(&mesh, 4e-3, 8)),
    ];
    let (mut sweep, mut answers) = (Sweep::default(), [0, 0]);
    for (name, from, to) in &ways {
        for reach in [THICKNESS, 0.5 * (THICKNESS + tiles.span())] {
            let said = may_meet(&mut sweep, (&tiles, &mesh), [from, to], reach);
            let meets = (0..=8).any(|k| {
                let part = f64::from(k) / 8.0;
                let between = from.iter().zip(to).map(|(a, b)| a + (b - a) * part);
                let positions: Vec<Point> = between.collect();
                let near = brute(&tiles, &mesh, &positions, reach);
                near.iter().any(|pairs| !pairs.is_empty())
            });
            assert!(said || !meets, "{name}, reach {reach}: missed");
            assert!(!said || !name.starts_with("turns"), "{name}, reach {reach}");
            answers[usize::from(said)] += 1;
        }
    }
    assert!(answers[0] >= 5 && answers[1] >= 5, "{answers:?}");
}
