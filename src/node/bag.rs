//! Where a recording goes. A path that ends in `.mcap` is a file and nothing else: viewers and
//! `ros2 bag play -s mcap FILE` take it as it is. Any other path is a rosbag2 bag, a directory `NAME` with
//! `NAME_0.mcap` and `metadata.yaml`, which `ros2 bag info/play NAME` takes on every distribution. (rosbag2 reads
//! one `metadata.yaml` per directory, so it is never written beside a bare file, where a second recording in
//! the same directory would take it over.)

use std::fmt::Write as _;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};

use super::NodeError;
use crate::wire::channels::Channel;

/// What rosbag2 reads first of a bag.
const METADATA: &str = "metadata.yaml";

/// Where a recording goes.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Destination {
    file: PathBuf,
    /// Directory of the bag, if it is one.
    bag: Option<PathBuf>,
}

impl Destination {
    /// A file if the path ends in `.mcap`, else a bag directory.
    pub fn new(path: &Path) -> Self {
        if path.extension().is_some_and(|e| e == "mcap") {
            return Self {
                file: path.to_path_buf(),
                bag: None,
            };
        }
        let name = path.file_name().unwrap_or("toile".as_ref());
        let file = format!("{}_0.mcap", name.to_string_lossy());
        Self {
            file: path.join(file),
            bag: Some(path.to_path_buf()),
        }
    }

    /// The MCAP file.
    pub fn file(&self) -> &Path {
        &self.file
    }

    /// Makes the directories that are missing. What holds other things than a bag is not made one.
    pub(super) fn prepare(&self) -> Result<(), NodeError> {
        if let Some(bag) = self.bag.as_deref().filter(|bag| bag.exists()) {
            self.refuse_others(bag)
                .map_err(NodeError::file("record into", bag))?;
        }
        let Some(parent) = self.file.parent().filter(|p| !p.as_os_str().is_empty()) else {
            return Ok(());
        };
        fs::create_dir_all(parent).map_err(NodeError::file("create directory", parent))
    }

    /// Whether what is there already is a bag or an empty directory.
    fn refuse_others(&self, bag: &Path) -> io::Result<()> {
        if !bag.is_dir() {
            return Err(io::Error::other(
                "it is a file whose name does not end in .mcap",
            ));
        }
        let ours = self.file.exists() || bag.join(METADATA).exists();
        match !ours && fs::read_dir(bag)?.next().is_some() {
            true => Err(io::Error::other(
                "the directory holds other files; name a new one, or FILE.mcap",
            )),
            false => Ok(()),
        }
    }

    /// Writes `metadata.yaml` of a bag, whole or not at all.
    pub(super) fn describe(&self, tally: &Tally) -> Result<(), NodeError> {
        let Some(bag) = &self.bag else {
            return Ok(());
        };
        let file = self.file.file_name().unwrap_or_default().to_string_lossy();
        let (path, draft) = (bag.join(METADATA), bag.join("metadata.yaml.part"));
        fs::write(&draft, tally.yaml(&file)).map_err(NodeError::file("write", &draft))?;
        fs::rename(&draft, &path).map_err(NodeError::file("write", &path))
    }
}

/// A topic of a recording.
#[derive(Clone, Debug)]
pub(super) struct Track {
    pub channel: &'static Channel,
    pub topic: String,
    /// Number of its channel record.
    pub id: u16,
    /// Messages so far.
    pub count: u32,
}

impl Track {
    /// Channel and sequence number of one more message.
    pub(super) fn next(&mut self) -> (u16, u32) {
        self.count += 1;
        (self.id, self.count)
    }
}

/// What a recording holds, as rosbag2's metadata counts it.
#[derive(Clone, Debug, Default)]
pub(super) struct Tally {
    /// In the order in which they were announced.
    tracks: Vec<Track>,
    /// Time of the last message \[ns\]; the first is at 0.
    last: u64,
}

impl Tally {
    /// A topic that has been announced.
    pub(super) fn find(&mut self, topic: &str) -> Option<&mut Track> {
        self.tracks.iter_mut().find(|track| track.topic == topic)
    }

    /// A new topic.
    pub(super) fn add(&mut self, track: Track) -> &mut Track {
        let index = self.tracks.len();
        self.tracks.push(track);
        &mut self.tracks[index]
    }

    /// The recording goes up to a time \[ns\].
    pub(super) fn reach(&mut self, stamp: u64) {
        self.last = self.last.max(stamp);
    }

    /// `metadata.yaml`, version 5 (Humble reads no newer one).
    fn yaml(&self, file: &str) -> String {
        let total: u64 = self.tracks.iter().map(|t| u64::from(t.count)).sum();
        let last = self.last;
        let mut text = format!(
            "rosbag2_bagfile_information:\n  version: 5\n  storage_identifier: mcap\n  \
             duration:\n    nanoseconds: {last}\n  \
             starting_time:\n    nanoseconds_since_epoch: 0\n  \
             message_count: {total}\n  topics_with_message_count:\n"
        );
        for track in &self.tracks {
            let (channel, count) = (track.channel, track.count);
            let qos = channel.qos.offered_profiles().replace('\n', "\\n");
            let _ = write!(
                text,
                "    - topic_metadata:\n        name: {}\n        type: {}\n        \
                 serialization_format: cdr\n        offered_qos_profiles: \"{qos}\"\n      \
                 message_count: {count}\n",
                track.topic, channel.message.name
            );
        }
        text + &format!(
            "  compression_format: \"\"\n  compression_mode: \"\"\n  relative_file_paths:\n    - {file}\n  \
             files:\n    - path: {file}\n      starting_time:\n        nanoseconds_since_epoch: 0\n      \
             duration:\n        nanoseconds: {last}\n      message_count: {total}\n"
        )
    }
}
