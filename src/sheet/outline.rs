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
        }
    }

    /// Half the extent along x and y \[m\].
    pub fn half_extent(&self) -> Vector2<f64> {
        match *self {
            Self::Rectangle { length, width } => Vector2::new(0.5 * length, 0.5 * width),
            Self::Disc { diameter } => Vector2::repeat(0.5 * diameter),
            Self::Annulus { outer, .. } => Vector2::repeat(0.5 * outer),
        }
    }

    /// Area \[m²\].
    pub fn area(&self) -> f64 {
        use std::f64::consts::FRAC_PI_4;
        match *self {
            Self::Rectangle { length, width } => length * width,
            Self::Disc { diameter } => FRAC_PI_4 * diameter * diameter,
            Self::Annulus { outer, inner } => FRAC_PI_4 * (outer * outer - inner * inner),
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
