//! What the way over ROS 2 costs, printed for whoever asks, on a quiet machine:
//! `cargo test --release --test it -- --ignored --nocapture measure_ros2`.

use std::process::{Child, Command, Stdio};
use std::thread::sleep;
use std::time::{Duration, Instant, SystemTime, UNIX_EPOCH};

use toile::node::shared_memory::SharedMemory;
use toile::node::{Carrier, Inbox};
use toile::wire::messages::builtin_interfaces::Time;
use toile::wire::messages::sensor_msgs::PointCloud2;
use toile::wire::messages::std_msgs::Header;
use toile::wire::{Packet, cdr, channels};

use super::rig::{Talk, free_domain};
use crate::python;
use crate::shared_measure::quantiles;
use crate::shared_memory::name;

/// States of one measurement.
const COUNT: u64 = 1000;

/// A bridge of its own, ended with the measurement.
struct Bridge(Child);

impl Drop for Bridge {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

fn since_epoch() -> Duration {
    SystemTime::now().duration_since(UNIX_EPOCH).unwrap()
}

/// A state of so many vertices that says when it was sent.
fn state(step: u64, vertices: usize) -> Packet {
    let now = since_epoch();
    let (sec, nanosec) = (now.as_secs() as i32, now.subsec_nanos());
    let cloud = PointCloud2 {
        header: Header {
            stamp: Time { sec, nanosec },
            frame_id: "world".to_string(),
        },
        height: 1,
        width: vertices as u32,
        point_step: 24,
        row_step: 24 * vertices as u32,
        data: vec![1; 24 * vertices],
        ..PointCloud2::default()
    };
    Packet {
        channel: &channels::STATE,
        obstacle: None,
        sequence: step,
        stamp: now.as_nanos() as u64,
        step,
        digest: 1,
        bytes: cdr::encode(&cloud).unwrap(),
    }
}

/// Publishes at a rate \[Hz\] until the foreign reader has its count or half of it is lost: latencies at the reader
/// and how many it missed meanwhile.
fn publish(vertices: usize, rate: f64) -> (Vec<Duration>, u64) {
    let (run, domain) = (name(), free_domain());
    let mut carrier = SharedMemory::open(run.clone(), Inbox::with_mailbox().0).unwrap();
    carrier.publish(&state(0, vertices)).unwrap();
    let bridge = Command::new(env!("CARGO_BIN_EXE_toile"))
        .args(["bridge", "--name", &run.to_string()])
        .env("ROS_DOMAIN_ID", domain.to_string())
        .stdin(Stdio::piped())
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn();
    let _bridge = Bridge(bridge.unwrap());
    let mut command = python::peer("ros2_peer.py", 60);
    command.args(["latency", &COUNT.to_string()]);
    command.env("ROS_DOMAIN_ID", domain.to_string());
    let mut peer = Talk::with(command.stdin(Stdio::null()));
    assert_eq!(peer.line(), "ready");
    sleep(Duration::from_secs(1));
    let begun = Instant::now();
    for step in 1..=COUNT * 3 / 2 {
        let due = begun + Duration::from_secs_f64(step as f64 / rate);
        sleep(due.saturating_duration_since(Instant::now()));
        carrier.publish(&state(step, vertices)).unwrap();
        carrier.commit().unwrap();
    }
    let lines = (0..COUNT)
        .map(|_| peer.line())
        .take_while(|l| !l.is_empty());
    let seen: Vec<[u64; 2]> = lines
        .map(|line| {
            let words: Vec<u64> = line.split(' ').map(|w| w.parse().unwrap()).collect();
            [words[0] * 1_000_000_000 + words[1], words[2]]
        })
        .collect();
    peer.kill();
    let late = seen
        .iter()
        .map(|[sent, at]| Duration::from_nanos(at.saturating_sub(*sent)));
    // Between the first and the last one seen there should be no others.
    let span = (seen.last().unwrap()[0] - seen[0][0]) as f64 * 1e-9;
    let missed = (span * rate).round() as u64 + 1;
    (late.collect(), missed.saturating_sub(seen.len() as u64))
}

#[test]
#[ignore = "a measurement: its numbers depend on the machine and on what else it does"]
fn measure_ros2() {
    for vertices in [3000, 12000] {
        for rate in [100.0, 200.0, 400.0, 800.0] {
            let (late, missed) = publish(vertices, rate);
            let count = late.len();
            let (median, high) = quantiles(late);
            println!(
                "{vertices} vertices at {rate} Hz over ROS 2: {count} seen, {missed} missed, median {median:.0} us, \
                 99 % {high:.0} us"
            );
        }
    }
}
