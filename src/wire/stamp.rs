//! Simulated time on the wire: nanoseconds since the start of the run.

use super::messages::{builtin_interfaces::Time, std_msgs::Header};

/// Root frame of everything (REP 103: x forward, y left, z up).
pub const WORLD: &str = "world";

/// Simulated time \[s\] in whole nanoseconds.
pub fn nanoseconds(time: f64) -> u64 {
    (time * 1e9).round() as u64
}

/// Nanoseconds in seconds \[s\].
pub fn seconds(nanoseconds: u64) -> f64 {
    nanoseconds as f64 * 1e-9
}

/// Simulated time \[s\] as a ROS 2 time.
pub fn stamp(time: f64) -> Time {
    let total = nanoseconds(time);
    Time {
        sec: (total / 1_000_000_000) as i32,
        nanosec: (total % 1_000_000_000) as u32,
    }
}

/// A header in the world frame at a simulated time \[s\].
pub fn header(time: f64) -> Header {
    Header {
        stamp: stamp(time),
        frame_id: WORLD.to_string(),
    }
}
