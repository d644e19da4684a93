//! The recording as a carrier: an MCAP file that rosbag2, rerun and Foxglove open as it is.
//!
//! A chunk is one instant. Chunks are cut by simulated time only, so the same run gives the same bytes, and
//! each is in the file as soon as its instant is published, so a kill loses what is still in the recorder's
//! queue and nothing else. Metadata and the scene come first: a file cut short still explains itself.

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::fs::File;
use std::path::{Path, PathBuf};

use mcap::records::{MessageHeader, Metadata};
use mcap::write::NoSeek;
use mcap::{Attachment, Compression, McapError, WriteOptions, Writer};

use super::bag::{Destination, Tally, Track};
use super::store::Store;
use super::{About, Carrier, NodeError, seal};
use crate::sim::Model;
use crate::wire::Packet;
use crate::wire::channels::{self, Channel};

/// Name of the metadata record and prefix of what toile adds to a file.
pub(super) const TOILE: &str = "toile";
/// Attachment that holds the scene as it was run.
pub(super) const SCENE_ATTACHMENT: &str = "scene.toml";
/// Attachment that holds the fabric's constants as they were used.
const FABRIC_ATTACHMENT: &str = "fabric.toml";

/// Options of every file that toile writes. One compression thread: the bytes must not depend on the machine.
pub(super) fn write_options() -> WriteOptions {
    WriteOptions::new()
        .profile("ros2")
        .library(TOILE)
        .compression(Some(Compression::Zstd))
        .compression_threads(0)
        .chunk_size(None)
        .disable_seeking(true)
}

/// An MCAP recording being written.
pub struct McapFile {
    destination: Destination,
    writer: Writer<NoSeek<Store>>,
    tally: Tally,
}

impl McapFile {
    /// Creates the file and writes everything that explains it.
    pub fn create(
        destination: Destination,
        model: &Model,
        about: &About,
    ) -> Result<Self, NodeError> {
        destination.prepare()?;
        let path = destination.file().to_path_buf();
        let file = File::create(&path).map_err(NodeError::file("create", &path))?;
        let store = Store::new(file, 0).map_err(NodeError::file("write", &path))?;
        let writer = write_options()
            .create(NoSeek::new(store))
            .map_err(|e| failure(&path, e))?;
        let mut recording = Self {
            destination,
            writer,
            tally: Tally::default(),
        };
        recording.explain(model, about)?;
        recording.announce().map_err(|e| failure(&path, e))?;
        Ok(recording)
    }

    fn path(&self) -> &Path {
        self.destination.file()
    }

    /// Metadata and attachments.
    fn explain(&mut self, model: &Model, about: &About) -> Result<(), NodeError> {
        let path = self.path().to_path_buf();
        let scene = to_toml(&path, &model.scene)?;
        let fabric = to_toml(&path, &model.fabric)?;
        let metadata = about.to_metadata();
        let mut write = || {
            self.writer.write_metadata(&Metadata {
                name: TOILE.to_string(),
                metadata: metadata.clone(),
            })?;
            self.writer.attach(&attachment(SCENE_ATTACHMENT, &scene))?;
            self.writer.attach(&attachment(FABRIC_ATTACHMENT, &fabric))
        };
        write().map_err(|e| failure(&path, e))
    }

    /// Schema and channel records of all topics that are known beforehand, in the order of the table.
    fn announce(&mut self) -> Result<(), McapError> {
        for channel in channels::ALL {
            if !channel.is_per_obstacle() {
                self.open(channel, channel.topic)?;
            }
        }
        Ok(())
    }

    /// Schema and channel record of a topic.
    fn open(&mut self, channel: &'static Channel, topic: &str) -> Result<&mut Track, McapError> {
        let message = channel.message;
        let schema = self
            .writer
            .add_schema(message.name, "ros2msg", message.schema.as_bytes())?;
        let metadata = BTreeMap::from(
            [
                ("offered_qos_profiles", channel.qos.offered_profiles()),
                ("topic_type_hash", message.hash.to_string()),
            ]
            .map(|(key, value)| (key.to_string(), value)),
        );
        let id = self.writer.add_channel(schema, topic, "cdr", &metadata)?;
        Ok(self.tally.add(Track {
            channel,
            topic: topic.to_string(),
            id,
            count: 0,
        }))
    }

    fn write(&mut self, packet: &Packet) -> Result<(), McapError> {
        let topic = packet.topic();
        let (channel_id, sequence) = match self.tally.find(&topic) {
            Some(track) => track.next(),
            None => self.open(packet.channel, &topic)?.next(),
        };
        self.tally.reach(packet.stamp);
        let header = MessageHeader {
            channel_id,
            sequence,
            log_time: packet.stamp,
            publish_time: packet.stamp,
        };
        self.writer.write_to_known_channel(&header, &packet.bytes)
    }

    /// The space ran out: completes the file with what is in it.
    fn rescue(&mut self, error: McapError) -> NodeError {
        let path = self.path().to_path_buf();
        let error = failure(&path, error);
        match seal(&path) {
            Ok(()) | Err(NodeError::Unreadable { .. }) => error,
            Err(worse) => worse,
        }
    }
}

impl Carrier for McapFile {
    fn publish(&mut self, packet: &Packet) -> Result<(), NodeError> {
        let result = self.write(packet);
        result.map_err(|e| self.rescue(e))
    }

    fn commit(&mut self) -> Result<(), NodeError> {
        let result = self.writer.flush();
        result.map_err(|e| self.rescue(e))
    }

    fn close(&mut self) -> Result<(), NodeError> {
        self.commit()?;
        let finished = self.writer.finish().map(|_| ());
        finished.map_err(|e| self.rescue(e))?;
        self.destination.describe(&self.tally)
    }
}

fn to_toml<T: serde::Serialize>(path: &Path, value: &T) -> Result<String, NodeError> {
    toml::to_string(value).map_err(|e| NodeError::unreadable(path, e))
}

fn attachment<'a>(name: &str, text: &'a str) -> Attachment<'a> {
    Attachment {
        log_time: 0,
        create_time: 0,
        name: name.to_string(),
        media_type: "application/toml".to_string(),
        data: Cow::Borrowed(text.as_bytes()),
    }
}

/// An error of the writer as an error of the node.
pub(super) fn failure(path: &Path, error: McapError) -> NodeError {
    let path: PathBuf = path.into();
    match error {
        McapError::Io(source) if is_full(&source) => NodeError::DiskFull {
            bytes: path.metadata().map_or(0, |m| m.len()),
            path,
            source,
        },
        McapError::Io(source) => NodeError::File {
            action: "write",
            path,
            source,
        },
        other => NodeError::unreadable(&path, other),
    }
}

fn is_full(error: &std::io::Error) -> bool {
    use std::io::ErrorKind::{FileTooLarge, QuotaExceeded, StorageFull};
    matches!(error.kind(), StorageFull | QuotaExceeded | FileTooLarge)
}
