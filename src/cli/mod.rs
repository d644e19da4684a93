//! The command line: parse, check into a job, run it, exit code.
//!
//! One file a verb, each with clap arguments and a `run`. Exit codes: 0 done, 1 the run failed or differed,
//! 2 bad usage or input. Results go to standard output, everything else to standard error; an error is one line.

mod ablate;
mod audit;
#[cfg(feature = "ros2")]
mod bridge;
mod chart;
mod chart_stability;
mod chart_waterfall;
mod commands;
mod drapes;
mod error;
mod explain;
mod explained;
mod identify;
mod info;
mod kept;
mod list;
mod measure;
mod output;
mod plan;
mod progress;
mod recover;
mod replay;
#[cfg(feature = "ros2")]
mod ros2;
mod run;
mod scene;
#[cfg(feature = "iceoryx2")]
mod send;
#[cfg(feature = "iceoryx2")]
mod shared;
mod show;
mod signals;
mod source;
mod specimen;
mod summary;
#[cfg(feature = "iceoryx2")]
mod transport;
mod verify;
#[cfg(feature = "iceoryx2")]
mod watch;

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
    /// Run a recording's commands again: the same bits, or where it differs.
    Replay(replay::ReplayArgs),
    /// Say what a recording holds.
    Info(info::InfoArgs),
    /// Check a recording: checksums, index, every message.
    Verify(verify::VerifyArgs),
    /// Complete a recording that was cut short.
    Recover(recover::RecoverArgs),
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
    /// Send a command to a running simulation.
    #[cfg(feature = "iceoryx2")]
    Send(send::SendArgs),
    /// Print what a running simulation publishes.
    #[cfg(feature = "iceoryx2")]
    Watch(watch::WatchArgs),
    /// Carry a run between shared memory and ROS 2; `run --ros2` starts one.
    #[cfg(feature = "ros2")]
    Bridge(bridge::BridgeArgs),
    /// Say what physics a scene pays for, what it costs, and what it leaves out, measured.
    Explain(explain::ExplainArgs),
    /// Find the cheapest method, step and mesh within a tolerance.
    Plan(plan::PlanArgs),
    /// Run and draw a chart: error against CPU time, stability.
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
        Verb::Replay(args) => args.run(),
        Verb::Info(args) => args.run(),
        Verb::Verify(args) => args.run(),
        Verb::Recover(args) => args.run(),
        Verb::List(args) => args.run(),
        Verb::Scene(args) => args.run(),
        Verb::Show(args) => args.run(),
        Verb::Measure(args) => args.run(),
        Verb::Identify(args) => args.run(),
        #[cfg(feature = "iceoryx2")]
        Verb::Send(args) => args.run(),
        #[cfg(feature = "iceoryx2")]
        Verb::Watch(args) => args.run(),
        #[cfg(feature = "ros2")]
        Verb::Bridge(args) => args.run(),
        Verb::Explain(args) => args.run(),
        Verb::Plan(args) => args.run(),
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
