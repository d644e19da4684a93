//! Textile units, converted to SI at the border and nowhere else.

/// Areal density: g/m² to kg/m².
pub const fn grams_per_square_metre(value: f64) -> f64 {
    value * 1e-3
}

/// Modulus: MPa to Pa.
pub const fn megapascals(value: f64) -> f64 {
    value * 1e6
}

/// Flexural rigidity: µN·m (per unit width µN·m²/m) to N·m.
pub const fn micronewton_metres(value: f64) -> f64 {
    value * 1e-6
}

/// Length: mm to m.
pub const fn millimetres(value: f64) -> f64 {
    value * 1e-3
}
