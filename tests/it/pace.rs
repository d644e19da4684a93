//! Pace, pause and live carriers: what happens against the wall, and that the physics does not know.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, channel};
use std::thread;
use std::time::{Duration, Instant};

use toile::node::{Carrier, Inbox, Live, Memory, NodeError, Pace, RunOptions, Summary, run};
use toile::wire::{Packet, channels, channels::Channel};

use crate::recording::scene;

fn paced(pace: Pace) -> (Summary, f64) {
    let mut scene = scene();
    scene.sheet.triangles = Some(60);
    let start = Instant::now();
    let options = RunOptions {
        pace,
        ..RunOptions::default()
    };
    let summary = run(&scene, options, &mut |_| {}).expect("the run succeeds");
    (summary, start.elapsed().as_secs_f64())
}

#[test]
fn pace_words() {
    for (text, pace) in [
        ("free", Pace::Free),
        ("real", Pace::Factor(1.0)),
        ("1", Pace::Factor(1.0)),
        ("0.25", Pace::Factor(0.25)),
        ("lockstep", Pace::Lockstep),
    ] {
        assert_eq!(text.parse(), Ok(pace));
        assert_eq!(pace.to_string().parse(), Ok(pace), "says what it reads");
    }
    for text in ["", "fast", "0", "-1", "nan", "inf", "1e4", "1e-4"] {
        let error = text.parse::<Pace>().expect_err(text).to_string();
        assert!(error.contains(text) && error.contains("from 0.001 to 1000"));
    }
}

/// A tenth of a second in steps of 5 ms, which take far less than that: the wall goes by at the factor.
#[test]
fn a_paced_run_takes_its_time_and_gives_the_same_bits() {
    let (free, _) = paced(Pace::Free);
    for (factor, seconds) in [(1.0, 0.1), (0.5, 0.2)] {
        let (summary, wall) = paced(Pace::Factor(factor));
        assert_eq!(summary.digest, free.digest);
        assert_eq!(summary.steps, 20);
        assert!(wall >= seconds, "{wall} s at factor {factor}");
    }
}

#[test]
fn steps_that_are_too_slow_are_counted() {
    let (summary, _) = paced(Pace::Factor(1000.0));
    let late = summary.lateness;
    assert!(late.overruns >= 15, "{late:?}");
    assert!(late.worst > 0.0, "{late:?}");
    let (free, _) = paced(Pace::Free);
    assert_eq!(free.lateness.overruns, 0);
}

/// Steps that take 20 ms of wall time where 5 ms are due: all are overruns, and what is lost is said.
#[test]
fn a_lag_is_given_up_and_said() {
    let mut scene = scene();
    scene.sheet.triangles = Some(60);
    let options = RunOptions {
        pace: Pace::Factor(1.0),
        ..RunOptions::default()
    };
    let summary = run(&scene, options, &mut |_| {
        thread::sleep(Duration::from_millis(20));
    });
    let late = summary.expect("the run succeeds").lateness;
    assert!(late.overruns >= 18, "{late:?}");
    assert!(late.slipped > 0.15 && late.worst < 0.2, "{late:?}");
}

#[test]
fn a_paused_run_takes_no_step_and_ends_when_told() {
    let memory = Memory::default();
    let stop = Arc::new(AtomicBool::new(false));
    let (mailbox, inbox) = Inbox::with_mailbox();
    let options = RunOptions {
        stop: stop.clone(),
        carriers: vec![Box::new(memory.clone())],
        inbox,
        wait_for_start: true,
        ..RunOptions::default()
    };
    let worker = thread::spawn(move || run(&scene(), options, &mut |_| {}));
    thread::sleep(Duration::from_millis(200));
    assert!(!worker.is_finished());
    let states = memory.packets();
    let states = states.iter().filter(|p| p.channel == &channels::STATE);
    assert_eq!(states.count(), 1, "the start is seen");
    stop.store(true, Ordering::Relaxed);
    let start = Instant::now();
    let summary = worker.join().expect("ends").expect("no error");
    assert!(start.elapsed() < Duration::from_secs(1));
    assert!(summary.stopped && summary.steps == 0);
    drop(mailbox);
}

#[test]
fn a_paused_run_with_nobody_to_start_it_ends() {
    let options = RunOptions {
        pace: Pace::Lockstep,
        ..RunOptions::default()
    };
    let summary = run(&scene(), options, &mut |_| {}).expect("no error");
    assert!(summary.stopped && summary.steps == 0);
}

/// A carrier that takes a message only when the test lets it.
struct Gate {
    leave: Receiver<()>,
    memory: Memory,
}

impl Carrier for Gate {
    fn publish(&mut self, packet: &Packet) -> Result<(), NodeError> {
        // When the test has gone, the gate stands open.
        let _ = self.leave.recv();
        self.memory.publish(packet)
    }

    fn commit(&mut self) -> Result<(), NodeError> {
        Ok(())
    }

    fn close(&mut self) -> Result<(), NodeError> {
        Ok(())
    }
}

fn packet(channel: &'static Channel, stamp: u64) -> Packet {
    Packet {
        channel,
        obstacle: None,
        sequence: 0,
        stamp,
        step: 0,
        digest: 0,
        bytes: vec![],
    }
}

#[test]
fn a_slow_carrier_loses_the_oldest_states_and_no_event() {
    let (open, leave) = channel();
    let memory = Memory::default();
    let gate = Gate {
        leave,
        memory: memory.clone(),
    };
    let mut live = Live::with_capacity("slow", Box::new(gate), 4).expect("starts");
    let gauge = live.gauge();
    live.publish(&packet(&channels::TOPOLOGY, 0))
        .expect("taken");
    // The thread holds the first one at the gate; then four wait.
    while gauge.waiting() > 0 {
        thread::yield_now();
    }
    live.publish(&packet(&channels::ROBOT_DESCRIPTION, 0))
        .expect("taken");
    live.publish(&packet(&channels::REPORT, 1)).expect("taken");
    for stamp in 1..=1000 {
        live.publish(&packet(&channels::STATE, stamp))
            .expect("taken");
    }
    drop(open);
    live.close().expect("closes");
    let came: Vec<_> = memory
        .packets()
        .iter()
        .map(|p| (p.channel.topic, p.stamp))
        .collect();
    let expected = [
        ("/toile/topology", 0),
        ("/robot_description", 0),
        ("/toile/report", 1),
        ("/toile/state", 999),
        ("/toile/state", 1000),
    ];
    assert_eq!(came, expected);
    let tally = gauge.tally();
    assert_eq!((tally.carried, tally.dropped), (5, 998));
    assert_eq!(tally.failure, None);
}

#[test]
fn a_hanging_carrier_does_not_hold_the_run() {
    let (open, leave) = channel();
    let gate = Gate {
        leave,
        memory: Memory::default(),
    };
    let options = RunOptions {
        live: vec![("stuck".to_string(), Box::new(gate))],
        ..RunOptions::default()
    };
    let start = Instant::now();
    let summary = run(&scene(), options, &mut |_| {}).expect("the run succeeds");
    assert!(start.elapsed() < Duration::from_secs(20));
    let [tally] = &summary.live[..] else {
        panic!("one live carrier");
    };
    assert_eq!((tally.name.as_str(), tally.carried), ("stuck", 0));
    assert!(tally.dropped > 0);
    let failure = tally.failure.as_deref().expect("it hangs");
    assert!(failure.contains("did not end"), "{failure}");
    drop(open);
}

/// A carrier that fails, or panics.
struct Broken {
    panics: bool,
}

impl Carrier for Broken {
    fn publish(&mut self, _: &Packet) -> Result<(), NodeError> {
        assert!(!self.panics, "as the test wants it");
        Err(NodeError::RecorderLost)
    }

    fn commit(&mut self) -> Result<(), NodeError> {
        Ok(())
    }

    fn close(&mut self) -> Result<(), NodeError> {
        Ok(())
    }
}

#[test]
fn a_live_carrier_that_fails_is_told_and_the_run_goes_on() {
    for (panics, reason) in [(false, "recorder thread"), (true, "panicked")] {
        let options = RunOptions {
            live: vec![("broken".to_string(), Box::new(Broken { panics }))],
            ..RunOptions::default()
        };
        let summary = run(&scene(), options, &mut |_| {}).expect("the run succeeds");
        assert_eq!(summary.steps, 20);
        let failure = summary.live[0].failure.as_deref().expect("it failed");
        assert!(failure.contains(reason), "{failure}");
        assert!(summary.live[0].dropped > 0);
    }
}
