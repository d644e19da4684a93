use super::{Fabric, PoissonCoupling, TwistRigidity, catalogue, find};

/// The paper's Table 2 as typed in by someone else.
const TABLE_2: &str = include_str!("../../tests/references/paper_table2_properties.csv");
const TABLE_1: &str = include_str!("../../tests/references/paper_table1_construction.csv");

fn rows() -> Vec<(String, Vec<f64>)> {
    let row = |line: &str| {
        let mut cells = line.split(',');
        let name = cells.next().unwrap().to_string();
        (name, cells.map(|cell| cell.parse().unwrap()).collect())
    };
    TABLE_2.lines().skip(1).map(row).collect()
}

fn close(a: f64, b: f64) {
    assert!((a / b - 1.0).abs() < 1e-12, "{a} is not {b}");
}

#[test]
fn the_catalogue_is_table_2_in_si() {
    let (rows, fabrics) = (rows(), catalogue());
    assert_eq!((rows.len(), fabrics.len()), (12, 12));
    for ((name, row), fabric) in rows.iter().zip(&fabrics) {
        assert_eq!(name, &fabric.name);
        let [e_wp, nu_wp, rf_wp, e_wt, nu_wt, rf_wt, _, h, rho, thickness] = row[..] else {
            panic!("{name} has {} columns", row.len());
        };
        close(fabric.young_warp, e_wp * 1e6);
        close(fabric.young_weft, e_wt * 1e6);
        close(fabric.shear_modulus, h * 1e6);
        close(fabric.rigidity_warp, rf_wp * 1e-6);
        close(fabric.rigidity_weft, rf_wt * 1e-6);
        close(fabric.areal_density, rho * 1e-3);
        close(fabric.thickness, thickness * 1e-3);
        close(fabric.poisson_warp, nu_wp);
        close(fabric.poisson_weft, nu_wt);
        fabric.check().unwrap();
    }
}

/// Table 1 gives weaves in groups of four, by which the catalogue is documented.
#[test]
fn the_catalogue_is_ordered_as_table_1() {
    let names: Vec<_> = TABLE_1
        .lines()
        .skip(1)
        .map(|l| l.split(',').next().unwrap())
        .collect();
    let ours: Vec<_> = catalogue().into_iter().map(|f| f.name).collect();
    assert_eq!(names, ours);
    let weaves: Vec<_> = TABLE_1
        .lines()
        .skip(1)
        .map(|l| l.split(',').nth(1).unwrap())
        .collect();
    assert_eq!(
        [weaves[0], weaves[4], weaves[8]],
        ["plain", "twill", "satin"]
    );
}

/// Modulus in tension at 45 degrees, from the inverse of C: 1/E45 = (S11 + S22 + 2 S12 + S66)/4 per thickness.
fn bias_modulus(fabric: &Fabric) -> f64 {
    let s = fabric.membrane().matrix().try_inverse().unwrap();
    4.0 / (s.m11 + s.m22 + 2.0 * s.m12 + s.m33) / fabric.thickness
}

/// With `symmetrised` the bias modulus that the paper measured comes back; H is printed to 0.01 MPa, which is
/// 0.5 % of it and leaves at most that in the bias modulus. Without it the model is 13 to 24 % low.
#[test]
fn poisson_symmetrised_gives_the_bias_modulus_back() {
    for ((name, row), mut fabric) in rows().into_iter().zip(catalogue()) {
        let measured = row[6] * 1e6;
        let without = bias_modulus(&fabric) / measured - 1.0;
        fabric.poisson = PoissonCoupling::Symmetrised;
        let with = bias_modulus(&fabric) / measured - 1.0;
        assert!(with.abs() < 5e-3, "{name}: bias modulus off by {with:e}");
        assert!((-0.25..-0.10).contains(&without), "{name}: {without}");
        let moduli = [fabric.young_warp, fabric.young_weft];
        let s = fabric.membrane().matrix().try_inverse().unwrap();
        close(1.0 / s.m11 / fabric.thickness, moduli[0]);
        close(1.0 / s.m22 / fabric.thickness, moduli[1]);
    }
}

#[test]
fn twist_is_geometric_or_none() {
    let mut fabric = find("f1").unwrap();
    let d = fabric.bending();
    close(d.c11, 25.21e-6);
    close(4.0 * d.c66, 2.0 * (25.21e-6f64 * 33.46e-6).sqrt());
    fabric.twist = TwistRigidity::None;
    assert_eq!(fabric.bending().c66, 0.0);
    assert!(find("F13").is_none());
}

/// A change that no cloth can have, the field it spoils, and how the refusal begins.
#[test]
fn the_unphysical_is_refused_by_name() {
    type Spoil = fn(&mut Fabric, f64);
    let fields: [(&str, Spoil); 7] = [
        ("areal_density", |f, x| f.areal_density = x),
        ("thickness", |f, x| f.thickness = x),
        ("young_warp", |f, x| f.young_warp = x),
        ("young_weft", |f, x| f.young_weft = x),
        ("shear_modulus", |f, x| f.shear_modulus = x),
        ("rigidity_warp", |f, x| f.rigidity_warp = x),
        ("rigidity_weft", |f, x| f.rigidity_weft = x),
    ];
    for (name, spoil) in fields {
        for value in [0.0, -1.0, f64::NAN, f64::INFINITY] {
            let mut fabric = find("F1").unwrap();
            spoil(&mut fabric, value);
            let refusal = fabric.check().unwrap_err();
            assert_eq!(refusal.field, name);
            assert!(
                refusal.to_string().contains("finite and positive"),
                "{refusal}"
            );
        }
    }
    let mut fabric = find("F1").unwrap();
    fabric.poisson_weft = -0.1;
    assert_eq!(fabric.check().unwrap_err().field, "poisson_weft");
    fabric.poisson_weft = 4.0;
    fabric
        .check()
        .expect("the ratio is not used without coupling");
    fabric.poisson = PoissonCoupling::Symmetrised;
    let refusal = fabric.check().unwrap_err();
    assert!(
        refusal.to_string().contains("not positive definite"),
        "{refusal}"
    );
}
