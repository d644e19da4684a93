//! Ranges with units, as they stand in the key table and in messages.

use std::fmt;

/// Closed range of a number. NaN and infinities lie outside every range.
#[derive(Clone, Copy, Debug)]
pub struct Range {
    /// Smallest allowed value.
    pub min: f64,
    /// Largest allowed value.
    pub max: f64,
    /// Unit, empty for a ratio.
    pub unit: &'static str,
}

/// A range from `min` to `max`.
pub(super) const fn range(min: f64, max: f64, unit: &'static str) -> Range {
    Range { min, max, unit }
}

impl Range {
    /// Whether a value lies in the range, ends included.
    pub fn contains(&self, value: f64) -> bool {
        value >= self.min && value <= self.max
    }
}

impl fmt::Display for Range {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "from {} to {}", short(self.min), short(self.max))?;
        match self.unit {
            "" => Ok(()),
            unit => write!(f, " {unit}"),
        }
    }
}

/// A number the way a person would write it: `0.005`, `1e-7`, `1e12`.
pub(super) fn short(value: f64) -> String {
    let magnitude = value.abs();
    if value == 0.0 || (1e-4..1e6).contains(&magnitude) {
        format!("{value}")
    } else {
        format!("{value:e}")
    }
}
