//! Recordings that something went wrong with: cut short, damaged, killed, out of space.

use std::fs::{self, File};
use std::io::{BufRead, BufReader, Write};
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::Duration;

use tempfile::TempDir;
use toile::node::{NodeError, Recording, RunOptions, run, seal, verify};

use crate::recording::{assert_whole, error_of, recorded, scene};

#[test]
fn a_file_cut_anywhere_still_explains_itself_and_can_be_sealed() {
    let (directory, path) = recorded();
    let bytes = fs::read(&path).expect("read");
    let whole = Recording::open(&path).expect("opens");
    let cut_path = directory.path().join("cut.mcap");
    let after_topology = bytes.len() / 4;
    for cut in (after_topology..bytes.len()).step_by(bytes.len() / 40) {
        fs::write(&cut_path, &bytes[..cut]).expect("write");
        let recording = Recording::open(&cut_path).expect("a cut file opens");
        assert_eq!(recording.scene(), whole.scene());
        assert_eq!(recording.faces(), whole.faces());
        let times = recording.times();
        assert_eq!(times, whole.times()[..times.len()]);
        if let Some(last) = times.len().checked_sub(1) {
            let (cut, full) = (recording.frame(last), whole.frame(last));
            assert_eq!(
                cut.expect("there").positions,
                full.expect("there").positions
            );
        }
        seal(&cut_path).expect("can be completed");
        assert_whole(&cut_path);
        assert_eq!(Recording::open(&cut_path).expect("opens").times(), times);
    }
    fs::write(&cut_path, &bytes).expect("write");
    seal(&cut_path).expect("a whole file");
    assert!(
        fs::read(&cut_path).expect("read") == bytes,
        "sealing a whole file changes nothing"
    );
}

#[test]
fn a_flipped_byte_is_noticed() {
    let (_directory, path) = recorded();
    let mut bytes = fs::read(&path).expect("read");
    let middle = bytes.len() / 2;
    bytes[middle] ^= 1;
    fs::write(&path, &bytes).expect("write");
    let error = Recording::open(&path).map(|_| ()).expect_err("damaged");
    assert!(matches!(error, NodeError::Unreadable { .. }), "{error}");
    assert!(error.to_string().contains("at byte"), "{error}");
}

/// Wherever a byte is flipped, reading ends with an error or with what was recorded: a length inside a damaged chunk
/// is not believed.
#[test]
fn flipped_bytes_all_over_a_file_do_no_harm() {
    let (_directory, path) = recorded();
    let whole = fs::read(&path).expect("read");
    let mut noticed = 0;
    for at in (0..whole.len()).step_by(whole.len() / 300) {
        let mut bytes = whole.clone();
        bytes[at] ^= 1;
        fs::write(&path, &bytes).expect("write");
        noticed += usize::from(verify(&path).is_ok_and(|faults| !faults.is_empty()));
    }
    assert!(noticed > 200, "{noticed} noticed");
}

/// Where a child process records to; see [`records_where_told`].
const TOLD: &str = "TOILE_TEST_RECORD";

/// Not a test of its own: the process that others limit and kill. Says each step that it has taken.
#[test]
fn records_where_told() {
    let Some(path) = std::env::var_os(TOLD) else {
        return;
    };
    let options = RunOptions {
        output: Some(path.into()),
        ..RunOptions::default()
    };
    let mut long = scene();
    long.duration = 10.0;
    long.output.rate = 200.0;
    let result = run(&long, options, &mut |progress| {
        std::thread::sleep(Duration::from_millis(1));
        let _ = writeln!(std::io::stderr(), "step {}", progress.step);
    });
    if let Err(error) = result {
        let _ = writeln!(std::io::stderr(), "error {error}");
    }
}

/// This binary again, running only [`records_where_told`], after a shell command.
fn child(before: &str, path: &Path) -> Command {
    let mut command = Command::new("bash");
    let run = "exec \"$0\" --exact damage::records_where_told --nocapture";
    command
        .arg("-c")
        .arg(format!("{before} {run}"))
        .arg(std::env::current_exe().expect("a path"))
        .env(TOLD, path)
        .stdout(Stdio::null())
        .stderr(Stdio::piped());
    command
}

#[test]
fn kill_loses_at_most_a_tenth_of_a_second() {
    let directory = TempDir::new().expect("a directory");
    let path = directory.path().join("killed.mcap");
    let mut process = child("", &path).spawn().expect("starts");
    let lines = BufReader::new(process.stderr.take().expect("piped")).lines();
    let steps = lines.filter_map(|l| l.ok()?.strip_prefix("step ")?.parse::<u64>().ok());
    let last = steps.take(150).last().expect("steps are said");
    process.kill().expect("kill -9");
    process.wait().expect("ends");
    let times = Recording::open(&path).expect("opens").times();
    let recorded = (times.last().expect("states") / 0.005).round() as u64;
    // A step takes at least 1 ms of wall time here, so 0.1 s are at most 100 steps; the queue holds 4.
    assert!(recorded + 20 >= last, "said {last}, recorded {recorded}");
    seal(&path).expect("can be completed");
    assert_whole(&path);
}

#[test]
fn a_full_disk_ends_with_an_error_and_a_file_that_opens() {
    let directory = TempDir::new().expect("a directory");
    let path = directory.path().join("full.mcap");
    // No file may grow past 300 KiB: every write beyond fails, as on a full disk, the index's too.
    let limited = child("trap '' XFSZ; ulimit -f 300;", &path)
        .output()
        .expect("runs");
    let said = String::from_utf8_lossy(&limited.stderr).into_owned();
    let error = said
        .lines()
        .find(|l| l.starts_with("error "))
        .expect("an error");
    assert!(
        error.contains("no space left") && error.contains("full.mcap"),
        "{error}"
    );
    assert_whole(&path);
    assert!(Recording::open(&path).expect("opens").times().len() > 10);
}

#[test]
fn a_device_without_space_is_an_error() {
    let directory = TempDir::new().expect("a directory");
    let path = directory.path().join("run.mcap");
    if !Path::new("/dev/full").exists() || File::open("/dev/full").is_err() {
        return;
    }
    std::os::unix::fs::symlink("/dev/full", &path).expect("link");
    let error = error_of(&path);
    assert!(matches!(error, NodeError::DiskFull { .. }), "{error}");
}
