//! A hundred thousand messages that no well-behaved program sends, against a run in a process of its own.

use std::collections::VecDeque;
use std::process::{Child, Stdio};
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::time::{Duration, Instant};

use iceoryx2::pending_response::PendingResponse;
use iceoryx2::port::client::Client;
use iceoryx2::prelude::*;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;
use serde_json::Value;
use tempfile::TempDir;
use toile::node::shared_memory::{ABI, CallHeader, INLET_BYTES, ReplyHeader, RunName};
use toile::wire::cdr::encode;
use toile::wire::inbound;
use toile::wire::messages::geometry_msgs::Vector3;
use toile::wire::messages::std_msgs::Header;
use toile::wire::messages::toile_msgs::{AirflowCommand, ObstacleCommand};

use super::shared_memory::name;
use super::shared_processes::toile;

type Ipc = ipc_threadsafe::Service;
type Port = Client<Ipc, [u8], CallHeader, [u8], ReplyHeader>;
type Pending = PendingResponse<Ipc, [u8], CallHeader, [u8], ReplyHeader>;

const MESSAGES: u64 = 100_000;
const CALLERS: u64 = 4;
/// Requests that a caller may have open.
const OPEN: usize = 8;
const PATIENCE: Duration = Duration::from_secs(60);

/// One that talks to the run without toile's own client, which would not send such things.
struct Vandal {
    port: Port,
    /// For requests whose answers nobody reads: what is late for one may take the place of another's answer.
    careless: Port,
    draw: Pcg64,
    open: VecDeque<Pending>,
    _node: Node<Ipc>,
}

impl Vandal {
    fn new(run: &RunName, seed: u64) -> Self {
        let builder = NodeBuilder::new().signal_handling_mode(SignalHandlingMode::Disabled);
        let node = builder.create::<Ipc>().unwrap();
        let service = ServiceName::new(&run.inlets()).unwrap();
        let inlets = node
            .service_builder(&service)
            .request_response::<[u8], [u8]>()
            .request_user_header::<CallHeader>()
            .response_user_header::<ReplyHeader>()
            .open()
            .unwrap();
        let port = || {
            inlets
                .client_builder()
                .initial_max_slice_len(256)
                .allocation_strategy(AllocationStrategy::PowerOfTwo)
                .backpressure_strategy(BackpressureStrategy::DiscardData)
                .create()
                .unwrap()
        };
        Self {
            port: port(),
            careless: port(),
            draw: Pcg64::seed_from_u64(seed),
            open: VecDeque::new(),
            _node: node,
        }
    }

    /// Something that means harm, or nothing.
    fn draft(&mut self, k: u64) -> (CallHeader, Vec<u8>) {
        let inlet = inbound::ALL[self.draw.random_range(0..inbound::ALL.len())].name;
        let noise = self.noise(200);
        match k % 8 {
            0 | 1 => (header(inlet), [&[7][..], &noise].concat()),
            2 => (
                CallHeader {
                    abi: ABI + 1 + k,
                    ..header(inlet)
                },
                noise,
            ),
            3 => (header(&format!("/toile/{k}")), noise),
            4 => (
                CallHeader {
                    abi: ABI,
                    inlet: self.draw.random(),
                },
                noise,
            ),
            5 => (header("/toile/cmd/obstacle"), self.obstacle()),
            6 => (header("/toile/cmd/airflow"), self.air()),
            _ if k % 4000 == 7 => (header(inlet), vec![0; (1 << 20) + k as usize]),
            _ => {
                let mut cut = self.obstacle();
                cut.truncate(self.draw.random_range(0..cut.len() / 2));
                (header("/toile/cmd/obstacle"), cut)
            }
        }
    }

    fn noise(&mut self, most: usize) -> Vec<u8> {
        let count = self.draw.random_range(0..most);
        (0..count).map(|_| self.draw.random()).collect()
    }

    /// Not a number, infinite, absurdly large, or of a wrong frame.
    fn obstacle(&mut self) -> Vec<u8> {
        let mut command = ObstacleCommand {
            name: "ball".to_string(),
            friction: [f64::NAN, f64::INFINITY, 1e300][self.draw.random_range(0..3)],
            ..ObstacleCommand::default()
        };
        command.solid.r#type = self.draw.random();
        command.solid.dimensions = vec![f64::MAX; self.draw.random_range(0..40)];
        command.operation = self.draw.random();
        if self.draw.random() {
            command.header.frame_id = "moon".to_string();
        }
        encode(&command).unwrap()
    }

    fn air(&mut self) -> Vec<u8> {
        let x = [f64::NAN, f64::NEG_INFINITY, 1e9][self.draw.random_range(0..3)];
        encode(&AirflowCommand {
            header: Header::default(),
            velocity: Vector3 { x, y: x, z: 0.0 },
            ..AirflowCommand::default()
        })
        .unwrap()
    }

    /// Sends one; false if the run takes no more for now.
    fn send(port: &Port, (header, bytes): &(CallHeader, Vec<u8>)) -> Option<Pending> {
        let mut loan = port.loan_slice_uninit(bytes.len()).ok()?;
        *loan.user_header_mut() = *header;
        let pending = loan.write_from_slice(bytes).send().ok()?;
        (pending.number_of_server_connections() > 0).then_some(pending)
    }

    /// Sends one for certain; every one but the careless gets an answer in time.
    fn insist(&mut self, k: u64) {
        let draft = self.draft(k);
        let begun = Instant::now();
        while self.open.len() >= OPEN {
            self.look_for_answers();
            assert!(begun.elapsed() < PATIENCE, "no answer to {k}");
        }
        let careless = k % 16 == 3;
        let port = if careless { &self.careless } else { &self.port };
        let pending = loop {
            match Self::send(port, &draft) {
                Some(pending) => break pending,
                None => std::thread::sleep(Duration::from_micros(100)),
            }
            assert!(begun.elapsed() < PATIENCE, "never taken");
        };
        if !careless {
            self.open.push_back(pending);
        }
    }

    fn look_for_answers(&mut self) {
        self.open
            .retain(|pending| pending.receive().unwrap().is_none());
        if self.open.len() >= OPEN {
            // The run needs the processor more.
            std::thread::sleep(Duration::from_micros(100));
        }
    }

    fn wait_for_answers(&mut self) {
        let begun = Instant::now();
        while !self.open.is_empty() {
            self.look_for_answers();
            assert!(begun.elapsed() < PATIENCE, "no answer");
        }
    }
}

fn header(inlet: &str) -> CallHeader {
    let mut bytes = [0; INLET_BYTES];
    bytes[..inlet.len()].copy_from_slice(inlet.as_bytes());
    CallHeader {
        abi: ABI,
        inlet: bytes,
    }
}

const SCENE: [&str; 9] = [
    "run",
    "free-fall",
    "--set",
    "sheet.triangles=200",
    "--set",
    "accept=[\"obstacles\", \"air\"]",
    "--duration",
    "2",
    "--json",
];

fn summary(child: Child) -> Value {
    let output = child.wait_with_output().unwrap();
    let errors = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{errors}");
    assert!(!errors.contains("panicked"), "{errors}");
    serde_json::from_slice(&output.stdout).unwrap()
}

#[test]
fn a_hundred_thousand_hostile_messages_change_nothing_and_are_all_counted() {
    let (run, folder) = (name(), TempDir::new().unwrap());
    let quiet = toile(folder.path(), &[&SCENE[..], &["-o", "a.mcap"]].concat());
    let quiet = summary({ quiet }.spawn().unwrap());
    let run_name = run.to_string();
    let shared = [
        "-o", "b.mcap", "--shm", "--name", &run_name, "--pace", "real",
    ];
    let mut command = toile(folder.path(), &[&SCENE[..], &shared].concat());
    command.arg("--wait-for-start").stderr(Stdio::piped());
    let child = command.spawn().unwrap();
    let watch = ["watch", "state", "--count", "1", "--name", &run_name];
    assert!(toile(folder.path(), &watch).status().unwrap().success());

    let vandals = (0..CALLERS).map(|seed| {
        let run = run.clone();
        std::thread::spawn(move || {
            let mut vandal = Vandal::new(&run, seed);
            (0..MESSAGES / CALLERS).for_each(|k| vandal.insist(k));
            vandal.wait_for_answers();
        })
    });
    vandals
        .collect::<Vec<_>>()
        .into_iter()
        .for_each(|v| v.join().unwrap());

    let (over, delivered) = (AtomicBool::new(false), AtomicU64::new(0));
    let disturbed = std::thread::scope(|scope| {
        scope.spawn(|| {
            let mut vandal = Vandal::new(&run, 99);
            for k in (0..).take_while(|_| !over.load(Ordering::Relaxed)) {
                let draft = vandal.draft(k);
                let sent = Vandal::send(&vandal.careless, &draft).is_some();
                delivered.fetch_add(sent.into(), Ordering::Relaxed);
            }
        });
        let resume = ["send", "resume", "--name", &run_name];
        assert!(toile(folder.path(), &resume).status().unwrap().success());
        let disturbed = summary(child);
        over.store(true, Ordering::Relaxed);
        disturbed
    });

    assert_eq!(disturbed["steps"], quiet["steps"]);
    assert_eq!(disturbed["digest"], quiet["digest"], "the same bits");
    let count = |group: &str, name: &str| disturbed[group][name].as_u64().unwrap();
    let orders = ["applied", "rejected", "malformed", "late"].map(|name| count("commands", name));
    let (received, refused) = (
        count("shared_memory", "received"),
        count("shared_memory", "refused"),
    );
    assert_eq!(orders[0], 1, "the one to resume");
    assert_eq!(
        received,
        refused + orders.iter().sum::<u64>(),
        "{disturbed}"
    );
    let most = MESSAGES + 1 + delivered.load(Ordering::Relaxed);
    assert!(
        (MESSAGES + 1..=most).contains(&received),
        "{received} of {most}"
    );
    // Three in eight do not get as far as the run, and a few that are huge.
    assert!(refused >= MESSAGES * 3 / 8, "{refused} refused");
    assert!(orders[2] >= MESSAGES / 2, "{} malformed", orders[2]);
}
