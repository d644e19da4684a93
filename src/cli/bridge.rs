//! `toile bridge`: a run's channels and commands on ROS 2, in a process of its own.

use std::io::{Read, stdin};
use std::panic;
use std::process::{self, exit};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;
use std::time::Duration;

use clap::Args;
use signal_hook::consts::{SIGINT, SIGTERM};
use signal_hook::flag;

use super::ros2::{Ros2Args, carried};
use super::{CliError, output};
use crate::node::NodeError;
use crate::node::ros2::{self, Traffic};
use crate::node::shared_memory::RunName;

/// How long a bridge that has lost its run may take to end.
const FAREWELL: Duration = Duration::from_secs(2);

/// Arguments of `toile bridge`.
#[derive(Args)]
pub(super) struct BridgeArgs {
    /// Name of the run in shared memory.
    #[arg(long, value_name = "RUN", default_value_t)]
    name: RunName,
    #[command(flatten)]
    ros2: Ros2Args,
    /// Started by a run: tells it the counts, and ends with it.
    #[arg(long, hide = true)]
    supervised: bool,
}

impl BridgeArgs {
    pub(super) fn run(&self) -> Result<(), CliError> {
        let settings = self.ros2.settings()?;
        end_at_panic();
        ros2::limit_memory(self.ros2.memory_limit()).map_err(NodeError::from)?;
        let stop = Arc::new(AtomicBool::new(false));
        if self.supervised {
            end_with_parent(Arc::clone(&stop));
        }
        for signal in [SIGINT, SIGTERM] {
            // The terminal's Ctrl-C reaches the run too, which then ends this process when all is sent.
            let flag = match (signal, self.supervised) {
                (SIGINT, true) => Arc::default(),
                _ => Arc::clone(&stop),
            };
            flag::register(signal, flag)
                .map_err(|error| CliError::Input(format!("cannot handle signals: {error}")))?;
        }
        let mut beat = |traffic: &Traffic| {
            if self.supervised
                && let Ok(line) = serde_json::to_string(traffic)
            {
                // Without a reader there is no run either.
                let _ = output::print(&format!("{line}\n"));
            }
        };
        let traffic = ros2::bridge(&self.name, &settings, &stop, &mut beat)?;
        match self.supervised {
            true => Ok(()),
            false => output::print(&format!("{}\n", carried(&traffic))),
        }
    }
}

/// A thread of the DDS library that panics would leave a bridge that stands and carries nothing.
fn end_at_panic() {
    let report = panic::take_hook();
    panic::set_hook(Box::new(move |info| {
        report(info);
        process::abort();
    }));
}

/// Sets the flag when standard input ends, which it does with the process that holds its other end.
fn end_with_parent(stop: Arc<AtomicBool>) {
    thread::spawn(move || {
        let mut rest = [0; 64];
        while matches!(stdin().read(&mut rest), Ok(1..)) {}
        stop.store(true, Ordering::Relaxed);
        thread::sleep(FAREWELL);
        exit(0);
    });
}
