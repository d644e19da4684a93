//! What a run does with what it is told: at step boundaries, recorded, answered.

use std::sync::atomic::Ordering;
use std::sync::mpsc::channel;
use std::sync::{Arc, atomic::AtomicBool};
use std::thread;
use std::time::Duration;

use toile::node::{Inbox, Memory, Order, Pace, RunOptions, run};
use toile::scene::{Accept, Scene};
use toile::wire::messages::moveit_msgs::CollisionObject;
use toile::wire::messages::simulation_interfaces::{
    GetEntityStateRequest, GetEntityStateResponse, GetSimulationStateRequest,
    GetSimulationStateResponse, ResetSimulationRequest, ResetSimulationResponse, Resource,
    Result as Reply, SetSimulationStateResponse, SimulationState, SpawnEntityRequest,
    SpawnEntityResponse, StepSimulationRequest, StepSimulationResponse,
};
use toile::wire::messages::toile_msgs::{AppliedCommand, StepReport};
use toile::wire::{cdr, channels, inbound};

use crate::recording;
use crate::session::{OBSTACLE, STATE, STEP, Session, add_ball, move_to, order, pose, wish};

/// Of few triangles, ready for commands.
fn scene() -> Scene {
    let mut scene = recording::scene();
    scene.sheet.triangles = Some(100);
    scene.accept = Some(vec![Accept::Obstacles]);
    scene
}

fn state(session: &Session) -> u8 {
    let request = GetSimulationStateRequest::default();
    let answer: GetSimulationStateResponse = session.call("/toile/get_simulation_state", &request);
    assert_eq!(answer.result.result, Reply::OK);
    answer.state.state
}

#[test]
fn lockstep_takes_the_steps_that_it_is_told() {
    let session = Session::lockstep(scene());
    assert_eq!(state(&session), SimulationState::STATE_PAUSED);
    for (steps, so_far) in [(3, 3), (1, 4), (6, 10)] {
        assert_eq!(session.step(steps).result, Reply::OK);
        let reports: Vec<StepReport> = session.heard(&channels::REPORT);
        assert_eq!(reports.last().expect("one").step, so_far);
    }
    // The scene has 20 steps: the last request outlives the run.
    let reply = session.step(100);
    assert_eq!(reply.result, Reply::OPERATION_FAILED);
    assert!(reply.error_message.contains("after 10 of 100 steps"));
    let (summary, _) = session.finish();
    assert_eq!((summary.steps, summary.stopped), (20, false));
    assert_eq!(summary.orders.applied, 4);
}

#[test]
fn what_is_told_in_lockstep_gives_the_bits_of_a_free_run() {
    let free = run(&scene(), RunOptions::default(), &mut |_| {}).expect("runs");
    let session = Session::lockstep(scene());
    assert_eq!(session.step(7).result, Reply::OK);
    assert_eq!(
        session.set(SimulationState::STATE_PLAYING).result,
        Reply::OK
    );
    let (summary, _) = session.finish();
    assert_eq!(summary.digest, free.digest);
}

#[test]
fn commands_latch_between_steps_and_are_recorded_as_they_came() {
    let session = Session::lockstep(scene());
    assert_eq!(session.step(4).result, Reply::OK);
    let command = move_to("ball", [0.0, 0.0, 0.05]);
    let applied = session.tell(OBSTACLE, &command);
    assert_eq!((applied.step, applied.accepted), (4, true));
    assert_eq!(applied.reason, "");
    assert_eq!(applied.channel, OBSTACLE);
    assert_eq!(applied.r#type, "toile_msgs/msg/ObstacleCommand");
    assert_eq!(applied.payload, cdr::encode(&command).expect("encodes"));
    assert_eq!(applied.header.stamp.nanosec, 20_000_000);
    let ask = GetEntityStateRequest {
        entity: "ball".to_string(),
    };
    let there: GetEntityStateResponse = session.call("/toile/get_entity_state", &ask);
    assert_eq!(there.state.pose, pose(0.0, 0.0, 0.05));
    session.set(SimulationState::STATE_PLAYING);
    let (summary, memory) = session.finish();
    let unmoved = run(&scene(), RunOptions::default(), &mut |_| {}).expect("runs");
    assert_ne!(summary.digest, unmoved.digest);
    // Four in all: two verbs, one command; the question is not one.
    let packets = memory.packets();
    let applied = packets.iter().filter(|p| p.channel == &channels::APPLIED);
    assert_eq!(applied.count(), 3);
    assert_eq!(summary.orders.applied, 3);
}

#[test]
fn what_is_refused_is_recorded_with_its_reason_and_changes_nothing() {
    let untouched = run(&scene(), RunOptions::default(), &mut |_| {}).expect("runs");
    let session = Session::lockstep(scene());
    session.step(5);
    let unknown = session.tell(OBSTACLE, &move_to("bal", [0.0; 3]));
    assert!(!unknown.accepted && unknown.reason.contains("there is no obstacle \"bal\""));
    let nan = session.tell(OBSTACLE, &move_to("ball", [f64::NAN, 0.0, 0.0]));
    assert!(
        !nan.accepted && nan.reason.contains("NaN"),
        "{}",
        nan.reason
    );
    let (reply, answer) = channel();
    let garbage = Order {
        inlet: inbound::find(OBSTACLE).expect("an inlet"),
        bytes: vec![0, 1, 0, 0, 9],
        reply: Some(reply),
    };
    session.mailbox.post(garbage).expect("there is room");
    let answer = answer.recv_timeout(Duration::from_secs(60));
    let applied: AppliedCommand = cdr::decode(&answer.expect("answered")).expect("decodes");
    assert!(!applied.accepted);
    assert_eq!(applied.payload, [0, 1, 0, 0, 9]);
    session.set(SimulationState::STATE_PLAYING);
    let (summary, memory) = session.finish();
    assert_eq!(summary.digest, untouched.digest);
    assert_eq!((summary.orders.rejected, summary.orders.malformed), (1, 2));
    let packets = memory.packets();
    let report = packets.iter().rfind(|p| p.channel == &channels::REPORT);
    let report: StepReport = cdr::decode(&report.expect("one").bytes).expect("decodes");
    assert_eq!(report.malformed_commands, 2);
}

/// Two shapes of one object, of which the second's name is taken: the first is not added either.
#[test]
fn a_request_of_several_changes_is_taken_whole_or_not_at_all() {
    let untouched = run(&scene(), RunOptions::default(), &mut |_| {}).expect("runs");
    let session = Session::lockstep(scene());
    session.step(5);
    let taken = session.tell(OBSTACLE, &add_ball("pair_1", 0.01, [0.5, 0.0, 0.0]));
    assert!(taken.accepted, "{}", taken.reason);
    let shape = add_ball("any", 0.02, [0.0; 3]).solid;
    let pair = CollisionObject {
        id: "pair".to_string(),
        operation: CollisionObject::ADD,
        primitives: vec![shape.clone(), shape],
        primitive_poses: vec![pose(0.5, 0.2, 0.0), pose(0.5, 0.4, 0.0)],
        pose: pose(0.0, 0.0, 0.0),
        ..CollisionObject::default()
    };
    let refused = session.tell("/toile/cmd/collision_object", &pair);
    assert!(!refused.accepted && refused.reason.contains("pair_1"));
    let ask = GetEntityStateRequest {
        entity: "pair_0".to_string(),
    };
    let gone: GetEntityStateResponse = session.call("/toile/get_entity_state", &ask);
    assert_eq!(gone.result.result, Reply::NOT_FOUND);
    let mut remove = add_ball("pair_1", 0.0, [0.0; 3]);
    remove.operation = 2;
    assert!(session.tell(OBSTACLE, &remove).accepted);
    session.set(SimulationState::STATE_PLAYING);
    let (summary, _) = session.finish();
    assert_eq!(summary.digest, untouched.digest);
}

#[test]
fn pause_stop_and_their_refusals() {
    let mut long = scene();
    long.duration = 1000.0;
    let session = Session::start(long, Pace::Factor(1.0), Arc::default());
    assert_eq!(state(&session), SimulationState::STATE_PLAYING);
    while session.heard::<StepReport>(&channels::REPORT).len() < 2 {
        thread::sleep(Duration::from_millis(1));
    }
    assert_eq!(session.step(1).result, Reply::OPERATION_FAILED);
    let code = |state| session.set(state).result;
    assert_eq!(
        code(SimulationState::STATE_PLAYING),
        SetSimulationStateResponse::ALREADY_IN_TARGET_STATE
    );
    assert_eq!(code(SimulationState::STATE_PAUSED), Reply::OK);
    assert_eq!(
        code(SimulationState::STATE_PAUSED),
        SetSimulationStateResponse::ALREADY_IN_TARGET_STATE
    );
    assert_eq!(code(SimulationState::STATE_STOPPED), Reply::OK);
    assert_eq!(state(&session), SimulationState::STATE_STOPPED);
    assert_eq!(
        code(SimulationState::STATE_PAUSED),
        SetSimulationStateResponse::INCORRECT_TRANSITION
    );
    // A stop is also a reset, seen at once: the sheet is flat again.
    let reports: Vec<StepReport> = session.heard(&channels::REPORT);
    let (first, last) = (&reports[0], reports.last().expect("one"));
    assert_eq!(first.energies.bend, last.energies.bend);
    assert!(last.step > 0);
    assert_eq!(session.step(2).result, Reply::OK);
    assert_eq!(state(&session), SimulationState::STATE_PAUSED);
    assert_eq!(code(SimulationState::STATE_QUITTING), Reply::OK);
    let (summary, _) = session.finish();
    assert!(summary.stopped && summary.time < 1000.0);
}

/// What passes on the wall while a run stands, or while it takes told steps, is no delay.
#[test]
fn a_pause_is_no_overrun() {
    let mut slow = scene();
    slow.duration = 0.3;
    let session = Session::start(slow, Pace::Factor(0.1), Arc::default());
    assert_eq!(session.set(SimulationState::STATE_PAUSED).result, Reply::OK);
    thread::sleep(Duration::from_millis(300));
    let start = std::time::Instant::now();
    assert_eq!(session.step(50).result, Reply::OK);
    // At a tenth of real time 50 steps of 5 ms would take 2.5 s.
    assert!(start.elapsed() < Duration::from_secs(2));
    assert_eq!(
        session.set(SimulationState::STATE_PLAYING).result,
        Reply::OK
    );
    let (summary, _) = session.finish();
    assert!(summary.lateness.slipped < 0.1, "{:?}", summary.lateness);
}

#[test]
fn a_pause_ends_the_steps_that_somebody_waits_for() {
    let mut long = scene();
    long.duration = 1000.0;
    let session = Session::lockstep(long);
    let waiting = session.ask(STEP, &StepSimulationRequest { steps: 100_000 });
    let paused: SetSimulationStateResponse =
        session.call(STATE, &wish(SimulationState::STATE_PAUSED));
    assert_eq!(paused.result.result, Reply::OK);
    let answer = waiting.recv_timeout(Duration::from_secs(60));
    let answer: StepSimulationResponse = cdr::decode(&answer.expect("answered")).expect("decodes");
    assert_eq!(answer.result.result, Reply::OPERATION_FAILED);
    assert!(answer.result.error_message.contains("of 100000 steps"));
    session.set(SimulationState::STATE_QUITTING);
    session.finish();
}

#[test]
fn reset_and_spawn() {
    let session = Session::lockstep(scene());
    session.step(10);
    let spawn = SpawnEntityRequest {
        name: "ball".to_string(),
        allow_renaming: true,
        entity_resource: Resource {
            resource_string: "shape = { kind = \"sphere\", radius = 0.01 }".to_string(),
            ..Resource::default()
        },
        ..SpawnEntityRequest::default()
    };
    let mut spawn = spawn;
    spawn.initial_pose.pose = pose(0.0, 0.0, 0.5);
    let spawned: SpawnEntityResponse = session.call("/toile/spawn_entity", &spawn);
    assert_eq!(spawned.result.result, Reply::OK);
    assert_eq!(spawned.entity_name, "ball_1");
    let reset: ResetSimulationResponse = session.call(
        "/toile/reset_simulation",
        &ResetSimulationRequest::default(),
    );
    assert_eq!(reset.result.result, Reply::OK);
    let again: SpawnEntityResponse = session.call("/toile/spawn_entity", &spawn);
    assert_eq!(again.entity_name, "ball_1", "the reset took the first away");
    let reports: Vec<StepReport> = session.heard(&channels::REPORT);
    let last = reports.last().expect("one");
    assert_eq!((last.step, last.energies.kinetic), (10, 0.0));
    session.set(SimulationState::STATE_QUITTING);
    session.finish();
}

/// More than a boundary takes and more than the queue holds: the run goes on, and what is lost is counted.
#[test]
fn a_flood_of_orders_does_not_stop_a_run() {
    let (mailbox, inbox) = Inbox::new(50);
    let memory = Memory::default();
    let options = RunOptions {
        inbox,
        carriers: vec![Box::new(memory.clone())],
        ..RunOptions::default()
    };
    let mut refused = 0;
    let summary = run(&scene(), options, &mut |_| {
        for _ in 0..100 {
            let posted = mailbox.post(order(OBSTACLE, &move_to("ball", [0.3, 0.0, 0.0])));
            refused += u64::from(posted.is_err());
        }
    });
    let summary = summary.expect("the run succeeds");
    assert_eq!(summary.steps, 20);
    assert_eq!(refused, 20 * 50);
    assert_eq!(summary.orders.dropped, refused);
    // What is posted after the last step has no boundary any more.
    assert_eq!(summary.orders.applied, 19 * 50);
    let packets = memory.packets();
    let report = packets.iter().rfind(|p| p.channel == &channels::REPORT);
    let report: StepReport = cdr::decode(&report.expect("one").bytes).expect("decodes");
    assert_eq!(report.dropped_commands, refused);
}

#[test]
fn scripted_orders_come_at_their_steps() {
    let memory = Memory::default();
    let inbox = Inbox::default().scripted([
        (12, order(OBSTACLE, &move_to("ball", [0.0, 0.0, 0.2]))),
        (3, order(STATE, &wish(SimulationState::STATE_PAUSED))),
        (3, order(STEP, &StepSimulationRequest { steps: 5 })),
        (8, order(STATE, &wish(SimulationState::STATE_PLAYING))),
    ]);
    let options = RunOptions {
        inbox,
        carriers: vec![Box::new(memory.clone())],
        ..RunOptions::default()
    };
    let summary = run(&scene(), options, &mut |_| {}).expect("the run succeeds");
    assert_eq!((summary.steps, summary.stopped), (20, false));
    let packets = memory.packets();
    let applied = packets.iter().filter(|p| p.channel == &channels::APPLIED);
    let steps: Vec<_> = applied
        .map(|p| cdr::decode::<AppliedCommand>(&p.bytes).expect("decodes"))
        .map(|applied| (applied.step, applied.accepted))
        .collect();
    assert_eq!(steps, [(3, true), (3, true), (8, true), (12, true)]);
}

#[test]
fn a_stop_from_outside_ends_a_paused_run_that_others_could_start() {
    let stop = Arc::new(AtomicBool::new(false));
    let session = Session::start(scene(), Pace::Lockstep, stop.clone());
    assert_eq!(session.step(3).result, Reply::OK);
    stop.store(true, Ordering::Relaxed);
    let (summary, memory) = session.finish();
    assert!(summary.stopped && summary.steps == 3);
    let packets = memory.packets();
    let report = packets.iter().rfind(|p| p.channel == &channels::REPORT);
    let report: StepReport = cdr::decode(&report.expect("one").bytes).expect("decodes");
    assert_eq!(report.step, 3);
}
