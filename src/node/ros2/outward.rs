//! From the run to DDS: each channel as it lies in shared memory, to a writer of its quality of service.

use std::collections::BTreeSet;
use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::time::Duration;

use super::dds::{Participant, Writer};
use super::discovery::{topic, type_name};
use super::traffic::Counters;
use super::{Ros2Error, Settings};
use crate::node::NodeError;
use crate::node::shared_memory::{Client, RunName, Subscription};
use crate::wire::cdr;
use crate::wire::channels::{self, Channel};
use crate::wire::messages::tf2_msgs::TFMessage;

/// Topics of single obstacles, at most so many in all.
const MOST_LINES: usize = 256;

/// A topic in shared memory and its writer.
struct Line {
    channel: &'static Channel,
    subscription: Subscription,
    writer: Writer,
}

/// All channels of a run.
pub struct Outward {
    client: Client,
    lines: Vec<Line>,
    obstacles: BTreeSet<String>,
    settings: Settings,
    counters: Arc<Counters>,
}

impl Outward {
    /// A line for each channel of the table; those of single obstacles follow when these are seen.
    pub fn new(
        run: RunName,
        participant: &mut Participant,
        settings: &Settings,
        counters: &Arc<Counters>,
    ) -> Result<Self, NodeError> {
        let mut outward = Self {
            client: Client::new(run)?,
            lines: vec![],
            obstacles: BTreeSet::new(),
            settings: settings.clone(),
            counters: Arc::clone(counters),
        };
        for channel in channels::ALL {
            if !channel.is_per_obstacle() {
                outward.open(participant, channel, channel.topic)?;
            }
        }
        Ok(outward)
    }

    fn open(
        &mut self,
        participant: &mut Participant,
        channel: &'static Channel,
        name: &str,
    ) -> Result<(), Ros2Error> {
        let dds = topic(&self.settings.resolve(name));
        let writer = participant.writer(&dds, &type_name(channel.message.name), channel.qos)?;
        self.lines.push(Line {
            channel,
            subscription: self.client.subscribe(name),
            writer,
        });
        Ok(())
    }

    /// Waits at most so long for the run to publish, and passes on all that it has.
    pub fn pass(&mut self, participant: &mut Participant, wait: Duration) -> Result<(), NodeError> {
        self.client.wait(wait);
        let mut frames = None;
        for line in &mut self.lines {
            while let Some(message) = line.subscription.receive()? {
                Counters::add(match line.writer.write(message.bytes()) {
                    true => &self.counters.published,
                    false => &self.counters.unsent,
                });
                if line.channel == &channels::TF {
                    frames = Some(message.bytes().to_vec());
                }
            }
        }
        let missed = self.lines.iter().map(|line| line.subscription.missed());
        self.counters.missed.store(missed.sum(), Ordering::Relaxed);
        match frames {
            Some(bytes) => self.meet(participant, &bytes),
            None => Ok(()),
        }
    }

    /// Opens the topics of obstacles that are new: each has a frame of its name.
    fn meet(&mut self, participant: &mut Participant, frames: &[u8]) -> Result<(), NodeError> {
        let frames: TFMessage = cdr::decode(frames)?;
        let mut opened = false;
        for transform in frames.transforms {
            let name = transform.child_frame_id;
            if self.obstacles.contains(&name) || self.lines.len() >= MOST_LINES {
                continue;
            }
            for channel in channels::ALL.iter().filter(|c| c.is_per_obstacle()) {
                let name = channel.topic.replace(channels::OBSTACLE, &name);
                self.open(participant, channel, &name)?;
                opened = true;
            }
            self.obstacles.insert(name);
        }
        if opened {
            participant.announce()?;
        }
        Ok(())
    }
}
