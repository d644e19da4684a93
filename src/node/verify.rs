//! Whether a recording is whole: container, index, order, and every message.

use std::collections::BTreeMap;
use std::fs::File;
use std::io::Read;
use std::path::Path;

use mcap::McapError;
use mcap::records::{Record, op};
use mcap::sans_io::linear_reader::{LinearReadEvent, LinearReader, LinearReaderOptions};

use super::message_check::Checker;
use super::recording::file_of;
use super::records::{Span, spans};
use super::scan::{Message, Scan, Topics};
use super::{Inventory, NodeError};
use crate::wire::channels::{REPORT, STATE, TOPOLOGY};

/// Most faults that are told.
const MOST_FAULTS: usize = 20;

/// What is wrong with a recording, one line each; at most twenty are told. None: it is whole, its checksums and
/// index are right, times do not go back, and every message decodes and belongs where it is.
pub fn verify(path: &Path) -> Result<Vec<String>, NodeError> {
    let path = &file_of(path);
    let mut file = File::open(path).map_err(NodeError::file("open", path))?;
    let chunks: Vec<_> = spans(&mut file, path)?
        .into_iter()
        .filter(|span| span.op == op::CHUNK)
        .collect();
    let mut faults = vec![];
    if let Err(fault) = content(path, &chunks, &mut faults) {
        faults.push(fault.to_string());
    }
    let complete = super::records::ends_with_magic(&mut file, path)?;
    if !complete {
        faults.push("it was not closed: there is no index; `toile recover` adds it".to_string());
    } else if let Err(fault) = container(path, &chunks, &mut faults) {
        faults.push(fault.to_string());
    }
    faults.truncate(MOST_FAULTS);
    Ok(faults)
}

/// Every message, in the order of the file.
fn content(path: &Path, chunks: &[Span], faults: &mut Vec<String>) -> Result<(), NodeError> {
    let mut scan = Scan::new(path, chunks.iter().copied(), Topics::new())?;
    let mut sequences: BTreeMap<String, u32> = BTreeMap::new();
    let (mut last, mut checker) = (0, Checker::default());
    while let Some(message) = scan.next()? {
        let mut fault = |reason: String| {
            let time = message.stamp as f64 * 1e-9;
            faults.push(format!("{} at {time} s: {reason}", message.topic));
        };
        if message.stamp < last {
            fault("its time goes back".to_string());
        }
        last = last.max(message.stamp);
        if message.published != message.stamp {
            fault("it was not published when it was logged".to_string());
        }
        let sequence = sequences.entry(message.topic.clone()).or_default();
        *sequence += 1;
        if message.sequence != *sequence {
            fault(format!("number {} instead of {sequence}", message.sequence));
            *sequence = message.sequence;
        }
        if let Err(reason) = checker.check(&message) {
            fault(reason);
        }
        if faults.len() >= MOST_FAULTS {
            return Ok(());
        }
    }
    let count = |topic: &str| sequences.get(topic).copied().unwrap_or(0);
    if count(TOPOLOGY.topic) != 1 {
        faults.push(format!("{} of {}", count(TOPOLOGY.topic), TOPOLOGY.topic));
    }
    let (states, reports) = (count(STATE.topic), count(REPORT.topic));
    if states == 0 || states != reports {
        faults.push(format!("{states} states with {reports} reports"));
    }
    Ok(())
}

/// Checksums of the file and of its index, and whether the index says what is there.
fn container(path: &Path, chunks: &[Span], faults: &mut Vec<String>) -> Result<(), NodeError> {
    let file = File::open(path).map_err(NodeError::file("open", path))?;
    let (mut indexed, mut statistics) = (vec![], None);
    let read = each_record(file, &mut |record| match record {
        Record::ChunkIndex(index) => indexed.push((index.chunk_start_offset, index.chunk_length)),
        Record::Statistics(found) => statistics = Some(found),
        _ => {}
    });
    if let Err(error) = read {
        faults.push(error.to_string());
        return Ok(());
    }
    let there = chunks
        .iter()
        .map(|span| (span.start, span.end - span.start));
    if !there.eq(indexed) {
        faults.push("the index of chunks is not that of the chunks that are there".to_string());
    }
    // Counting needs readable chunks; where they are not, that is said already.
    let Ok(inventory) = Inventory::of(path) else {
        return Ok(());
    };
    let counted = statistics.map(|s| (s.message_count, u64::from(s.chunk_count)));
    if counted != Some((inventory.messages(), inventory.chunks)) {
        faults.push("the statistics do not count what is there".to_string());
    }
    Ok(())
}

/// Reads a file from its first magic to its last, checksums of data and index included; chunks stay closed.
fn each_record(mut file: File, take: &mut dyn FnMut(Record)) -> Result<(), McapError> {
    let longest = usize::try_from(file.metadata()?.len()).unwrap_or(usize::MAX);
    let options = LinearReaderOptions::default()
        .with_emit_chunks(true)
        .with_validate_data_section_crc(true)
        .with_validate_summary_section_crc(true)
        .with_check_finishes_after_end_magic(true)
        .with_record_length_limit(longest);
    let mut reader = LinearReader::new_with_options(options);
    while let Some(event) = reader.next_event() {
        match event? {
            LinearReadEvent::ReadRequest(count) => {
                let read = file.read(reader.insert(count))?;
                reader.notify_read(read);
            }
            LinearReadEvent::Record { opcode, data } => take(mcap::parse_record(opcode, data)?),
        }
    }
    Ok(())
}

impl Message {
    /// Whether the message is one of a topic.
    pub(super) fn is(&self, topic: &str) -> bool {
        self.topic == topic
    }
}
