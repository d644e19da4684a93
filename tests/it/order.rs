//! Orders in time on the released strip (DESIGN section 3), and against an independent code in space and time.

use crate::lab::{Table, built_in, reading, run, simulation, slopes};

const STRIP: &str = include_str!("../references/strip_release_F1warp_L100_mu0.0.csv");

/// Tip of a coarse released strip at 0.15 s, in full swing \[m\].
fn tip(scheme: &str, dt: f64, extra: &[&str]) -> [f64; 2] {
    let (scheme, dt) = (format!("method.scheme={scheme}"), format!("method.dt={dt}"));
    let mut set = vec![&*scheme, &dt, "duration=0.15", "sheet.triangles=60", "method.tolerance=1e-8"];
    set.extend(extra);
    let simulation = run(&built_in("strip-release", &set));
    ["tip_x", "tip_z"].map(|name| reading(&simulation, name))
}

#[test]
fn order_of_the_schemes_in_time() {
    let exact = tip("bdf2", 0.15 / 6000.0, &[]);
    for (scheme, parts, expected, extra) in [
        ("backward-euler", [600.0, 1200.0, 2400.0], 1.0, vec![]),
        ("bdf2", [150.0, 300.0, 600.0], 2.0, vec![]),
        ("generalised-alpha", [150.0, 300.0, 600.0], 2.0, vec![]),
        ("generalised-alpha", [150.0, 300.0, 600.0], 2.0, vec!["method.rho_infinity=1.0"]),
    ] {
        let steps = parts.map(|n| 0.15 / n);
        let errors = steps.map(|dt| {
            let [x, z] = tip(scheme, dt, &extra);
            (x - exact[0]).hypot(z - exact[1])
        });
        let orders = slopes(&steps, &errors);
        println!("{scheme} {extra:?}: errors {errors:.7?} m at {steps:.6?} s, orders {orders:.2?}");
    }
}

/// The chain code's tip is good to 0.013 mm; what is left is the mesh.
#[test]
fn verify_released_strip_against_an_independent_code() {
    let scene = built_in("strip-release", &["sheet.triangles=1200"]);
    let mut simulation = simulation(&scene);
    let table = Table::new(STRIP);
    let mut rows = table.rows(&[]);
    let mut next = rows.next();
    let mut worst = 0.0f64;
    while let Some(row) = &next {
        simulation.step().unwrap();
        if simulation.report().time < row.get("t_s") - 1e-9 {
            continue;
        }
        let (x, z) = (0.1 + reading(&simulation, "tip_x"), reading(&simulation, "tip_z"));
        let off = (x - row.get("x_tip_m")).hypot(z - row.get("z_tip_m"));
        println!("strip release, t {}: tip ({x:.5}, {z:.5}), off {:.3} mm", row.get("t_s"), 1e3 * off);
        worst = worst.max(off);
        next = rows.next();
    }
}
