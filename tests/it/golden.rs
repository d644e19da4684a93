//! The golden recordings: every build repeats them.

use std::fs;
use std::path::{Path, PathBuf};

use tempfile::TempDir;
use toile::node::{About, Pace, Recording, ReplayOptions, replay, verify};
use toile::scene::parse;
use toile::sim::Simulation;
use toile::wire::cdr;
use toile::wire::channels::APPLIED;
use toile::wire::messages::toile_msgs::AppliedCommand;

use crate::cli::{err, toile};
use crate::python;
use crate::tamper::changed;
use crate::tidy::read;

const FOLDER: &str = "recordings/golden";
/// Set to make the recordings again.
const UPDATE: &str = "UPDATE_RECORDINGS";
/// Most bytes of one.
const LARGEST: u64 = 1_000_000;

fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join(FOLDER)
}

/// Their names; made again first if that is asked for.
fn golden() -> Vec<String> {
    let names = fs::read_dir(folder()).unwrap().filter_map(|entry| {
        let name = entry.unwrap().file_name().into_string().unwrap();
        let stem = name.strip_suffix(".toml")?;
        (!stem.ends_with(".commands")).then(|| stem.to_string())
    });
    let mut names: Vec<_> = names.collect();
    names.sort();
    assert!(names.len() >= 5, "{names:?}");
    names
}

fn make(name: &str) {
    let (scene, commands) = (format!("{name}.toml"), format!("{name}.commands.toml"));
    let output = format!("{name}.mcap");
    let mut args = vec!["run", &scene, "-o", &output];
    if folder().join(&commands).exists() {
        args.extend(["--commands", &commands]);
    }
    let output = toile(&folder(), &args);
    assert_eq!(output.status.code(), Some(0), "{name}: {}", err(&output));
}

fn path(name: &str) -> PathBuf {
    folder().join(format!("{name}.mcap"))
}

/// One test for all, since making them again must come before replaying them.
#[test]
fn golden_recordings_are_repeated() {
    let mut here = None;
    for name in golden() {
        if std::env::var_os(UPDATE).is_some() {
            make(&name);
        }
        let recording = Recording::open(&path(&name)).unwrap();
        let here = here.get_or_insert_with(|| {
            let simulation = Simulation::new(recording.scene(), 1).unwrap();
            About::run(simulation.model(), Pace::Free, false)
        });
        let same_processor = recording.about().processor == here.processor;
        let middle = recording.last_step() / 2 + 1;
        for (threads, from) in [(1, None), (2, None), (1, Some(middle))] {
            let options = ReplayOptions {
                threads,
                from,
                ..ReplayOptions::default()
            };
            let replay = replay(&path(&name), &options, &mut |_| {}).unwrap();
            if let Some(difference) = &replay.difference {
                panic!("{name} differs at {difference}; {ADVICE}");
            }
            if let Some(first) = replay.bits.as_ref().filter(|_| same_processor) {
                panic!("{name} has other bits at {first}; {ADVICE}");
            }
            assert!(replay.states >= 3 && replay.to == recording.last_step());
            assert_eq!(replay.from > 0, from.is_some());
            let commands = recording.commands().iter();
            let expected = commands.filter(|c| c.step >= replay.from).count() as u64;
            assert_eq!(replay.commands, expected);
        }
    }
}

#[test]
fn golden_recordings_are_read_by_programs_of_others() {
    for name in golden() {
        let mut peer = python::peer("check_mcap.py", 120);
        let peer = peer.arg(path(&name)).output().unwrap();
        let said = String::from_utf8_lossy(&peer.stdout);
        assert!(peer.status.success(), "{name}: {said}");
        assert!(said.contains("/toile/state"), "{name}: {said}");
    }
}

/// The last byte that says something in the first command that was taken: a size, a direction, a mode.
fn flip_a_byte_of_a_command() -> impl FnMut(&str, &mut Vec<u8>) {
    let mut done = false;
    move |topic, bytes| {
        if done || topic != APPLIED.topic {
            return;
        }
        let mut applied: AppliedCommand = cdr::decode(bytes).unwrap();
        if applied.accepted {
            let byte = applied.payload.iter_mut().rfind(|byte| **byte != 0);
            *byte.unwrap() ^= 1;
            *bytes = cdr::encode(&applied).unwrap();
            done = true;
        }
    }
}

#[test]
fn a_flipped_byte_in_a_command_is_found_in_each() {
    let folder = TempDir::new().unwrap();
    let mut with_commands = 0;
    for name in golden() {
        if Recording::open(&path(&name)).unwrap().commands().is_empty() {
            continue;
        }
        with_commands += 1;
        let tampered = folder.path().join("tampered.mcap");
        let bytes = changed(&path(&name), flip_a_byte_of_a_command(), &[]);
        fs::write(&tampered, bytes).unwrap();
        let replay = replay(&tampered, &ReplayOptions::default(), &mut |_| {}).unwrap();
        let found = replay.difference.or(replay.bits);
        assert!(found.is_some(), "{name}");
    }
    assert!(with_commands >= 4);
}

const ADVICE: &str = "if the physics was changed on purpose, see recordings/golden/README.md";

#[test]
fn golden_recordings_are_small_whole_and_made_from_what_lies_beside_them() {
    if std::env::var_os(UPDATE).is_some() {
        return;
    }
    let readme = read(format!("{FOLDER}/README.md"));
    for name in golden() {
        let size = path(&name).metadata().unwrap().len();
        assert!(size <= LARGEST, "{name}: {size} bytes");
        assert_eq!(verify(&path(&name)).unwrap(), [""; 0], "{name}");
        let recording = Recording::open(&path(&name)).unwrap();
        let (scene, _) = parse(&read(format!("{FOLDER}/{name}.toml")), &[]).unwrap();
        assert_eq!(*recording.scene(), scene, "{name}");
        assert!(recording.keyframes().len() >= 2, "{name}");
        let wanted = folder().join(format!("{name}.commands.toml"));
        let wanted = fs::read_to_string(wanted).unwrap_or_default();
        let wanted = wanted.matches("[[command]]").count();
        assert_eq!(recording.commands().len(), wanted, "{name}");
        let refused = recording.commands().iter().any(|c| !c.accepted);
        assert!(
            wanted == 0 || refused,
            "{name} tries nothing that is refused"
        );
        assert!(readme.contains(&format!("| `{name}` |")), "{name}");
    }
}
