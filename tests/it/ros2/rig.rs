//! A run with its bridge, started as a user would, on a DDS domain that nobody else is on.

use std::fs;
use std::io::{BufRead, BufReader, Read};
use std::net::UdpSocket;
use std::path::{Path, PathBuf};
use std::process::{Child, ChildStdout, Command, Stdio};
use std::sync::Mutex;
use std::thread::sleep;
use std::time::{Duration, Instant};

use rustix::process::{Pid, Signal, kill_process};
use serde_json::Value;
use tempfile::TempDir;
use toile::node::ros2::Settings;

use crate::python;

/// Longest wait for anything that should happen at once, on a machine that has much else to do.
pub const PATIENCE: Duration = Duration::from_secs(60);

/// A small square over a table, 5 ms a step, 100 states a second of simulated time, until it is stopped.
pub const SCENE: &str = r#"
name = "rig"
description = "a square over a table that can be moved and blown at"
duration = 1000.0
accept = ["obstacles", "air"]
[sheet]
outline = { kind = "rectangle", length = 0.2, width = 0.2 }
triangles = 150
position = [0.0, 0.0, 0.001]
[fabric]
name = "F1"
[obstacle.table]
shape = { kind = "box", size = [0.1, 0.1, 0.1] }
position = [0.0, 0.0, -0.05]
friction = 0.3
[method]
dt = 0.005
[output]
rate = 100.0
mesh_rate = 10.0
"#;

/// A domain that no other test and no other program on this machine is on.
pub fn free_domain() -> u16 {
    static TAKEN: Mutex<Vec<u16>> = Mutex::new(vec![]);
    let mut taken = TAKEN.lock().unwrap();
    // Domains whose ports lie below those that the system hands out.
    let first = std::process::id() % 100;
    let domains = (0..100).map(|k| u16::try_from(1 + (first + 7 * k) % 100).unwrap());
    let is_free = |domain: &u16| UdpSocket::bind(("0.0.0.0", 7410 + 250 * domain)).is_ok();
    let free = domains
        .filter(|domain| !taken.contains(domain))
        .find(is_free);
    let domain = free.expect("one of a hundred domains is free");
    taken.push(domain);
    domain
}

/// A running `toile run SCENE --ros2`.
pub struct Rig {
    run: Child,
    pub domain: u16,
    directory: TempDir,
}

impl Rig {
    /// Starts a scene with further arguments and waits until its bridge is on the domain.
    pub fn start(scene: &str, arguments: &[&str]) -> Self {
        let domain = free_domain();
        let directory = TempDir::new().unwrap();
        fs::write(directory.path().join("scene.toml"), scene).unwrap();
        let name = format!("it-{}-{domain}", std::process::id());
        let run = Command::new(env!("CARGO_BIN_EXE_toile"))
            .args(["run", "scene.toml", "-o", "run.mcap", "--json"])
            .args(["--ros2", "--name", &name])
            .args(arguments)
            .current_dir(directory.path())
            .env("ROS_DOMAIN_ID", domain.to_string())
            .stdin(Stdio::null())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .unwrap();
        let rig = Self {
            run,
            domain,
            directory,
        };
        rig.bridge();
        rig
    }

    /// Process of the bridge that is on the domain now.
    pub fn bridge(&self) -> Pid {
        wait("a bridge on its domain", || {
            let pid = child_of(self.run.id())?;
            let taken = UdpSocket::bind(("0.0.0.0", 7410 + 250 * self.domain)).is_err();
            taken.then_some(pid)
        })
    }

    pub fn settings(&self) -> Settings {
        Settings {
            domain: self.domain,
            node_name: "tester".to_string(),
            ..Settings::default()
        }
    }

    /// A foreign program on the same domain.
    pub fn peer(&self, script: &str, seconds: u32) -> Command {
        let mut command = python::peer(script, seconds);
        command.env("ROS_DOMAIN_ID", self.domain.to_string());
        command.stdin(Stdio::null());
        command
    }

    pub fn recording(&self) -> PathBuf {
        self.directory.path().join("run.mcap")
    }

    /// Asks the run to end as Ctrl-C does; its summary and what it said on standard error.
    pub fn stop(&mut self) -> (Value, String) {
        let pid = Pid::from_child(&self.run);
        kill_process(pid, Signal::INT).unwrap();
        self.finish()
    }

    /// Waits for the end of the run.
    pub fn finish(&mut self) -> (Value, String) {
        let status = wait("the end of the run", || self.run.try_wait().unwrap());
        let mut errors = String::new();
        let mut summary = String::new();
        let (stdout, stderr) = (self.run.stdout.take(), self.run.stderr.take());
        stdout.unwrap().read_to_string(&mut summary).unwrap();
        stderr.unwrap().read_to_string(&mut errors).unwrap();
        assert!(status.success(), "{status}: {errors}");
        (serde_json::from_str(&summary).unwrap(), errors)
    }
}

impl Drop for Rig {
    fn drop(&mut self) {
        // A failed test leaves nothing running.
        let _ = self.run.kill();
        let _ = self.run.wait();
    }
}

/// Looks for something until it is there.
pub fn wait<T>(what: &str, mut look: impl FnMut() -> Option<T>) -> T {
    let start = Instant::now();
    loop {
        if let Some(found) = look() {
            return found;
        }
        assert!(
            start.elapsed() < PATIENCE,
            "{what}: not within {PATIENCE:?}"
        );
        sleep(Duration::from_millis(10));
    }
}

/// The process that another one started and that still runs.
fn child_of(parent: u32) -> Option<Pid> {
    let line = format!("PPid:\t{parent}");
    let processes = fs::read_dir("/proc").unwrap().flatten();
    let mut numbers = processes.filter_map(|entry| entry.file_name().to_str()?.parse().ok());
    let found = numbers.find(|number: &i32| {
        let status = fs::read_to_string(format!("/proc/{number}/status")).unwrap_or_default();
        status.lines().any(|l| l == line) && !status.contains("State:\tZ")
    });
    found.and_then(Pid::from_raw)
}

/// What a program says, line by line.
pub struct Talk {
    child: Child,
    lines: BufReader<ChildStdout>,
}

impl Talk {
    pub fn with(command: &mut Command) -> Self {
        let mut child = command.stdout(Stdio::piped()).spawn().unwrap();
        let lines = BufReader::new(child.stdout.take().unwrap());
        Self { child, lines }
    }

    /// The next line.
    pub fn line(&mut self) -> String {
        let mut line = String::new();
        self.lines.read_line(&mut line).unwrap();
        line.trim().to_string()
    }

    /// The next line as JSON.
    pub fn json(&mut self) -> Value {
        let line = self.line();
        serde_json::from_str(&line).unwrap_or_else(|error| panic!("{error}: {line:?}"))
    }

    pub fn kill(mut self) {
        self.child.kill().unwrap();
        self.child.wait().unwrap();
    }

    /// Waits until it has ended well.
    pub fn end(mut self) {
        let status = self.child.wait().unwrap();
        assert!(status.success(), "{status}");
    }
}

/// Runs a program to its end, which must be a good one; its words.
pub fn output(command: &mut Command) -> String {
    let output = command.output().unwrap();
    let said = String::from_utf8_lossy(&output.stdout).into_owned();
    let errors = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{}: {said}{errors}", output.status);
    said
}

/// All messages of a topic in a recording.
pub fn recorded<M: toile::wire::Message>(recording: &Path, topic: &str) -> Vec<M> {
    let bytes = fs::read(recording).unwrap();
    let messages = mcap::MessageStream::new(&bytes)
        .unwrap()
        .map(Result::unwrap);
    let of_topic = messages.filter(|message| message.channel.topic == topic);
    of_topic
        .map(|message| toile::wire::cdr::decode(&message.data).unwrap())
        .collect()
}
