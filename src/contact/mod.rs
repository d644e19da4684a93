//! Obstacles and their distance to points, edges and faces of the sheet.

mod obstacle;

pub use obstacle::{Obstacle, Pose, Shape, Velocity};
