//! The integration tests: one binary, a module per subject.

mod architecture;
mod byte_identity;
mod charts;
mod cli;
mod commands;
mod consistency;
mod damage;
mod encoding;
mod energy;
mod friction;
mod inbound;
mod inbound_objects;
mod inbound_services;
mod lab;
mod messages;
mod needs;
mod order;
mod pace;
mod pictures;
mod python;
mod recording;
mod refusal;
#[cfg(feature = "ros2")]
mod ros2;
mod samples;
mod scene;
mod schema_reader;
#[cfg(feature = "iceoryx2")]
mod shared_memory;
mod tidy;
mod type_hashes;
mod verify;
mod views;
