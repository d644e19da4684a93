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
use crate::layers::held;

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
            assert_eq!(count == 0, contacts.is_empty());
            seen += contacts.len();
            let pairs: Vector3<f64> = simulation.layers().iter().map(|p| p.force).sum();
            let all: Vector3<f64> = contacts.iter().map(|c| c.normal * c.normal_force).sum();
            assert!(
                (pairs - all).norm() < 1e-9 * (1.0 + pairs.norm()),
                "{pairs} {all}"
            );
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
    run(&scene, options, &mut |_| {}).expect("runs");
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
