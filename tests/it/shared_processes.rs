//! Shared memory between processes: readers in Rust and Python, and processes that die without a word.

use std::fs;
use std::io::{BufRead, BufReader, Read};
use std::os::unix::fs::PermissionsExt;
use std::path::Path;
use std::process::{Child, ChildStdout, Command, Stdio};
use std::time::{Duration, Instant};

use serde_json::Value;
use tempfile::TempDir;
use toile::node::shared_memory::{RunName, SharedMemory};
use toile::node::{Carrier, Live, Mailbox};
use toile::sim::StepReport;
use toile::wire::{Encoder, Extras};

use super::lab::{built_in, simulation};
use super::python;
use super::shared_memory::name;

/// What a child may take before it is killed \[s\].
const LONGEST: &str = "120";

/// A process of the binary, killed when it takes too long.
pub fn toile(folder: &Path, args: &[&str]) -> Command {
    let mut command = Command::new("timeout");
    command.args(["--kill-after=5", LONGEST, env!("CARGO_BIN_EXE_toile")]);
    command.args(args).current_dir(folder);
    command
        .stdin(Stdio::null())
        .stdout(Stdio::piped())
        .stderr(Stdio::null());
    command
}

fn signal(process: u32, signal: &str) {
    let sent = Command::new("kill")
        .args([signal, &process.to_string()])
        .status();
    assert!(sent.unwrap().success(), "kill {signal} {process}");
}

/// The process behind a `timeout`, which would not hand on a signal that cannot be caught.
fn behind(child: &Child) -> u32 {
    let path = format!("/proc/{0}/task/{0}/children", child.id());
    let until = Instant::now() + Duration::from_secs(10);
    loop {
        let text = fs::read_to_string(&path).unwrap_or_default();
        if let Some(process) = text.split_whitespace().next() {
            return process.parse().unwrap();
        }
        assert!(Instant::now() < until, "{path} stays empty");
        std::thread::sleep(Duration::from_millis(5));
    }
}

/// A free-running publisher of real states, one a millisecond when the machine lets it.
struct Publisher {
    model: toile::sim::Model,
    state: toile::sim::State,
    encoder: Encoder,
    carrier: Live,
    report: StepReport,
    due: Instant,
}

impl Publisher {
    fn start(name: &RunName, triangles: usize) -> Self {
        let scene = built_in("free-fall", &[&format!("sheet.triangles={triangles}")]);
        let simulation = simulation(&scene);
        let run = SharedMemory::open(name.clone(), nobody()).unwrap();
        Self {
            model: simulation.model().clone(),
            state: simulation.state().clone(),
            encoder: Encoder::default(),
            carrier: Live::start("shared memory", Box::new(run)).unwrap(),
            report: simulation.report().clone(),
            due: Instant::now(),
        }
    }

    /// The next state, one millisecond after the one before; after a delay there is no hurry to catch up.
    fn publish(&mut self) {
        self.due = (self.due + Duration::from_millis(1)).max(Instant::now());
        let extras = Extras::default();
        let encoder = &mut self.encoder;
        let packets = encoder.instant(&self.model, &self.state, &self.report, extras);
        let packets = packets.unwrap();
        // The queue before shared memory is for carriers that hang; here it is not to overflow.
        while self.carrier.gauge().waiting() > 32 {
            std::thread::sleep(Duration::from_micros(100));
        }
        for mut packet in packets {
            packet.sequence = self.report.step;
            self.carrier.publish(&packet).unwrap();
        }
        self.carrier.commit().unwrap();
        self.report.step += 1;
        self.report.digest = self.report.digest.rotate_left(1) ^ self.report.step;
        std::thread::sleep(self.due.saturating_duration_since(Instant::now()));
    }
}

/// A mailbox that leads nowhere.
fn nobody() -> Mailbox {
    toile::node::Inbox::with_mailbox().0
}

fn finish(child: Child) -> (bool, String) {
    let output = child.wait_with_output().unwrap();
    (
        output.status.success(),
        String::from_utf8(output.stdout).unwrap(),
    )
}

#[test]
fn a_rust_and_a_python_process_receive_a_thousand_states_in_a_row_at_1_khz() {
    const COUNT: usize = 1000;
    let (name, folder) = (name(), TempDir::new().unwrap());
    let mut publisher = Publisher::start(&name, 5750);
    let vertices = publisher.state.positions.len();
    assert!((2900..3100).contains(&vertices), "{vertices} vertices");
    publisher.publish();
    let (run, count) = (name.to_string(), COUNT.to_string());
    let watch = [
        "watch", "state", "--json", "--name", &run, "--count", &count,
    ];
    let mut rust = toile(folder.path(), &watch).spawn().unwrap();
    let mut python = python::peer("shm_reader.py", 120);
    python.args([&run, &count]).current_dir(folder.path());
    let mut python = python.stdout(Stdio::piped()).spawn().unwrap();
    // Lines of a thousand states do not fit a pipe.
    let lines = [rust.stdout.take(), python.stdout.take()].map(|out| {
        let out = out.unwrap();
        std::thread::spawn(move || BufReader::new(out).lines().map(Result::unwrap).collect())
    });
    let begun = Instant::now();
    while !lines.iter().all(|reader| reader.is_finished()) {
        publisher.publish();
        assert!(begun.elapsed() < Duration::from_secs(100), "readers hang");
    }
    let [rust_lines, python_lines] = lines.map(|reader| -> Vec<String> { reader.join().unwrap() });
    assert!(rust.wait().unwrap().success() && python.wait().unwrap().success());
    assert_eq!((rust_lines.len(), python_lines.len()), (COUNT, COUNT));
    let rust: Vec<_> = rust_lines.iter().map(|line| in_json(line)).collect();
    let python: Vec<_> = python_lines
        .iter()
        .map(|line| in_words(line, vertices))
        .collect();
    for seen in [&rust, &python] {
        let steps: Vec<u64> = seen.iter().map(|(step, _)| *step).collect();
        let expected: Vec<u64> = (steps[0]..).take(COUNT).collect();
        assert!(steps == expected, "not consecutive: {steps:?}");
    }
    let common = rust.iter().filter(|seen| python.contains(seen)).count();
    let overlap = |a: u64, b: u64| COUNT.saturating_sub(a.abs_diff(b) as usize);
    assert_eq!(common, overlap(rust[0].0, python[0].0), "same digests");
    assert_eq!(publisher.carrier.gauge().tally().dropped, 0);
}

/// Step and digest of a line of `toile watch --json`.
fn in_json(line: &str) -> (u64, String) {
    let line: Value = serde_json::from_str(line).unwrap();
    assert_eq!(line["missed"], 0, "{line}");
    let digest = line["digest"].as_str().unwrap().to_string();
    (line["step"].as_u64().unwrap(), digest)
}

/// Step and digest of a line of the Python reader, whose points must be those of the sheet.
fn in_words(line: &str, vertices: usize) -> (u64, String) {
    let words: Vec<_> = line.split_whitespace().collect();
    let [_, step, digest, points, lowest] = words[..] else {
        panic!("{line}")
    };
    assert_eq!(points, vertices.to_string());
    assert!(lowest.parse::<f32>().unwrap().is_finite());
    (step.parse().unwrap(), digest.to_string())
}

#[test]
fn the_readme_has_the_python_reader() {
    let script = include_str!("peers/shm_reader.py");
    let readme = super::tidy::read("README.md");
    let quoted = format!("```python\n{script}```\n");
    assert!(readme.contains(&quoted), "README.md quotes another reader");
}

/// Processes of a folder with such a file do not see those of others.
fn isolated(folder: &Path) -> String {
    let prefix = format!("{}_", name()).replace('-', "_");
    fs::create_dir(folder.join("config")).unwrap();
    let text = format!("[global]\nprefix = \"{prefix}\"\n");
    fs::write(folder.join("config/iceoryx2.toml"), text).unwrap();
    prefix
}

/// What iceoryx2 has left of processes with this prefix, and that others may not read it.
fn left_behind(prefix: &str) -> Vec<String> {
    let mut found = vec![];
    let mut folders = vec!["/dev/shm".into(), "/tmp/iceoryx2".into()];
    while let Some(folder) = folders.pop() {
        let Ok(entries) = fs::read_dir::<&std::path::PathBuf>(&folder) else {
            continue;
        };
        for entry in entries.flatten() {
            let (path, file) = (entry.path(), entry.file_name().into_string().unwrap());
            if path.is_dir() {
                folders.push(path);
            } else if path.to_str().unwrap().contains(prefix) && !file.ends_with(".global_mgmt") {
                if let Ok(data) = entry.metadata() {
                    assert_eq!(data.permissions().mode() & 0o077, 0, "{}", path.display());
                }
                found.push(file);
            }
        }
    }
    found
}

/// A run that goes on for long, in small steps.
fn long_run(folder: &Path, name: &str) -> Child {
    let run = [
        "run",
        "free-fall",
        "--set",
        "sheet.triangles=200",
        "--duration",
        "500",
    ];
    let fast = [
        "--set",
        "output.rate=200",
        "-o",
        "a.mcap",
        "--shm",
        "--name",
        name,
    ];
    toile(folder, &[&run[..], &fast].concat()).spawn().unwrap()
}

/// The next line of a reader.
fn line(lines: &mut BufReader<ChildStdout>) -> Value {
    let mut text = String::new();
    assert!(lines.read_line(&mut text).unwrap() > 0, "the reader ended");
    serde_json::from_str(&text).unwrap()
}

#[test]
fn a_run_killed_ten_times_comes_back_and_its_reader_follows() {
    let folder = TempDir::new().unwrap();
    let prefix = isolated(folder.path());
    let watch = ["watch", "state", "--json", "--name", "phoenix"];
    let mut reader = toile(folder.path(), &watch).spawn().unwrap();
    let mut lines = BufReader::new(reader.stdout.take().unwrap());
    for life in 0..=10 {
        let mut run = long_run(folder.path(), "phoenix");
        // What the last life left unread comes first.
        while line(&mut lines)["first"] != true {}
        for _ in 0..5 {
            assert_eq!(line(&mut lines)["first"], false);
        }
        assert!(left_behind(&prefix).len() > 5, "files in life {life}");
        let last = life == 10;
        signal(behind(&run), if last { "-TERM" } else { "-KILL" });
        assert_eq!(run.wait().unwrap().success(), last, "life {life}");
    }
    signal(behind(&reader), "-TERM");
    let mut rest = String::new();
    lines.read_to_string(&mut rest).unwrap();
    assert!(reader.wait().unwrap().success());
    // What a process was just making when it was killed is removed when it has been so for five seconds.
    std::thread::sleep(Duration::from_millis(5500));
    let nobody = ["watch", "state", "--name", "phoenix", "--timeout", "0.1"];
    toile(folder.path(), &nobody).output().unwrap();
    assert_eq!(left_behind(&prefix), [""; 0], "all cleaned up");
}

#[test]
fn a_second_run_of_a_name_is_refused() {
    let folder = TempDir::new().unwrap();
    isolated(folder.path());
    let mut first = long_run(folder.path(), "twin");
    let watch = ["watch", "state", "--json", "--name", "twin", "--count", "1"];
    assert!(finish(toile(folder.path(), &watch).spawn().unwrap()).0);
    let mut command = toile(
        folder.path(),
        &["run", "free-fall", "--shm", "--name", "twin"],
    );
    let second = command.stderr(Stdio::piped()).output().unwrap();
    let error = String::from_utf8(second.stderr).unwrap();
    assert_eq!(second.status.code(), Some(2), "{error}");
    assert!(error.starts_with("error: a run named \"twin\" is in shared memory already"));
    assert_eq!(error.lines().count(), 1);
    signal(behind(&first), "-TERM");
    assert!(first.wait().unwrap().success());
}

#[test]
fn a_folder_that_iceoryx2_cannot_use_is_named() {
    let folder = TempDir::new().unwrap();
    fs::create_dir(folder.path().join("config")).unwrap();
    let (file, config) = ("taken", "config/iceoryx2.toml");
    fs::write(folder.path().join(file), "").unwrap();
    let root = folder.path().join(file);
    let text = format!("[global]\nroot-path = \"{}\"\n", root.display());
    fs::write(folder.path().join(config), text).unwrap();
    let mut command = toile(folder.path(), &["run", "free-fall", "--shm"]);
    let output = command.stderr(Stdio::piped()).output().unwrap();
    let error = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(1), "{error}");
    let named = format!("error: shared memory: {} is not to be used", root.display());
    assert!(
        error.starts_with(&named) && error.lines().count() == 1,
        "{error}"
    );
}

#[test]
fn readers_that_stand_still_or_die_hold_nobody_up() {
    let (name, folder) = (name(), TempDir::new().unwrap());
    let mut run = SharedMemory::open(name.clone(), nobody()).unwrap();
    let mut publish = |steps: std::ops::Range<u64>| {
        for step in steps {
            run.publish(&super::shared_memory::state(step)).unwrap();
            run.commit().unwrap();
        }
    };
    publish(0..1);
    let run_name = name.to_string();
    let watch = ["watch", "state", "--json", "--name", &run_name];
    let mut reader = toile(folder.path(), &watch).spawn().unwrap();
    let mut lines = BufReader::new(reader.stdout.take().unwrap());
    assert_eq!(line(&mut lines)["step"], 0);
    signal(behind(&reader), "-STOP");
    let begun = Instant::now();
    publish(1..2001);
    let took = begun.elapsed();
    assert!(took < Duration::from_secs(20), "publishing took {took:?}");
    signal(behind(&reader), "-CONT");
    let first = line(&mut lines);
    let (step, missed) = (
        first["step"].as_u64().unwrap(),
        first["missed"].as_u64().unwrap(),
    );
    assert_eq!(step, missed + 1, "it knows what it missed");
    assert!(missed > 1700, "missed {missed}");
    for expected in step + 1..2001 {
        assert_eq!(line(&mut lines)["step"], expected);
    }
    // More than can read at a time.
    for _ in 0..12 {
        let mut other = toile(folder.path(), &watch).spawn().unwrap();
        let mut lines = BufReader::new(other.stdout.take().unwrap());
        assert_eq!(line(&mut lines)["step"], 2000);
        signal(behind(&other), "-KILL");
        other.wait().unwrap();
    }
    publish(2001..2002);
    assert_eq!(line(&mut lines)["step"], 2001);
    signal(behind(&reader), "-TERM");
    assert!(reader.wait().unwrap().success());
}
