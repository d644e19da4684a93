//! Whatever bytes arrive on an inlet: no panic, no number out of range, memory and time within bounds.

use std::process::Command as Process;
use std::time::{Duration, Instant};

use rand::{Rng, RngExt, SeedableRng};
use rand_pcg::Pcg64;
use toile::contact::{Obstacle, Pose, Shape, Velocity};
use toile::sim::Command;
use toile::wire::inbound::{self, Inlet};
use toile::wire::messages::geometry_msgs::{Point, Vector3, Vector3Stamped};
use toile::wire::messages::moveit_msgs::CollisionObject;
use toile::wire::messages::nav_msgs::Odometry;
use toile::wire::messages::shape_msgs::SolidPrimitive;
use toile::wire::messages::simulation_interfaces as verbs;
use toile::wire::messages::toile_msgs::{AirflowCommand, ObstacleCommand};
use toile::wire::{Message, cdr};

use crate::inbound::{AHEAD, LEFT, solid, wire_pose};
use crate::inbound_services::{BALL, spawn};
use crate::samples::sample;

/// Buffers in all.
const BUFFERS: usize = 100_000;
/// Longest time that they may take, many times what they do.
const LONGEST: Duration = Duration::from_secs(60);
/// Address space of the process that reads them \[KiB\]: a length field that was believed would want gigabytes.
const MEMORY: &str = "400000";
/// Set for that process.
const CHILD: &str = "TOILE_TEST_READS_BUFFERS";

#[test]
fn no_bytes_do_harm() {
    if std::env::var_os(CHILD).is_some() {
        return read_them_all();
    }
    let status = Process::new("sh")
        .args(["-c", "ulimit -v $1; shift; exec \"$@\"", "sh", MEMORY])
        .arg(std::env::current_exe().expect("this binary"))
        .args(["--exact", "inbound_property::no_bytes_do_harm"])
        .arg("--test-threads=1")
        .env(CHILD, "1")
        .status();
    assert!(status.expect("it ran").success());
}

fn read_them_all() {
    let mut random = Pcg64::seed_from_u64(20);
    let start = Instant::now();
    let (mut understood, mut refused) = (0, 0);
    for round in 0..BUFFERS / inbound::ALL.len() + 1 {
        for inlet in inbound::ALL {
            let mut bytes = match round % 4 {
                0 => drawn(inlet, &mut random),
                _ => meant(inlet),
            };
            if round % 8 != 0 {
                spoil(&mut bytes, &mut random);
            }
            match inbound::decode(inlet, &bytes) {
                Ok(request) => {
                    understood += 1;
                    request.commands(&[]).iter().for_each(assert_sane);
                }
                Err(malformed) => {
                    refused += 1;
                    let said = malformed.to_string();
                    assert!(said.lines().count() == 1 && said.len() < 500, "{said}");
                }
            }
        }
    }
    assert!(understood > BUFFERS / 20 && refused > BUFFERS / 5);
    assert!(start.elapsed() < LONGEST, "{:?}", start.elapsed());
}

/// Every number is finite and of a size that can be meant.
fn assert_sane(command: &Command) {
    let small = |v: &nalgebra::Vector3<f64>, most: f64| assert!(v.amax() <= most, "{command:?}");
    let placed = |pose: &Pose| {
        small(&pose.translation.vector, 1e3);
        assert!((pose.rotation.norm() - 1.0).abs() < 1e-14);
    };
    let moving = |velocity: &Velocity| {
        small(&velocity.linear, 200.0);
        small(&velocity.angular, 2e3);
    };
    let shaped = |shape: &Shape| {
        let sizes = match shape {
            Shape::Plane | Shape::Mesh(_) => vec![],
            Shape::Box { size } => size.to_vec(),
            Shape::Sphere { radius } | Shape::Disc { radius } => vec![*radius],
            Shape::Cylinder { radius, length } | Shape::Capsule { radius, length } => {
                vec![*radius, *length]
            }
        };
        assert!(
            sizes.iter().all(|s| (1e-4..=100.0).contains(s)),
            "{shape:?}"
        );
    };
    match command {
        Command::AddObstacle(Obstacle {
            name,
            shape,
            pose,
            velocity,
            friction,
            ..
        }) => {
            assert!((1..=64).contains(&name.len()));
            shaped(shape);
            placed(pose);
            moving(velocity);
            assert!((0.0..=10.0).contains(friction));
        }
        Command::MoveObstacle { pose, velocity, .. } => {
            pose.iter().for_each(placed);
            velocity.iter().for_each(moving);
        }
        Command::RemoveObstacle { .. } | Command::Reset => {}
        Command::Blow(flow) => {
            small(&flow.velocity, 200.0);
            let numbers = [Some(flow.rise), flow.hold, flow.fluid_damping];
            let sane = |x: f64| (0.0..=1e5).contains(&x);
            assert!(numbers.into_iter().flatten().all(sane));
        }
    }
}

/// Truncated, lengthened, bits flipped, words overwritten, or noise altogether.
fn spoil(bytes: &mut Vec<u8>, random: &mut Pcg64) {
    let length = bytes.len();
    match random.random_range(0..6) {
        0 => bytes.truncate(random.random_range(0..=length)),
        1 => bytes.resize(length + random.random_range(0..64), random.random()),
        2 => {
            let length = random.random_range(0..256);
            bytes.resize(length, 0);
            random.fill_bytes(bytes);
            bytes.splice(
                0..length.min(4),
                cdr::ENCAPSULATION.into_iter().take(length),
            );
        }
        3 => {
            let at = random.random_range(0..=length - 4);
            let word: [u8; 4] = match random.random_range(0..3) {
                0 => [0xff; 4],
                1 => random.random(),
                _ => [0, 0, 0, random.random()],
            };
            bytes[at..at + 4].copy_from_slice(&word);
        }
        _ => {
            for _ in 0..random.random_range(1..9) {
                let at = random.random_range(0..length);
                bytes[at] ^= 1 << random.random_range(0..8);
            }
        }
    }
}

fn encoded<M: Message>(message: &M) -> Vec<u8> {
    cdr::encode(message).expect("encodes")
}

/// Bytes of the inlet's type with whatever values.
fn drawn(inlet: &Inlet, random: &mut Pcg64) -> Vec<u8> {
    fn of<M: Message>(seed: u64) -> Vec<u8> {
        encoded(&sample::<M>(seed))
    }
    let seed = random.random();
    match inlet.name.rsplit('/').next().expect("a name") {
        "obstacle" => of::<ObstacleCommand>(seed),
        "collision_object" => of::<CollisionObject>(seed),
        "obstacle_odometry" => of::<Odometry>(seed),
        "airflow" => of::<AirflowCommand>(seed),
        "wind" => of::<Vector3Stamped>(seed),
        "get_simulator_features" => of::<verbs::GetSimulatorFeaturesRequest>(seed),
        "get_simulation_state" => of::<verbs::GetSimulationStateRequest>(seed),
        "set_simulation_state" => of::<verbs::SetSimulationStateRequest>(seed),
        "step_simulation" => of::<verbs::StepSimulationRequest>(seed),
        "reset_simulation" => of::<verbs::ResetSimulationRequest>(seed),
        "get_entity_state" => of::<verbs::GetEntityStateRequest>(seed),
        "set_entity_state" => of::<verbs::SetEntityStateRequest>(seed),
        "spawn_entity" => of::<verbs::SpawnEntityRequest>(seed),
        "delete_entity" => of::<verbs::DeleteEntityRequest>(seed),
        other => panic!("no values for {other}"),
    }
}

/// Bytes that are understood.
fn meant(inlet: &Inlet) -> Vec<u8> {
    let entity = "table".to_string();
    let sphere = solid(SolidPrimitive::SPHERE, &[0.05]);
    match inlet.name.rsplit('/').next().expect("a name") {
        "obstacle" => encoded(&ObstacleCommand {
            name: entity,
            solid: sphere,
            pose: wire_pose([0.1, 0.2, 0.3], LEFT),
            ..ObstacleCommand::default()
        }),
        "collision_object" => encoded(&CollisionObject {
            id: entity,
            pose: wire_pose([1.0, 0.0, 0.0], LEFT),
            primitives: vec![sphere.clone(), sphere],
            primitive_poses: vec![wire_pose([0.5, 0.0, 0.0], AHEAD); 2],
            ..CollisionObject::default()
        }),
        "obstacle_odometry" => {
            let mut odometry = Odometry {
                child_frame_id: entity,
                ..Odometry::default()
            };
            odometry.pose.pose = wire_pose([1.0, 2.0, 3.0], LEFT);
            encoded(&odometry)
        }
        "airflow" => encoded(&AirflowCommand {
            in_region: true,
            region_max: Point {
                x: 1.0,
                y: 1.0,
                z: 1.0,
            },
            ..AirflowCommand::default()
        }),
        "wind" => encoded(&Vector3Stamped {
            vector: Vector3 {
                x: 1.0,
                y: 0.0,
                z: 0.5,
            },
            ..Vector3Stamped::default()
        }),
        "step_simulation" => encoded(&verbs::StepSimulationRequest { steps: 3 }),
        "get_entity_state" => encoded(&verbs::GetEntityStateRequest { entity }),
        "set_entity_state" => encoded(&verbs::SetEntityStateRequest {
            entity,
            set_twist: true,
            ..Default::default()
        }),
        "delete_entity" => encoded(&verbs::DeleteEntityRequest { entity }),
        "spawn_entity" => encoded(&spawn(BALL)),
        // The others mean something with all zeros.
        _ => drawn(inlet, &mut Pcg64::seed_from_u64(0)),
    }
}
