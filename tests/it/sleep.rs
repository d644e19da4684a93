//! A sheet at rest sleeps: it costs nothing, stays within its limits, and wakes at whatever moves, with the same bits.

use nalgebra::Vector3;
use toile::scene::{Override, Scheme, library, parse};
use toile::sim::{Command, Simulation, Work};

use crate::air::wind;
use crate::commands::{add, plate, remove, run, sheet, slide};
use crate::lab::{built_in, simulation};

const SLEEP: &str = "sleep={}";
const DAMPED: &str = "damping=10.0";
const AIRY: &str = "air={ fluid_damping = 1.0 }";

/// Generalised-alpha is left out: its contacts may chatter for ever, and then nothing is at rest.
const ON_A_PLATE: [Scheme; 3] = [
    Scheme::BackwardEuler,
    Scheme::Bdf2,
    Scheme::CentralDifference,
];

fn asleep(simulation: &Simulation) -> bool {
    simulation.report().work == Work::default()
}

/// Lies on a plate, and sleeps after how many steps.
fn laid_to_sleep(scheme: Scheme, set: &[&str]) -> (Simulation, usize) {
    let set = [&[SLEEP, DAMPED, "accept=[\"obstacles\", \"air\"]"], set].concat();
    let mut simulation = simulation(&sheet(scheme, &set));
    add(&mut simulation, plate("plate", -3e-4, 0.3));
    for step in 1..=600 {
        simulation.step().unwrap();
        if asleep(&simulation) {
            return (simulation, step);
        }
    }
    panic!("{scheme:?}: no rest after 600 steps");
}

fn fastest(simulation: &Simulation) -> f64 {
    let speeds = simulation.state().velocities.iter().map(|v| v.norm());
    speeds.fold(0.0, f64::max)
}

/// A sleeping sheet does no work and keeps its bits but for the step; one that never sleeps ends in the same place.
#[test]
fn sleep_costs_nothing_and_moves_nothing() {
    for scheme in ON_A_PLATE {
        let (mut sleeper, steps) = laid_to_sleep(scheme, &[]);
        assert!(steps > 3, "{scheme:?} sleeps at once");
        let before = sleeper.state().clone();
        let energies = sleeper.report().energies;
        run(&mut sleeper, 0.1);
        assert_eq!(sleeper.state().positions, before.positions, "{scheme:?}");
        assert_eq!(sleeper.report().energies, energies, "{scheme:?}");
        assert!(asleep(&sleeper) && fastest(&sleeper) == 0.0, "{scheme:?}");
        assert_eq!(sleeper.report().step, before.step + 50);

        let mut awake = simulation(&sheet(scheme, &[DAMPED]));
        add(&mut awake, plate("plate", -3e-4, 0.3));
        run(&mut awake, 2e-3 * (steps + 50) as f64);
        let pairs = awake.state().positions.iter().zip(&before.positions);
        let apart = pairs.map(|(a, b)| (a - b).norm()).fold(0.0, f64::max);
        println!(
            "{scheme:?}: asleep after {steps} steps, {apart:.1e} m from one that never sleeps"
        );
        assert!(apart < 2e-6, "{scheme:?}: {apart} m");
    }
}

/// At the turning points of a swing the speed is nothing, but not the acceleration.
#[test]
fn a_swinging_sheet_never_sleeps() {
    let scene = built_in("strip-release", &["sleep={ speed = 0.05 }", "duration=0.6"]);
    let mut simulation = simulation(&scene);
    for _ in 0..scene.steps() {
        simulation.step().unwrap();
        assert!(!asleep(&simulation), "at {} s", simulation.report().time);
    }
}

/// Whatever moves wakes it in the step in which it moves, for every scheme; what does not, lets it sleep.
#[test]
fn a_sleeping_sheet_wakes_at_what_moves() {
    for scheme in ON_A_PLATE {
        let wakes = |what: &str, expected: bool, change: &dyn Fn(&mut Simulation)| {
            let (mut simulation, _) = laid_to_sleep(scheme, &[AIRY]);
            change(&mut simulation);
            let before = simulation.state().positions.clone();
            simulation.step().unwrap();
            assert_eq!(asleep(&simulation), !expected, "{scheme:?}: {what}");
            if expected {
                run(&mut simulation, 0.02);
                assert_ne!(simulation.state().positions, before, "{scheme:?}: {what}");
            }
        };
        wakes("plate gone", true, &|s| remove(s, "plate"));
        wakes("plate slides", true, &|s| {
            slide(s, "plate", Vector3::new(0.1, 0.0, 0.0))
        });
        wakes("wind", true, &|s| {
            s.apply(&Command::Blow(wind([0.0, 0.0, 1.0]))).unwrap();
        });
        // Implicit steps look again after any command, and fall asleep in the next.
        if scheme == Scheme::CentralDifference {
            wakes("a plate far away", false, &|s| {
                add(s, plate("far", 0.5, 0.0))
            });
        }
    }
}

/// Where nothing touches, every scheme comes to rest; a reset wakes it.
#[test]
fn a_held_sheet_sleeps_under_every_scheme_until_a_reset() {
    for scheme in Scheme::IN_TIME {
        let scheme_is = format!("method.scheme={}", scheme.name());
        let set = [SLEEP, "damping=60", "sheet.triangles=100", &scheme_is];
        let mut simulation = simulation(&built_in("four-edges", &set));
        run(&mut simulation, 1.0);
        assert!(asleep(&simulation), "{scheme:?}: {}", fastest(&simulation));
        simulation.apply(&Command::Reset).unwrap();
        simulation.step().unwrap();
        assert!(!asleep(&simulation), "{scheme:?}");
    }
}

/// An obstacle that the scene moves wakes the sheet in the step in which it begins to move.
#[test]
fn a_sleeping_sheet_wakes_when_a_script_begins() {
    let set = [
        "sleep={}",
        "damping=20.0",
        "sheet.triangles=200",
        "sheet.position=[0.0, 0.0, 3e-4]",
        "obstacle.table.shape={ kind = \"box\", size = [0.3, 0.3, 0.1] }",
        "obstacle.table.motion.times=[0.5, 0.7]",
        "obstacle.table.motion.positions=[[0.0, 0.0, -0.05], [0.1, 0.0, -0.05]]",
        "duration=0.7",
    ];
    let scene = built_in("drape-table", &set);
    let mut simulation = simulation(&scene);
    let mut awake = vec![];
    for step in 1..=scene.steps() {
        simulation.step().unwrap();
        if !asleep(&simulation) {
            awake.push(step);
        }
    }
    // The step that ends when the motion begins ends with its velocity.
    let wakes = (0.5 / scene.method.dt).round() as u64;
    assert!(awake.contains(&1) && awake.contains(&wakes), "{awake:?}");
    assert!(!awake.contains(&(wakes - 1)), "{awake:?}");
}

/// Whoever goes on from a sleeping state, or replays the commands, has the bits of the whole run.
#[test]
fn sleep_resumes_with_the_same_bits() {
    for scheme in ON_A_PLATE {
        let (mut whole, _) = laid_to_sleep(scheme, &[]);
        run(&mut whole, 0.01);
        let scene = whole.model().scene.clone();
        let mut resumed = simulation(&scene);
        resumed.resume(whole.state().clone()).unwrap();
        for part in 0..3 {
            for _ in 0..5 {
                let expected = whole.step().unwrap();
                assert_eq!(resumed.step().unwrap(), expected, "{scheme:?}, {part}");
            }
            for simulation in [&mut whole, &mut resumed] {
                match part {
                    0 => slide(simulation, "plate", Vector3::new(0.2, 0.0, 0.0)),
                    _ => remove(simulation, "plate"),
                }
                if part == 1 {
                    add(simulation, plate("plate", -0.01, 0.3));
                }
            }
        }
    }
}

/// Methods that know no accelerations refuse the table, and values name their range.
#[test]
fn sleep_is_refused_where_it_cannot_be() {
    let refused = |name: &str, set: &[&str]| {
        let set: Vec<_> = set.iter().map(|s| Override::parse(s).unwrap()).collect();
        let text = library::text(name).unwrap();
        parse(text, &set).unwrap_err().to_string()
    };
    let message = refused("four-edges", &[SLEEP, "method.scheme=equilibrium"]);
    assert!(
        message.contains("sleep") && message.contains("equilibrium"),
        "{message}"
    );
    let message = refused("four-edges", &["sleep={ speed = 2.0 }"]);
    assert!(
        message.contains("sleep.speed") && message.contains("1 m/s"),
        "{message}"
    );
}
