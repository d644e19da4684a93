//! Contacts of the sheet with itself, as whoever asks and as a recording tells them.

use std::collections::BTreeSet;
use std::fs;

use nalgebra::Vector3;
use tempfile::TempDir;
use toile::node::{RunOptions, run};
use toile::sim::SHEET;
use toile::wire::messages::toile_msgs::{ContactEvent, ContactEvents};
use toile::wire::{cdr, channels};

use crate::lab::simulation;
use crate::layers::{held, scene_of_a_fall};

/// The forces are those of the pairs, each on a face of its own and on the triangle that it names.
#[test]
fn contacts_of_layers_carry_what_their_pairs_do() {
    for scheme in ["central-difference", "bdf2"] {
        let scheme = format!("method.scheme={scheme}");
        let mut simulation = simulation(&held(&[&scheme, "output.rate=50"]));
        let mut seen = 0;
        while seen < 5 {
            let report = simulation.step().unwrap_or_else(|e| panic!("{e}"));
            assert!(report.time < 0.6, "nothing touches");
            let (count, contacts) = (report.layer_contacts, simulation.layer_contacts());
            assert!(count > 0 || contacts.is_empty());
            seen += contacts.len();
            // The explicit scheme damps what meets: its forces are not the law's alone.
            if scheme.ends_with("bdf2") {
                assert_eq!(count == 0, contacts.is_empty());
                let pairs: Vector3<f64> = simulation.layers().iter().map(|p| p.force).sum();
                let all: Vector3<f64> = contacts.iter().map(|c| c.normal * c.normal_force).sum();
                assert!(
                    (pairs - all).norm() < 1e-9 * (1.0 + pairs.norm()),
                    "{pairs} {all}"
                );
            }
            let mut keys = BTreeSet::new();
            let faces = &simulation.model().mesh.faces;
            for contact in &contacts {
                assert!(keys.insert(contact.key), "a key repeats");
                let other = contact
                    .obstacle
                    .strip_prefix(SHEET)
                    .expect("names the sheet");
                let other: usize = other.parse().expect("names a triangle");
                assert!(other < faces.len() && other != contact.face as usize);
                assert!(contact.slip_velocity.dot(&contact.normal).abs() < 1e-9);
                let slip = contact.friction_force.dot(&contact.normal).abs();
                assert!(
                    slip < 1e-3 * contact.normal_force + 1e-12,
                    "friction along the normal"
                );
            }
        }
    }
}

/// Friction of layers in the events: within the cone, and on it where they slide, against the slip. Explicit and
/// implicit, in a sheet that falls on itself.
#[test]
fn verify_friction_of_layers_is_on_the_cone() {
    for (scheme, dt) in [("central-difference", 1.0 / 60.0), ("bdf2", 1.0 / 240.0)] {
        let sets = [format!("method.scheme={scheme}"), format!("method.dt={dt}")];
        let mut set: Vec<&str> = sets.iter().map(String::as_str).collect();
        set.extend(["duration=0.5", "output.rate=50", "sheet.edge=8e-3"]);
        let scene = scene_of_a_fall(&set);
        let mut simulation = simulation(&scene);
        let (mut rubbed, mut sliding) = (0, 0);
        let mut before = BTreeSet::new();
        for _ in 0..scene.steps() {
            simulation.step().unwrap_or_else(|e| panic!("{e}"));
            let contacts = simulation.layer_contacts();
            let keys = contacts.iter().map(|contact| contact.key).collect();
            let known = std::mem::replace(&mut before, keys);
            for contact in contacts {
                let (force, slip) = (contact.friction_force, contact.slip_velocity);
                let share = force.norm() / (0.3 * contact.normal_force);
                assert!(share < 1.001, "{scheme}: {share} of the cone");
                rubbed += u32::from(share > 0.0);
                // The bond of a contact that has just begun may still be elastic.
                if slip.norm() > 0.1 && (scheme != "bdf2" || known.contains(&contact.key)) {
                    let cosine = force.dot(&slip) / (force.norm() * slip.norm());
                    assert!(
                        share > 0.99 && cosine < -0.5,
                        "{scheme}: {share} of the cone at {cosine} to the slip"
                    );
                    sliding += 1;
                }
            }
        }
        println!("{scheme}: {rubbed} contacts rub, {sliding} slide");
        assert!(sliding > 5, "{scheme}: {sliding} slide");
    }
}

/// A contact begins, persists at most ten times a second, and ends; each in its turn.
#[test]
fn a_recording_tells_when_layers_meet_and_part() {
    let dir = TempDir::new().expect("a directory");
    let path = dir.path().join("a.mcap");
    let options = RunOptions {
        output: Some(path.clone()),
        ..RunOptions::default()
    };
    let scene = held(&["output.rate=50", "method.dt=0.005"]);
    let summary = run(&scene, options, &mut |_| {}).expect("runs");
    let layers = summary.layers;
    assert!(
        layers.from.is_some_and(|from| from > 0.1 && from < 0.6),
        "{layers:?}"
    );
    assert!((5..summary.steps).contains(&layers.steps), "{layers:?}");
    let bytes = fs::read(&path).expect("read");
    let messages = mcap::MessageStream::new(&bytes).expect("an MCAP file");
    let (mut open, mut begun, mut tenth) = (BTreeSet::new(), 0, BTreeSet::new());
    for message in messages.map(|m| m.expect("an undamaged message")) {
        if message.channel.topic != channels::CONTACTS.topic {
            continue;
        }
        let said: ContactEvents = cdr::decode(&message.data).expect("decodes");
        let persists = |e: &ContactEvent| e.phase == ContactEvent::PERSIST;
        if said.events.iter().any(persists) {
            let turn = (message.log_time as f64 * 1e-8 + 1e-9).floor() as u64;
            assert!(tenth.insert(turn), "said twice in a tenth of a second");
        }
        for event in said.events.iter().filter(|e| e.obstacle.starts_with(SHEET)) {
            match event.phase {
                ContactEvent::BEGIN => {
                    assert!(open.insert(event.key), "begins twice");
                    begun += 1;
                }
                ContactEvent::PERSIST => assert!(open.contains(&event.key), "was not there"),
                _ => assert!(open.remove(&event.key), "ends without being there"),
            }
        }
    }
    println!("{begun} contacts of layers began");
    assert!(begun > 5);
}
