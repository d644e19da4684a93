//! The outline of a flat sheet.

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
