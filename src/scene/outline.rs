//! The outline of the flat sheet, and its plane geometry.

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
    /// Area \[m²\].
    pub fn area(&self) -> f64 {
        let disc = |diameter: f64| 0.25 * std::f64::consts::PI * diameter * diameter;
        match *self {
            Outline::Rectangle { length, width } => length * width,
            Outline::Disc { diameter } => disc(diameter),
            Outline::Annulus { outer, inner } => disc(outer) - disc(inner),
        }
    }

    /// Half the extent along sheet x and y \[m\].
    pub fn half_extent(&self) -> [f64; 2] {
        match *self {
            Outline::Rectangle { length, width } => [0.5 * length, 0.5 * width],
            Outline::Disc { diameter } => [0.5 * diameter; 2],
            Outline::Annulus { outer, .. } => [0.5 * outer; 2],
        }
    }

    /// Whether a point of the sheet's x, y lies on the sheet, its rim included.
    pub fn contains(&self, [x, y]: [f64; 2]) -> bool {
        // Rounding must not push a corner off its own sheet.
        let slack = 1e-9;
        let [half_x, half_y] = self.half_extent();
        let radius = x.hypot(y);
        match *self {
            Outline::Rectangle { .. } => x.abs() <= half_x + slack && y.abs() <= half_y + slack,
            Outline::Disc { .. } => radius <= half_x + slack,
            Outline::Annulus { inner, .. } => {
                radius <= half_x + slack && radius >= 0.5 * inner - slack
            }
        }
    }

    /// Edge length of equilateral triangles, that many of which cover the outline \[m\].
    pub fn edge_for(&self, triangles: f64) -> f64 {
        (4.0 * self.area() / (3.0_f64.sqrt() * triangles)).sqrt()
    }
}
