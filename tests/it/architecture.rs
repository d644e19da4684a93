//! ARCHITECTURE.md and README.md against the code: what they list is what there is.

use std::collections::{BTreeMap, BTreeSet};

use toile::instrument::Instrument;
use toile::scene::{OutputSpec, Scheme, Term};
use toile::wire::channels::{self, Rate};

use crate::tidy::{IMPORTS, code, folders, identifier, read, root, sources, tracked};

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
    let needed = variants("src/scene/needs.rs", "Term");
    assert_eq!(needed, terms, "terms in scene/needs.rs");
    let all: BTreeSet<_> = Term::ALL.iter().map(Term::to_string).collect();
    assert_eq!(all, terms, "in Term::ALL");
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
    let all: BTreeSet<_> = Scheme::ALL
        .iter()
        .map(|scheme| scheme.name().to_string())
        .collect();
    assert_eq!(all, schemes, "in Scheme::ALL");
}

#[test]
fn every_instrument_is_named() {
    let instruments = variants("src/instrument/mod.rs", "Instrument");
    assert_eq!(names(&rows("Instruments")), instruments);
    let all: BTreeSet<_> = Instrument::ALL
        .iter()
        .map(|instrument| instrument.name().to_string())
        .collect();
    assert_eq!(all, instruments, "in Instrument::ALL");
    for name in &instruments {
        let path = format!("src/instrument/{name}.rs");
        assert!(root().join(&path).is_file(), "{path} is missing");
    }
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
                || root().join(format!("tests/it/{name}.rs")).is_file()
                || root().join(format!("tests/it/{name}/mod.rs")).is_file();
            assert!(known, "ARCHITECTURE.md: there is no test {guard}");
        }
    }
}

#[test]
fn the_readme_describes_every_channel() {
    let readme = read("README.md");
    for channel in channels::ALL {
        let rate = match channel.rate {
            Rate::Once => "once",
            Rate::Output => "`output.rate`",
            Rate::Mesh => "`output.mesh_rate`",
            Rate::Event => "on event",
            Rate::Second => "every simulated second",
            Rate::Keyframe => "`output.keyframe_interval`",
        };
        let row = format!(
            "| `{}` | `{}` | {rate} |",
            channel.topic, channel.message.name
        );
        assert!(readme.contains(&row), "README.md has no row {row}");
    }
    let OutputSpec {
        rate,
        mesh_rate,
        keyframe_interval,
    } = OutputSpec::default();
    let said = format!(
        "`output.rate` is {rate} Hz of simulated time, `output.mesh_rate` {mesh_rate} Hz and \
         `output.keyframe_interval` {keyframe_interval} s"
    );
    assert!(readme.contains(&said), "README.md does not say: {said}");
}

#[test]
fn every_kept_recording_says_where_it_comes_from() {
    let said = read("recordings/README.md");
    let kept = tracked("recordings");
    let names = kept
        .iter()
        .map(|path| path.trim_start_matches("recordings/"));
    // The golden ones have a README of their own.
    for name in names.filter(|name| *name != "README.md" && !name.starts_with("golden/")) {
        let stem = name.trim_end_matches(".png");
        assert!(
            said.contains(&format!("`{name}`")) || said.contains(&format!("`{stem}.svg`, `.png`")),
            "recordings/README.md does not name {name}"
        );
    }
}
