//! A run goes on from a kept state with the same bits, or is refused.

use nalgebra::Vector3;
use toile::scene::Scheme;
use toile::sim::{Mismatch, Simulation, State};

use crate::commands::{add, plate, run, sheet, slide};
use crate::lab::simulation;

/// The sheet sticks to a plate that slides and rises, under another that comes down.
fn on_a_sliding_plate(scheme: Scheme) -> Simulation {
    let mut simulation = simulation(&sheet(scheme, &["damping=5.0"]));
    add(&mut simulation, plate("low", -2.45e-4, 0.5));
    add(&mut simulation, plate("high", 0.05, 0.5));
    slide(&mut simulation, "low", Vector3::new(0.05, 0.0, 0.005));
    slide(&mut simulation, "high", Vector3::new(0.0, 0.0, -0.1));
    run(&mut simulation, 0.03);
    simulation
}

/// A new simulation goes on from a kept state as if nothing had been: with bonds that stick, a moving obstacle,
/// and the scheme's memory of the step before.
#[test]
fn a_resumed_run_has_the_same_bits() {
    for scheme in Scheme::IN_TIME {
        let mut whole = on_a_sliding_plate(scheme);
        let scene = whole.model().scene.clone();
        let kept = whole.state().clone();
        let (report, bonds) = (whole.report(), kept.bonds.len());
        // The explicit scheme has no bonds.
        let sticks = bonds > 0 || scheme == Scheme::CentralDifference;
        assert!(report.contacts > 0 && sticks, "{scheme:?}: nothing sticks");
        let mut resumed = simulation(&scene);
        resumed.resume(kept).unwrap();
        for _ in 0..10 {
            let expected = whole.step().unwrap();
            assert_eq!(resumed.step().unwrap(), expected, "{scheme:?}");
        }
    }
}

#[test]
fn a_state_that_does_not_fit_is_refused() {
    let mut simulation = on_a_sliding_plate(Scheme::Bdf2);
    let good = simulation.state().clone();
    let digest = good.digest();
    let mut refused = |part: &str, change: &dyn Fn(&mut State)| {
        let mut state = good.clone();
        change(&mut state);
        let message = simulation.resume(state).unwrap_err().to_string();
        assert!(message.contains(part), "`{part}` is not in: {message}");
        assert!(!message.contains('\n'), "{message:?} is not one line");
        assert_eq!(simulation.state().digest(), digest, "{message}");
    };
    refused("positions has", &|s| s.positions.truncate(5));
    refused("history.velocities has 0", &|s| {
        s.history.velocities.clear()
    });
    refused("slopes holds a value", &|s| s.slopes[3].y = f64::NAN);
    refused("history.dt holds", &|s| s.history.dt = f64::INFINITY);
    refused("from 0 to 10", &|s| s.obstacles[0].friction = 11.0);
    refused("obstacles is out of order", &|s| {
        let first = s.obstacles[0].clone();
        s.obstacles.push(first);
    });
    refused("bonds is out of order", &|s| s.obstacles.clear());
    let mut other = crate::lab::simulation(&sheet(Scheme::Bdf2, &["accept=[]"]));
    assert_eq!(other.resume(good), Err(Mismatch::NoContact));
}
