//! Pictures and charts: plain data in, PNG, SVG and CSV text out. Nothing here touches files or clocks.
//!
//! - [`picture`]: a sheet with its obstacles, shaded, in one frame or a strip of frames.
//! - [`diagram`]: the report of a laboratory instrument.
//! - [`drape`]: the audit of the paper's drape tables.
//! - [`work_precision`]: error against CPU time of every method, step and mesh, failures included.
//! - [`plan`]: the cheapest method, step and mesh within a tolerance.
//! - [`mesh_error`]: how far a mesh is from ever finer ones.
//! - [`waterfall`]: what each economy saves on a scene.
//! - [`stability`]: where a method converges, goes wrong, is lost: step, stiffness, mesh.

mod course;
pub mod diagram;
pub mod drape;
mod drape_plot;
mod lettering;
pub mod mesh_error;
pub mod peers;
pub mod picture;
mod picture_camera;
mod picture_cloth;
mod picture_framing;
mod picture_labels;
mod picture_light;
mod picture_solids;
mod picture_strip;
pub mod plan;
mod plan_error;
mod plan_meshes;
pub mod plot;
mod plot_frame;
mod plot_marks;
mod plot_points;
pub mod problems;
mod raster;
pub mod reference;
pub mod rows;
pub mod stability;
pub mod stability_plot;
pub mod waterfall;
pub mod waterfall_plot;
pub mod work_precision;

pub use course::{CpuClock, Watch};
pub use diagram::report;
pub use lettering::{DrawError, png_of_svg};
pub use picture::{Moment, Picture, Size, Subject, draw};
pub use picture_framing::{Framing, View};
pub use picture_strip::draw_strip;
