//! Obstacles and their distance to points, edges and faces of the sheet; and the sheet near itself, in [`layers`].

mod detect;
mod distance;
pub mod layers;
mod minimum;
mod motion;
mod nearby;
mod obstacle;
mod search;
pub mod surface;
#[cfg(test)]
mod test;

pub use detect::{Features, Proximity, detect, obstacle_of, with_obstacle};
pub use distance::Distance;
pub use motion::{Law, Motion};
pub use nearby::{FAR, Nearby, Side, depth_inside};
pub use obstacle::{Obstacle, Overlap, Pose, Shape, Velocity};
pub use search::{Search, Spot};
pub use surface::{Surface, SurfaceError};
