//! Where the sheet comes near to itself: pairs of a vertex and a face, of two edges.
//!
//! [`Tiles`] finds what may be near and skips what provably is not; [`Candidates`] keeps it while patches move little against
//! each other; [`Pair`]s are what is nearer than a reach; [`safe_share`] says how far a motion may go before two parts
//! meet, [`may_meet`] whether they do; [`crossings`] tells exactly whether they have.

mod bounds;
mod candidates;
mod closest;
mod crossing;
mod detect;
mod features;
mod fit;
mod gaps;
mod hunt;
#[cfg(test)]
mod motion_test;
mod patches;
mod plane;
mod rooms;
mod spread;
#[cfg(test)]
mod spread_test;
mod sweep;
#[cfg(test)]
mod test;
mod tiles;

pub use candidates::Candidates;
pub use closest::{Pair, point_to_face, segment_to_segment};
pub use crossing::{crosses, crossings};
pub use detect::{Part, is_pair_of, parts_of};
pub use sweep::{Sweep, may_meet, safe_share};
pub use tiles::Tiles;
