//! Plane geometry of outlines, as far as checking a scene needs it.

use crate::sheet::Outline;

/// Area \[m²\].
pub(super) fn area(outline: &Outline) -> f64 {
    let disc = |diameter: f64| 0.25 * std::f64::consts::PI * diameter * diameter;
    match *outline {
        Outline::Rectangle { length, width } => length * width,
        Outline::Disc { diameter } => disc(diameter),
        Outline::Annulus { outer, inner } => disc(outer) - disc(inner),
    }
}

/// Half the extent along sheet x and y \[m\].
pub(super) fn half_extent(outline: &Outline) -> [f64; 2] {
    match *outline {
        Outline::Rectangle { length, width } => [0.5 * length, 0.5 * width],
        Outline::Disc { diameter } => [0.5 * diameter; 2],
        Outline::Annulus { outer, .. } => [0.5 * outer; 2],
    }
}

/// Whether a point of the sheet's x, y lies on the sheet, its rim included.
pub(super) fn contains(outline: &Outline, [x, y]: [f64; 2]) -> bool {
    // Rounding must not push a corner off its own sheet.
    let slack = 1e-9;
    let [half_x, half_y] = half_extent(outline);
    let radius = x.hypot(y);
    match *outline {
        Outline::Rectangle { .. } => x.abs() <= half_x + slack && y.abs() <= half_y + slack,
        Outline::Disc { .. } => radius <= half_x + slack,
        Outline::Annulus { inner, .. } => radius <= half_x + slack && radius >= 0.5 * inner - slack,
    }
}

/// Edge length of equilateral triangles, that many of which have the area of the outline \[m\].
pub(super) fn equilateral_edge(outline: &Outline, triangles: f64) -> f64 {
    (4.0 * area(outline) / (3.0_f64.sqrt() * triangles)).sqrt()
}
