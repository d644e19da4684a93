//! Commands: what they do to the sheet, what is refused, and that neither leaves a trace where it should not.

use nalgebra::{Quaternion, UnitQuaternion, Vector3};
use toile::contact::{Obstacle, Pose, Shape, Velocity};
use toile::scene::{Scene, Scheme};
use toile::sim::{Command, Rejected, Simulation};

use crate::lab::{built_in, simulation};

/// 2 ms steps of a coarse sheet 100 mm square that takes obstacle commands.
pub fn sheet(scheme: Scheme, set: &[&str]) -> Scene {
    let scheme = format!("method.scheme={}", scheme.name());
    let mut all = vec![
        "sheet.outline={ kind = \"rectangle\", length = 0.1, width = 0.1 }",
        "sheet.triangles=120",
        "method.dt=2e-3",
        "accept=[\"obstacles\"]",
        &*scheme,
    ];
    all.extend(set);
    built_in("free-fall", &all)
}

/// A plate 20 mm thick whose top is at `top` \[m\].
pub fn plate(name: &str, top: f64, friction: f64) -> Obstacle {
    Obstacle {
        name: name.into(),
        shape: Shape::Box {
            size: [0.3, 0.3, 0.02],
        },
        pose: Pose::translation(0.0, 0.0, top - 0.01),
        friction,
        ..Obstacle::default()
    }
}

pub fn add(simulation: &mut Simulation, obstacle: Obstacle) {
    simulation.apply(&Command::AddObstacle(obstacle)).unwrap();
}

pub fn remove(simulation: &mut Simulation, name: &str) {
    let name = name.to_string();
    simulation.apply(&Command::RemoveObstacle { name }).unwrap();
}

pub fn slide(simulation: &mut Simulation, name: &str, linear: Vector3<f64>) {
    let velocity = Velocity {
        linear,
        angular: Vector3::zeros(),
    };
    simulation
        .apply(&Command::MoveObstacle {
            name: name.into(),
            pose: None,
            velocity: Some(velocity),
        })
        .unwrap();
}

pub fn run(simulation: &mut Simulation, seconds: f64) {
    let steps = (seconds / simulation.model().scene.method.dt).round() as u64;
    for _ in 0..steps {
        simulation.step().unwrap_or_else(|e| panic!("{e}"));
    }
}

fn lowest(simulation: &Simulation) -> f64 {
    let heights = simulation.state().positions.iter().map(|p| p.z);
    heights.fold(f64::INFINITY, f64::min)
}

fn centre(simulation: &Simulation) -> Vector3<f64> {
    let positions = &simulation.state().positions;
    positions.iter().sum::<Vector3<f64>>() / positions.len() as f64
}

/// A scene that begins with no obstacle has a contact law all the same, if it accepts obstacles: the falling sheet
/// comes to rest on the plate, half a thickness above it, and falls on when the plate is gone.
#[test]
fn an_added_obstacle_catches_the_sheet_and_a_removed_one_lets_it_fall() {
    for scheme in Scheme::IN_TIME {
        let mut simulation = simulation(&sheet(scheme, &["damping=5.0"]));
        run(&mut simulation, 0.02);
        add(&mut simulation, plate("plate", -5e-3, 0.3));
        run(&mut simulation, 0.3);
        let half = 0.5 * simulation.model().fabric.thickness;
        let sunk = -5e-3 + half - lowest(&simulation);
        println!("{scheme:?}: {sunk:.1e} m into the plate");
        assert!(
            sunk.abs() < 5e-5,
            "{scheme:?}: lowest point {sunk} m into the plate"
        );
        remove(&mut simulation, "plate");
        let (before, dt) = (centre(&simulation).z, 0.05);
        let velocities = &simulation.state().velocities;
        let speed = -velocities.iter().map(|v| v.z).sum::<f64>() / velocities.len() as f64;
        run(&mut simulation, dt);
        // Free fall with damping: v' = g - (mu / rho) v from what is left of the bounce.
        let (rho, mu) = (simulation.model().fabric.areal_density, 5.0);
        let tau = rho / mu;
        let decay = tau * (1.0 - (-dt / tau).exp());
        let fallen = speed * decay + 9.81 * tau * (dt - decay);
        let error = (before - centre(&simulation).z) / fallen - 1.0;
        println!("{scheme:?}: falls {:.1e} off the closed form", error);
        // Euler's first order: half a step of velocity in 25 steps.
        let most = if scheme == Scheme::BackwardEuler {
            0.05
        } else {
            0.01
        };
        assert!(error.abs() < most, "{scheme:?}: falls {error} off");
    }
}

/// A cloth on a plate that slides goes with it, but for the slip at the start; without friction it stays behind,
/// and so it does if the plate jumps. Places that agree with the velocity change nothing.
#[test]
fn a_moved_obstacle_carries_the_sheet_by_friction() {
    let velocity = Vector3::new(0.1, 0.0, 0.0);
    let place = |t: f64| Pose::translation(0.1 * t, 0.0, -2.45e-4 - 0.01);
    for scheme in Scheme::IN_TIME {
        for (friction, by_velocity, by_place, carried) in [
            (0.5, true, false, 1.0),
            (0.5, true, true, 1.0),
            (0.5, false, true, 0.0),
            (0.0, true, false, 0.0),
        ] {
            let mut simulation = simulation(&sheet(scheme, &["damping=0.05"]));
            add(&mut simulation, plate("plate", -2.45e-4, friction));
            run(&mut simulation, 0.02);
            let given = Velocity {
                linear: velocity,
                ..Velocity::default()
            };
            for step in 0..50 {
                let pose = by_place.then(|| place(f64::from(step) * 2e-3));
                let command = moved(pose, by_velocity.then_some(given));
                simulation.apply(&command).unwrap();
                simulation.step().unwrap();
            }
            let went = centre(&simulation).x / 0.01;
            println!(
                "{scheme:?}, friction {friction}, {by_velocity}, {by_place}: {went:.3} of the way"
            );
            let error = (went - carried).abs();
            assert!(
                error < 0.12,
                "{scheme:?}, friction {friction}, {by_velocity}, {by_place}: {went}"
            );
        }
    }
}

fn script(simulation: &mut Simulation) -> Vec<u64> {
    let mut digests = vec![];
    let mut go = |simulation: &mut Simulation, steps: usize| {
        for _ in 0..steps {
            digests.push(simulation.step().unwrap().digest);
        }
    };
    go(simulation, 5);
    add(simulation, plate("m", -1e-3, 0.3));
    go(simulation, 10);
    add(simulation, plate("a", -2e-3, 0.3));
    slide(simulation, "m", Vector3::new(0.05, 0.0, 0.02));
    go(simulation, 5);
    remove(simulation, "m");
    go(simulation, 5);
    digests
}

/// Threads share the faces in parts of 256 or more.
#[test]
fn the_same_bits_with_commands_for_any_number_of_threads() {
    for scheme in Scheme::IN_TIME {
        let scene = sheet(scheme, &["sheet.triangles=700"]);
        let digests = |threads| script(&mut Simulation::new(&scene, threads).unwrap());
        let one = digests(1);
        assert_eq!(one, digests(1), "{scheme:?} twice");
        assert_eq!(one, digests(2), "{scheme:?} on two threads");
    }
}

/// After a reset the run is the same again, bit for bit, but time goes on.
#[test]
fn a_reset_run_is_the_same_again() {
    for scheme in Scheme::IN_TIME {
        let scene = sheet(scheme, &["perturbation.amplitude=1e-4"]);
        let mut simulation = simulation(&scene);
        let fresh = simulation.report().clone();
        let path = |simulation: &mut Simulation| {
            script(simulation);
            (simulation.state().clone(), simulation.report().clone())
        };
        let (first, report) = path(&mut simulation);
        simulation.apply(&Command::Reset).unwrap();
        assert_eq!(simulation.state().step, first.step);
        assert_eq!(simulation.report().readings, fresh.readings);
        assert_eq!(simulation.report().energies, fresh.energies);
        let (mut again, second) = path(&mut simulation);
        assert_eq!(again.step, 2 * first.step, "time does not go back");
        assert_eq!(second.time, 2.0 * report.time);
        again.step = first.step;
        again.air.since = first.air.since;
        again.began = first.began;
        assert_eq!(again.digest(), first.digest(), "{scheme:?}");
        assert_eq!(second.energies, report.energies, "{scheme:?}");
    }
}

/// Bonds belong to obstacles, not to their places in the list: one added before and taken away again changes
/// nothing, however the sheet sticks to the other.
#[test]
fn bonds_keep_their_obstacle_when_others_come_and_go() {
    for scheme in Scheme::IN_TIME {
        let run_with = |others: bool| {
            let mut simulation = simulation(&sheet(scheme, &[]));
            add(&mut simulation, plate("m", -2.45e-4, 0.5));
            slide(&mut simulation, "m", Vector3::new(0.05, 0.0, 0.0));
            run(&mut simulation, 0.02);
            assert!(simulation.report().contacts > 0, "{scheme:?}: no contact");
            if others {
                add(&mut simulation, plate("a", -0.5, 0.1));
                add(&mut simulation, plate("z", -0.5, 0.1));
            }
            run(&mut simulation, 0.01);
            if others {
                remove(&mut simulation, "a");
                remove(&mut simulation, "z");
            }
            run(&mut simulation, 0.01);
            simulation.state().digest()
        };
        assert_eq!(run_with(false), run_with(true), "{scheme:?}");
    }
}

#[track_caller]
fn rejected(simulation: &mut Simulation, command: Command, parts: &[&str]) {
    let (digest, ledger) = (simulation.state().digest(), simulation.state().ledger);
    let message = simulation.apply(&command).unwrap_err().to_string();
    for part in parts {
        assert!(message.contains(part), "`{part}` is not in: {message}");
    }
    assert!(!message.contains('\n'), "{message:?} is not one line");
    assert_eq!(simulation.state().digest(), digest, "{message}");
    assert_eq!(simulation.state().ledger, ledger, "{message}");
}

fn moved(pose: Option<Pose>, velocity: Option<Velocity>) -> Command {
    Command::MoveObstacle {
        name: "plate".into(),
        pose,
        velocity,
    }
}

#[test]
fn a_rejected_command_names_field_value_and_range_and_changes_nothing() {
    let mut simulation = simulation(&sheet(Scheme::Bdf2, &["overlap.rule=refuse"]));
    add(&mut simulation, plate("plate", -2.45e-4, 0.3));
    run(&mut simulation, 0.01);
    let with = |change: &dyn Fn(&mut Obstacle)| {
        let mut obstacle = plate("other", -0.1, 0.3);
        change(&mut obstacle);
        Command::AddObstacle(obstacle)
    };
    let bad_size = Shape::Box {
        size: [0.1, f64::NAN, 0.1],
    };
    let cases: Vec<(Command, &[&str])> = vec![
        (
            with(&|o| o.name = "plate".into()),
            &["\"plate\"", "already"],
        ),
        (
            with(&|o| o.name = "a/b\n".into()),
            &["name = \"a/b\\n\"", "letters"],
        ),
        (
            with(&|o| o.name = "x".repeat(100_000)),
            &["name = \"xxx", "1 to 64"],
        ),
        (
            with(&|o| o.friction = -0.1),
            &["friction = -1e-1", "from 0 to 10"],
        ),
        (
            with(&|o| o.shape = bad_size.clone()),
            &["shape.size.y = NaN", "from 1e-6 to 1000 m"],
        ),
        (
            with(&|o| o.shape = Shape::Sphere { radius: 1e9 }),
            &["shape.radius = 1e9"],
        ),
        (
            with(&|o| o.pose.translation.vector.z = f64::INFINITY),
            &["position.z = inf", "from -1000 to 1000 m"],
        ),
        (
            with(&|o| o.velocity.angular.x = 1e6),
            &["velocity.angular.x = 1e6", "rad/s"],
        ),
        (
            moved(
                None,
                Some(Velocity {
                    linear: Vector3::repeat(f64::NAN),
                    ..Velocity::default()
                }),
            ),
            &["velocity.linear.x = NaN", "m/s"],
        ),
        (
            moved(
                Some(Pose::from_parts(
                    Vector3::zeros().into(),
                    UnitQuaternion::new_unchecked(Quaternion::new(0.0, 0.0, 0.0, 0.0)),
                )),
                None,
            ),
            &["orientation = [0e0, 0e0, 0e0, 0e0]", "norm 1"],
        ),
        (
            with(&|o| o.pose.translation.vector.z = -0.01),
            &["\"other\" would reach 0.24", "at most 0.245 mm"],
        ),
        (
            moved(Some(Pose::translation(0.0, 0.0, 0.0)), None),
            &["\"plate\" would reach", "at most 0.245 mm"],
        ),
        (
            Command::RemoveObstacle {
                name: "table".into(),
            },
            &["no obstacle \"table\"", "there are plate"],
        ),
    ];
    for (command, parts) in cases {
        rejected(&mut simulation, command, parts);
    }
    for i in 0..255 {
        add(&mut simulation, plate(&format!("o{i}"), -1.0, 0.0));
    }
    rejected(
        &mut simulation,
        with(&|_| ()),
        &["number of obstacles = 257", "256"],
    );
}

/// A scene takes commands for what it has, or for what it lists; nothing else.
#[test]
fn what_a_scene_does_not_accept_is_rejected() {
    let plate = || Command::AddObstacle(plate("plate", -1.0, 0.3));
    let not_accepted = Err(Rejected::NotAccepted {
        commands: "obstacles",
    });
    let coarse = "sheet.triangles=20";
    for (name, set, taken) in [
        ("free-fall", vec![coarse], false),
        ("free-fall", vec![coarse, "accept=[\"obstacles\"]"], true),
        ("drape-table", vec![coarse], true),
        ("drape-table", vec![coarse, "accept=[]"], false),
    ] {
        let mut simulation = simulation(&built_in(name, &set));
        let expected = if taken { Ok(()) } else { not_accepted.clone() };
        assert_eq!(simulation.apply(&plate()), expected, "{name} {set:?}");
    }
}

/// Two obstacles at one place make contact twice as stiff, which a heavy sheet's explicit substep has to respect; as
/// soon as one is gone it does not.
#[test]
fn stability_where_obstacles_meet() {
    let set = ["fabric.areal_density=20.0", "sheet.triangles=60"];
    let mut simulation = simulation(&sheet(Scheme::CentralDifference, &set));
    add(&mut simulation, plate("one", -2.45e-4, 0.3));
    let substeps = |simulation: &mut Simulation| {
        run(simulation, 0.01);
        let report = simulation.report();
        assert!(
            report.largest_strain < 0.01,
            "strain {}",
            report.largest_strain
        );
        report.work.substeps
    };
    let one = substeps(&mut simulation);
    add(&mut simulation, plate("two", -2.45e-4, 0.3));
    let two = substeps(&mut simulation);
    remove(&mut simulation, "one");
    let again = substeps(&mut simulation);
    println!("{one} substeps on one plate, {two} on two");
    assert!(
        two as f64 > 1.2 * one as f64 && again == one,
        "{one} {two} {again}"
    );
}
