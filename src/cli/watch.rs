//! `toile watch`: what a running simulation publishes.

use std::io::{self, BufWriter, ErrorKind, Write};
use std::sync::atomic::Ordering;
use std::time::{Duration, Instant};

use clap::Args;
use serde_json::{Value, json};

use super::transport::{Seen, TransportArgs};
use super::{CliError, signals};
use crate::wire::cdr::{CdrError, decode};
use crate::wire::channels::{self, Channel, OBSTACLE};
use crate::wire::messages::{
    geometry_msgs, rosgraph_msgs, sensor_msgs, std_msgs, tf2_msgs, toile_msgs, visualization_msgs,
};
use crate::wire::{Message, seconds as in_seconds};

/// How often it is asked whether to stop.
const LOOK: Duration = Duration::from_millis(50);

/// Arguments of `toile watch`.
#[derive(Args)]
pub(super) struct WatchArgs {
    /// Topic, such as /toile/state or just state (see `toile list messages`).
    #[arg(default_value = "/toile/report")]
    channel: String,
    #[command(flatten)]
    transport: TransportArgs,
    /// End after so many messages.
    #[arg(long, value_name = "N")]
    count: Option<u64>,
    /// Give up when nothing comes for so long [s]; else it waits for a run to start, or to start again.
    #[arg(long, value_name = "S", value_parser = seconds)]
    timeout: Option<f64>,
    /// One JSON object a line.
    #[arg(long)]
    json: bool,
    /// With what is in the messages; as JSON.
    #[arg(long)]
    full: bool,
}

/// A time that can be waited \[s\].
pub(super) fn seconds(text: &str) -> Result<f64, String> {
    let fine = |s: &f64| (0.0..=1e6).contains(s);
    let parsed = text.parse().ok().filter(fine);
    parsed.ok_or_else(|| "must be 0 to 1e6 s".to_string())
}

impl WatchArgs {
    pub(super) fn run(&self) -> Result<(), CliError> {
        let (topic, channel) = find(&self.channel)?;
        let mut source = self.transport.open()?.watch(channel, &topic)?;
        let stop = signals::stop_flag()?;
        let mut out = BufWriter::new(io::stdout().lock());
        let (mut count, mut missed) = (0, 0);
        let mut latest = Instant::now();
        while self.count.is_none_or(|most| count < most) && !stop.load(Ordering::Relaxed) {
            // What is there is read before anything is waited for, and shown before that too.
            let mut seen = source.next(Duration::ZERO)?;
            if seen.is_none() {
                if !shown(out.flush())? {
                    return Ok(());
                }
                seen = source.next(LOOK)?;
            }
            let Some(seen) = seen else {
                if self
                    .timeout
                    .is_some_and(|s| latest.elapsed().as_secs_f64() > s)
                {
                    let waited = self.timeout.unwrap_or_default();
                    return Err(CliError::Refused(format!(
                        "nothing on {topic} for {waited} s"
                    )));
                }
                continue;
            };
            latest = Instant::now();
            count += 1;
            missed += seen.missed;
            if !shown(writeln!(out, "{}", self.line(&topic, channel, &seen)?))? {
                return Ok(());
            }
        }
        shown(out.flush())?;
        eprintln!("{count} messages of {topic}, {missed} missed");
        Ok(())
    }

    fn line(&self, topic: &str, channel: &Channel, seen: &Seen) -> Result<String, CliError> {
        let time = in_seconds(seen.stamp);
        let bytes = seen.bytes.len();
        if !self.json && !self.full {
            let state = seen.state.map_or(String::new(), |(step, digest)| {
                format!("  step {step}  digest {digest:016x}")
            });
            let missed = match seen.missed {
                0 => String::new(),
                missed => format!("  {missed} missed before it"),
            };
            return Ok(format!(
                "{topic}  {time:.6} s{state}  {bytes} bytes{missed}"
            ));
        }
        let mut line = json!({
            "topic": topic,
            "time": time,
            "bytes": bytes,
            "missed": seen.missed,
            "first": seen.first,
        });
        if let Some((step, digest)) = seen.state {
            line["step"] = step.into();
            line["digest"] = format!("{digest:016x}").into();
        }
        if self.full {
            let content = content(channel, &seen.bytes);
            line["message"] = content.map_err(crate::node::NodeError::from)?;
        }
        Ok(line.to_string())
    }
}

/// Whether there is still a reader; one that closed the pipe has all it wants.
fn shown(written: io::Result<()>) -> Result<bool, CliError> {
    match written {
        Ok(()) => Ok(true),
        Err(error) if error.kind() == ErrorKind::BrokenPipe => Ok(false),
        Err(error) => Err(CliError::Output(error)),
    }
}

/// The topic that is meant, and its channel.
fn find(name: &str) -> Result<(String, &'static Channel), CliError> {
    let bare = name.trim_start_matches('/');
    let bare = bare.strip_prefix("toile/").unwrap_or(bare);
    for channel in channels::ALL {
        let topic = channel.topic.trim_start_matches('/');
        let topic = topic.strip_prefix("toile/").unwrap_or(topic);
        let pairs = || topic.split('/').zip(bare.split('/'));
        let as_long = topic.split('/').count() == bare.split('/').count();
        if as_long && pairs().all(|(ours, theirs)| ours == theirs || ours == OBSTACLE) {
            let obstacle = pairs().find(|(ours, _)| *ours == OBSTACLE);
            let obstacle = obstacle.map_or(OBSTACLE, |(_, theirs)| theirs);
            return Ok((channel.topic.replace(OBSTACLE, obstacle), channel));
        }
    }
    let all: Vec<_> = channels::ALL.iter().map(|c| c.topic).collect();
    let all = all.join(", ");
    Err(CliError::Input(format!(
        "channel = {name:?} must be one of {all}"
    )))
}

/// A message as JSON.
fn content(channel: &Channel, bytes: &[u8]) -> Result<Value, CdrError> {
    fn read<M: Message>(bytes: &[u8]) -> Result<Value, CdrError> {
        let message: M = decode(bytes)?;
        Ok(serde_json::to_value(message).unwrap_or_default())
    }
    type Read = fn(&[u8]) -> Result<Value, CdrError>;
    fn row<M: Message>() -> (&'static str, Read) {
        (M::TYPE.name, read::<M>)
    }
    let all = [
        row::<geometry_msgs::WrenchStamped>(),
        row::<rosgraph_msgs::Clock>(),
        row::<sensor_msgs::PointCloud2>(),
        row::<std_msgs::String>(),
        row::<tf2_msgs::TFMessage>(),
        row::<toile_msgs::AppliedCommand>(),
        row::<toile_msgs::ContactEvents>(),
        row::<toile_msgs::Keyframe>(),
        row::<toile_msgs::MeshTopology>(),
        row::<toile_msgs::StepReport>(),
        row::<visualization_msgs::MarkerArray>(),
    ];
    let found = all.iter().find(|(name, _)| *name == channel.message.name);
    found.map_or(Ok(Value::Null), |(_, read)| read(bytes))
}
