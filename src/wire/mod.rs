//! What leaves the core, as ROS 2 messages: one definition (a `.msg`), one encoding (CDR).
//!
//! `build.rs`, which runs before the crate is compiled, turns `msgs/msg/*.msg` and the standard types into the structs of [`messages`]; [`channels`] says
//! which of them goes where, and an [`Encoder`] turns a model and its state into encoded [`Packet`]s.
//! Nothing here knows files, sockets or the clock.

mod applied;
pub mod cdr;
pub mod channels;
pub mod cloud;
mod contacts;
mod encoder;
mod health;
pub mod inbound;
pub mod keyframe;
mod message;
mod obstacles;
mod packets;
mod report;
mod sheet;
mod solids;
mod stamp;

pub use applied::applied;
pub use contacts::{ContactWatch, wrench};
pub use encoder::{Encoder, Extras};
pub use health::{Level, diagnostics, log};
pub use message::{Message, MessageType, Service, ServiceType, messages};
pub use obstacles::{pose, robot_description, transforms};
pub use packets::{Packet, kept};
pub use report::{Counters, report};
pub use sheet::{markers, topology};
pub use solids::solids;
pub use stamp::{WORLD, header, nanoseconds, seconds, stamp};
