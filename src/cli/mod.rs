//! The command line: parse, check into a job, run it, exit code.
//!
//! One file a verb, each with clap arguments and a `run`. Exit codes: 0 done, 1 the run failed or differed,
//! 2 bad usage or input. Results go to standard output, everything else to standard error; an error is one line.

mod chart;
mod error;
mod identify;
mod list;
mod measure;
mod output;
mod progress;
mod run;
mod scene;
mod show;
mod source;
mod specimen;
mod summary;

use std::process::ExitCode;

use clap::error::ErrorKind;
use clap::{Parser, Subcommand};

pub use error::CliError;

/// A fabric simulator that a robot or a test rig logs like a ROS node, and a textile lab trusts.
#[derive(Parser)]
#[command(name = "toile", version, arg_required_else_help = true)]
struct Cli {
    #[command(subcommand)]
    verb: Verb,
}

#[derive(Subcommand)]
enum Verb {
    /// Simulate a scene and record it.
    Run(run::RunArgs),
    /// List what is built in.
    List(list::ListArgs),
    /// Print the TOML of a built-in scene, to start one's own from.
    Scene(scene::SceneArgs),
    /// Draw a recording as PNG; write the layouts of viewers.
    Show(show::ShowArgs),
    /// Measure a fabric in a laboratory instrument.
    Measure(measure::MeasureArgs),
    /// Turn measured tests into the constants of a fabric.
    Identify(identify::IdentifyArgs),
    /// Run and draw a chart: error against CPU time.
    Chart(chart::ChartArgs),
}

/// Entry point of the binary.
pub fn main() -> ExitCode {
    let cli = match Cli::try_parse() {
        Ok(cli) => cli,
        Err(error) => return usage(&error),
    };
    let done = match cli.verb {
        Verb::Run(args) => args.run(),
        Verb::List(args) => args.run(),
        Verb::Scene(args) => args.run(),
        Verb::Show(args) => args.run(),
        Verb::Measure(args) => args.run(),
        Verb::Identify(args) => args.run(),
        Verb::Chart(args) => args.run(),
    };
    match done {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error}");
            error.exit_code()
        }
    }
}

/// Help and version as clap prints them; a usage error as one line.
fn usage(error: &clap::Error) -> ExitCode {
    let asked_for = matches!(
        error.kind(),
        ErrorKind::DisplayHelp | ErrorKind::DisplayVersion
    );
    if asked_for || error.kind() == ErrorKind::DisplayHelpOnMissingArgumentOrSubcommand {
        // A reader that went away has had enough of the help.
        let _ = error.print();
        return if asked_for {
            ExitCode::SUCCESS
        } else {
            ExitCode::from(2)
        };
    }
    let text = error.to_string();
    let reason = text.split("\n\nUsage:").next().unwrap_or(&text);
    let reason = reason.split("\n\nFor more").next().unwrap_or(reason);
    let words: Vec<_> = reason.split_whitespace().collect();
    eprintln!("{} (see toile --help)", words.join(" "));
    ExitCode::from(2)
}
