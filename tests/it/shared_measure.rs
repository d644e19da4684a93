//! What shared memory costs, printed for whoever asks, on a quiet machine:
//! `cargo test --release --test it -- --ignored --nocapture measure_shared_memory`.

use std::fs;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex};
use std::thread::sleep;
use std::time::{Duration, Instant};

use cpu_time::ThreadTime;
use toile::node::shared_memory::{Client, RunName, SharedMemory};
use toile::node::{Carrier, Inbox, Pace, RunOptions, run};
use toile::wire::Packet;

use super::lab::built_in;
use super::shared_memory::{name, state};

/// Median and 99th percentile \[µs\].
pub fn quantiles(mut times: Vec<Duration>) -> (f64, f64) {
    times.sort();
    let at = |share: f64| times[((times.len() - 1) as f64 * share) as usize].as_secs_f64() * 1e6;
    (at(0.5), at(0.99))
}

/// When each step was received, and how many were missed.
struct Reader {
    over: Arc<AtomicBool>,
    thread: std::thread::JoinHandle<(Vec<(u64, Instant)>, u64)>,
}

impl Reader {
    fn start(run: &RunName) -> Self {
        let client = Client::new(run.clone()).unwrap();
        let over = Arc::new(AtomicBool::new(false));
        let flag = Arc::clone(&over);
        let thread = std::thread::spawn(move || {
            let mut subscription = client.subscribe("/toile/state");
            let mut seen = vec![];
            loop {
                let last = flag.load(Ordering::Relaxed);
                while let Some(message) = subscription.receive().unwrap() {
                    seen.push((message.header().step, Instant::now()));
                }
                if last {
                    return (seen, subscription.missed());
                }
                client.wait(Duration::from_millis(10));
            }
        });
        Self { over, thread }
    }

    fn finish(self) -> (Vec<(u64, Instant)>, u64) {
        sleep(Duration::from_millis(100));
        self.over.store(true, Ordering::Relaxed);
        self.thread.join().unwrap()
    }
}

/// A state of so many vertices.
fn sized(step: u64, vertices: usize) -> Packet {
    let mut packet = state(step);
    packet.bytes.resize(24 * vertices + 300, 1);
    packet
}

/// Publishes so many states at a rate \[Hz\]: latencies, how many were missed, and CPU time of one publication.
fn publish(vertices: usize, rate: f64, count: u64) -> (Vec<Duration>, u64, Duration) {
    let run = name();
    let nobody = Inbox::with_mailbox().0;
    let mut carrier = SharedMemory::open(run.clone(), nobody).unwrap();
    carrier.publish(&sized(0, vertices)).unwrap();
    let reader = Reader::start(&run);
    sleep(Duration::from_millis(200));
    let packets: Vec<_> = (0..4).map(|k| sized(k, vertices)).collect();
    let (begun, mut sent, mut cpu) = (Instant::now(), vec![], Duration::ZERO);
    for step in 1..=count {
        let mut packet = packets[step as usize % packets.len()].clone();
        (packet.step, packet.sequence) = (step, step);
        let due = begun + Duration::from_secs_f64(step as f64 / rate);
        sleep(due.saturating_duration_since(Instant::now()));
        sent.push(Instant::now());
        let thread = ThreadTime::now();
        carrier.publish(&packet).unwrap();
        carrier.commit().unwrap();
        cpu += thread.elapsed();
    }
    let (seen, missed) = reader.finish();
    let late = |(step, at): &(u64, Instant)| Some(*at - *sent.get(step.checked_sub(1)? as usize)?);
    (
        seen.iter().filter_map(late).collect(),
        missed,
        cpu / count as u32,
    )
}

/// From the end of a step to its reception, through encoding, queues and shared memory.
fn from_step() -> (Vec<Duration>, usize) {
    let set = [
        "sheet.triangles=5750",
        "method.dt=0.02",
        "output.rate=50",
        "duration=6",
    ];
    let scene = built_in("free-fall", &set);
    let run_name = name();
    let (mailbox, inbox) = Inbox::with_mailbox();
    let carrier = SharedMemory::open(run_name.clone(), mailbox).unwrap();
    let reader = Reader::start(&run_name);
    let ends = Mutex::new(vec![]);
    let options = RunOptions {
        live: vec![("shared memory".to_string(), Box::new(carrier))],
        inbox,
        pace: Pace::Factor(1.0),
        ..RunOptions::default()
    };
    run(&scene, options, &mut |_| {
        ends.lock().unwrap().push(Instant::now())
    })
    .unwrap();
    let (seen, _) = reader.finish();
    let ends = ends.into_inner().unwrap();
    let late = |(step, at): &(u64, Instant)| Some(*at - *ends.get(step.checked_sub(1)? as usize)?);
    (seen.iter().filter_map(late).collect(), ends.len())
}

#[test]
#[ignore = "a measurement: its numbers depend on the machine and on what else it does"]
fn measure_shared_memory() {
    let load = || fs::read_to_string("/proc/loadavg").unwrap_or_default();
    println!("load before: {}", load().trim());
    let (late, steps) = from_step();
    let (median, high) = quantiles(late);
    println!(
        "step to reader, 3,000 vertices, {steps} steps: median {median:.0} us, 99 % {high:.0} us"
    );
    for vertices in [3000, 12000] {
        let (late, missed, cpu) = publish(vertices, 1000.0, 5000);
        let (median, high) = quantiles(late);
        let cpu = cpu.as_secs_f64();
        println!(
            "{vertices} vertices at 1 kHz: median {median:.0} us, 99 % {high:.0} us, missed {missed}, \
             {:.1} us CPU each = {:.1} % of a core",
            1e6 * cpu,
            1e5 * cpu
        );
        for rate in [2e3, 5e3, 1e4, 2e4, 5e4] {
            let begun = Instant::now();
            let (_, missed, _) = publish(vertices, rate, 10_000);
            let took = begun.elapsed().as_secs_f64() - 0.3;
            println!(
                "  {rate} Hz asked, {:.0} Hz done: missed {missed}",
                1e4 / took
            );
        }
    }
    println!("load after: {}", load().trim());
}
