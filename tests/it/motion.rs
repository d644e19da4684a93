//! What the scene moves by keyframes: obstacles and supports, exactly on time, until a command takes over.

use nalgebra::{Rotation3, Vector3};
use toile::contact::{Law, Motion, Pose, Velocity};
use toile::scene::{Scene, Scheme};
use toile::sim::{Command, Energies, Simulation};
use toile::wire::keyframe;

use crate::commands::sheet;
use crate::lab::{built_in, simulation};
use crate::refusal::refuses;

const OBSTACLE: [&str; 2] = [
    "obstacle.arm.shape={ kind = \"box\", size = [0.01, 0.02, 0.03] }",
    "obstacle.arm.motion={ law = \"smooth\", times = [0.01, 0.03, 0.05], positions = [[1.0, 0.0, 0.0], \
     [1.1, 0.2, 0.0], [1.0, 0.0, 0.1]], rotations = [[0.0, 0.0, 0.0], [0.0, 0.0, 90.0], [30.0, 0.0, 90.0]] }",
];

fn turned(roll: f64, yaw: f64) -> nalgebra::UnitQuaternion<f64> {
    let [roll, yaw] = [roll, yaw].map(f64::to_radians);
    nalgebra::UnitQuaternion::from_euler_angles(roll, 0.0, yaw)
}

fn path(law: Law) -> Motion {
    let pose = |at: [f64; 3], turn| Pose::from_parts(Vector3::from(at).into(), turn);
    let poses = vec![
        (0.01, pose([1.0, 0.0, 0.0], turned(0.0, 0.0))),
        (0.03, pose([1.1, 0.2, 0.0], turned(0.0, 90.0))),
        (0.05, pose([1.0, 0.0, 0.1], turned(30.0, 90.0))),
    ];
    Motion::new(law, poses)
}

/// Velocities are the rates of the poses; both laws meet the keyframes; half way in time is half the way.
#[test]
fn verify_velocities_are_the_rates_of_the_poses() {
    for law in [Law::Linear, Law::Smooth] {
        let motion = path(law);
        for time in [0.0, 0.005, 0.012, 0.021, 0.029, 0.034, 0.0401, 0.06] {
            let e = 1e-6;
            let [(before, _), (_, velocity), (after, _)] =
                [time - e, time, time + e].map(|t| motion.at(t));
            let rate = (after.translation.vector - before.translation.vector) / (2.0 * e);
            assert!((rate - velocity.linear).norm() < 1e-5, "{law:?} {time}");
            let turn = (after.rotation * before.rotation.inverse()).scaled_axis() / (2.0 * e);
            assert!((turn - velocity.angular).norm() < 1e-4, "{law:?} {time}");
        }
        let half = motion.at(0.02).0;
        assert!((half.translation.vector - Vector3::new(1.05, 0.1, 0.0)).norm() < 1e-12);
        assert!(half.rotation.angle_to(&turned(0.0, 45.0)) < 1e-7);
        assert!((motion.at(0.05).0.translation.vector.z - 0.1).abs() < 1e-15);
        let fastest = motion.fastest();
        for i in 0..500 {
            let (_, velocity) = motion.at(f64::from(i) * 1e-4);
            assert!(velocity.linear.norm() <= fastest.0 * (1.0 + 1e-12));
            assert!(velocity.angular.norm() <= fastest.1 * (1.0 + 1e-12));
        }
    }
}

fn moved(pose: Option<Pose>, velocity: Option<Velocity>) -> Command {
    let name = "arm".into();
    Command::MoveObstacle {
        name,
        pose,
        velocity,
    }
}

/// On every scheme the obstacle is where its motion has it, bit for bit, after a reset too; a command takes it over.
#[test]
fn an_obstacle_follows_its_motion_until_a_command_takes_over() {
    for scheme in Scheme::IN_TIME {
        let mut simulation = simulation(&sheet(scheme, &OBSTACLE));
        for _ in 0..2 {
            let began = simulation.state().step;
            for step in 0..30 {
                let (pose, velocity) = path(Law::Smooth).at(f64::from(step) * 2e-3);
                let arm = &simulation.state().obstacles[0];
                assert_eq!(
                    (arm.pose, arm.velocity),
                    (pose, velocity),
                    "{scheme:?} {step}"
                );
                simulation.step().unwrap();
            }
            assert_eq!(simulation.state().step, began + 30);
            simulation.apply(&Command::Reset).unwrap();
        }
        for _ in 0..10 {
            simulation.step().unwrap();
        }
        let there = Pose::translation(2.0, 0.0, 0.0);
        simulation.apply(&moved(Some(there), None)).unwrap();
        simulation.step().unwrap();
        let arm = &simulation.state().obstacles[0];
        assert_eq!((arm.pose, arm.velocity), (there, Velocity::default()));
        let linear = Vector3::new(0.0, 1.0, 0.0);
        let velocity = Velocity {
            linear,
            ..Velocity::default()
        };
        simulation.apply(&moved(None, Some(velocity))).unwrap();
        simulation.step().unwrap();
        let at = simulation.state().obstacles[0].pose.translation.vector;
        assert!((at - Vector3::new(2.0, 2e-3, 0.0)).norm() < 1e-15, "{at}");
    }
}

/// A strip whose clamp swings and turns. It would meet itself at 0.16 s: what the clamp does is looked at alone.
fn swung(scheme: Scheme, set: &[&str]) -> Scene {
    let scheme = format!("method.scheme={}", scheme.name());
    let mut all = vec![
        &*scheme,
        "sheet.triangles=60",
        "layers.contact=off",
        "method.tolerance=1e-8",
        "duration=0.2",
        "support.end={ kind = \"clamp\", region = { kind = \"x-min\" }, motion = { law = \"smooth\", \
         times = [0.02, 0.12], displacements = [[0.0, 0.0, 0.0], [0.05, 0.0, 0.05]], \
         rotations = [[0.0, 0.0, 0.0], [0.0, -60.0, 0.0]] } }",
    ];
    all.extend(set);
    let mut scene = built_in("strip-release", &all);
    scene.support.retain(|name, _| name == "end");
    scene
}

fn total(e: &Energies) -> f64 {
    e.kinetic + e.stretch + e.bend + e.gravity + e.contact + e.damping + e.friction
        - e.supports
        - e.air
}

/// The clamp carries vertices and slopes exactly, and the ledger closes over the work that it does.
#[test]
fn energy_of_a_strip_that_its_clamp_swings() {
    for (scheme, dt, most) in [
        (Scheme::GeneralisedAlpha, "method.dt=2.5e-4", 5e-3),
        (Scheme::CentralDifference, "method.dt=1e-3", 5e-3),
        (Scheme::Bdf2, "method.dt=5e-4", 0.05),
    ] {
        for damping in ["damping=0", "damping=0.2"] {
            let set = [dt, "method.rho_infinity=1.0", damping];
            let mut simulation = simulation(&swung(scheme, &set));
            let start = simulation.state().clone();
            let (first, mut drift, mut scale) =
                (total(&simulation.report().energies), 0.0f64, 0.0f64);
            while simulation.report().time < 0.2 {
                let energies = simulation.step().unwrap().energies;
                scale = scale.max(energies.kinetic).max(energies.supports.abs());
                drift = drift.max((total(&energies) - first).abs());
            }
            println!(
                "{scheme:?} {damping}: drift {:.1e} of {scale:.1e} J",
                drift / scale
            );
            assert!(
                drift < most * scale,
                "{scheme:?} {damping}: {drift} of {scale}"
            );
            carried(&simulation, &start.positions, &start.slopes);
        }
    }
}

fn carried(simulation: &Simulation, positions: &[Vector3<f64>], slopes: &[Vector3<f64>]) {
    let (state, support) = (simulation.state(), &simulation.model().supports[0]);
    let turn = Rotation3::from_axis_angle(&Vector3::y_axis(), -60f64.to_radians());
    let held = support.vertices.iter().map(|&v| v as usize);
    let centre = held.clone().map(|v| positions[v]).sum::<Vector3<f64>>() / held.len() as f64;
    assert!(held.len() > 2 && support.edges.len() > 1);
    for v in held {
        let there = centre + Vector3::new(0.05, 0.0, 0.05) + turn * (positions[v] - centre);
        assert!((state.positions[v] - there).norm() < 1e-14);
        assert_eq!(state.velocities[v], Vector3::zeros());
    }
    for &e in &support.edges {
        assert!((state.slopes[e as usize] - turn * slopes[e as usize]).norm() < 1e-14);
    }
}

/// In the middle of the motions a keyframe holds all that the steps to come depend on.
#[test]
fn a_run_with_motions_resumes_bit_for_bit() {
    for scheme in Scheme::IN_TIME {
        let scene = swung(scheme, &["method.dt=1e-3", OBSTACLE[0], OBSTACLE[1]]);
        let mut whole = simulation(&scene);
        for _ in 0..25 {
            whole.step().unwrap();
        }
        let digest = whole.state().digest();
        let message = keyframe::keyframe(whole.state(), digest, 0.025);
        let mut resumed = simulation(&scene);
        resumed.resume(keyframe::state(&message).unwrap()).unwrap();
        for _ in 0..10 {
            let expected = whole.step().unwrap();
            assert_eq!(resumed.step().unwrap(), expected, "{scheme:?}");
        }
    }
}

#[test]
fn a_motion_that_cannot_be_is_refused() {
    let arm = |motion: &str| format!("friction = 0.3\nmotion = {motion}");
    let cases = [
        (
            "{ times = [1.0, 1.0], positions = [[0, 0, 0], [1, 0, 0]] }",
            "motion.times = [1, 1]: must rise",
        ),
        (
            "{ times = [1.0] }",
            "obstacle.table.motion: needs positions, rotations or both",
        ),
        (
            "{ times = [0.0, 1.0], positions = [[0, 0, 0]] }",
            "has 1 entries; must be 2, one a time",
        ),
        (
            "{ times = [], positions = [] }",
            "an array of numbers from 0 to 100000 s, at least one",
        ),
        (
            "{ times = [0.0], positions = [[0, 0]] }",
            "[x, y, z] triples from -1000 to 1000 m",
        ),
        (
            "{ times = [0.0, 0.001], positions = [[0, 0, 0], [1, 0, 0]] }",
            "at up to 1000 m/s; at most 100 m/s",
        ),
        (
            "{ times = [0.0], displacements = [[0, 0, 0]] }",
            "unknown key; allowed here: law, times, positions, rotations",
        ),
    ];
    for (motion, part) in cases {
        refuses(
            "friction = 0.3",
            &arm(motion),
            &["obstacle.table.motion", part],
        );
    }
    let clamp =
        "kind = \"clamp\"\nmotion = { times = [2.0, 1.0], rotations = [[0, 0, 0], [0, 0, 0]] }";
    refuses(
        "kind = \"clamp\"",
        clamp,
        &["support.left.motion.times", "must rise"],
    );
}
