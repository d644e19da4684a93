//! The house rules, read off the source tree: what the compiler does not check.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};

/// DESIGN section 5, each module with what it may import of the crate.
const IMPORTS: [(&str, &str); 12] = [
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

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

fn read(path: impl AsRef<Path>) -> String {
    let path = root().join(path);
    fs::read_to_string(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}

/// All Rust files under a folder of the repository, with their text.
fn sources(folder: &str) -> Vec<(PathBuf, String)> {
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

fn folders(folder: &str) -> BTreeSet<String> {
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
fn code(line: &str) -> &str {
    line.split("//").next().unwrap_or(line)
}

/// The identifier that a text begins with.
fn identifier(text: &str) -> &str {
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

/// Rows of the table under a heading of ARCHITECTURE.md: the cells of each, first the name without backticks.
fn rows(heading: &str) -> BTreeMap<String, Vec<String>> {
    let text = read("src/ARCHITECTURE.md");
    let start = format!("## {heading}\n");
    let section = text.split(&start).nth(1).unwrap_or_else(|| {
        panic!("ARCHITECTURE.md has no heading `{heading}`");
    });
    let section = section.split("\n## ").next().unwrap();
    section
        .lines()
        .filter(|line| line.starts_with("| `"))
        .map(|line| {
            let cells: Vec<_> = line
                .trim_matches('|')
                .split(" | ")
                .map(|cell| cell.trim().to_string())
                .collect();
            (cells[0].trim_matches('`').to_string(), cells)
        })
        .collect()
}

fn names(rows: &BTreeMap<String, Vec<String>>) -> BTreeSet<String> {
    rows.keys().cloned().collect()
}

#[test]
fn modules_are_those_of_the_table() {
    let known: BTreeSet<_> = IMPORTS.iter().map(|(name, _)| name.to_string()).collect();
    assert_eq!(folders("src"), known, "folders of src");
    let table = rows("Modules");
    assert_eq!(names(&table), known, "modules in ARCHITECTURE.md");
    for (name, allowed) in IMPORTS {
        let said = table[name][1].replace(", ", " ");
        assert_eq!(said.trim_matches('-'), allowed, "imports of {name}");
    }
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

#[test]
fn every_term_is_complete_and_named() {
    let terms = folders("src/physics");
    for term in &terms {
        for file in ["mod.rs", "doc.md", "test.rs"] {
            let path = format!("src/physics/{term}/{file}");
            assert!(root().join(&path).is_file(), "{path} is missing");
        }
        let text = read(format!("src/physics/{term}/mod.rs"));
        assert!(
            text.contains("include_str!(\"doc.md\")"),
            "src/physics/{term}/mod.rs does not show its doc.md"
        );
    }
    assert_eq!(names(&rows("Terms")), terms, "terms in ARCHITECTURE.md");
}

/// Variants of an enum without fields, in kebab case, read off its source.
fn variants(path: &str, name: &str) -> BTreeSet<String> {
    let text = read(path);
    let body = text.split(&format!("pub enum {name} {{\n")).nth(1).unwrap();
    let body = body.split("\n}").next().unwrap();
    let names = body.lines().map(|line| identifier(code(line).trim()));
    names.filter(|name| !name.is_empty()).map(kebab).collect()
}

fn kebab(name: &str) -> String {
    let mut kebab = String::new();
    for c in name.chars() {
        if c.is_uppercase() && !kebab.is_empty() {
            kebab.push('-');
        }
        kebab.extend(c.to_lowercase());
    }
    kebab
}

#[test]
fn every_scheme_is_named() {
    let schemes = variants("src/scene/method.rs", "Scheme");
    assert!(schemes.contains("generalised-alpha"), "{schemes:?}");
    assert_eq!(names(&rows("Schemes")), schemes, "in ARCHITECTURE.md");
    let all = toile::scene::Scheme::ALL;
    let all: BTreeSet<_> = all.iter().map(|scheme| scheme.name().to_string()).collect();
    assert_eq!(all, schemes, "in Scheme::ALL");
}

#[test]
fn every_instrument_is_named() {
    let files = fs::read_dir(root().join("src/instrument")).unwrap();
    let instruments: BTreeSet<_> = files
        .map(|entry| entry.unwrap().path())
        .map(|path| path.file_stem().unwrap().to_str().unwrap().to_string())
        .filter(|name| name != "mod")
        .collect();
    assert_eq!(names(&rows("Instruments")), instruments);
}

#[test]
fn every_dependency_has_a_reason() {
    let manifest: toml::Table = read("Cargo.toml").parse().unwrap();
    let tables = ["dependencies", "dev-dependencies", "build-dependencies"];
    let crates: BTreeSet<_> = tables
        .iter()
        .filter_map(|name| manifest.get(*name)?.as_table())
        .flat_map(|table| table.keys().cloned())
        .collect();
    let table = rows("Dependencies");
    assert_eq!(names(&table), crates, "dependencies in ARCHITECTURE.md");
    for (name, cells) in table {
        let reason = cells.get(1).map_or(0, String::len);
        assert!(reason > 8, "{name} has no reason");
    }
}

#[test]
fn banned_words_stay_out() {
    for (path, text) in sources("src") {
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

/// A name given in the table of invariants is a test or a module of tests that there is.
#[test]
fn every_guard_of_an_invariant_exists() {
    let tests: String = sources("tests").into_iter().map(|(_, text)| text).collect();
    let text = read("src/ARCHITECTURE.md");
    let section = text.split("## Invariants\n").nth(1).unwrap();
    let section = section.split("\n## ").next().unwrap();
    let guards = section.lines().filter(|line| line.starts_with('|')).skip(2);
    for guards in guards.map(|line| line.trim_end_matches(" |").rsplit(" | ").next().unwrap()) {
        for guard in guards.split('`').skip(1).step_by(2) {
            let name = guard.rsplit("::").next().unwrap();
            let known = ["[lints]", "step"].contains(&name)
                || tests.contains(&format!("fn {name}("))
                || root().join(format!("tests/it/{name}.rs")).is_file();
            assert!(known, "ARCHITECTURE.md: there is no test {guard}");
        }
    }
}

#[test]
fn the_readme_names_every_topic() {
    let readme = read("README.md");
    for channel in toile::wire::channels::ALL {
        let topic = format!("`{}`", channel.topic);
        assert!(readme.contains(&topic), "README.md does not name {topic}");
    }
}
