//! An orthographic camera: equal lengths across the view are equal in the picture, so a scale bar is exact.

use nalgebra::{Vector2, Vector3};

use super::picture_framing::View;

/// Directions of the view and the affine map from world to pixels.
#[derive(Clone, Debug)]
pub(super) struct Camera {
    /// Unit vector to the right of the picture.
    pub right: Vector3<f64>,
    /// Unit vector to the top of the picture.
    pub up: Vector3<f64>,
    /// Unit vector towards the viewer.
    pub toward: Vector3<f64>,
    low: Vector2<f64>,
    high: Vector2<f64>,
    scale: f64,
    offset: Vector2<f64>,
}

impl Camera {
    /// Looks along a view; frames nothing yet.
    pub fn new(view: View) -> Self {
        let (sa, ca) = view.azimuth.to_radians().sin_cos();
        let (se, ce) = view.elevation.to_radians().sin_cos();
        Self {
            right: Vector3::new(-sa, ca, 0.0),
            up: Vector3::new(-se * ca, -se * sa, ce),
            toward: Vector3::new(ce * ca, ce * sa, se),
            low: Vector2::repeat(f64::INFINITY),
            high: Vector2::repeat(f64::NEG_INFINITY),
            scale: 1.0,
            offset: Vector2::zeros(),
        }
    }

    /// Widens the frame to hold a point.
    pub fn include(&mut self, point: &Vector3<f64>) {
        let p = Vector2::new(self.right.dot(point), self.up.dot(point));
        self.low = self.low.inf(&p);
        self.high = self.high.sup(&p);
    }

    /// Width over height of what is framed \[-\].
    pub fn aspect(&self) -> f64 {
        let size = self.size();
        size.x / size.y
    }

    /// Extent of what is framed across the view \[m\]; never zero.
    pub fn size(&self) -> Vector2<f64> {
        let size = self.high - self.low;
        let least = 0.05 * size.max().max(1e-6);
        size.map(|s| s.max(least))
    }

    /// Fits the frame into `width` x `height` pixels less the margins (left and right, top, bottom).
    pub fn fit(&mut self, width: f64, height: f64, margins: [f64; 3]) {
        let [side, top, bottom] = margins;
        let room = Vector2::new(width - 2.0 * side, height - top - bottom);
        let size = self.size();
        self.scale = (room.x / size.x).min(room.y / size.y);
        let middle = 0.5 * (self.low + self.high);
        self.offset = Vector2::new(
            0.5 * width - self.scale * middle.x,
            top + 0.5 * room.y + self.scale * middle.y,
        );
    }

    /// Pixels per metre.
    pub fn scale(&self) -> f64 {
        self.scale
    }

    /// Pixel x, y (y down) and depth \[m\] (larger is nearer) of a world point.
    pub fn project(&self, point: &Vector3<f64>) -> Vector3<f64> {
        Vector3::new(
            self.scale * self.right.dot(point) + self.offset.x,
            -self.scale * self.up.dot(point) + self.offset.y,
            self.toward.dot(point),
        )
    }
}
