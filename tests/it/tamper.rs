//! A recording rewritten with other contents.

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

use mcap::read::LinearReader;
use mcap::records::Record;
use mcap::{Attachment, WriteOptions, Writer};

/// The bytes of a file with messages changed and all its checksums right.
pub fn changed(
    path: &Path,
    mut change: impl FnMut(&str, &mut Vec<u8>),
    metadata: &[(&str, &str)],
) -> Vec<u8> {
    let bytes = fs::read(path).expect("read");
    let mut out = std::io::Cursor::new(vec![]);
    let options = WriteOptions::new().profile("ros2").library("toile");
    let mut writer = Writer::with_options(&mut out, options.disable_seeking(true)).expect("starts");
    let mut topics = BTreeMap::new();
    for record in LinearReader::new(&bytes).expect("an MCAP file") {
        match record.expect("readable") {
            Record::Metadata(mut found) => {
                let new = metadata.iter().map(|(k, v)| (k.to_string(), v.to_string()));
                found.metadata.extend(new);
                writer.write_metadata(&found).expect("written");
            }
            Record::Attachment { header, data, .. } => writer
                .attach(&Attachment {
                    log_time: header.log_time,
                    create_time: header.create_time,
                    name: header.name,
                    media_type: header.media_type,
                    data: Cow::Borrowed(&data),
                })
                .expect("written"),
            Record::Chunk { header, data } => {
                let chunk = mcap::read::ChunkReader::new(header, &data).expect("a chunk");
                for inner in chunk {
                    match inner.expect("readable") {
                        Record::Schema { header, data } => {
                            writer
                                .add_schema(&header.name, &header.encoding, &data)
                                .expect("written");
                        }
                        Record::Channel(c) => {
                            writer
                                .add_channel(
                                    c.schema_id,
                                    &c.topic,
                                    &c.message_encoding,
                                    &c.metadata,
                                )
                                .expect("written");
                            topics.insert(c.id, c.topic);
                        }
                        Record::Message { header, data } => {
                            let mut data = data.into_owned();
                            change(&topics[&header.channel_id], &mut data);
                            writer
                                .write_to_known_channel(&header, &data)
                                .expect("written");
                        }
                        _ => {}
                    }
                }
                writer.flush().expect("written");
            }
            _ => {}
        }
    }
    writer.finish().expect("written");
    drop(writer);
    out.into_inner()
}
