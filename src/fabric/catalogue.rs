//! The twelve fabrics of Hedfi, Ghith, BelHadjSalah, J. Textile Institute 102:8 (2011), Tables 1 and 2.

use super::law::{Fabric, PoissonCoupling, TwistRigidity};
use super::units::{grams_per_square_metre, megapascals, micronewton_metres, millimetres};

/// One row of Table 2 in the paper's own units.
struct Row {
    name: &'static str,
    /// E_wp, E_wt, H \[MPa\].
    moduli: [f64; 3],
    /// nu_wp, nu_wt \[-\].
    poisson: [f64; 2],
    /// Rf_wp, Rf_wt \[µN·m\].
    rigidities: [f64; 2],
    /// Areal density \[g/m²\].
    areal_density: f64,
    /// Thickness \[mm\].
    thickness: f64,
}

const fn row(
    name: &'static str,
    moduli: [f64; 3],
    poisson: [f64; 2],
    rigidities: [f64; 2],
    areal_density: f64,
    thickness: f64,
) -> Row {
    Row {
        name,
        moduli,
        poisson,
        rigidities,
        areal_density,
        thickness,
    }
}

/// Table 2. Weaves and fibres (Table 1): F1-F4 plain, F5-F8 twill, F9-F12 satin; in each group cotton/cotton,
/// cotton/polyester, polyester/cotton, polyester/polyester (warp/weft).
const TABLE_2: [Row; 12] = [
    row(
        "F1",
        [6.33, 2.55, 1.82],
        [0.3, 0.4],
        [25.21, 33.46],
        198.0,
        0.49,
    ),
    row(
        "F2",
        [7.30, 2.39, 1.99],
        [0.3, 0.4],
        [21.59, 20.40],
        203.0,
        0.46,
    ),
    row(
        "F3",
        [6.41, 3.17, 1.89],
        [0.3, 0.4],
        [21.36, 17.99],
        200.0,
        0.48,
    ),
    row(
        "F4",
        [7.56, 4.15, 2.05],
        [0.3, 0.3],
        [12.56, 16.45],
        179.0,
        0.43,
    ),
    row(
        "F5",
        [2.47, 1.67, 1.22],
        [0.3, 0.4],
        [11.38, 11.06],
        187.0,
        0.47,
    ),
    row(
        "F6",
        [4.34, 1.14, 1.62],
        [0.3, 0.3],
        [6.80, 10.0],
        189.0,
        0.57,
    ),
    row(
        "F7",
        [1.79, 2.26, 1.20],
        [0.4, 0.3],
        [7.26, 5.93],
        191.0,
        0.62,
    ),
    row(
        "F8",
        [3.36, 2.03, 1.35],
        [0.3, 0.4],
        [8.28, 8.66],
        188.0,
        0.58,
    ),
    row(
        "F9",
        [2.00, 1.29, 1.15],
        [0.4, 0.4],
        [5.93, 6.98],
        188.0,
        0.62,
    ),
    row(
        "F10",
        [5.59, 1.45, 1.82],
        [0.3, 0.4],
        [10.53, 6.62],
        184.0,
        0.57,
    ),
    row(
        "F11",
        [2.21, 2.29, 1.25],
        [0.3, 0.3],
        [6.07, 8.16],
        186.0,
        0.68,
    ),
    row(
        "F12",
        [4.76, 2.03, 1.49],
        [0.3, 0.3],
        [9.74, 9.05],
        187.0,
        0.58,
    ),
];

impl Row {
    fn fabric(&self) -> Fabric {
        Fabric {
            name: self.name.to_string(),
            areal_density: grams_per_square_metre(self.areal_density),
            thickness: millimetres(self.thickness),
            young_warp: megapascals(self.moduli[0]),
            young_weft: megapascals(self.moduli[1]),
            shear_modulus: megapascals(self.moduli[2]),
            rigidity_warp: micronewton_metres(self.rigidities[0]),
            rigidity_weft: micronewton_metres(self.rigidities[1]),
            poisson_warp: self.poisson[0],
            poisson_weft: self.poisson[1],
            twist: TwistRigidity::default(),
            poisson: PoissonCoupling::default(),
        }
    }
}

/// The catalogue in the paper's order.
pub fn catalogue() -> Vec<Fabric> {
    TABLE_2.iter().map(Row::fabric).collect()
}

/// A fabric of the catalogue by name, `F1` to `F12` (case does not matter).
pub fn find(name: &str) -> Option<Fabric> {
    TABLE_2
        .iter()
        .find(|row| row.name.eq_ignore_ascii_case(name))
        .map(Row::fabric)
}
