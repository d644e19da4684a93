//! SVG to pixels with an embedded typeface, since a fresh machine has none.
//!
//! The typeface is DejaVu Sans Condensed (Bitstream Vera licence and public domain, carried by the crate
//! `dejavu`): free to embed, complete in the units and exponents that labels need.

use std::sync::{Arc, OnceLock};

use resvg::tiny_skia::{Pixmap, Transform};
use resvg::usvg::{self, fontdb};

/// Font family named in every SVG that is written; `sans-serif` stands in where it is missing.
pub(super) const FAMILY: &str = "DejaVu Sans";

/// A picture or chart that could not be drawn.
#[derive(Debug, thiserror::Error)]
pub enum DrawError {
    /// The size cannot be drawn.
    #[error("size {width}x{height} px is outside 64x64 to {limit}x{limit}", limit = super::picture::LARGEST_SIDE)]
    Size {
        /// \[px\]
        width: u32,
        /// \[px\]
        height: u32,
    },
    /// There is nothing to draw.
    #[error("nothing to draw: {0}")]
    Empty(&'static str),
    /// A face names a vertex that is not there.
    #[error("face {face} names vertex {vertex}, but there are {vertices}")]
    Face {
        /// Index of the face.
        face: usize,
        /// Vertex that it names.
        vertex: u32,
        /// Number of vertices.
        vertices: usize,
    },
    /// A position that is not a number.
    #[error("vertex {vertex} at {time} s is not finite")]
    NotFinite {
        /// Index of the vertex.
        vertex: usize,
        /// Time of the frame \[s\].
        time: f64,
    },
    /// The chart library refused.
    #[error("chart: {0}")]
    Chart(String),
    /// The SVG could not be read back.
    #[error("svg: {0}")]
    Svg(#[from] usvg::Error),
    /// The PNG could not be encoded.
    #[error("png: {0}")]
    Png(String),
}

fn options() -> usvg::Options<'static> {
    static FONTS: OnceLock<Arc<fontdb::Database>> = OnceLock::new();
    let fonts = FONTS.get_or_init(|| {
        let mut fonts = fontdb::Database::new();
        fonts.load_font_data(dejavu::sans_condensed::regular().to_vec());
        fonts.load_font_data(dejavu::sans_condensed::bold().to_vec());
        fonts.set_sans_serif_family(FAMILY);
        Arc::new(fonts)
    });
    usvg::Options {
        fontdb: fonts.clone(),
        font_family: FAMILY.to_string(),
        ..usvg::Options::default()
    }
}

/// Draws an SVG document over a pixmap, scaled by `scale`.
pub(super) fn draw_over(pixmap: &mut Pixmap, svg: &str, scale: f32) -> Result<(), DrawError> {
    let tree = usvg::Tree::from_str(svg, &options())?;
    resvg::render(
        &tree,
        Transform::from_scale(scale, scale),
        &mut pixmap.as_mut(),
    );
    Ok(())
}

/// Rasterises an SVG chart on white, `scale` pixels to its unit.
pub fn png_of_svg(svg: &str, scale: f32) -> Result<Vec<u8>, DrawError> {
    let tree = usvg::Tree::from_str(svg, &options())?;
    let size = tree.size();
    let (width, height) = (size.width() * scale, size.height() * scale);
    let mut pixmap = Pixmap::new(width.ceil() as u32, height.ceil() as u32)
        .ok_or(DrawError::Empty("the SVG has no area"))?;
    pixmap.fill(resvg::tiny_skia::Color::WHITE);
    resvg::render(
        &tree,
        Transform::from_scale(scale, scale),
        &mut pixmap.as_mut(),
    );
    pixmap
        .encode_png()
        .map_err(|e| DrawError::Png(e.to_string()))
}

/// Text made safe inside an SVG element.
pub(super) fn escape(text: &str) -> String {
    text.replace('&', "&amp;")
        .replace('<', "&lt;")
        .replace('>', "&gt;")
        .replace('"', "&quot;")
}
