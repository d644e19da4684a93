//! The records of an MCAP file from the first to the last complete one, wherever the file ends.

use std::fs::File;
use std::io::{Read, Seek, SeekFrom};
use std::path::Path;

use mcap::read::parse_record;
use mcap::records::{Record, op};
use mcap::sans_io::{LinearReadEvent, LinearReader, LinearReaderOptions};

use super::NodeError;

/// Opcode and length before each record \[bytes\].
const PREFIX: u64 = 9;
/// Most bytes of a chunk, unpacked: a thousand times what the recorder makes.
const LARGEST_CHUNK: usize = 1 << 30;

/// A complete record at the top level of a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Span {
    /// Opcode.
    pub op: u8,
    /// Where its prefix starts \[bytes\].
    pub start: u64,
    /// Where it ends \[bytes\].
    pub end: u64,
}

/// All complete records, up to the end of the data section or to where the file was cut.
pub(super) fn spans(file: &mut File, path: &Path) -> Result<Vec<Span>, NodeError> {
    let length = file
        .metadata()
        .map_err(NodeError::file("read", path))?
        .len();
    let mut magic = [0; mcap::MAGIC.len()];
    read_at(file, 0, &mut magic, path)?;
    if magic != mcap::MAGIC {
        return Err(NodeError::unreadable(path, "it is not an MCAP file"));
    }
    let mut spans = vec![];
    let mut start = magic.len() as u64;
    while start + PREFIX <= length {
        let mut prefix = [0; PREFIX as usize];
        read_at(file, start, &mut prefix, path)?;
        let [op, size @ ..] = prefix;
        let end = (start + PREFIX).saturating_add(u64::from_le_bytes(size));
        if op == op::DATA_END || end > length {
            break;
        }
        spans.push(Span { op, start, end });
        start = end;
    }
    Ok(spans)
}

/// Whether the file ends as one does that was closed.
pub(super) fn ends_with_magic(file: &mut File, path: &Path) -> Result<bool, NodeError> {
    let length = file
        .metadata()
        .map_err(NodeError::file("read", path))?
        .len();
    let mut magic = [0; mcap::MAGIC.len()];
    // A file of one magic alone has only begun.
    if length < 2 * magic.len() as u64 {
        return Ok(false);
    }
    read_at(file, length - magic.len() as u64, &mut magic, path)?;
    Ok(magic == mcap::MAGIC)
}

/// One record of the file.
pub(super) fn record(
    file: &mut File,
    path: &Path,
    span: Span,
) -> Result<Record<'static>, NodeError> {
    let start = span.start + PREFIX;
    let mut body = vec![0; (span.end - start) as usize];
    read_at(file, start, &mut body, path)?;
    let record = parse_record(span.op, &body).map_err(|e| at(path, span, e))?;
    Ok(record.into_owned())
}

/// The records inside a chunk, its checksum verified; nothing for other records.
pub(super) fn unpack(
    file: &mut File,
    path: &Path,
    span: Span,
) -> Result<Vec<Record<'static>>, NodeError> {
    if span.op != op::CHUNK {
        return Ok(vec![]);
    }
    let mut bytes = vec![0; (span.end - span.start) as usize];
    read_at(file, span.start, &mut bytes, path)?;
    let mut rest = &bytes[..];
    // No length inside is believed before the checksum has been seen: a damaged one would ask for all memory.
    let mut reader = LinearReader::new_with_options(
        LinearReaderOptions::default()
            .with_skip_start_magic(true)
            .with_skip_end_magic(true)
            .with_prevalidate_chunk_crcs(true)
            .with_record_length_limit(LARGEST_CHUNK),
    );
    let mut records = vec![];
    while let Some(event) = reader.next_event() {
        match event.map_err(|e| at(path, span, e))? {
            LinearReadEvent::ReadRequest(wanted) => {
                let (now, later) = rest.split_at(wanted.min(rest.len()));
                reader.insert(now.len()).copy_from_slice(now);
                reader.notify_read(now.len());
                rest = later;
            }
            LinearReadEvent::Record { data, opcode } => {
                let record = parse_record(opcode, data).map_err(|e| at(path, span, e))?;
                records.push(record.into_owned());
            }
        }
    }
    Ok(records)
}

fn read_at(file: &mut File, start: u64, bytes: &mut [u8], path: &Path) -> Result<(), NodeError> {
    let read = file
        .seek(SeekFrom::Start(start))
        .and_then(|_| file.read_exact(bytes));
    match read {
        Err(e) if e.kind() == std::io::ErrorKind::UnexpectedEof => Err(NodeError::unreadable(
            path,
            format!("it ends at byte {start}"),
        )),
        other => other.map_err(NodeError::file("read", path)),
    }
}

fn at(path: &Path, span: Span, error: mcap::McapError) -> NodeError {
    NodeError::unreadable(
        path,
        format!("{error}, in the record at byte {}", span.start),
    )
}
