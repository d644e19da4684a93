//! The whole state as a message: back bit for bit, and refused when it is damaged.

use nalgebra::Vector3;
use toile::contact::{Obstacle, Pose, Shape, Velocity};
use toile::sim::{AirRegion, Airflow, Command, Simulation, State};
use toile::wire::messages::toile_msgs::Keyframe;
use toile::wire::{cdr, channels, kept, keyframe};

use crate::lab::{built_in, simulation};

/// The draped cloth in motion, in a gust, beside a capsule that turns: contacts, bonds, air, history, ledger.
fn in_motion(scheme: &str) -> Simulation {
    let method = format!("method.scheme={scheme}");
    let set = [
        "sheet.triangles=200",
        "duration=1",
        "method.dt=2e-3",
        "accept=[\"obstacles\", \"air\"]",
        &method,
    ];
    let mut simulation = simulation(&built_in("drape-table", &set));
    let gust = Airflow {
        velocity: Vector3::new(1.0, 0.5, -0.25),
        fluid_damping: Some(1.5),
        region: Some(AirRegion {
            min: Vector3::repeat(-0.05),
            max: Vector3::repeat(1.0),
        }),
        rise: 0.01,
        hold: Some(0.03),
    };
    let capsule = Obstacle {
        name: "capsule".into(),
        shape: Shape::Capsule {
            radius: 0.1,
            length: 0.2,
        },
        pose: Pose::new(Vector3::new(1.0, 1.0, 0.0), Vector3::new(0.1, 0.2, 0.3)),
        velocity: Velocity {
            linear: Vector3::zeros(),
            angular: Vector3::new(3.0, 2.0, 1.0),
        },
        friction: 0.5,
        ..Obstacle::default()
    };
    for command in [Command::Blow(gust), Command::AddObstacle(capsule)] {
        simulation.apply(&command).expect("accepted");
    }
    for _ in 0..20 {
        simulation.step().expect("converges");
    }
    simulation
}

fn sent(simulation: &Simulation) -> Keyframe {
    let (state, report) = (simulation.state(), simulation.report());
    let packet = kept(state, report.digest, report.time).expect("encodes");
    assert_eq!(packet.channel, &channels::KEYFRAME);
    cdr::decode(&packet.bytes).expect("decodes")
}

/// Every bit, zeros with their sign included: what `Debug` prints tells floats apart.
fn assert_same(a: &State, b: &State) {
    assert_eq!(format!("{a:?}"), format!("{b:?}"));
}

#[test]
fn a_state_comes_back_bit_for_bit_and_goes_on() {
    for scheme in ["bdf2", "generalised-alpha", "central-difference"] {
        let mut whole = in_motion(scheme);
        let message = sent(&whole);
        assert_eq!((message.step, message.digest), (20, whole.report().digest));
        let state = keyframe::state(&message).expect("a state");
        assert_same(&state, whole.state());
        let mut resumed = in_motion(scheme);
        for _ in 0..3 {
            resumed.step().expect("converges");
        }
        resumed.resume(state).expect("it fits");
        for _ in 0..5 {
            let digest = whole.step().expect("converges").digest;
            assert_eq!(
                resumed.step().expect("converges").digest,
                digest,
                "{scheme}"
            );
        }
    }
}

#[test]
fn a_damaged_keyframe_is_refused() {
    let message = sent(&in_motion("bdf2"));
    let refusal = |change: fn(&mut Keyframe)| {
        let mut damaged = message.clone();
        change(&mut damaged);
        keyframe::state(&damaged).expect_err("refused").to_string()
    };
    assert!(refusal(|k| k.slopes.truncate(4)).contains("slopes = 4 numbers"));
    assert!(refusal(|k| k.bond_keys.push(1)).contains("bond_offsets"));
    assert!(refusal(|k| k.obstacles[0].shape = 99).contains("obstacles.shape"));
    assert!(refusal(|k| k.obstacles[1].dimensions.clear()).contains("obstacles.shape"));
}
