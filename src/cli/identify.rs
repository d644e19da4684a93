//! `toile identify`: measured tests in, the constants of the fabric out.

use std::fs;
use std::io::{self, Read};

use clap::Args;
use serde_json::json;

use super::specimen::one_line;
use super::{CliError, output};
use crate::fabric::identify::{Cantilever, Identified, Tests};
use crate::fabric::{Fabric, PoissonCoupling, TwistRigidity};

/// Arguments of `toile identify`.
#[derive(Args)]
pub(super) struct IdentifyArgs {
    /// Measured tests, a TOML file, or `-` for standard input; `--example` prints one.
    #[arg(required_unless_present = "example")]
    tests: Option<String>,
    /// Prints an example of the tests, those of fabric F1.
    #[arg(long)]
    example: bool,
    /// A JSON object instead of the report, SI units throughout.
    #[arg(long)]
    json: bool,
}

const EXAMPLE: &str = include_str!("identify_example.toml");

impl IdentifyArgs {
    pub(super) fn run(&self) -> Result<(), CliError> {
        let Some(name) = self.tests.as_deref().filter(|_| !self.example) else {
            return output::print(EXAMPLE);
        };
        let refuse = |reason: String| CliError::Input(format!("{name}: {reason}"));
        let text = read(name).map_err(|error| refuse(format!("cannot be read: {error}")))?;
        let tests: Tests = toml::from_str(&text).map_err(|error| {
            let line = error
                .span()
                .map_or(1, |span| text[..span.start].lines().count().max(1));
            refuse(format!("line {line}: {}", one_line(&error)))
        })?;
        let found = tests
            .identify()
            .map_err(|error| refuse(error.to_string()))?;
        for finding in &found.findings {
            eprintln!("warning: {finding}");
        }
        match self.json {
            true => output::print_json(&json!(found)),
            false => output::print(&report(&found)),
        }
    }
}

fn read(name: &str) -> io::Result<String> {
    match name {
        "-" => {
            let mut text = String::new();
            io::stdin().lock().read_to_string(&mut text)?;
            Ok(text)
        }
        path => fs::read_to_string(path),
    }
}

/// A TOML document: the report as comments, then the table.
fn report(found: &Identified) -> String {
    let mut rows = vec![];
    let mut row = |cells: [String; 4]| rows.push(cells.to_vec());
    row(["# tension", "measured", "given back", ""].map(String::from));
    let (measured, back) = (&found.measured, &found.given_back);
    for (k, name) in ["E warp", "E weft", "E bias"].into_iter().enumerate() {
        let [put, got] = [measured.young[k], back.young[k]].map(megapascals);
        row([format!("#   {name}"), put, got, String::new()]);
    }
    for (k, name) in ["nu warp", "nu weft"].into_iter().enumerate() {
        let [put, got] = [measured.poisson[k], back.poisson[k]].map(|nu| format!("{nu:.4}"));
        row([format!("#   {name}"), put, got, String::new()]);
    }
    row([
        "# cantilever",
        "overhang",
        "exact elastica",
        "Peirce (19)-(20)",
    ]
    .map(String::from));
    for (test, name) in found.cantilever.iter().zip(["warp", "weft"]) {
        row(bending(test, name));
    }
    row([
        "# shear modulus",
        "(18) as printed",
        "in tensor form",
        "without nu",
    ]
    .map(String::from));
    let shear = &found.shear;
    let [printed, consistent, uncoupled] = [shear.printed, shear.consistent, shear.uncoupled]
        .map(|h| h.map_or("none".to_string(), megapascals));
    row(["#   H".to_string(), printed, consistent, uncoupled]);
    let findings: String = found
        .findings
        .iter()
        .map(|f| format!("# does not fit: {f}\n"))
        .collect();
    output::table(&rows) + &findings + &table(&found.fabric)
}

fn bending(test: &Cantilever, name: &str) -> [String; 4] {
    let shown = |bending: &crate::fabric::identify::Bending| {
        format!(
            "c {:.3} mm, Rf {:.4} µN·m",
            1e3 * bending.length,
            1e6 * bending.rigidity
        )
    };
    [
        format!("#   {name}"),
        format!("{:.3} mm", 1e3 * test.overhang),
        shown(&test.exact),
        shown(&test.peirce),
    ]
}

fn megapascals(modulus: f64) -> String {
    format!("{:.5} MPa", 1e-6 * modulus)
}

/// The table that a scene takes.
fn table(fabric: &Fabric) -> String {
    // Exponents as TOML takes them: a float needs a point or an e, and {:e} always writes one.
    let number = |value: f64| format!("{value:e}");
    let poisson = match fabric.poisson {
        PoissonCoupling::None => "none",
        PoissonCoupling::Symmetrised => "symmetrised",
    };
    let twist = match fabric.twist {
        TwistRigidity::Geometric => "geometric",
        TwistRigidity::None => "none",
    };
    let name = toml::Value::String(fabric.name.clone());
    let constants = [
        ("areal_density", fabric.areal_density, "kg/m²"),
        ("thickness", fabric.thickness, "m"),
        ("young_warp", fabric.young_warp, "Pa"),
        ("young_weft", fabric.young_weft, "Pa"),
        ("shear_modulus", fabric.shear_modulus, "Pa"),
        ("rigidity_warp", fabric.rigidity_warp, "N·m"),
        ("rigidity_weft", fabric.rigidity_weft, "N·m"),
        ("poisson_warp", fabric.poisson_warp, "-"),
        ("poisson_weft", fabric.poisson_weft, "-"),
    ];
    let mut rows = vec![vec!["[fabric]".to_string()], vec![format!("name = {name}")]];
    for (key, value, unit) in constants {
        rows.push(vec![
            format!("{key} = {}", number(value)),
            format!("# {unit}"),
        ]);
    }
    rows.push(vec![format!("poisson = \"{poisson}\"")]);
    rows.push(vec![
        format!("twist = \"{twist}\""),
        "# assumed: these tests do not measure it".into(),
    ]);
    output::table(&rows)
}
