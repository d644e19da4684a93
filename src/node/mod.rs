//! The border to the world: the loop, the wall clock, threads and files.
//!
//! [`run()`] steps a simulation and hands what it says to a recorder thread, which encodes it once and gives
//! the same bytes to every [`Carrier`]. [`Recording`] reads back what was recorded.

mod bag;
mod carrier;
mod clock;
mod error;
mod mcap_file;
mod recorder;
mod recording;
mod records;
mod run;
mod seal;
#[cfg(feature = "iceoryx2")]
pub mod shared_memory;
mod store;
mod summary;
pub mod viewers;

pub use bag::Destination;
pub use carrier::{Carrier, Memory};
pub use error::NodeError;
pub use mcap_file::McapFile;
pub use recording::{Frame, Recording};
pub use run::{Progress, RunOptions, run};
pub use seal::seal;
pub use summary::{Peak, Summary};
