//! What a recording holds, topic by topic.

use std::fs::File;
use std::path::Path;

use mcap::records::{Record, op};
use serde::Serialize;

use super::NodeError;
use super::recording::file_of;
use super::records::{spans, unpack};
use crate::wire::channels::{self, Channel, OBSTACLE};
use crate::wire::seconds;

/// A topic of a recording.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Topic {
    /// Its name.
    pub topic: String,
    /// ROS 2 type of its messages.
    pub r#type: String,
    /// Messages.
    pub count: u64,
    /// Bytes of all messages, uncompressed.
    pub bytes: u64,
    /// Simulated time of the first message \[s\]; zero without one.
    pub first: f64,
    /// Simulated time of the last message \[s\]; zero without one.
    pub last: f64,
}

/// What a recording holds.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Inventory {
    /// Size of the file \[bytes\].
    pub bytes: u64,
    /// Whether the file ends with its index, as a recording does that was closed.
    pub complete: bool,
    /// Bytes after the last complete record, which a recovery gives up; zero in a complete file.
    pub ragged: u64,
    /// Chunks.
    pub chunks: u64,
    /// In the order in which they were announced, those without messages too.
    pub topics: Vec<Topic>,
}

impl Inventory {
    /// Reads a whole recording, an MCAP file or a bag directory.
    pub fn of(path: &Path) -> Result<Self, NodeError> {
        let path = &file_of(path);
        let mut file = File::open(path).map_err(NodeError::file("open", path))?;
        let bytes = file
            .metadata()
            .map_err(NodeError::file("read", path))?
            .len();
        let spans = spans(&mut file, path)?;
        let end = spans.last().map_or(mcap::MAGIC.len() as u64, |s| s.end);
        let complete = super::records::ends_with_magic(&mut file, path)?;
        let mut inventory = Self {
            bytes,
            complete,
            ragged: if complete { 0 } else { bytes - end },
            ..Self::default()
        };
        let (mut schemas, mut ids) = (vec![], vec![]);
        for span in spans.into_iter().filter(|s| s.op == op::CHUNK) {
            inventory.chunks += 1;
            for record in unpack(&mut file, path, span)? {
                match record {
                    Record::Schema { header, .. } => schemas.push((header.id, header.name)),
                    Record::Channel(channel) => {
                        let named = |(id, _): &&(u16, String)| *id == channel.schema_id;
                        let kind = schemas.iter().find(named).map(|(_, name)| name.clone());
                        inventory.announce(&mut ids, channel.id, channel.topic, kind);
                    }
                    Record::Message { header, data } => {
                        let found = ids.iter().position(|id| *id == header.channel_id);
                        if let Some(topic) = found.and_then(|at| inventory.topics.get_mut(at)) {
                            topic.add(header.log_time, data.len());
                        }
                    }
                    _ => {}
                }
            }
        }
        Ok(inventory)
    }

    fn announce(&mut self, ids: &mut Vec<u16>, id: u16, topic: String, kind: Option<String>) {
        if ids.contains(&id) {
            return;
        }
        ids.push(id);
        self.topics.push(Topic {
            topic,
            r#type: kind.unwrap_or_default(),
            count: 0,
            bytes: 0,
            first: 0.0,
            last: 0.0,
        });
    }

    /// All messages.
    pub fn messages(&self) -> u64 {
        self.topics.iter().map(|topic| topic.count).sum()
    }
}

impl Topic {
    fn add(&mut self, stamp: u64, bytes: usize) {
        let time = seconds(stamp);
        if self.count == 0 {
            self.first = time;
        }
        self.count += 1;
        self.bytes += bytes as u64;
        self.last = time;
    }
}

/// The channel that a topic belongs to.
pub(super) fn channel_of(topic: &str) -> Option<&'static Channel> {
    let fits = |channel: &&&'static Channel| {
        let mut parts = channel.topic.split('/');
        let same = topic
            .split('/')
            .all(|part| parts.next().is_some_and(|p| p == part || p == OBSTACLE));
        same && parts.next().is_none()
    };
    channels::ALL.iter().find(fits).copied()
}
