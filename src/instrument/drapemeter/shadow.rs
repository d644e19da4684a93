//! The shadow of a draped disc in light from straight above.

use std::f64::consts::{PI, TAU};

use nalgebra::{Vector2, Vector3};

use crate::sheet::Mesh;

/// Directions in which the outline is read.
pub const DIRECTIONS: usize = 720;
/// Rays of (21).
pub const RAYS: usize = 16;

/// Outline about the plate's axis: how far the cloth reaches in each direction. Where a fold hides another, the
/// farther one counts, as in a shadow.
#[derive(Clone, Debug, PartialEq)]
pub struct Shadow {
    /// Radius in each of [`DIRECTIONS`] directions, the first along x \[m\].
    pub radii: Vec<f64>,
}

impl Shadow {
    /// Casts the shadow of a sheet.
    pub fn of(mesh: &Mesh, positions: &[Vector3<f64>]) -> Self {
        let mut radii = vec![0.0; DIRECTIONS];
        for ends in &mesh.edges {
            let [a, b] = ends.map(|v| positions[v as usize].xy());
            cross(&a, &b, &mut radii);
        }
        Self { radii }
    }

    /// Angle of a direction \[rad\].
    pub fn angle(direction: usize) -> f64 {
        TAU * direction as f64 / DIRECTIONS as f64
    }

    /// Place of the outline in a direction \[m\].
    pub fn place(&self, direction: usize) -> Vector2<f64> {
        let (sin, cos) = Self::angle(direction).sin_cos();
        Vector2::new(cos, sin) * self.radii[direction]
    }

    /// Share of the ring beyond the plate that lies in the shadow, by its area.
    pub fn coefficient(&self, plate: f64, rim: f64) -> f64 {
        let turn = TAU / DIRECTIONS as f64;
        let sector = |k: usize| self.radii[k] * self.radii[(k + 1) % DIRECTIONS];
        let area = 0.5 * turn.sin() * (0..DIRECTIONS).map(sector).sum::<f64>();
        // A polygon of chords is a little less than the circle through its corners.
        let circle = 0.5 * turn.sin() * DIRECTIONS as f64 / PI;
        (area / circle - PI * plate * plate) / (PI * (rim * rim - plate * plate))
    }

    /// The same from [`RAYS`] radii, (21).
    pub fn coefficient_by_rays(&self, plate: f64, rim: f64) -> f64 {
        let rays = self.radii.iter().step_by(DIRECTIONS / RAYS);
        let square = rays.map(|r| r * r).sum::<f64>() / RAYS as f64;
        (square - plate * plate) / (rim * rim - plate * plate)
    }
}

/// Raises the radii in the directions that a segment spans to where it is.
fn cross(a: &Vector2<f64>, b: &Vector2<f64>, radii: &mut [f64]) {
    let turn = TAU / DIRECTIONS as f64;
    let from = a.y.atan2(a.x);
    let span = a.perp(b).atan2(a.dot(b));
    let (low, high) = match span >= 0.0 {
        true => (from, from + span),
        false => (from + span, from),
    };
    let (first, last) = ((low / turn).ceil() as i64, (high / turn).floor() as i64);
    let along = b - a;
    for k in first..=last {
        let direction = k.rem_euclid(DIRECTIONS as i64) as usize;
        let (sin, cos) = Shadow::angle(direction).sin_cos();
        let across = Vector2::new(cos, sin).perp(&along);
        // A segment along the ray: its neighbours reach as far.
        if across != 0.0 {
            let radius = a.perp(&along) / across;
            radii[direction] = radii[direction].max(radius);
        }
    }
}
