//! The house rules, read off the source tree: what the compiler does not check.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

/// DESIGN section 5, each module with what it may import of the crate.
pub const IMPORTS: [(&str, &str); 12] = [
    ("math", ""),
    ("sheet", "math"),
    ("fabric", "math"),
    ("contact", "math sheet fabric"),
    ("physics", "math sheet fabric contact"),
    ("scene", "math sheet fabric contact physics"),
    ("sim", "math sheet fabric contact physics scene"),
    ("instrument", "math sheet fabric contact physics scene sim"),
    (
        "chart",
        "math sheet fabric contact physics scene sim instrument",
    ),
    (
        "wire",
        "math sheet fabric contact physics scene sim instrument",
    ),
    (
        "node",
        "math sheet fabric contact physics scene sim instrument wire",
    ),
    (
        "cli",
        "math sheet fabric contact physics scene sim instrument chart wire node",
    ),
];

/// The top level that the customer fixed, and what Cargo adds; beside them only files that begin with a dot.
const TOP_LEVEL: [&str; 9] = [
    "Cargo.lock",
    "Cargo.toml",
    "LICENSE",
    "README.md",
    "benches",
    "msgs",
    "recordings",
    "src",
    "tests",
];

/// The build script stands beside the messages that it generates, and is no module of the crate.
const BUILD_SCRIPT: &str = "src/wire/build.rs";

/// Words, and the modules in which they may stand. Tests beside the source are held to the same.
const BANNED: [(&str, &[&str]); 10] = [
    ("HashMap", &[]),
    ("HashSet", &[]),
    ("Instant::now", &["node", "cli"]),
    ("SystemTime", &["node", "cli"]),
    ("std::fs", &["node", "cli"]),
    ("std::env", &["node", "cli"]),
    ("mul_add", &[]),
    ("println!", &["cli"]),
    ("eprintln!", &["cli"]),
    ("unsafe", &[]),
];

const MOST_LINES: usize = 400;
const MOST_ARCHITECTURE_LINES: usize = 200;

pub fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

pub fn read(path: impl AsRef<Path>) -> String {
    let path = root().join(path);
    fs::read_to_string(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}

/// All Rust files under a folder of the repository, with their text.
pub fn sources(folder: &str) -> Vec<(PathBuf, String)> {
    let mut found = vec![];
    let mut folders = vec![root().join(folder)];
    while let Some(folder) = folders.pop() {
        for entry in fs::read_dir(&folder).unwrap() {
            let path = entry.unwrap().path();
            match path.extension() {
                _ if path.is_dir() => folders.push(path),
                Some(extension) if extension == "rs" => found.push(path),
                _ => {}
            }
        }
    }
    found.sort();
    let relative = |path: &Path| path.strip_prefix(root()).unwrap().to_path_buf();
    found
        .iter()
        .map(|path| (relative(path), read(path)))
        .collect()
}

pub fn folders(folder: &str) -> BTreeSet<String> {
    let entries = fs::read_dir(root().join(folder)).unwrap();
    entries
        .map(|entry| entry.unwrap())
        .filter(|entry| entry.path().is_dir())
        .map(|entry| entry.file_name().into_string().unwrap())
        .collect()
}

/// The top module that a source file belongs to; empty for `lib.rs` and `main.rs`.
fn module(path: &Path) -> String {
    let parts: Vec<_> = path.iter().map(|part| part.to_str().unwrap()).collect();
    match parts[..] {
        ["src", folder, _, ..] => folder.to_string(),
        _ => String::new(),
    }
}

/// The code of a line: what stands before a comment.
pub fn code(line: &str) -> &str {
    line.split("//").next().unwrap_or(line)
}

/// The identifier that a text begins with.
pub fn identifier(text: &str) -> &str {
    let end = text.find(|c: char| !c.is_alphanumeric() && c != '_');
    &text[..end.unwrap_or(text.len())]
}

/// Whether a word stands in a text with no letter on either side.
fn has_word(text: &str, word: &str) -> bool {
    let part = |c: char| c.is_alphanumeric() || c == '_';
    text.match_indices(word).any(|(at, _)| {
        let before = text[..at].chars().next_back();
        let after = text[at + word.len()..].chars().next();
        !before.is_some_and(part) && !after.is_some_and(part)
    })
}

/// What a file imports of the crate, by `crate::name`, `crate::{...}` or enough `super::`.
fn imported(path: &Path, text: &str) -> Vec<(usize, String)> {
    let modules: Vec<_> = IMPORTS.iter().map(|(name, _)| *name).collect();
    // src/a.rs and src/a/mod.rs are one module deep, src/a/b.rs two.
    let deep = path.iter().count() - 1 - usize::from(path.ends_with("mod.rs"));
    let to_root = "super::".repeat(deep);
    let mut found = vec![];
    for (number, line) in text.lines().enumerate() {
        let line = code(line);
        for way in ["crate::", to_root.as_str()] {
            for (at, _) in line.match_indices(way) {
                let name = identifier(&line[at + way.len()..]);
                let from_root = way == "crate::" || modules.contains(&name);
                if from_root {
                    found.push((number + 1, name.to_string()));
                }
            }
        }
    }
    found
}

#[test]
fn imports_go_one_way() {
    let allowed: BTreeMap<_, _> = IMPORTS.into_iter().collect();
    let mut seen = 0;
    for (path, text) in sources("src") {
        let Some(allowed) = allowed.get(module(&path).as_str()) else {
            continue;
        };
        for (line, name) in imported(&path, &text) {
            let fine = name == module(&path) || allowed.split(' ').any(|other| other == name);
            let place = format!("{}:{line}", path.display());
            assert!(
                !name.is_empty(),
                "{place}: write crate::module, not crate::{{...}}"
            );
            assert!(fine, "{place}: {} may not import {name}", module(&path));
            seen += 1;
        }
    }
    assert!(seen > 20, "only {seen} imports seen: the scan is broken");
}

#[test]
fn the_scan_of_imports_sees_them() {
    let seen = |path: &str, line: &str| -> Vec<String> {
        let found = imported(Path::new(path), line);
        found.into_iter().map(|(_, name)| name).collect()
    };
    assert_eq!(seen("src/sim/a.rs", "use crate::node::run;"), ["node"]);
    assert_eq!(seen("src/sim/a.rs", "use crate::{node, cli};"), [""]);
    assert_eq!(seen("src/sim/a.rs", "use super::super::node::x;"), ["node"]);
    assert_eq!(seen("src/sim/mod.rs", "use super::node::x;"), ["node"]);
    assert_eq!(seen("src/cli/a.rs", "use super::scene;"), [""; 0]);
    assert_eq!(seen("src/sim/a.rs", "// crate::node runs it"), [""; 0]);
}

#[test]
fn files_stay_short() {
    let mut files = sources("src");
    files.extend(sources("tests"));
    for (path, text) in files {
        let lines = text.lines().count();
        assert!(
            lines <= MOST_LINES,
            "{} has {lines} lines, more than {MOST_LINES}",
            path.display()
        );
    }
    let lines = read("src/ARCHITECTURE.md").lines().count();
    assert!(
        lines <= MOST_ARCHITECTURE_LINES,
        "ARCHITECTURE.md has {lines} lines, more than {MOST_ARCHITECTURE_LINES}"
    );
}

/// Files of the repository under a folder; none in an unpacked archive, which has no list of them.
pub fn tracked(folder: &str) -> Vec<String> {
    let list = Command::new("git")
        .args(["ls-files", "-z", folder])
        .current_dir(root())
        .output();
    let list = list.ok().filter(|output| output.status.success());
    let list = String::from_utf8(list.map_or(vec![], |output| output.stdout)).unwrap();
    list.split_terminator('\0').map(str::to_string).collect()
}

/// What a checkout has beside the repository's files (`target`, the recordings of one's own) does not count.
#[test]
fn the_top_level_is_the_one_agreed() {
    let top = |path: String| path.split('/').next().unwrap().to_string();
    let tops: BTreeSet<_> = tracked(".").into_iter().map(top).collect();
    let strangers: Vec<_> = tops
        .iter()
        .filter(|name| !name.starts_with('.') && !TOP_LEVEL.contains(&name.as_str()))
        .collect();
    assert!(strangers.is_empty(), "at the top level: {strangers:?}");
}

#[test]
fn banned_words_stay_out() {
    let modules = sources("src").into_iter();
    for (path, text) in modules.filter(|(path, _)| path != Path::new(BUILD_SCRIPT)) {
        for (number, line) in text.lines().enumerate() {
            for (word, places) in BANNED {
                let here = places.contains(&module(&path).as_str());
                assert!(
                    here || !has_word(code(line), word),
                    "{}:{}: {word} has no place here",
                    path.display(),
                    number + 1
                );
            }
        }
    }
    assert!(has_word("let m: HashMap<u8, u8>", "HashMap"));
    assert!(!has_word("unsafely", "unsafe") && !has_word("eprintln!()", "println!"));
}
