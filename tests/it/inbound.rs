//! What comes in: requests that are understood, and requests that are refused with their reason.

use nalgebra::Vector3;
use toile::contact::{Pose, Shape, Velocity};
use toile::sim::Command;
use toile::wire::inbound::{self, Malformed, Request};
use toile::wire::messages::geometry_msgs::{self, Point, Quaternion, Twist};
use toile::wire::messages::nav_msgs::Odometry;
use toile::wire::messages::shape_msgs::{Plane, SolidPrimitive};
use toile::wire::messages::toile_msgs::{AirflowCommand, ObstacleCommand};
use toile::wire::{Message, cdr};

/// The request that a message is on an inlet.
pub fn ask<M: Message>(inlet: &str, message: &M) -> Result<Request, Malformed> {
    let inlet = inbound::find(inlet).expect("an inlet");
    assert_eq!(inlet.request.name, M::TYPE.name);
    inbound::decode(inlet, &cdr::encode(message).expect("encodes"))
}

pub fn commands<M: Message>(inlet: &str, message: &M) -> Vec<Command> {
    ask(inlet, message).expect("understood").commands(&[])
}

pub fn refusal<M: Message>(inlet: &str, message: &M) -> String {
    let refused = ask(inlet, message).expect_err("refused").to_string();
    assert_eq!(refused.lines().count(), 1, "{refused}");
    refused
}

pub fn wire_pose(position: [f64; 3], [x, y, z, w]: [f64; 4]) -> geometry_msgs::Pose {
    let orientation = Quaternion { x, y, z, w };
    let [x, y, z] = position;
    geometry_msgs::Pose {
        position: Point { x, y, z },
        orientation,
    }
}

fn wire_vector([x, y, z]: [f64; 3]) -> geometry_msgs::Vector3 {
    geometry_msgs::Vector3 { x, y, z }
}

pub const AHEAD: [f64; 4] = [0.0, 0.0, 0.0, 1.0];
/// A quarter turn about z.
pub const LEFT: [f64; 4] = [
    0.0,
    0.0,
    std::f64::consts::FRAC_1_SQRT_2,
    std::f64::consts::FRAC_1_SQRT_2,
];

fn ball() -> ObstacleCommand {
    ObstacleCommand {
        operation: ObstacleCommand::ADD,
        name: "ball".into(),
        shape: ObstacleCommand::SOLID,
        solid: solid(SolidPrimitive::SPHERE, &[0.05]),
        friction: 0.25,
        pose: wire_pose([0.1, 0.2, 0.3], AHEAD),
        ..ObstacleCommand::default()
    }
}

pub fn solid(kind: u8, dimensions: &[f64]) -> SolidPrimitive {
    SolidPrimitive {
        r#type: kind,
        dimensions: dimensions.to_vec(),
        ..SolidPrimitive::default()
    }
}

#[test]
fn an_obstacle_is_added_as_sent() {
    let [Command::AddObstacle(ball)] = &commands("/toile/cmd/obstacle", &ball())[..] else {
        panic!("not an obstacle");
    };
    assert_eq!(ball.name, "ball");
    assert_eq!(ball.shape, Shape::Sphere { radius: 0.05 });
    assert_eq!(ball.pose, Pose::translation(0.1, 0.2, 0.3));
    assert_eq!(ball.velocity, Velocity::default());
    assert_eq!(ball.friction, 0.25);
}

#[test]
fn every_shape_that_there_is_can_be_added() {
    let cylinder = solid(SolidPrimitive::CYLINDER, &[0.3, 0.1]);
    let (length, radius) = (0.3, 0.1);
    let disc = solid(SolidPrimitive::CYLINDER, &[0.0, 0.1]);
    let cuboid = solid(SolidPrimitive::BOX, &[0.1, 0.2, 0.3]);
    let size = [0.1, 0.2, 0.3];
    for (shape, solid, expected) in [
        (ObstacleCommand::SOLID, &cuboid, Shape::Box { size }),
        (
            ObstacleCommand::SOLID,
            &cylinder,
            Shape::Cylinder { radius, length },
        ),
        (
            ObstacleCommand::CAPSULE,
            &cylinder,
            Shape::Capsule { radius, length },
        ),
        (ObstacleCommand::DISC, &disc, Shape::Disc { radius }),
        (ObstacleCommand::PLANE, &cuboid, Shape::Plane),
    ] {
        let command = ObstacleCommand {
            shape,
            solid: solid.clone(),
            plane: Plane {
                coef: [0.0, 0.0, 1.0, 0.0],
            },
            ..ball()
        };
        let [Command::AddObstacle(added)] = &commands("/toile/cmd/obstacle", &command)[..] else {
            panic!("not an obstacle");
        };
        assert_eq!(added.shape, expected);
    }
}

/// The half-space lies where the equation says: its surface, and the side of its normal.
#[test]
fn verify_a_plane_is_where_its_equation_says() {
    for coef in [
        [0.0, 0.0, 1.0, -0.5],
        [0.0, 0.0, -2.0, 1.0],
        [1.0, 2.0, -2.0, 3.0],
    ] {
        let command = ObstacleCommand {
            shape: ObstacleCommand::PLANE,
            plane: Plane { coef },
            pose: wire_pose([0.0; 3], AHEAD),
            ..ball()
        };
        let [Command::AddObstacle(plane)] = &commands("/toile/cmd/obstacle", &command)[..] else {
            panic!("not an obstacle");
        };
        let [a, b, c, d] = coef;
        let height = |x: &Vector3<f64>| a * x.x + b * x.y + c * x.z + d;
        for local in [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [-3.0, 2.0, 0.0]] {
            let on_surface = plane.pose * nalgebra::Point3::from(local);
            assert!(height(&on_surface.coords).abs() < 1e-12, "{coef:?}");
        }
        let above = plane.pose * nalgebra::Point3::new(0.0, 0.0, 1.0);
        assert!(height(&above.coords) > 0.9, "{coef:?}");
    }
}

#[test]
fn what_cannot_be_meant_is_refused_with_field_and_range() {
    let cases: Vec<(&str, ObstacleCommand)> = vec![
        (
            "operation = 7",
            ObstacleCommand {
                operation: 7,
                ..ball()
            },
        ),
        (
            "name = \"\"",
            ObstacleCommand {
                name: String::new(),
                ..ball()
            },
        ),
        (
            "name = \"world\"",
            ObstacleCommand {
                name: "world".into(),
                ..ball()
            },
        ),
        (
            "name = \"a/b\"",
            ObstacleCommand {
                name: "a/b".into(),
                ..ball()
            },
        ),
        (
            "name = \"a\\n",
            ObstacleCommand {
                name: "a\nb".into(),
                ..ball()
            },
        ),
        (
            "name = \"xxxx",
            ObstacleCommand {
                name: "x".repeat(65),
                ..ball()
            },
        ),
        (
            "friction = NaN",
            ObstacleCommand {
                friction: f64::NAN,
                ..ball()
            },
        ),
        (
            "friction = -0.1",
            ObstacleCommand {
                friction: -0.1,
                ..ball()
            },
        ),
        ("shape = 9", ObstacleCommand { shape: 9, ..ball() }),
        (
            "mesh = 0 triangles",
            ObstacleCommand {
                shape: ObstacleCommand::MESH,
                ..ball()
            },
        ),
        (
            "solid.dimensions[0] = 1e-5",
            ObstacleCommand {
                solid: solid(SolidPrimitive::SPHERE, &[1e-5]),
                ..ball()
            },
        ),
        (
            "solid.dimensions = 2 numbers",
            ObstacleCommand {
                solid: solid(SolidPrimitive::SPHERE, &[1.0, 1.0]),
                ..ball()
            },
        ),
        (
            "solid.type = 4 is not supported",
            ObstacleCommand {
                solid: solid(SolidPrimitive::CONE, &[1.0, 1.0]),
                ..ball()
            },
        ),
        (
            "solid.type = 77",
            ObstacleCommand {
                solid: solid(77, &[1.0]),
                ..ball()
            },
        ),
        (
            "pose.orientation = [0.0, 0.0, 0.0, 1.1]",
            ObstacleCommand {
                pose: wire_pose([0.0; 3], [0.0, 0.0, 0.0, 1.1]),
                ..ball()
            },
        ),
        (
            "pose.position.y = inf",
            ObstacleCommand {
                pose: wire_pose([0.0, f64::INFINITY, 0.0], AHEAD),
                ..ball()
            },
        ),
        (
            "plane.coef",
            ObstacleCommand {
                shape: ObstacleCommand::PLANE,
                ..ball()
            },
        ),
        (
            "twist.linear.x = 1000.0",
            ObstacleCommand {
                set_twist: true,
                twist: Twist {
                    linear: wire_vector([1e3, 0.0, 0.0]),
                    ..Twist::default()
                },
                ..ball()
            },
        ),
        (
            "set_pose = false",
            ObstacleCommand {
                operation: ObstacleCommand::MOVE,
                ..ball()
            },
        ),
    ];
    for (expected, command) in cases {
        let said = refusal("/toile/cmd/obstacle", &command);
        assert!(said.contains(expected), "{said} does not say {expected}");
    }
    let mut elsewhere = ball();
    elsewhere.header.frame_id = "map".into();
    assert!(refusal("/toile/cmd/obstacle", &elsewhere).contains("header.frame_id = \"map\""));
    for frame in ["", "world"] {
        elsewhere.header.frame_id = frame.into();
        ask("/toile/cmd/obstacle", &elsewhere).expect("understood");
    }
}

/// Single precision gives quaternions that are off by 1e-7: they are normalised; unit ones are left as they are.
#[test]
fn quaternions_are_normalised_within_tolerance() {
    let tilted = [0.1_f32, 0.2, 0.3, 0.927_361_85].map(f64::from);
    let command = ObstacleCommand {
        pose: wire_pose([0.0; 3], tilted),
        ..ball()
    };
    let [Command::AddObstacle(added)] = &commands("/toile/cmd/obstacle", &command)[..] else {
        panic!("not an obstacle");
    };
    assert!((added.pose.rotation.norm() - 1.0).abs() < 1e-15);
    let [x, y, z, w] = tilted;
    assert_ne!((x * x + y * y + z * z + w * w).sqrt(), 1.0);
}

/// nav_msgs/Odometry: the twist is in the child's frame. A rig that faces left and drives ahead goes along y.
#[test]
fn verify_odometry_turns_its_twist_into_the_world() {
    let mut odometry = Odometry {
        child_frame_id: "table".into(),
        ..Odometry::default()
    };
    odometry.pose.pose = wire_pose([1.0, 2.0, 3.0], LEFT);
    odometry.twist.twist.linear = wire_vector([0.5, 0.0, 0.0]);
    odometry.twist.twist.angular = wire_vector([0.0, 0.1, 0.2]);
    let [
        Command::MoveObstacle {
            name,
            pose: Some(pose),
            velocity: Some(velocity),
        },
    ] = &commands("/toile/cmd/obstacle_odometry", &odometry)[..]
    else {
        panic!("not a move");
    };
    assert_eq!(name, "table");
    assert_eq!(pose.translation.vector, Vector3::new(1.0, 2.0, 3.0));
    assert!((velocity.linear - Vector3::new(0.0, 0.5, 0.0)).norm() < 1e-15);
    assert!((velocity.angular - Vector3::new(-0.1, 0.0, 0.2)).norm() < 1e-15);
}

#[test]
fn air_says_what_is_given_and_what_stays() {
    let command = AirflowCommand {
        velocity: wire_vector([1.0, 0.0, -2.0]),
        rise: 0.1,
        hold: 0.5,
        fluid_damping: 3.0,
        ..AirflowCommand::default()
    };
    let blow = |command: &AirflowCommand| match &commands("/toile/cmd/airflow", command)[..] {
        [Command::Blow(flow)] => flow.clone(),
        other => panic!("{other:?}"),
    };
    let plain = blow(&command);
    assert_eq!(plain.velocity, Vector3::new(1.0, 0.0, -2.0));
    assert_eq!(
        (plain.rise, plain.hold, plain.fluid_damping),
        (0.1, None, None)
    );
    assert_eq!(plain.region, None);
    let mut full = AirflowCommand {
        set_fluid_damping: true,
        in_region: true,
        ends: true,
        region_max: Point {
            x: 1.0,
            y: 1.0,
            z: 1.0,
        },
        ..command
    };
    let flow = blow(&full);
    assert_eq!((flow.hold, flow.fluid_damping), (Some(0.5), Some(3.0)));
    assert_eq!(flow.region.expect("a region").max, Vector3::repeat(1.0));
    full.region_max.y = 0.0;
    assert!(refusal("/toile/cmd/airflow", &full).contains("region_max"));
    full.rise = -1.0;
    full.in_region = false;
    assert!(refusal("/toile/cmd/airflow", &full).contains("rise = -1.0"));
}
