//! One Python environment for all peers, the programs in `peers/` that share no code with toile: made once under
//! `target/peers-venv`, from the pinned versions of `peers/requirements.txt`. Tests that need it need Python 3.10
//! to 3.13 with its `venv` module and, the first time, a package index.

use std::fs::{self, File};
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::sync::LazyLock;
use std::thread;

use serde_json::Value;

const REQUIREMENTS: &str = include_str!("peers/requirements.txt");
/// Holds the requirements that were installed; written last.
const SEAL: &str = "installed.txt";

/// The interpreter; panics with one line that says what to install.
pub fn interpreter() -> &'static Path {
    static MADE: LazyLock<Result<PathBuf, String>> = LazyLock::new(make);
    MADE.as_deref().unwrap_or_else(|reason| panic!("{reason}"))
}

/// A script of `tests/it/peers`, ready for arguments; it is killed after so many seconds.
pub fn peer(script: &str, seconds: u32) -> Command {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/it/peers");
    let mut command = Command::new("timeout");
    command.args(["--kill-after=5", &seconds.to_string()]);
    command.arg(interpreter()).arg(folder.join(script));
    command.env("PYTHONDONTWRITEBYTECODE", "1");
    command
}

/// Hands each line to a peer that reads JSON lines; its answers, one a line.
pub fn ask(script: &str, lines: &[Value]) -> Vec<String> {
    let mut peer = peer(script, 120);
    peer.stdin(Stdio::piped()).stdout(Stdio::piped());
    let mut peer = peer.spawn().expect("the peer starts");
    let mut input = peer.stdin.take().expect("a pipe");
    let text: String = lines.iter().map(|line| format!("{line}\n")).collect();
    let writer = thread::spawn(move || input.write_all(text.as_bytes()));
    let output = peer.wait_with_output().expect("the peer ends");
    writer.join().expect("joins").expect("written");
    assert!(output.status.success(), "{script}: {}", output.status);
    let answers = String::from_utf8(output.stdout).expect("UTF-8");
    let answers: Vec<_> = answers.lines().map(str::to_string).collect();
    assert_eq!(answers.len(), lines.len(), "{script}");
    answers
}

fn make() -> Result<PathBuf, String> {
    let target = Path::new(env!("CARGO_TARGET_TMPDIR")).parent();
    let target = target.expect("it lies in target");
    // Test binaries that run at the same time make it once; the lock goes with the file.
    let lock = File::create(target.join("peers-venv.lock")).map_err(|e| e.to_string())?;
    lock.lock().map_err(|e| e.to_string())?;
    let folder = target.join("peers-venv");
    let (python, seal) = (folder.join("bin/python3"), folder.join(SEAL));
    if fs::read_to_string(&seal).is_ok_and(|text| text == REQUIREMENTS) {
        return Ok(python);
    }
    let mut venv = Command::new("python3");
    finish(
        venv.args(["-m", "venv", "--clear"]).arg(&folder),
        "install Python with its venv module (apt-get install python3-venv)",
    )?;
    let wanted = concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/tests/it/peers/requirements.txt"
    );
    let mut pip = Command::new(&python);
    pip.args(["-m", "pip", "install", "--quiet", "--only-binary=:all:"]);
    finish(
        pip.args(["-r", wanted]),
        "the peers need Python 3.10 to 3.13 and a package index, or their wheels in PIP_FIND_LINKS",
    )?;
    fs::write(&seal, REQUIREMENTS).map_err(|e| e.to_string())?;
    Ok(python)
}

/// Runs a command to its end; its last words and what to do about them if it fails.
fn finish(command: &mut Command, advice: &str) -> Result<(), String> {
    let output = command.output();
    let last = match &output {
        Ok(output) if output.status.success() => return Ok(()),
        Ok(output) => {
            let text = [output.stdout.as_slice(), &output.stderr].concat();
            let text = String::from_utf8_lossy(&text).into_owned();
            let mut lines = text.lines().map(str::trim).filter(|l| !l.is_empty());
            lines.next_back().unwrap_or_default().to_string()
        }
        Err(error) => error.to_string(),
    };
    let program = command.get_program().display();
    Err(format!(
        "no Python environment for the peers: {program}: {last}; {advice}"
    ))
}

#[test]
fn every_peer_package_is_there() {
    let script = "import cyclonedds, iceoryx2, mcap, mcap_ros2, numpy, rosbags.highlevel";
    let mut python = Command::new(interpreter());
    finish(
        python.args(["-c", script]),
        "look at peers/requirements.txt",
    )
    .expect("imports");
}

#[test]
fn a_missing_python_is_one_line_of_advice() {
    let refused = finish(&mut Command::new("no-such-python"), "install Python").unwrap_err();
    assert!(refused.contains("no-such-python") && refused.ends_with("; install Python"));
    assert_eq!(refused.lines().count(), 1);
}
