//! The outline of a flat sheet.

use nalgebra::Vector2;
use serde::{Deserialize, Serialize};

/// Outline of the flat sheet in material coordinates, centred on the origin unless said; metres.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(tag = "kind", rename_all = "kebab-case", deny_unknown_fields)]
pub enum Outline {
    /// A rectangle, `length` along sheet x and `width` along sheet y (a strip is a narrow one).
    Rectangle {
        /// Extent along sheet x \[m\].
        length: f64,
        /// Extent along sheet y \[m\].
        width: f64,
    },
    /// A disc.
    Disc {
        /// Diameter \[m\].
        diameter: f64,
    },
    /// A ring.
    Annulus {
        /// Outer diameter \[m\].
        outer: f64,
        /// Inner diameter \[m\].
        inner: f64,
    },
    /// A part of a ring, from sheet x counter-clockwise: what a flared skirt is cut from.
    Sector {
        /// Outer diameter \[m\].
        outer: f64,
        /// Inner diameter \[m\].
        inner: f64,
        /// Angle between its two straight sides, up to 359.9 \[degrees\].
        angle: f64,
    },
}

impl Outline {
    /// Distance from an inner point to the boundary, negative outside \[m\].
    pub fn depth(&self, p: &Vector2<f64>) -> f64 {
        match *self {
            Self::Rectangle { length, width } => {
                (0.5 * length - p.x.abs()).min(0.5 * width - p.y.abs())
            }
            Self::Disc { diameter } => 0.5 * diameter - p.norm(),
            Self::Annulus { outer, inner } => (0.5 * outer - p.norm()).min(p.norm() - 0.5 * inner),
            Self::Sector {
                outer,
                inner,
                angle,
            } => (0.5 * outer - p.norm())
                .min(p.norm() - 0.5 * inner)
                .min(between_sides(p, angle.to_radians())),
        }
    }

    /// Half the extent along x and y \[m\].
    pub fn half_extent(&self) -> Vector2<f64> {
        match *self {
            Self::Rectangle { length, width } => Vector2::new(0.5 * length, 0.5 * width),
            Self::Disc { diameter } => Vector2::repeat(0.5 * diameter),
            Self::Annulus { outer, .. } | Self::Sector { outer, .. } => {
                Vector2::repeat(0.5 * outer)
            }
        }
    }

    /// Area \[m²\].
    pub fn area(&self) -> f64 {
        use std::f64::consts::FRAC_PI_4;
        match *self {
            Self::Rectangle { length, width } => length * width,
            Self::Disc { diameter } => FRAC_PI_4 * diameter * diameter,
            Self::Annulus { outer, inner } => FRAC_PI_4 * (outer * outer - inner * inner),
            Self::Sector {
                outer,
                inner,
                angle,
            } => angle / 360.0 * FRAC_PI_4 * (outer * outer - inner * inner),
        }
    }

    /// Whether a point lies on the sheet, its rim included.
    pub fn contains(&self, at: &[f64; 2]) -> bool {
        // Rounding must not push a corner off its own sheet.
        self.depth(&Vector2::from(*at)) >= -1e-9
    }

    /// Edge length of equilateral triangles, that many of which have the area of the outline \[m\].
    pub fn equilateral_edge(&self, triangles: f64) -> f64 {
        (4.0 * self.area() / (3f64.sqrt() * triangles)).sqrt()
    }
}

/// Distance to the nearer of two rays from the origin, along x and `angle` from there \[rad\]; negative outside.
fn between_sides(p: &Vector2<f64>, angle: f64) -> f64 {
    let to_ray = |at: f64| {
        let along = Vector2::new(at.cos(), at.sin());
        match along.dot(p) > 0.0 {
            true => along.perp(p).abs(),
            false => p.norm(),
        }
    };
    let distance = to_ray(0.0).min(to_ray(angle));
    let at = p.y.atan2(p.x).rem_euclid(std::f64::consts::TAU);
    if at <= angle { distance } else { -distance }
}
