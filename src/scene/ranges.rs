//! What values and names may be, wherever they come from: a scene or a command.

pub use super::quantity::Range;
use super::quantity::range;

/// Sizes of sheets and obstacles.
pub const SIZE: Range = range(1e-6, 1e3, "m");
/// Coordinates in the world.
pub const PLACE: Range = range(-1e3, 1e3, "m");
/// Components of an obstacle's linear velocity.
pub const SPEED: Range = range(-100.0, 100.0, "m/s");
/// Components of an obstacle's angular velocity.
pub const TURN_RATE: Range = range(-1e3, 1e3, "rad/s");
/// Depths of obstacles in the cloth \[m\], and speeds at which they push it out \[m/s\].
pub const OVERLAP: Range = range(0.0, 1e4, "m or m/s");
/// Coulomb friction coefficients.
pub const FRICTION: Range = range(0.0, 10.0, "");

/// What the lengths in a file of triangles are multiplied by.
pub const MESH_SCALE: Range = range(1e-6, 1e6, "");

/// Components of the air's velocity.
pub const WIND: Range = range(-200.0, 200.0, "m/s");
/// C of the air force.
pub const FLUID_DAMPING: Range = range(0.0, 1e4, "kg/(m²·s)");
/// Lengths of ramps and flows.
pub const TIME: Range = range(0.0, 1e5, "s");

/// What [`is_name`] asks for, as it stands after "must be" in a message.
pub const NAME: &str =
    "1 to 64 letters, digits or single `_`, a letter first, no `_` at the end, and not `world`";

/// Whether a name can stand in ROS topics and frames, and is not the root frame.
pub fn is_name(name: &str) -> bool {
    let plain = |c: char| c.is_ascii_alphanumeric() || c == '_';
    name.starts_with(|c: char| c.is_ascii_alphabetic())
        && name.chars().all(plain)
        && !name.contains("__")
        && !name.ends_with('_')
        && name.len() <= 64
        && name != "world"
}
