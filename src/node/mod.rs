//! The border to the world: the loop, the wall clock, threads and files.
//!
//! [`run()`] steps a simulation and hands what it says to a recorder thread, which encodes it once and gives
//! the same bytes to every [`Carrier`]. [`Recording`] reads back what was recorded.

mod about;
mod bag;
mod carrier;
mod cast;
mod clock;
mod compare;
mod difference;
mod drive;
mod error;
mod inbox;
mod inventory;
mod live;
mod mcap_file;
mod message_check;
mod mode;
mod orders;
mod pace;
mod recorder;
mod recording;
mod records;
mod recover;
mod replay;
#[cfg(feature = "ros2")]
pub mod ros2;
mod run;
mod scan;
mod schedule;
mod seal;
#[cfg(feature = "iceoryx2")]
pub mod shared_memory;
mod store;
mod summary;
mod verify;
pub mod viewers;

pub use about::About;
pub use bag::Destination;
pub use carrier::{Carrier, Memory};
pub use clock::Lateness;
pub use compare::TOLERANCE;
pub use difference::{Difference, What};
pub use error::NodeError;
pub use inbox::{Inbox, Mailbox, Order, Unposted};
pub use inventory::{Inventory, Topic};
pub use live::{Gauge, Live, LiveTally};
pub use mcap_file::McapFile;
pub use pace::{BadPace, Pace};
pub use recording::{Frame, Recording};
pub use recover::{Recovery, recover};
pub use replay::{Replay, ReplayOptions, replay};
pub use run::{Progress, RunOptions, run};
pub use seal::seal;
pub use summary::{Layers, Orders, Peak, Summary};
pub use verify::verify;
