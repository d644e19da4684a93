//! Making a recording that was cut short a whole one.

use std::path::Path;

use serde::Serialize;

use super::bag::{Destination, Tally, Track};
use super::inventory::channel_of;
use super::recording::file_of;
use super::{Inventory, NodeError, seal};
use crate::wire::channels::STATE;
use crate::wire::nanoseconds;

/// What a recovery came to.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct Recovery {
    /// Whether the recording was whole already; nothing was changed.
    pub was_complete: bool,
    /// Bytes of an incomplete record at the end, which are gone \[bytes\].
    pub lost: u64,
    /// Messages that are there.
    pub messages: u64,
    /// States that are there.
    pub states: u64,
}

/// Completes a recording in place, an MCAP file or a bag directory: what is readable is kept, a record that was
/// not completely written goes, and the index is added.
pub fn recover(path: &Path) -> Result<Recovery, NodeError> {
    let file = file_of(path);
    let before = Inventory::of(&file)?;
    if !before.complete {
        seal(&file)?;
    }
    let after = Inventory::of(&file)?;
    if path.is_dir() {
        Destination::new(path).describe(&tally(&after))?;
    }
    let states = after.topics.iter().find(|t| t.topic == STATE.topic);
    Ok(Recovery {
        was_complete: before.complete,
        lost: before.ragged,
        messages: after.messages(),
        states: states.map_or(0, |topic| topic.count),
    })
}

fn tally(inventory: &Inventory) -> Tally {
    let mut tally = Tally::default();
    for (id, topic) in inventory.topics.iter().enumerate() {
        let Some(channel) = channel_of(&topic.topic) else {
            continue;
        };
        tally.add(Track {
            channel,
            topic: topic.topic.clone(),
            id: id as u16,
            count: u32::try_from(topic.count).unwrap_or(u32::MAX),
        });
        tally.reach(nanoseconds(topic.last));
    }
    tally
}
