//! Shared memory between real processes, and between threads where that is the same: real iceoryx2 either way.

use std::sync::atomic::{AtomicU32, Ordering};
use std::time::{Duration, Instant};

use toile::node::Carrier;
use toile::node::shared_memory::{
    ABI, Call, Client, Header, Received, Refusal, RunName, SharedMemory, SharedMemoryError,
    Subscription, schema,
};
use toile::wire::Packet;
use toile::wire::channels::{self, Channel};

/// A run's name that nobody else uses.
pub fn name() -> RunName {
    static COUNT: AtomicU32 = AtomicU32::new(0);
    let count = COUNT.fetch_add(1, Ordering::Relaxed);
    let name = format!("test-{}-{count}", std::process::id());
    name.parse().unwrap()
}

/// Answers with the end of what was asked, backwards.
fn mirror(call: Call) -> Result<(), Refusal> {
    if call.inlet != "/mirror" {
        return Err(Refusal::UnknownInlet);
    }
    call.reply.send(mirrored(&call.bytes)).unwrap();
    Ok(())
}

fn mirrored(bytes: &[u8]) -> Vec<u8> {
    bytes.iter().rev().take(8000).copied().collect()
}

fn packet(channel: &'static Channel, step: u64, bytes: usize) -> Packet {
    Packet {
        channel,
        obstacle: None,
        sequence: step,
        stamp: step * 1_000_000,
        step,
        digest: !step,
        bytes: (0..bytes).map(|k| (k as u64 + step) as u8).collect(),
    }
}

/// A state of 3,000 vertices, as far as its length goes.
pub fn state(step: u64) -> Packet {
    packet(&channels::STATE, step, 72_000)
}

fn publish(carrier: &mut SharedMemory, packet: &Packet) {
    carrier.publish(packet).unwrap();
    carrier.commit().unwrap();
}

/// The next message, waited for.
#[track_caller]
fn next(subscription: &mut Subscription) -> Received {
    let until = Instant::now() + Duration::from_secs(20);
    loop {
        if let Some(message) = subscription.receive().unwrap() {
            return message;
        }
        assert!(
            Instant::now() < until,
            "nothing on {}",
            subscription.topic()
        );
        std::thread::sleep(Duration::from_micros(200));
    }
}

const PATIENCE: Duration = Duration::from_secs(20);

#[test]
fn a_late_joiner_gets_the_latest_of_each_channel_even_while_nothing_is_published() {
    let name = name();
    let mut run = SharedMemory::open(name.clone(), mirror).unwrap();
    let client = Client::new(name).unwrap();
    let mut early = client.subscribe("/toile/state");
    assert!(early.receive().unwrap().is_none(), "nobody has published");
    for channel in [&channels::TOPOLOGY, &channels::ROBOT_DESCRIPTION] {
        publish(&mut run, &packet(channel, 0, 1000));
    }
    for step in 0..5 {
        publish(&mut run, &packet(&channels::STATE, step, 72_000));
    }
    for (topic, step, bytes) in [
        ("/toile/topology", 0, 1000),
        ("/robot_description", 0, 1000),
        ("/toile/state", 4, 72_000),
    ] {
        let mut late = client.subscribe(topic);
        let message = next(&mut late);
        assert_eq!(message.header().step, step, "{topic}");
        assert_eq!(message.bytes(), packet(&channels::STATE, step, bytes).bytes);
        assert!(message.first && message.missed == 0);
        assert!(late.receive().unwrap().is_none(), "only the latest");
    }
    let hash = channels::STATE.message.hash;
    let header = Header {
        abi: ABI,
        sequence: 4,
        stamp: 4_000_000,
        step: 4,
        digest: !4,
        schema: schema(hash),
    };
    assert_eq!(
        *next(&mut client.subscribe("/toile/state")).header(),
        header
    );
    let digits: String = schema(hash).iter().map(|b| format!("{b:02x}")).collect();
    assert_eq!(hash, format!("RIHS01_{digits}"));
}

#[test]
fn a_slow_reader_learns_what_it_missed_and_holds_nobody_up() {
    let name = name();
    let mut run = SharedMemory::open(name.clone(), mirror).unwrap();
    let client = Client::new(name).unwrap();
    let mut slow = client.subscribe("/toile/state");
    publish(&mut run, &packet(&channels::STATE, 0, 72_000));
    assert_eq!(next(&mut slow).header().sequence, 0);
    for step in 1..=1000 {
        publish(&mut run, &packet(&channels::STATE, step, 72_000));
    }
    let first = next(&mut slow);
    assert_eq!(first.missed, first.header().sequence - 1);
    assert!(
        first.missed > 700 && !first.first,
        "missed {}",
        first.missed
    );
    let (missed, mut last) = (first.missed, first.header().sequence);
    drop(first);
    while let Some(message) = slow.receive().unwrap() {
        assert_eq!((message.missed, message.header().sequence), (0, last + 1));
        last += 1;
    }
    assert_eq!(last, 1000, "what is left is the newest");
    assert_eq!(slow.missed(), missed);
    let counts = run.counts();
    assert_eq!(counts.published.load(Ordering::Relaxed), 1001);
    assert_eq!(counts.dropped.load(Ordering::Relaxed), 0);
}

#[test]
fn messages_may_grow() {
    let name = name();
    let mut run = SharedMemory::open(name.clone(), mirror).unwrap();
    let client = Client::new(name).unwrap();
    let mut reader = client.subscribe("/toile/report");
    for (step, bytes) in [1, 0, 100, 5000, 3, 400_000].into_iter().enumerate() {
        let sent = packet(&channels::REPORT, step as u64, bytes);
        publish(&mut run, &sent);
        assert_eq!(next(&mut reader).bytes(), sent.bytes, "{bytes} bytes");
    }
}

#[test]
fn a_name_belongs_to_one_run_at_a_time() {
    let name = name();
    let run = SharedMemory::open(name.clone(), mirror).unwrap();
    let second = SharedMemory::open(name.clone(), mirror);
    let message = second.unwrap_err().to_string();
    let expected = format!(
        "a run named \"{name}\" is in shared memory already; give this one another name with --name"
    );
    assert_eq!(message, expected);
    drop(run);
    SharedMemory::open(name, mirror).unwrap();
    for bad in ["", "a/b", "ä", &"x".repeat(65)] {
        let message = bad.parse::<RunName>().unwrap_err().to_string();
        assert!(message.starts_with("run name"), "{message}");
    }
}

#[test]
fn calls_are_answered_or_refused_with_the_reason() {
    let name = name();
    let mut client = Client::new(name.clone()).unwrap();
    let nobody = client.call("/mirror", b"x", PATIENCE);
    assert!(matches!(nobody, Err(SharedMemoryError::NoRun { .. })));
    let run = SharedMemory::open(name.clone(), mirror).unwrap();
    for length in [0, 1, 1000, 100_000, 1 << 20] {
        let asked: Vec<u8> = (0..length).map(|k| k as u8).collect();
        let answer = client.call("/mirror", &asked, PATIENCE).unwrap();
        assert!(answer == mirrored(&asked), "{length} bytes");
    }
    let refused = client.call("/nowhere", b"x", PATIENCE).unwrap_err();
    assert_eq!(refused.to_string(), "/nowhere: there is no such inlet");
    let huge = client.call("/mirror", &vec![0; (1 << 20) + 1], PATIENCE);
    let huge = huge.unwrap_err().to_string();
    assert_eq!(huge, "/mirror: the request has more than 1048576 bytes");
    drop(run);
    let gone = client.call("/mirror", b"x", PATIENCE);
    assert!(
        matches!(gone, Err(SharedMemoryError::NoRun { .. })),
        "{gone:?}"
    );
    let _back = SharedMemory::open(name, mirror).unwrap();
    assert_eq!(client.call("/mirror", b"xy", PATIENCE).unwrap(), b"yx");
}

#[test]
fn a_call_that_is_not_answered_ends_when_the_run_does() {
    let name = name();
    let mut kept = vec![];
    let hoard = move |call: Call| {
        kept.push(call);
        Ok(())
    };
    let mut run = SharedMemory::open(name.clone(), hoard).unwrap();
    let mut client = Client::new(name).unwrap();
    let late = client.call("/mirror", b"x", Duration::from_millis(50));
    assert!(matches!(late, Err(SharedMemoryError::TimedOut { .. })));
    let waiting = std::thread::spawn(move || client.call("/mirror", b"x", PATIENCE));
    std::thread::sleep(Duration::from_millis(100));
    run.close().unwrap();
    let ended = waiting.join().unwrap();
    let refusal = Refusal::NoAnswer;
    assert!(
        matches!(&ended, Err(SharedMemoryError::Refused { refusal: r, .. }) if *r == refusal),
        "{ended:?}"
    );
}

#[test]
fn a_reader_that_waits_is_woken() {
    let name = name();
    let mut run = SharedMemory::open(name.clone(), mirror).unwrap();
    let client = Client::new(name).unwrap();
    assert!(!client.wait(Duration::from_millis(20)), "nothing yet");
    let reader = std::thread::spawn(move || client.wait(PATIENCE));
    publish(&mut run, &packet(&channels::CLOCK, 0, 12));
    assert!(reader.join().unwrap());
}

#[test]
fn a_reader_follows_a_run_that_is_started_anew() {
    let name = name();
    let client = Client::new(name.clone()).unwrap();
    let mut reader = client.subscribe("/toile/state");
    for start in 0..3 {
        let mut run = SharedMemory::open(name.clone(), mirror).unwrap();
        for step in 0..3 {
            // The sheet may have another size.
            publish(
                &mut run,
                &packet(&channels::STATE, step, 1000 + 70_000 * start),
            );
            let message = next(&mut reader);
            assert_eq!(message.header().step, step);
            assert_eq!((message.first, message.missed), (step == 0, 0));
        }
    }
}
