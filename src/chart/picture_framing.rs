//! From where a picture is seen, and how much of the world it holds.

use nalgebra::Vector3;

use super::picture::Moment;
use super::picture_camera::Camera;
use super::picture_solids::solid;
use crate::contact::Shape;

/// Direction from which a scene is looked at.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct View {
    /// Direction of the viewer about z, from x \[degrees\].
    pub azimuth: f64,
    /// Height of the viewer over the horizon \[degrees\].
    pub elevation: f64,
}

impl Default for View {
    fn default() -> Self {
        Self {
            azimuth: -58.0,
            elevation: 24.0,
        }
    }
}

/// The camera and all that it must hold: include every moment of a run, and all its pictures match.
#[derive(Clone, Debug)]
pub struct Framing {
    pub(super) view: View,
    pub(super) camera: Camera,
    low: Vector3<f64>,
    high: Vector3<f64>,
}

impl Framing {
    /// A camera that frames nothing yet.
    pub fn new(view: View) -> Self {
        Self {
            view,
            camera: Camera::new(view),
            low: Vector3::repeat(f64::INFINITY),
            high: Vector3::repeat(f64::NEG_INFINITY),
        }
    }

    /// Widens the frame to hold a moment: the sheet, and every obstacle that is not a plane.
    pub fn include(&mut self, moment: &Moment) {
        moment.positions.iter().for_each(|p| self.hold(p));
        for obstacle in moment.obstacles.iter().filter(|o| o.shape != Shape::Plane) {
            let coarse = solid(obstacle, f64::INFINITY, Vector3::zeros(), 0.0);
            coarse.points.iter().for_each(|p| self.hold(p));
        }
    }

    fn hold(&mut self, point: &Vector3<f64>) {
        if point.iter().all(|x| x.is_finite()) {
            self.camera.include(point);
            self.low = self.low.inf(point);
            self.high = self.high.sup(point);
        }
    }

    pub(super) fn diagonal(&self) -> f64 {
        (self.high - self.low).norm().max(1e-6)
    }

    /// Point on the ground under the middle of what is framed.
    pub(super) fn foot(&self) -> Vector3<f64> {
        let middle = 0.5 * (self.low + self.high);
        Vector3::new(middle.x, middle.y, self.low.z)
    }
}
