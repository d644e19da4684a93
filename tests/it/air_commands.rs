//! Air commands: that the state holds the flow, what is refused, and what a scene accepts.

use nalgebra::Vector3;
use toile::scene::{Scene, Scheme};
use toile::sim::{AirRegion, Airflow, Command, Mismatch, Simulation};

use crate::air::{blow, in_air, wind};
use crate::lab::{built_in, simulation};

fn windy(scheme: Scheme, set: &[&str]) -> Scene {
    let mut all = vec![
        "gravity=[0, 0, -9.81]",
        "air.velocity=[2, 0, 1]",
        "air.rise=0.05",
        "air.start=0.01",
        "method.dt=2e-3",
    ];
    all.extend(set);
    in_air(scheme, &all)
}

fn script(simulation: &mut Simulation) -> Vec<u64> {
    let mut digests = vec![];
    for step in 0..30 {
        match step {
            12 => blow(
                simulation,
                Airflow {
                    rise: 0.04,
                    ..wind([0.0, 3.0, 0.0])
                },
            ),
            20 => blow(
                simulation,
                Airflow {
                    hold: Some(0.01),
                    rise: 0.005,
                    ..wind([0.0, 0.0, 4.0])
                },
            ),
            _ => {}
        }
        digests.push(simulation.step().unwrap().digest);
    }
    digests
}

#[test]
fn the_same_bits_in_air_for_any_number_of_threads() {
    for scheme in Scheme::IN_TIME {
        let scene = windy(scheme, &["sheet.triangles=700"]);
        let digests = |threads| script(&mut Simulation::new(&scene, threads).unwrap());
        assert_eq!(digests(1), digests(2), "{scheme:?}");
    }
}

/// In the middle of a ramp: the state holds the flow and when it began.
#[test]
fn a_resumed_run_and_a_reset_one_have_the_same_wind() {
    for scheme in Scheme::IN_TIME {
        let scene = windy(scheme, &[]);
        let mut whole = simulation(&scene);
        for _ in 0..15 {
            whole.step().unwrap();
        }
        blow(
            &mut whole,
            Airflow {
                rise: 0.05,
                ..wind([-2.0, 0.0, 3.0])
            },
        );
        whole.step().unwrap();
        let mut resumed = simulation(&scene);
        resumed.resume(whole.state().clone()).unwrap();
        for _ in 0..10 {
            assert_eq!(resumed.step().unwrap(), whole.step().unwrap(), "{scheme:?}");
        }
        let mut fresh = simulation(&scene);
        let first = script(&mut fresh);
        let kept = fresh.state().clone();
        fresh.apply(&Command::Reset).unwrap();
        assert_ne!(script(&mut fresh), first, "the digest holds the step");
        let mut again = fresh.state().clone();
        again.step = kept.step;
        again.air.since = kept.air.since;
        again.began = kept.began;
        assert_eq!(again.digest(), kept.digest(), "{scheme:?}");
        assert_eq!(again.positions, kept.positions, "{scheme:?}");
    }
}

#[test]
fn a_rejected_wind_changes_nothing() {
    let mut simulation = simulation(&windy(Scheme::Bdf2, &[]));
    simulation.step().unwrap();
    let digest = simulation.state().digest();
    let region = |min: [f64; 3]| {
        Some(AirRegion {
            min: min.into(),
            max: Vector3::repeat(0.1),
        })
    };
    let still = || wind([0.0; 3]);
    for (flow, parts) in [
        (
            wind([0.0, f64::NAN, 0.0]),
            ["velocity.y = NaN", "from -200 to 200 m/s"],
        ),
        (wind([0.0, 0.0, 201.0]), ["velocity.z = 2.01e2", "m/s"]),
        (
            Airflow {
                fluid_damping: Some(-1.0),
                ..still()
            },
            ["fluid_damping = -1e0", "kg/(m²·s)"],
        ),
        (
            Airflow {
                rise: -0.1,
                ..still()
            },
            ["rise = -1e-1", "from 0 to 100000 s"],
        ),
        (
            Airflow {
                hold: Some(f64::INFINITY),
                ..still()
            },
            ["hold = inf", "s"],
        ),
        (
            Airflow {
                region: region([0.0, 0.1, 0.0]),
                ..still()
            },
            ["region.min.y = 1e-1", "less than region.max.y"],
        ),
        (
            Airflow {
                region: region([-1e9, 0.0, 0.0]),
                ..still()
            },
            ["region.min.x = -1e9", "from -1000 to 1000 m"],
        ),
    ] {
        let message = simulation
            .apply(&Command::Blow(flow))
            .unwrap_err()
            .to_string();
        for part in parts {
            assert!(message.contains(part), "`{part}` is not in: {message}");
        }
        assert_eq!(simulation.state().digest(), digest, "{message}");
    }
}

/// A scene without air takes none, unless it says that it accepts it; C has to come from somewhere.
#[test]
fn what_air_a_scene_accepts() {
    let coarse = "sheet.triangles=20";
    let message = |set: &[&str], flow: Airflow| {
        let result = simulation(&built_in("free-fall", set)).apply(&Command::Blow(flow));
        result.map_or_else(|e| e.to_string(), |()| "taken".into())
    };
    let with = Airflow {
        fluid_damping: Some(1.0),
        ..wind([1.0; 3])
    };
    let refused = "the scene does not accept air commands; add \"air\" to its key accept";
    assert_eq!(message(&[coarse], with.clone()), refused);
    assert_eq!(
        message(&[coarse, "accept=[\"obstacles\"]"], with.clone()),
        refused
    );
    assert_eq!(
        message(&[coarse, "accept=[\"air\"]"], with.clone()),
        "taken"
    );
    let none = message(&[coarse, "accept=[\"air\"]"], wind([1.0; 3]));
    assert!(
        none.starts_with("fluid_damping = none is out of range: the air has none yet"),
        "{none}"
    );
    assert_eq!(
        message(&[coarse, "air.fluid_damping=1"], wind([1.0; 3])),
        "taken"
    );
    assert_eq!(
        message(&[coarse, "air.fluid_damping=1", "accept=[]"], with),
        refused
    );
    let windy = simulation(&built_in("free-fall", &[coarse, "air.fluid_damping=1"]));
    let mut calm = simulation(&built_in("free-fall", &[coarse]));
    assert_eq!(calm.resume(windy.state().clone()), Err(Mismatch::NoAir));
}
