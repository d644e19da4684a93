//! The messages of a recording, in the order in which they were published.

use std::collections::{BTreeMap, VecDeque};
use std::fs::File;
use std::path::{Path, PathBuf};

use mcap::records::{Record, op};

use super::NodeError;
use super::records::{Span, unpack};

/// A message as it was recorded.
#[derive(Clone, Debug)]
pub(super) struct Message {
    pub topic: String,
    /// Simulated time \[ns\].
    pub stamp: u64,
    /// Time of publication \[ns\], which should be the same.
    pub published: u64,
    /// Number of the message on its topic, from 1.
    pub sequence: u32,
    /// CDR with its encapsulation header.
    pub bytes: Vec<u8>,
}

/// Topic of each channel number.
pub(super) type Topics = BTreeMap<u16, String>;

/// Reads chunk by chunk, so that a recording of any length fits.
pub(super) struct Scan {
    file: File,
    path: PathBuf,
    chunks: VecDeque<Span>,
    topics: Topics,
    waiting: VecDeque<Message>,
}

impl Scan {
    /// Of these chunks of a file; `topics` are those announced before them.
    pub(super) fn new(
        path: &Path,
        chunks: impl IntoIterator<Item = Span>,
        topics: Topics,
    ) -> Result<Self, NodeError> {
        Ok(Self {
            file: File::open(path).map_err(NodeError::file("open", path))?,
            path: path.to_path_buf(),
            chunks: chunks
                .into_iter()
                .filter(|span| span.op == op::CHUNK)
                .collect(),
            topics,
            waiting: VecDeque::new(),
        })
    }

    /// The next message; nothing at the end.
    pub(super) fn next(&mut self) -> Result<Option<Message>, NodeError> {
        while self.waiting.is_empty() {
            match self.next_chunk()? {
                Some((_, messages)) => self.waiting = messages.into(),
                None => return Ok(None),
            }
        }
        Ok(self.waiting.pop_front())
    }

    /// The messages of the next chunk, with where it is; nothing at the end.
    pub(super) fn next_chunk(&mut self) -> Result<Option<(Span, Vec<Message>)>, NodeError> {
        let Some(span) = self.chunks.pop_front() else {
            return Ok(None);
        };
        let chunk = unpack(&mut self.file, &self.path, span)?;
        let mut messages = vec![];
        for record in chunk {
            match record {
                Record::Channel(channel) => {
                    self.topics.insert(channel.id, channel.topic);
                }
                Record::Message { header, data } => {
                    let Some(topic) = self.topics.get(&header.channel_id) else {
                        let reason = format!("a message on unknown channel {}", header.channel_id);
                        return Err(NodeError::unreadable(&self.path, reason));
                    };
                    messages.push(Message {
                        topic: topic.clone(),
                        stamp: header.log_time,
                        published: header.publish_time,
                        sequence: header.sequence,
                        bytes: data.into_owned(),
                    });
                }
                _ => {}
            }
        }
        Ok(Some((span, messages)))
    }

    /// The topics announced so far.
    pub(super) fn topics(&self) -> &Topics {
        &self.topics
    }
}
