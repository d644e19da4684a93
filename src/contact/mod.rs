//! Obstacles and their distance to points, edges and faces of the sheet.

mod detect;
mod distance;
mod minimum;
mod motion;
mod obstacle;
#[cfg(test)]
mod test;

pub use detect::{Features, Nearby, Proximity, detect, obstacle_of, with_obstacle};
pub use distance::Distance;
pub use motion::{Law, Motion};
pub use obstacle::{Obstacle, Overlap, Pose, Shape, Velocity};
