//! A flood of what no well-behaved peer sends: nothing falls over, nothing changes, nothing goes uncounted.

use std::collections::BTreeSet;
use std::ops::Range;
use std::thread::sleep;
use std::time::Duration;

use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;
use toile::node::ros2::{Participant, Peer, Writer};
use toile::wire::cdr::{ENCAPSULATION, decode, encode};
use toile::wire::channels::{APPLIED, Qos};
use toile::wire::inbound::{self, Inlet, InletKind};
use toile::wire::messages::geometry_msgs::Vector3Stamped;
use toile::wire::messages::toile_msgs::AppliedCommand;

use super::rig::{Rig, SCENE, recorded, wait};
use super::supervision::assert_undisturbed;

const PAYLOADS: u64 = 100_000;

#[test]
fn a_hundred_thousand_hostile_payloads_change_nothing_and_are_all_counted() {
    let mut rig = Rig::start(SCENE, &["--pace", "real"]);
    let mut participant = Participant::join(&rig.settings()).unwrap();
    let writers: Vec<_> = inbound::ALL
        .iter()
        .filter(|inlet| inlet.kind == InletKind::Topic)
        .map(|inlet| connected(&mut participant, inlet))
        .collect();
    let mut draws = Pcg64Mcg::seed_from_u64(7);
    let count = writers.len() as u64;
    let mut flood = |payloads: Range<u64>| {
        for k in payloads {
            let writer = &writers[(k % count) as usize];
            let payload = hostile(&mut draws);
            // A full window is the writer's way to say that the bridge has not caught up.
            wait("room for one more payload", || {
                let sent = writer.write(&payload);
                if !sent {
                    sleep(Duration::from_millis(1));
                }
                sent.then_some(())
            });
        }
    };
    // What is lost is seen from a writer's first message on.
    let mut peer = Peer::join(rig.settings()).unwrap();
    let mut applied = peer.subscribe(&APPLIED, APPLIED.topic).unwrap();
    wait("the bridge to be there", || {
        (applied.publishers() > 0).then_some(())
    });
    let (mut sent, mut heard) = (0, BTreeSet::new());
    wait("a rejection on every topic", || {
        flood(sent..sent + count);
        sent += count;
        sleep(Duration::from_millis(200));
        while let Some(sample) = applied.take() {
            let told: AppliedCommand = decode(&sample.bytes).unwrap();
            heard.insert(told.channel);
        }
        (heard.len() as u64 == count).then_some(())
    });
    flood(sent..PAYLOADS);
    for writer in &writers {
        assert!(
            writer.acknowledged(Duration::from_secs(60)),
            "all have arrived"
        );
    }
    // What has arrived is taken within the next looks of the bridge and the next step of the run.
    sleep(Duration::from_secs(2));
    let (summary, errors) = rig.stop();
    let bridge = &summary["bridge"];
    let counted = |name: &str| bridge["traffic"][name].as_u64().unwrap();
    assert_eq!(bridge["restarts"], 0, "{errors}");
    assert_eq!(counted("received") + counted("lost"), PAYLOADS, "{bridge}");
    assert_eq!(
        counted("received"),
        counted("delivered") + counted("dropped") + counted("refused"),
        "{bridge}"
    );
    let told: Vec<AppliedCommand> = recorded(&rig.recording(), "/toile/applied");
    assert!(
        told.iter()
            .all(|command| !command.accepted && !command.reason.is_empty())
    );
    let dropped = summary["commands"]["dropped"].as_u64().unwrap();
    assert_eq!(
        told.len() as u64 + dropped,
        counted("delivered"),
        "{summary}"
    );
    assert!(
        told.len() as u64 > PAYLOADS / 100,
        "the run has seen {}",
        told.len()
    );
    assert_undisturbed(&rig.recording());
}

fn connected(participant: &mut Participant, inlet: &Inlet) -> Writer {
    let topic = format!("rt{}", inlet.name);
    let kind = inlet.request.name.replace("/msg/", "::msg::dds_::") + "_";
    let mut writer = participant.writer(&topic, &kind, Qos::Reliable).unwrap();
    wait("a subscription of the bridge", || {
        (writer.subscriptions() > 0).then_some(())
    });
    writer
}

/// Noise, messages cut short, lengths beyond the end, numbers that are none.
fn hostile(draws: &mut Pcg64Mcg) -> Vec<u8> {
    let mut wind = Vector3Stamped::default();
    wind.header.frame_id = "world".to_string();
    let body = match draws.random_range(0..5) {
        0 => {
            let length = draws.random_range(0..400);
            (0..length).map(|_| draws.random()).collect()
        }
        1 => {
            let whole = encode(&wind).unwrap();
            let end = draws.random_range(4..whole.len() - 1);
            whole[4..end].to_vec()
        }
        2 => {
            wind.vector.x = [f64::NAN, f64::INFINITY, f64::NEG_INFINITY][draws.random_range(0..3)];
            encode(&wind).unwrap()[4..].to_vec()
        }
        3 => {
            // A frame whose name claims to be four billion letters long.
            let mut lie = encode(&wind).unwrap()[4..].to_vec();
            lie[8..12].copy_from_slice(&u32::MAX.to_le_bytes());
            lie
        }
        _ => vec![0xff; draws.random_range(0..2_000)],
    };
    [&ENCAPSULATION, &body[..]].concat()
}
