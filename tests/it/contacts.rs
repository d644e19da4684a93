//! Contacts as they leave the node: forces that carry the weight, friction on its cone, events, wrenches, markers.

use nalgebra::Vector3;
use toile::contact::{Obstacle, Pose, Shape, Velocity};
use toile::sim::{Command, ContactPoint, Simulation};
use toile::wire::messages::toile_msgs::{ContactEvent, ContactEvents};
use toile::wire::messages::visualization_msgs::{Marker, MarkerArray};
use toile::wire::{ContactWatch, cdr, channels, wrench};

use crate::friction::{SLOPE, incline};
use crate::lab::{built_in, simulation};

const SCHEMES: [(&str, f64); 2] = [("bdf2", 1e-4), ("central-difference", 1e-3)];

fn weight(simulation: &Simulation) -> f64 {
    9.81 * simulation.model().masses.iter().sum::<f64>()
}

fn after(scheme: &str, friction: f64, seconds: f64) -> Simulation {
    let mut simulation = simulation(&incline(scheme, friction, seconds));
    for _ in 0..(seconds / 2e-3) as usize {
        simulation.step().expect("converges");
    }
    simulation
}

fn total(contacts: &[ContactPoint], part: fn(&ContactPoint) -> Vector3<f64>) -> Vector3<f64> {
    contacts.iter().map(part).sum()
}

/// A sheet at rest on a slope: normal forces carry m g cos, friction m g sin.
#[test]
fn verify_contact_forces_at_rest_carry_the_weight() {
    for (scheme, tolerance) in SCHEMES {
        let simulation = after(scheme, 1.2 * SLOPE.tan(), 1.0);
        let (contacts, weight) = (simulation.contacts(), weight(&simulation));
        assert_eq!(contacts.len() as u64, simulation.report().contacts);
        let normal = total(&contacts, |c| c.normal * c.normal_force) / weight;
        let friction = total(&contacts, |c| c.friction_force) / weight;
        println!("{scheme}: normal {normal:?}, friction {friction:?} of the weight");
        assert!((normal - Vector3::z() * SLOPE.cos()).norm() < tolerance);
        assert!((friction + Vector3::x() * SLOPE.sin()).norm() < tolerance);
    }
}

/// A sheet that slides: every contact is on the cone, against its slip.
#[test]
fn verify_friction_of_a_sliding_sheet_is_on_the_cone() {
    let mu = 0.5 * SLOPE.tan();
    for (scheme, _) in SCHEMES {
        let simulation = after(scheme, mu, 0.2);
        let contacts = simulation.contacts();
        let normal: f64 = contacts.iter().map(|c| c.normal_force).sum();
        let against = |c: &ContactPoint| {
            let direction = c.slip_velocity.normalize();
            assert!(c.slip_velocity.z == 0.0 && c.slip_velocity.x > 0.1);
            -c.friction_force.dot(&direction)
        };
        let friction: f64 = contacts.iter().map(against).sum();
        println!("{scheme}: {} of mu", friction / normal / mu);
        assert!((friction / (mu * normal) - 1.0).abs() < 1e-3, "{scheme}");
    }
}

fn contact(obstacle: &str, key: u64, point: [f64; 3], force: f64) -> ContactPoint {
    ContactPoint {
        obstacle: obstacle.into(),
        key,
        face: 7,
        point: point.into(),
        normal: Vector3::z(),
        normal_force: force,
        friction_force: Vector3::new(0.5, 0.0, 0.0),
        slip_velocity: Vector3::zeros(),
        overlap: false,
    }
}

fn obstacle(name: &str) -> Obstacle {
    let quarter = Vector3::new(0.0, 0.0, std::f64::consts::FRAC_PI_2);
    Obstacle {
        name: name.into(),
        shape: Shape::Plane,
        pose: Pose::new(Vector3::new(1.0, 0.0, 0.0), quarter),
        velocity: Velocity::default(),
        friction: 0.0,
        ..Obstacle::default()
    }
}

/// The cloth pushes with (-0.5, 0, -2) N at (0, 0.1, 0) m from the origin of an obstacle that faces left: in the
/// obstacle's axes that is (0, 0.5, -2) N at (0.1, 0, 0) m.
#[test]
fn verify_a_wrench_is_about_the_origin_in_the_axes_of_the_obstacle() {
    let contacts = [
        contact("table", 1, [1.0, 0.1, 0.0], 2.0),
        contact("other", 1, [1.0, 0.1, 0.0], 2.0),
    ];
    let found = wrench(&obstacle("table"), &contacts, 0.5);
    assert_eq!(found.header.frame_id, "table");
    let (force, torque) = (&found.wrench.force, &found.wrench.torque);
    let near = |a: [f64; 3], b: [f64; 3]| (Vector3::from(a) - Vector3::from(b)).norm() < 1e-14;
    assert!(near([force.x, force.y, force.z], [0.0, 0.5, -2.0]));
    assert!(near([torque.x, torque.y, torque.z], [0.0, 0.2, 0.05]));
}

/// Phases of the events of an output, by obstacle and key; nothing if there was no message.
fn phases(
    watch: &mut ContactWatch,
    contacts: Vec<ContactPoint>,
    time: f64,
) -> Vec<(String, u64, u8)> {
    let packets = watch.packets(&[], contacts, time, false).expect("encodes");
    let mut messages = packets.iter().filter(|p| p.channel == &channels::CONTACTS);
    let events = messages.next().map_or(vec![], |packet| {
        let message: ContactEvents = cdr::decode(&packet.bytes).expect("decodes");
        message.events
    });
    let phase = |e: ContactEvent| (e.obstacle, e.key, e.phase);
    events.into_iter().map(phase).collect()
}

#[test]
fn contacts_begin_persist_and_end() {
    let mut watch = ContactWatch::default();
    let [a, b, c] = [("a", 1), ("b", 1), ("b", 2)].map(|(o, k)| contact(o, k, [0.0; 3], 1.0));
    let event = |o: &str, k, phase| (o.to_string(), k, phase);
    assert!(phases(&mut watch, vec![], 0.0).is_empty());
    let first = phases(&mut watch, vec![c.clone(), a.clone()], 0.01);
    let begin = ContactEvent::BEGIN;
    assert_eq!(first, [event("a", 1, begin), event("b", 2, begin)]);
    let second = phases(&mut watch, vec![b.clone(), c.clone()], 0.11);
    let expected = [
        event("a", 1, ContactEvent::END),
        event("b", 1, begin),
        event("b", 2, ContactEvent::PERSIST),
    ];
    assert_eq!(second, expected);
    // Within the same tenth of a second, what goes on is not said again.
    assert!(phases(&mut watch, vec![b.clone(), c.clone()], 0.15).is_empty());
    assert_eq!(phases(&mut watch, vec![b, c], 0.2).len(), 2);
    assert_eq!(phases(&mut watch, vec![], 0.21).len(), 2);
    assert!(phases(&mut watch, vec![], 0.3).is_empty());
}

#[test]
fn contact_markers_are_drawn_while_there_are_contacts() {
    let mut watch = ContactWatch::default();
    let mut drawn = |contacts: Vec<ContactPoint>| -> MarkerArray {
        let packets = watch.packets(&[obstacle("a")], contacts, 0.0, true);
        let packets = packets.expect("encodes");
        assert_eq!(
            packets[packets.len() - 2].topic(),
            "/toile/obstacles/a/wrench"
        );
        cdr::decode(&packets[packets.len() - 1].bytes).expect("decodes")
    };
    let with = drawn(vec![contact("a", 1, [0.0; 3], 1.0)]).markers;
    assert_eq!([with[0].points.len(), with[1].points.len()], [1, 2]);
    let length = Vector3::new(
        with[1].points[1].x,
        with[1].points[1].y,
        with[1].points[1].z,
    )
    .norm();
    assert!((length - 0.03).abs() < 1e-12);
    let without = drawn(vec![]).markers;
    assert!(without.iter().all(|m| m.action == Marker::DELETE));
}

/// What is asked of a simulation is there after a command too: the obstacle is gone, and with it its contacts.
#[test]
fn a_removed_obstacle_has_no_contacts() {
    for (scheme, _) in SCHEMES {
        let method = format!("method.scheme={scheme}");
        let set = [
            "sheet.triangles=200",
            "accept=[\"obstacles\"]",
            "duration=1",
            &method,
        ];
        let mut simulation = simulation(&built_in("drape-table", &set));
        simulation.step().expect("converges");
        assert!(!simulation.contacts().is_empty());
        let name = simulation.state().obstacles[0].name.clone();
        let remove = Command::RemoveObstacle { name };
        simulation.apply(&remove).expect("accepted");
        assert!(simulation.contacts().is_empty());
    }
}

/// Newton's third law, in motion: what the contacts do to the cloth is what its momentum, weight and damping say, and
/// the wrenches on the obstacles are the opposite.
#[test]
fn verify_contact_forces_close_the_balance_of_momentum() {
    let ball = "obstacle.ball={ shape = { kind = \"sphere\", radius = 0.02 }, position = [0.01, 0.0, -0.0215], friction = 0.4 }";
    let set = ["damping=0.3", "method.tolerance=1e-9", ball];
    let mut simulation = simulation(&crate::commands::sheet(toile::scene::Scheme::Bdf2, &set));
    for step in 0..60 {
        simulation.step().expect("converges");
        let (model, state) = (simulation.model(), simulation.state());
        let balance: Vector3<f64> = (0..model.masses.len())
            .map(|v| {
                let (mass, area) = (model.masses[v], model.mesh.vertex_areas[v]);
                let weight = Vector3::new(0.0, 0.0, -9.81 * mass);
                state.history.accelerations[v] * mass + state.velocities[v] * (0.3 * area) - weight
            })
            .sum();
        let contacts = simulation.contacts();
        let given = total(&contacts, ContactPoint::force);
        let wrench = wrench(&state.obstacles[0], &contacts, 0.0).wrench.force;
        let taken = Vector3::new(wrench.x, wrench.y, wrench.z);
        let open = (balance - given).norm() / model.weight;
        if step % 10 == 0 {
            println!(
                "{} contacts, {:.2} weights, {open:.1e} open",
                contacts.len(),
                given.norm() / model.weight
            );
        }
        assert!(open < 1e-8, "step {step}: {open}");
        assert!(
            (taken + given).norm() < 1e-14 * given.norm().max(1e-9),
            "{taken} {given}"
        );
    }
    assert!(!simulation.contacts().is_empty());
}

/// A draped sheet at rest weighs its weight on the table.
#[test]
fn verify_a_draped_sheet_weighs_its_weight() {
    let set = [
        "sheet.triangles=150",
        "damping=3.0",
        "duration=4",
        "method.dt=0.02",
    ];
    let mut simulation = simulation(&built_in("drape-table", &set));
    let mut forces = vec![];
    for step in 0..200 {
        simulation.step().expect("is stable");
        if step >= 150 {
            let force = wrench(
                &simulation.state().obstacles[0],
                &simulation.contacts(),
                0.0,
            )
            .wrench
            .force;
            forces.push(-force.z / weight(&simulation));
        }
    }
    let mean = forces.iter().sum::<f64>() / forces.len() as f64;
    println!("{mean:.6} of the weight, from {forces:?}");
    assert!((mean - 1.0).abs() < 1e-3, "{mean}");
}

/// No buffer ends: thousands of contacts are all there, and all of them are in the wrench.
#[test]
fn thousands_of_contacts_are_all_counted() {
    let plane = "obstacle.plane={ shape = { kind = \"plane\" }, position = [0.0, 0.0, -2.4e-4] }";
    let set = ["sheet.triangles=20000", plane];
    let simulation = simulation(&crate::commands::sheet(toile::scene::Scheme::Bdf2, &set));
    let contacts = simulation.contacts();
    assert_eq!(contacts.len(), simulation.model().masses.len());
    assert_eq!(contacts.len() as u64, simulation.report().contacts);
    let each = contacts[0].normal_force;
    let wrench = wrench(&simulation.state().obstacles[0], &contacts, 0.0)
        .wrench
        .force;
    let sum = each * contacts.len() as f64;
    assert!(each > 0.0 && contacts.len() > 9000, "{}", contacts.len());
    assert!((wrench.z / sum + 1.0).abs() < 1e-9, "{} {sum}", wrench.z);
}
