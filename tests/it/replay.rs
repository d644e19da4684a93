//! A recording is replayed: the same bits, or where it differs.

use std::fs;
use std::path::{Path, PathBuf};

use tempfile::TempDir;
use toile::node::{
    Inbox, NodeError, Order, Recording, Replay, ReplayOptions, RunOptions, TOLERANCE, What, replay,
    run,
};
use toile::scene::{Accept, Scene};
use toile::wire::cdr;
use toile::wire::messages::sensor_msgs::PointCloud2;
use toile::wire::messages::simulation_interfaces::{
    ResetSimulationRequest, SimulationState, StepSimulationRequest,
};
use toile::wire::messages::toile_msgs::{AppliedCommand, Keyframe, ObstacleCommand};

use crate::recording;
use crate::session::{OBSTACLE, STATE, STEP, add_ball, move_to, order, wish};
use crate::tamper::changed;

pub fn scene() -> Scene {
    let mut scene = recording::scene();
    scene.sheet.triangles = Some(200);
    scene.accept = Some(vec![Accept::Obstacles]);
    scene.output.rate = 50.0;
    scene.output.keyframe_interval = 0.02;
    scene
}

/// A bit of everything, some of it refused.
fn script() -> Vec<(u64, Order)> {
    let mut remove = add_ball("bump", 0.0, [0.0; 3]);
    remove.operation = ObstacleCommand::REMOVE;
    vec![
        (2, order(OBSTACLE, &move_to("table", [0.01, 0.0, -0.05]))),
        (
            3,
            order(OBSTACLE, &add_ball("bump", 0.02, [0.0, 0.0, -0.03])),
        ),
        (3, order(OBSTACLE, &add_ball("bump", 0.02, [0.0; 3]))),
        (5, order(STATE, &wish(SimulationState::STATE_PAUSED))),
        (5, order(STEP, &StepSimulationRequest { steps: 4 })),
        (6, order(OBSTACLE, &move_to("ball", [f64::NAN, 0.0, 0.0]))),
        (9, order(STATE, &wish(SimulationState::STATE_PLAYING))),
        (12, order(OBSTACLE, &remove)),
        (
            15,
            order(
                "/toile/reset_simulation",
                &ResetSimulationRequest::default(),
            ),
        ),
        (17, order(OBSTACLE, &move_to("ball", [0.0, 0.0, 0.1]))),
    ]
}

pub fn record(scene: &Scene, orders: Vec<(u64, Order)>, path: &Path) {
    let options = RunOptions {
        output: Some(path.to_path_buf()),
        inbox: Inbox::default().scripted(orders),
        ..RunOptions::default()
    };
    run(scene, options, &mut |_| {}).expect("the run succeeds");
}

fn recorded() -> (TempDir, PathBuf) {
    let directory = TempDir::new().expect("a directory");
    let path = directory.path().join("run.mcap");
    record(&scene(), script(), &path);
    (directory, path)
}

pub fn replayed(path: &Path, threads: usize) -> Replay {
    let options = ReplayOptions {
        threads,
        ..ReplayOptions::default()
    };
    replay(path, &options, &mut |_| {}).expect("the recording can be replayed")
}

#[test]
fn a_recording_replays_to_the_same_bits_on_any_number_of_threads() {
    let (_directory, path) = recorded();
    let commands = Recording::open(&path).expect("opens").commands().to_vec();
    let steps: Vec<_> = commands.iter().map(|c| (c.step, c.accepted)).collect();
    let expected = [
        (2, true),
        (3, true),
        (3, false),
        (5, true),
        (5, true),
        (6, false),
        (9, true),
        (12, true),
        (15, true),
        (17, true),
    ];
    assert_eq!(steps, expected);
    for threads in [1, 2] {
        let replay = replayed(&path, threads);
        assert_eq!((replay.bits, replay.difference), (None, None));
        assert!(replay.strict);
        assert_eq!((replay.from, replay.to), (0, 20));
        // Steps 0, 4, ... 20, and the pauses after 5 and 9.
        assert_eq!((replay.states, replay.commands), (8, 10));
        assert_eq!(replay.largest, 0.0);
    }
}

/// What a replay finds after messages and metadata were changed.
fn after(path: &Path, change: impl FnMut(&str, &mut Vec<u8>), metadata: &[(&str, &str)]) -> Replay {
    let bytes = changed(path, change, metadata);
    let tampered = path.with_file_name("tampered.mcap");
    fs::write(&tampered, bytes).expect("write");
    replayed(&tampered, 1)
}

const ELSEWHERE: [(&str, &str); 1] = [("processor", "another")];

#[test]
fn rewriting_alone_changes_nothing() {
    let (_directory, path) = recorded();
    let replay = after(&path, |_, _| {}, &[]);
    assert_eq!((replay.bits, replay.difference), (None, None));
    assert!(replay.strict);
}

#[test]
fn a_changed_byte_of_a_command_is_found() {
    let (_directory, path) = recorded();
    let mut seen = 0;
    let shift = |topic: &str, bytes: &mut Vec<u8>| {
        if topic != "/toile/applied" {
            return;
        }
        seen += 1;
        if seen != 1 {
            return;
        }
        let mut applied: AppliedCommand = cdr::decode(bytes).expect("decodes");
        let mut command: ObstacleCommand = cdr::decode(&applied.payload).expect("decodes");
        let intact = applied.payload.clone();
        command.pose.position.x = f64::from_bits(command.pose.position.x.to_bits() ^ (1 << 48));
        applied.payload = cdr::encode(&command).expect("encodes");
        let flipped = intact.iter().zip(&applied.payload).filter(|(a, b)| a != b);
        assert_eq!(flipped.count(), 1, "one byte of the payload");
        *bytes = cdr::encode(&applied).expect("encodes");
    };
    let difference = after(&path, shift, &[]).difference.expect("found");
    // The command took effect after step 2; the next state that was recorded is that of step 4, where the table is
    // seen first.
    assert_eq!(difference.step, 4);
    let What::Message { topic } = difference.what else {
        panic!("{difference}");
    };
    assert_eq!(topic, "/tf");
}

#[test]
fn a_command_that_fares_otherwise_is_found() {
    let (_directory, path) = recorded();
    let lie = |topic: &str, bytes: &mut Vec<u8>| {
        if topic == "/toile/applied" {
            let mut applied: AppliedCommand = cdr::decode(bytes).expect("decodes");
            if !applied.accepted {
                applied.accepted = true;
                *bytes = cdr::encode(&applied).expect("encodes");
            }
        }
    };
    for elsewhere in [&[][..], &ELSEWHERE] {
        let replay = after(&path, lie, elsewhere);
        let difference = replay.difference.expect("found");
        assert_eq!(difference.step, 3);
        let text = difference.to_string();
        assert!(
            text.contains(
                "is rejected (there is an obstacle \"bump\" already), recorded as accepted"
            ),
            "{text}"
        );
    }
}

/// Moves vertex 17 of the states from the third on.
fn nudge(by: f32) -> impl FnMut(&str, &mut Vec<u8>) {
    let mut seen = 0;
    move |topic, bytes| {
        if topic != "/toile/state" {
            return;
        }
        seen += 1;
        if seen < 3 {
            return;
        }
        let mut state: PointCloud2 = cdr::decode(bytes).expect("decodes");
        let at = 17 * state.point_step as usize;
        let x = f32::from_le_bytes(state.data[at..at + 4].try_into().expect("four"));
        state.data[at..at + 4].copy_from_slice(&(x + by).to_le_bytes());
        *bytes = cdr::encode(&state).expect("encodes");
    }
}

#[test]
fn the_first_step_and_vertex_are_named() {
    let (_directory, path) = recorded();
    let replay = after(&path, nudge(1e-6), &[]);
    let difference = replay.difference.expect("found");
    // States of steps 0, 4, 5 (a pause).
    assert_eq!(difference.step, 5);
    assert_eq!(Some(&difference), replay.bits.as_ref());
    let What::State {
        vertex,
        distance,
        furthest,
        largest,
    } = difference.what
    else {
        panic!("{difference}");
    };
    assert_eq!((vertex, furthest), (17, 17));
    assert!((distance - 1e-6).abs() < 1e-7 && largest == distance);
}

#[test]
fn another_processor_has_a_tolerance() {
    let (_directory, path) = recorded();
    let near = after(&path, nudge(0.5 * TOLERANCE as f32), &ELSEWHERE);
    assert!(!near.strict && near.difference.is_none());
    assert_eq!(near.bits.expect("noted").step, 5);
    assert!((near.largest - 0.5 * TOLERANCE).abs() < 0.01 * TOLERANCE);
    assert_eq!(near.states, 8, "it goes on to the end");
    let far = after(&path, nudge(2.0 * TOLERANCE as f32), &ELSEWHERE);
    assert_eq!(far.difference.expect("found").step, 5);
    let nan = after(&path, nudge(f32::NAN), &ELSEWHERE);
    assert!(nan.difference.is_some());
}

/// Keyframes of steps 4, 8, ... 20: before, during and after a stretch of told steps, and after a reset.
#[test]
fn a_replay_may_start_at_any_keyframe() {
    let (_directory, path) = recorded();
    let kept = Recording::open(&path).expect("opens").keyframes();
    assert_eq!(kept, [4, 8, 12, 16, 20]);
    let whole = replayed(&path, 1);
    for (from, start) in [
        (0, 0),
        (3, 0),
        (4, 4),
        (7, 4),
        (8, 8),
        (13, 12),
        (19, 16),
        (99, 20),
    ] {
        let options = ReplayOptions {
            from: Some(from),
            ..ReplayOptions::default()
        };
        let replay = replay(&path, &options, &mut |_| {}).expect("replays");
        assert_eq!((replay.bits, replay.difference), (None, None), "{from}");
        assert_eq!((replay.from, replay.to), (start, 20));
        assert!(replay.states < whole.states || start == 0);
        assert!(replay.states > 0);
    }
}

/// From a keyframe after the change the replay does not see it; from one before it does.
#[test]
fn a_difference_is_seen_from_keyframes_before_it() {
    let (_directory, path) = recorded();
    let mut states = 0;
    let bytes = changed(
        &path,
        |topic, bytes| {
            states += u64::from(topic == "/toile/state");
            // The states of steps 0, 4, 5, 8, 9, 12.
            if topic == "/toile/state" && states == 5 {
                // Within the velocity of the last vertex: the cloud ends with a flag.
                let end = bytes.len() - 8;
                bytes[end] ^= 1;
            }
        },
        &[],
    );
    let tampered = path.with_file_name("tampered.mcap");
    fs::write(&tampered, bytes).expect("write");
    let from = |step| {
        let options = ReplayOptions {
            from: Some(step),
            ..ReplayOptions::default()
        };
        replay(&tampered, &options, &mut |_| {}).expect("replays")
    };
    assert_eq!(from(8).difference.expect("found").step, 9);
    assert_eq!(from(12).difference, None);
}

/// A keyframe whose state is not the one that its digest says.
#[test]
fn a_damaged_keyframe_is_refused() {
    let (_directory, path) = recorded();
    let damage = |topic: &str, bytes: &mut Vec<u8>| {
        if topic == "/toile/keyframe" {
            let mut keyframe: Keyframe = cdr::decode(bytes).expect("decodes");
            keyframe.slopes[5] += 1e-15;
            *bytes = cdr::encode(&keyframe).expect("encodes");
        }
    };
    let tampered = path.with_file_name("tampered.mcap");
    fs::write(&tampered, changed(&path, damage, &[])).expect("write");
    let options = ReplayOptions {
        from: Some(10),
        ..ReplayOptions::default()
    };
    let error = replay(&tampered, &options, &mut |_| {}).expect_err("refused");
    assert!(
        error
            .to_string()
            .contains("digest of the keyframe of step 8"),
        "{error}"
    );
    let faults = toile::node::verify(&tampered).expect("readable");
    assert_eq!(faults.len(), 5, "{faults:?}");
    assert!(faults[0].contains("/toile/keyframe at 0.02 s: its digest is another"));
}

#[test]
fn a_recording_that_was_cut_short_replays_as_far_as_it_goes() {
    let (_directory, path) = recorded();
    let bytes = fs::read(&path).expect("read");
    let cut = path.with_file_name("cut.mcap");
    let (mut short, mut lengths) = (0, vec![]);
    for part in [4, 5, 6, 7, 8, 9] {
        fs::write(&cut, &bytes[..bytes.len() * part / 10]).expect("write");
        let replay = replayed(&cut, 1);
        assert_eq!((replay.bits, replay.difference), (None, None), "{part}");
        assert_eq!(replay.to, Recording::open(&cut).expect("opens").last_step());
        short += u64::from(replay.to < 20);
        lengths.push(replay.states);
    }
    assert!(short >= 3 && lengths.is_sorted(), "{short} {lengths:?}");
}

#[test]
fn a_run_that_was_ended_by_order_replays() {
    let directory = TempDir::new().expect("a directory");
    let path = directory.path().join("run.mcap");
    for end in [
        vec![(7, order(STATE, &wish(SimulationState::STATE_QUITTING)))],
        vec![(7, order(STATE, &wish(SimulationState::STATE_PAUSED)))],
        vec![(8, order(STATE, &wish(SimulationState::STATE_STOPPED)))],
    ] {
        let step = end[0].0;
        record(&scene(), end, &path);
        let replay = replayed(&path, 1);
        assert_eq!((replay.bits, replay.difference), (None, None));
        assert_eq!((replay.to, replay.commands), (step, 1));
    }
}

#[test]
fn what_is_no_recording_is_refused() {
    let directory = TempDir::new().expect("a directory");
    let path = directory.path().join("text.mcap");
    fs::write(&path, "not a recording").expect("write");
    let error = replay(&path, &ReplayOptions::default(), &mut |_| {}).expect_err("refused");
    assert!(matches!(error, NodeError::Unreadable { .. }), "{error}");
}
