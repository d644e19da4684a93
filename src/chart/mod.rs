//! Pictures and charts: plain data in, PNG, SVG and CSV text out. Nothing here touches files or clocks.
//!
//! - [`picture`]: a sheet with its obstacles, shaded, in one frame or a strip of frames.

mod lettering;
pub mod picture;
mod picture_camera;
mod picture_cloth;
mod picture_labels;
mod picture_light;
mod picture_solids;
mod raster;

pub use lettering::{DrawError, png_of_svg};
pub use picture::{Framing, Moment, Picture, Size, Subject, View, draw, draw_strip};
