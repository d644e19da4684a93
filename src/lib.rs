#![doc = include_str!("ARCHITECTURE.md")]

pub mod chart;
pub mod cli;
pub mod contact;
pub mod fabric;
pub mod instrument;
pub mod math;
pub mod node;
pub mod physics;
pub mod scene;
pub mod sheet;
pub mod sim;
pub mod wire;
