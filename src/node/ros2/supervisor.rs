//! The run's side of its bridge: starts the process, starts it again when it dies, ends it with the run.

use std::io::{self, BufRead, BufReader};
use std::path::PathBuf;
use std::process::{Child, Command, ExitStatus, Stdio};
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};

use serde::Serialize;

use super::traffic::Traffic;
use super::{Ros2Error, ServiceMapping, Settings};
use crate::node::shared_memory::RunName;

/// Wait before the first restart, doubled at each until the longest.
const FIRST_PAUSE: Duration = Duration::from_millis(200);
const LONGEST_PAUSE: Duration = Duration::from_secs(10);
/// A bridge that lived so long was well: the wait begins anew.
const WELL: Duration = Duration::from_secs(30);
/// A bridge that has not told its counts for so long hangs, and is killed.
const SILENCE: Duration = Duration::from_secs(20);
/// How long a bridge may take to end when the run does.
const FAREWELL: Duration = Duration::from_secs(3);

/// What is said of a bridge while it is supervised.
pub type Notice = Box<dyn Fn(&str) + Send>;

/// What came of a bridge.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize)]
pub struct BridgeReport {
    /// Times that it was started again.
    pub restarts: u64,
    /// How it ended the last time that it did so by itself.
    pub last_death: Option<String>,
    /// What it carried, over all its lives; of a killed one up to half a second before.
    pub traffic: Traffic,
}

/// How to start a bridge.
#[derive(Clone, Debug)]
pub struct BridgeCommand {
    /// The toile binary.
    pub program: PathBuf,
    /// The run that it belongs to.
    pub run: RunName,
    /// Where and as whom it speaks.
    pub settings: Settings,
    /// Address space that it may have \[MiB\].
    pub memory_limit: u64,
}

impl BridgeCommand {
    /// Starts it with its standard input and output tied to this process.
    fn spawn(&self) -> Result<Child, Ros2Error> {
        let Settings {
            domain,
            lan,
            node_name,
            namespace,
            services,
        } = &self.settings;
        let mut command = Command::new(&self.program);
        command
            .args(["bridge", "--supervised", "--name", &self.run.to_string()])
            .args(["--node-name", node_name, "--namespace", namespace])
            .args(["--memory-limit", &self.memory_limit.to_string()])
            .args([
                "--service-mapping",
                match services {
                    ServiceMapping::Enhanced => "enhanced",
                    ServiceMapping::Cyclone => "cyclone",
                },
            ])
            .env("ROS_DOMAIN_ID", domain.to_string())
            // A backtrace needs memory: out of it, the process would hang instead of ending.
            .env("RUST_BACKTRACE", "0")
            .stdin(Stdio::piped())
            .stdout(Stdio::piped());
        if *lan {
            command.arg("--allow-lan");
        }
        command.spawn().map_err(|reason| Ros2Error::Start {
            program: self.program.clone(),
            reason,
        })
    }
}

/// A supervised bridge; ends with this.
#[derive(Debug)]
pub struct Supervisor {
    /// Dropped to end it.
    alive: Option<Sender<()>>,
    thread: Option<JoinHandle<BridgeReport>>,
}

impl Supervisor {
    /// Starts the bridge; deaths and restarts go to `notice`.
    pub fn start(command: BridgeCommand, notice: Notice) -> Result<Self, Ros2Error> {
        let first = command.spawn()?;
        let (alive, ended) = channel();
        let watch = Watch {
            command,
            notice,
            ended,
            report: BridgeReport::default(),
            pause: FIRST_PAUSE,
        };
        let thread = thread::Builder::new()
            .name("bridge".to_string())
            .spawn(move || watch.watch(first))
            .map_err(|reason| Ros2Error::Start {
                program: "a thread".into(),
                reason,
            })?;
        Ok(Self {
            alive: Some(alive),
            thread: Some(thread),
        })
    }

    /// Ends the bridge and says what came of it.
    pub fn finish(mut self) -> BridgeReport {
        self.end()
    }

    fn end(&mut self) -> BridgeReport {
        self.alive = None;
        let thread = self.thread.take();
        // A panic there has been reported by its hook.
        thread
            .and_then(|thread| thread.join().ok())
            .unwrap_or_default()
    }
}

impl Drop for Supervisor {
    fn drop(&mut self) {
        self.end();
    }
}

/// Why a life of the bridge is over.
enum End {
    /// The run ended it.
    Wanted,
    /// It died by itself; how.
    Died(String),
}

/// The supervising thread.
struct Watch {
    command: BridgeCommand,
    notice: Notice,
    /// Disconnected when the run is over.
    ended: Receiver<()>,
    report: BridgeReport,
    pause: Duration,
}

impl Watch {
    fn watch(mut self, first: Child) -> BridgeReport {
        let mut child = first;
        loop {
            let born = Instant::now();
            let death = match self.live(child) {
                End::Wanted => return self.report,
                End::Died(how) => how,
            };
            if born.elapsed() > WELL {
                self.pause = FIRST_PAUSE;
            }
            self.report.last_death = Some(death.clone());
            child = loop {
                let again = self.pause.as_secs_f64();
                (self.notice)(&format!(
                    "the ROS 2 bridge died ({death}); the run goes on, the bridge starts again in {again} s"
                ));
                if self.over_within(self.pause) {
                    return self.report;
                }
                self.pause = (2 * self.pause).min(LONGEST_PAUSE);
                match self.command.spawn() {
                    Ok(child) => break child,
                    Err(error) => (self.notice)(&error.to_string()),
                }
            };
            self.report.restarts += 1;
        }
    }

    /// One life of the bridge, from start to end.
    fn live(&mut self, mut child: Child) -> End {
        let lifeline = child.stdin.take();
        let (said, beats) = channel();
        if let Some(output) = child.stdout.take() {
            // It ends with the pipe.
            let reader = thread::Builder::new().name("bridge counts".to_string());
            let _ = reader.spawn(move || listen(BufReader::new(output), &said));
        }
        let mut latest = Traffic::default();
        let mut heard = Instant::now();
        let end = loop {
            if self.over_within(Duration::from_millis(20)) {
                drop(lifeline);
                let _ = ended(&mut child, FAREWELL);
                break End::Wanted;
            }
            while let Ok(traffic) = beats.try_recv() {
                (latest, heard) = (traffic, Instant::now());
            }
            if let Ok(Some(status)) = child.try_wait() {
                break End::Died(describe(status));
            }
            if heard.elapsed() > SILENCE {
                let _ = child.kill();
                let _ = child.wait();
                break End::Died(format!("silent for {} s, killed", SILENCE.as_secs()));
            }
        };
        // What it said last: the reader ends with the pipe, and the pipe with the process.
        while let Ok(traffic) = beats.recv_timeout(FAREWELL) {
            latest = traffic;
        }
        self.report.traffic += latest;
        end
    }

    /// Whether the run is over, now or within this time.
    fn over_within(&self, time: Duration) -> bool {
        self.ended.recv_timeout(time) != Err(RecvTimeoutError::Timeout)
    }
}

/// Passes the counts on that the bridge writes, a line of JSON each.
fn listen(output: impl BufRead, said: &Sender<Traffic>) {
    for line in output.lines().map_while(Result::ok) {
        if let Ok(traffic) = serde_json::from_str(&line)
            && said.send(traffic).is_err()
        {
            return;
        }
    }
}

/// Waits for the end of a process that has been asked to, and then no longer.
fn ended(child: &mut Child, patience: Duration) -> io::Result<ExitStatus> {
    let asked = Instant::now();
    while asked.elapsed() < patience {
        if let Some(status) = child.try_wait()? {
            return Ok(status);
        }
        thread::sleep(Duration::from_millis(10));
    }
    child.kill()?;
    child.wait()
}

fn describe(status: ExitStatus) -> String {
    status.to_string()
}
