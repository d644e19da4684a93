//! Draws a sheet and its obstacles: no display, no GPU, the same bytes for the same input.
//!
//! A picture is orthographic, so that its scale bar is exact everywhere; it is shaded by a sky and a soft key
//! light with shadows, supersampled over a depth buffer, and lettered with an embedded typeface.

use nalgebra::{Vector2, Vector3};
use resvg::tiny_skia::{IntSize, Pixmap};

use super::lettering::{DrawError, draw_over};
use super::picture_camera::Camera;
use super::picture_cloth::{Kind, Surface, cloth};
use super::picture_framing::Framing;
use super::picture_labels::{Labels, round_down, time};
use super::picture_light::light;
use super::picture_solids::{floor, solid};
use super::raster::{Canvas, Weave};
use crate::contact::{Obstacle, Shape};

/// Longest side of a picture \[px\].
pub const LARGEST_SIDE: u32 = 8192;

/// What stays the same in every frame.
#[derive(Clone, Debug)]
pub struct Subject<'a> {
    /// Written large: the scene's name.
    pub title: &'a str,
    /// Written small under it: fabric, number of triangles.
    pub subtitle: &'a str,
    /// Vertices of each triangle, counter-clockwise.
    pub faces: &'a [[u32; 3]],
    /// Warp and weft coordinates \[m\] of each vertex, or empty: then no lines are drawn on the cloth.
    pub material: &'a [Vector2<f64>],
}

/// The sheet and its obstacles at one time.
#[derive(Clone, Debug)]
pub struct Moment {
    /// Simulated time \[s\].
    pub time: f64,
    /// Vertex positions \[m\].
    pub positions: Vec<Vector3<f64>>,
    /// Obstacles where they are then.
    pub obstacles: Vec<Obstacle>,
}

/// Width and height \[px\].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Size {
    /// \[px\]
    pub width: u32,
    /// \[px\]
    pub height: u32,
}

impl Default for Size {
    fn default() -> Self {
        Self {
            width: 1200,
            height: 900,
        }
    }
}

impl Size {
    pub(super) fn check(self) -> Result<Self, DrawError> {
        let Self { width, height } = self;
        let fits = 64..=LARGEST_SIDE;
        match fits.contains(&width) && fits.contains(&height) {
            true => Ok(self),
            false => Err(DrawError::Size { width, height }),
        }
    }
}

/// Finished pixels.
#[derive(Clone, Debug, PartialEq)]
pub struct Picture {
    pub(super) pixmap: Pixmap,
}

impl Picture {
    /// Width and height \[px\].
    pub fn size(&self) -> Size {
        Size {
            width: self.pixmap.width(),
            height: self.pixmap.height(),
        }
    }

    /// Red, green and blue of a pixel; white outside.
    pub fn pixel(&self, x: u32, y: u32) -> [u8; 3] {
        self.pixmap
            .pixel(x, y)
            .map_or([255; 3], |p| [p.red(), p.green(), p.blue()])
    }

    /// The file.
    pub fn png(&self) -> Result<Vec<u8>, DrawError> {
        self.pixmap
            .encode_png()
            .map_err(|e| DrawError::Png(e.to_string()))
    }
}

/// Draws one moment.
pub fn draw(
    subject: &Subject,
    moment: &Moment,
    framing: &Framing,
    size: Size,
) -> Result<Picture, DrawError> {
    let size = size.check()?;
    let (width, height) = (f64::from(size.width), f64::from(size.height));
    let unit = (height / 45.0).min(width / 50.0).max(7.0);
    let mut framing = framing.clone();
    framing
        .camera
        .fit(width, height, [3.0 * unit, 5.0 * unit, 5.0 * unit]);
    let mut pixmap = panel(subject, moment, &framing, size)?;
    let mut labels = Labels::new(width, height, unit);
    labels.title(subject.title, subject.subtitle);
    labels.stamp(width - 1.5 * unit, 2.3 * unit, &time(moment.time));
    labels.scale_bar(&framing.camera, 0.2 * width, spacing(subject));
    labels.axes(&framing.camera, width - 4.2 * unit, height - 3.2 * unit);
    draw_over(&mut pixmap, &labels.svg(), 1.0)?;
    Ok(Picture { pixmap })
}

/// Distance of the thread lines \[m\]: 10 mm on a 200 mm sheet, and a round number near 1/20 on others.
pub(super) fn spacing(subject: &Subject) -> Option<f64> {
    let mut bounds = [[f64::INFINITY; 2], [f64::NEG_INFINITY; 2]];
    for m in subject.material {
        for k in 0..2 {
            bounds[0][k] = bounds[0][k].min(m[k]);
            bounds[1][k] = bounds[1][k].max(m[k]);
        }
    }
    let extent = (bounds[1][0] - bounds[0][0]).max(bounds[1][1] - bounds[0][1]);
    (extent.is_finite() && extent > 0.0).then(|| round_down(extent / 12.0))
}

/// One frame without lettering.
pub(super) fn panel(
    subject: &Subject,
    moment: &Moment,
    framing: &Framing,
    size: Size,
) -> Result<Pixmap, DrawError> {
    check(subject, moment)?;
    let surfaces = surfaces(subject, moment, framing);
    let colours = light(&surfaces, &framing.camera);
    let mut canvas = Canvas::new(size.width as usize, size.height as usize);
    let spacing = spacing(subject);
    // The sheet comes last: what it lies on, lines included, is under it.
    for (surface, colours) in surfaces.iter().zip(&colours) {
        paint(&mut canvas, surface, colours, framing, spacing);
        outline(&mut canvas, surface, &framing.camera);
    }
    let size = IntSize::from_wh(size.width, size.height).ok_or(DrawError::Empty("no pixels"))?;
    Pixmap::from_vec(canvas.resolve(), size).ok_or(DrawError::Empty("no pixels"))
}

fn check(subject: &Subject, moment: &Moment) -> Result<(), DrawError> {
    let vertices = moment.positions.len();
    if vertices == 0 || subject.faces.is_empty() {
        return Err(DrawError::Empty("the sheet has no triangles"));
    }
    for (face, corners) in subject.faces.iter().enumerate() {
        if let Some(&vertex) = corners.iter().find(|v| **v as usize >= vertices) {
            return Err(DrawError::Face {
                face,
                vertex,
                vertices,
            });
        }
    }
    let bad = moment
        .positions
        .iter()
        .position(|p| !p.iter().all(|x| x.is_finite()));
    bad.map_or(Ok(()), |vertex| {
        Err(DrawError::NotFinite {
            vertex,
            time: moment.time,
        })
    })
}

fn surfaces(subject: &Subject, moment: &Moment, framing: &Framing) -> Vec<Surface> {
    let diagonal = framing.diagonal();
    let (foot, radius) = (framing.foot(), 1.0 * diagonal);
    let cell = diagonal / 90.0;
    let mut all = vec![];
    let grounded = moment.obstacles.iter().any(|o| o.shape == Shape::Plane);
    if !grounded && framing.view.elevation > 5.0 {
        let below = foot - Vector3::z() * (2e-3 * diagonal);
        all.push(floor(below, radius, cell));
    }
    for obstacle in &moment.obstacles {
        all.push(solid(obstacle, cell, foot, radius));
    }
    let material = match subject.material.len() == moment.positions.len() {
        true => subject.material,
        false => &[],
    };
    all.push(cloth(
        subject.faces,
        &moment.positions,
        material,
        diagonal / 80.0,
    ));
    all
}

fn paint(
    canvas: &mut Canvas,
    surface: &Surface,
    colours: &[super::picture_light::TwoSided],
    framing: &Framing,
    spacing: Option<f64>,
) {
    // Cloth exactly on a face of an obstacle is seen, not the face.
    let front = match surface.kind {
        Kind::Cloth => Vector3::z() * (2e-4 * framing.diagonal()),
        _ => Vector3::zeros(),
    };
    for face in &surface.faces {
        let at = face.map(|v| v as usize);
        let corners = at.map(|v| framing.camera.project(&surface.points[v]) + front);
        // The picture's y axis points down, so faces towards the viewer run clockwise in it.
        let turn = (corners[1] - corners[0])
            .xy()
            .perp(&(corners[2] - corners[0]).xy());
        let side = usize::from(turn > 0.0);
        let light = at.map(|v| colours[v][side]);
        let weave = spacing
            .filter(|_| !surface.material.is_empty())
            .map(|spacing| Weave {
                material: at.map(|v| surface.material[v]),
                spacing,
            });
        canvas.triangle(corners, light, weave.as_ref());
    }
}

fn outline(canvas: &mut Canvas, surface: &Surface, camera: &Camera) {
    let (width, ink) = match surface.kind {
        Kind::Cloth => (1.3, [0.030, 0.050, 0.085]),
        _ => (1.0, [0.18, 0.18, 0.18]),
    };
    let lift = 1.2 / camera.scale();
    for line in &surface.lines {
        let ends = line.map(|p| camera.project(&p));
        canvas.line(ends, width, lift, ink);
    }
}
