//! The bridge may die; the run does not notice.

use std::fs;
use std::net::UdpSocket;
use std::path::Path;
use std::process::{Command, Stdio};

use rustix::process::{Pid, Signal, kill_process, test_kill_process};
use serde_json::Value;
use tempfile::TempDir;
use toile::node::ros2::Peer;
use toile::scene::Scene;
use toile::sim::Simulation;
use toile::wire::channels::REPORT;
use toile::wire::messages::toile_msgs::StepReport;

use super::rig::{Rig, SCENE, Talk, output, recorded, wait};

/// Every recorded state is, bit for bit, the one of a run that nobody disturbs.
#[track_caller]
pub fn assert_undisturbed(recording: &Path) {
    let scene: Scene = toml::from_str(SCENE).unwrap();
    let mut simulation = Simulation::new(&scene, 1).unwrap();
    let reports: Vec<StepReport> = recorded(recording, "/toile/report");
    assert!(reports.len() > 10, "{} reports", reports.len());
    for report in reports {
        while simulation.report().step < report.step {
            simulation.step().unwrap();
        }
        assert_eq!(
            report.digest,
            simulation.report().digest,
            "step {}",
            report.step
        );
    }
}

fn kill(pid: Pid) {
    kill_process(pid, Signal::KILL).unwrap();
}

/// Waits until the bridge is another process than before.
fn reborn(rig: &Rig, before: Pid) -> Pid {
    wait("the bridge to be started again", || {
        let pid = rig.bridge();
        (pid != before).then_some(pid)
    })
}

#[test]
fn a_killed_bridge_is_started_again_and_the_run_is_none_the_wiser() {
    let mut rig = Rig::start(SCENE, &["--pace", "real"]);
    let first = rig.bridge();
    kill(first);
    let second = reborn(&rig, first);
    kill(second);
    reborn(&rig, second);
    // What was said once, before all this, is still said to who comes now.
    let topology = output(rig.peer("ros2_peer.py", 60).arg("topology"));
    let topology: Value = serde_json::from_str(&topology).unwrap();
    assert!(topology["triangles"].as_u64().unwrap() > 100);
    let (summary, errors) = rig.stop();
    assert_eq!(summary["bridge"]["restarts"], 2, "{summary}");
    let said = "the ROS 2 bridge died (signal: 9";
    assert_eq!(errors.matches(said).count(), 2, "{errors}");
    assert_undisturbed(&rig.recording());
}

#[test]
fn a_forged_packet_that_wants_all_memory_costs_the_bridge_its_life_and_nothing_else() {
    let mut rig = Rig::start(SCENE, &["--pace", "real", "--memory-limit", "768"]);
    let first = rig.bridge();
    let limits = fs::read_to_string(format!("/proc/{}/limits", first.as_raw_nonzero())).unwrap();
    let limit = limits
        .lines()
        .find(|line| line.starts_with("Max address space"));
    assert!(
        limit.unwrap().contains(&(768u64 << 20).to_string()),
        "{limit:?}"
    );
    // Packets that come before the bridge is ready go nowhere.
    let mut peer = Peer::join(rig.settings()).unwrap();
    let mut reports = peer.subscribe(&REPORT, REPORT.topic).unwrap();
    wait("the bridge to be there", || {
        (reports.publishers() > 0).then_some(())
    });
    let socket = UdpSocket::bind("127.0.0.1:0").unwrap();
    let port = 7410 + 250 * rig.domain;
    socket.send_to(&forged(), ("127.0.0.1", port)).unwrap();
    reborn(&rig, first);
    let (summary, errors) = rig.stop();
    assert_eq!(summary["bridge"]["restarts"], 1, "{errors}");
    assert_undisturbed(&rig.recording());
}

/// The first fragment of a message of 4 GiB for the reader that takes announcements of participants: the DDS
/// library sets the memory for all of it aside at once (RTPS 2.5, 9.4.5.5).
fn forged() -> Vec<u8> {
    let announcements = [0x00, 0x01, 0x00, 0xc7];
    let announcer = [0x00, 0x01, 0x00, 0xc2];
    let mut fragment = vec![];
    fragment.extend([0, 0]); // extra flags
    fragment.extend(28u16.to_le_bytes()); // octets to inline QoS
    fragment.extend(announcements);
    fragment.extend(announcer);
    fragment.extend(0i32.to_le_bytes()); // sequence number, high
    fragment.extend(1u32.to_le_bytes()); // and low
    fragment.extend(1u32.to_le_bytes()); // first fragment
    fragment.extend(1u16.to_le_bytes()); // fragments here
    fragment.extend(60_000u16.to_le_bytes()); // bytes of each
    fragment.extend(u32::MAX.to_le_bytes()); // bytes of all
    fragment.extend([0; 64]);
    let mut packet = b"RTPS".to_vec();
    packet.extend([2, 3, 1, 18]); // version, vendor
    packet.extend([7; 12]); // participant
    packet.extend([0x16, 0x01]); // DATA_FRAG, little endian
    packet.extend((fragment.len() as u16).to_le_bytes());
    packet.extend(fragment);
    packet
}

#[test]
fn a_killed_subscriber_holds_nobody_up() {
    let mut rig = Rig::start(SCENE, &["--pace", "real"]);
    let mut peer = Talk::with(rig.peer("ros2_peer.py", 60).arg("hold"));
    assert_eq!(peer.line(), "ready");
    peer.kill();
    let listened = rig
        .peer("dds_peer.py", 60)
        .args(["listen", "--seconds", "5"])
        .output()
        .unwrap();
    let said = String::from_utf8_lossy(&listened.stdout).into_owned();
    let states: usize = said.split_whitespace().nth(1).unwrap().parse().unwrap();
    assert!(states > 250, "{said}");
    let (summary, _) = rig.stop();
    assert_eq!(summary["bridge"]["restarts"], 0);
    assert_undisturbed(&rig.recording());
}

#[test]
fn a_bridge_ends_with_its_run_however_that_ends() {
    let mut rig = Rig::start(SCENE, &["--pace", "real"]);
    let bridge = rig.bridge();
    rig.stop();
    assert!(
        test_kill_process(bridge).is_err(),
        "it is gone before the run is"
    );
    let rig = Rig::start(SCENE, &["--pace", "real"]);
    let bridge = rig.bridge();
    // Killed, the run cannot say goodbye.
    drop(rig);
    wait("the orphan to end", || {
        test_kill_process(bridge).is_err().then_some(())
    });
}

#[test]
fn what_ros_2_cannot_be_told_is_refused_before_anything_starts() {
    for (variable, value, arguments, part) in [
        ("ROS_DOMAIN_ID", "233", &[][..], "from 0 to 232"),
        ("ROS_LOCALHOST_ONLY", "1", &["--allow-lan"], "contradicts"),
        ("ROS_AUTOMATIC_DISCOVERY_RANGE", "OFF", &[], "LOCALHOST"),
        ("ROS_DOMAIN_ID", "0", &["--node-name", "2nd"], "2nd"),
    ] {
        for verb in [&["bridge"][..], &["run", "free-fall", "--ros2"]] {
            let directory = TempDir::new().unwrap();
            let output = Command::new(env!("CARGO_BIN_EXE_toile"))
                .args(verb)
                .args(arguments)
                .env(variable, value)
                .current_dir(directory.path())
                .stdin(Stdio::null())
                .output()
                .unwrap();
            let said = String::from_utf8_lossy(&output.stderr).into_owned();
            assert_eq!(output.status.code(), Some(2), "{said}");
            assert_eq!(said.lines().count(), 1, "{said}");
            assert!(said.starts_with("error: ") && said.contains(part), "{said}");
            assert_eq!(directory.path().read_dir().unwrap().count(), 0);
        }
    }
}
