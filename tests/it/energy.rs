//! The energy ledger closes: what a scheme does not conserve, it must only lose.

use toile::sim::{Energies, Simulation};

use crate::lab::{built_in, simulation};

/// All that the ledger holds: constant if the scheme and the solver are exact \[J\].
fn total(e: &Energies) -> f64 {
    e.kinetic + e.stretch + e.bend + e.gravity + e.contact + e.damping + e.friction
        - e.supports
        - e.air
}

/// Steps to the end; drift of the ledger after each step over the largest kinetic energy so far.
fn drifts(simulation: &mut Simulation, steps: u64) -> Vec<f64> {
    let start = total(&simulation.report().energies);
    let (mut scale, mut drifts) = (0.0f64, vec![]);
    for _ in 0..steps {
        let energies = simulation.step().unwrap().energies;
        scale = scale.max(energies.kinetic);
        drifts.push(total(&energies) - start);
    }
    drifts.iter().map(|d| d / scale).collect()
}

fn extremes(values: &[f64]) -> [f64; 2] {
    let fold = |f: fn(f64, f64) -> f64| values.iter().fold(0.0, |m, &v| f(m, v));
    [fold(f64::min), fold(f64::max)]
}

/// Released strip, 0.2 s: the largest gain and loss of each scheme over the kinetic energy, with and without
/// viscous damping, whose share the ledger counts by the trapezoidal rule.
#[test]
fn energy_of_the_released_strip() {
    for damping in ["0.0", "0.5"] {
        for (scheme, dt, loss, gain) in [
            ("generalised-alpha", 2.5e-4, 1e-3, 1e-3),
            ("backward-euler", 1e-3, 1.0, 1e-6),
            ("bdf2", 1e-3, 5e-2, 1e-3),
            ("central-difference", 1e-3, 1e-3, 1e-3),
        ] {
            let scene = built_in(
                "strip-release",
                &[
                    &format!("method.scheme={scheme}"),
                    &format!("method.dt={dt}"),
                    &format!("damping={damping}"),
                    "duration=0.2",
                    "sheet.triangles=100",
                    "method.rho_infinity=1.0",
                    "method.tolerance=1e-8",
                ],
            );
            let drifts = drifts(&mut simulation(&scene), scene.steps());
            let [low, high] = extremes(&drifts);
            println!(
                "{scheme}, dt {dt}, damping {damping}: ledger from {low:.1e} to {high:.1e} of the kinetic energy"
            );
            assert!(high < gain, "{scheme}, damping {damping}: gains {high:e}");
            assert!(low > -loss, "{scheme}, damping {damping}: loses {low:e}");
            if scheme == "backward-euler" {
                let rises = drifts.windows(2).map(|w| w[1] - w[0]);
                let most = rises.fold(f64::MIN, f64::max);
                assert!(most < 1e-5, "backward Euler gains {most:e} in a step");
            }
        }
    }
}

/// A small drape over the table: contact and friction are in the ledger. BDF2 gains at contact onset what its
/// memory of the velocity before it carries, 0.6 % of the kinetic energy where it was measured (300 triangles, 0.1 s).
#[test]
fn energy_of_a_drape_never_grows() {
    for (scheme, gain) in [("bdf2", 2e-2), ("central-difference", 2e-2)] {
        let scene = built_in(
            "drape-table",
            &[
                &format!("method.scheme={scheme}"),
                "method.dt=1e-3",
                "sheet.triangles=100",
                "duration=0.05",
            ],
        );
        let drifts = drifts(&mut simulation(&scene), scene.steps());
        let [low, high] = extremes(&drifts);
        println!("drape, {scheme}: ledger from {low:.1e} to {high:.1e} of the kinetic energy");
        assert!(high < gain, "{scheme}: gains {high:e}");
        assert!(low > -0.5, "{scheme}: loses {low:e}");
    }
}
