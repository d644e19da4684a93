//! Completing a recording that was cut short, in place and without room for a copy.
//!
//! The writer is deterministic: fed with what is in the file, it produces the very bytes that are there, then
//! the index that is missing. So the file is written over itself, and where bytes would differ (a file of
//! another program or version) nothing is touched.

use std::fs::{File, OpenOptions};
use std::io::{self, Read, Write};
use std::path::Path;

use mcap::records::{Record, op};
use mcap::write::NoSeek;
use mcap::{Attachment, McapError, Writer};

use super::NodeError;
use super::mcap_file::{failure, write_options};
use super::records::{Span, record, spans, unpack};
use super::store::Store;

/// Adds the index to a recording that ends without one; an incomplete last chunk goes. On a full disk chunks
/// are given up from the end, twice as many at each attempt, until the index fits.
pub fn seal(path: &Path) -> Result<(), NodeError> {
    let mut surplus = 1;
    loop {
        match complete(path) {
            Err(NodeError::DiskFull { .. }) if give_up(path, surplus)? => surplus *= 2,
            other => return other,
        }
    }
}

/// Cuts off the last chunks, up to `count` but not the first; false if there was none to cut.
fn give_up(path: &Path, count: usize) -> Result<bool, NodeError> {
    let mut file = open(path)?;
    let mut chunks = spans(&mut file, path)?;
    chunks.retain(|s| s.op == op::CHUNK);
    let keep = chunks.len().saturating_sub(count).max(1);
    let Some(first_lost) = chunks.get(keep) else {
        return Ok(false);
    };
    let cut = file.set_len(first_lost.start);
    cut.map_err(NodeError::file("shorten", path))?;
    Ok(true)
}

fn complete(path: &Path) -> Result<(), NodeError> {
    let mut file = open(path)?;
    let records = spans(&mut file, path)?;
    let end = records.last().map_or(0, |s| s.end);
    file.set_len(end)
        .map_err(NodeError::file("shorten", path))?;
    let rest = OpenOptions::new().write(true).open(path);
    let rest = rest
        .and_then(|f| Store::new(f, end))
        .map_err(NodeError::file("open", path))?;
    let sink = Overwrite {
        old: open(path)?.take(end),
        rest,
    };
    let options = write_options();
    let mut writer = options
        .create(NoSeek::new(sink))
        .map_err(|e| failure(path, e))?;
    for span in records {
        copy(&mut writer, &mut file, path, span)?;
    }
    writer.finish().map_err(|e| failure(path, e))?;
    Ok(())
}

fn open(path: &Path) -> Result<File, NodeError> {
    let file = OpenOptions::new().read(true).write(true).open(path);
    file.map_err(NodeError::file("open", path))
}

/// Says one record of the file again.
fn copy<W: Write + io::Seek>(
    writer: &mut Writer<W>,
    file: &mut File,
    path: &Path,
    span: Span,
) -> Result<(), NodeError> {
    let result = match span.op {
        op::METADATA => match record(file, path, span)? {
            Record::Metadata(metadata) => writer.write_metadata(&metadata),
            _ => Ok(()),
        },
        op::ATTACHMENT => match record(file, path, span)? {
            Record::Attachment { header, data, .. } => writer.attach(&Attachment {
                log_time: header.log_time,
                create_time: header.create_time,
                name: header.name,
                media_type: header.media_type,
                data,
            }),
            _ => Ok(()),
        },
        op::CHUNK => {
            let chunk = unpack(file, path, span)?;
            let copied = chunk.iter().try_for_each(|r| copy_inner(writer, r));
            copied.and_then(|()| writer.flush())
        }
        _ => Ok(()),
    };
    result.map_err(|e| failure(path, e))
}

/// Says one record of a chunk again.
fn copy_inner<W: Write + io::Seek>(
    writer: &mut Writer<W>,
    record: &Record,
) -> Result<(), McapError> {
    match record {
        Record::Schema { header, data } => writer
            .add_schema(&header.name, &header.encoding, data)
            .map(|_| ()),
        Record::Channel(c) => writer
            .add_channel(c.schema_id, &c.topic, &c.message_encoding, &c.metadata)
            .map(|_| ()),
        Record::Message { header, data } => writer.write_to_known_channel(header, data),
        _ => Ok(()),
    }
}

/// Compares with what is in the file, and appends from its end on.
struct Overwrite {
    old: io::Take<File>,
    rest: Store,
}

impl Write for Overwrite {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let known = self.old.limit().min(bytes.len() as u64) as usize;
        let mut old = vec![0; known];
        self.old.read_exact(&mut old)?;
        if old != bytes[..known] {
            return Err(io::Error::other(
                "the file was written by another program or version",
            ));
        }
        self.rest.write_all(&bytes[known..])?;
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        self.rest.flush()
    }
}
