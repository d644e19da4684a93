//! Collision objects as planners send them.

use nalgebra::{UnitQuaternion, Vector3};
use toile::contact::Pose;
use toile::sim::Command;
use toile::wire::messages::geometry_msgs;
use toile::wire::messages::moveit_msgs::CollisionObject;
use toile::wire::messages::shape_msgs::SolidPrimitive;

use crate::inbound::{AHEAD, LEFT, ask, commands, refusal, solid, wire_pose};

fn object(primitives: usize) -> CollisionObject {
    CollisionObject {
        id: "table".into(),
        pose: wire_pose([1.0, 0.0, 0.0], LEFT),
        primitives: vec![solid(SolidPrimitive::BOX, &[0.1, 0.2, 0.3]); primitives],
        primitive_poses: vec![wire_pose([0.5, 0.0, 0.0], AHEAD); primitives],
        ..CollisionObject::default()
    }
}

/// Object pose times primitive pose: a quarter turn brings (0.5, 0, 0) to (0, 0.5, 0).
#[test]
fn verify_the_poses_of_a_collision_object_are_composed() {
    let [Command::AddObstacle(a), Command::AddObstacle(b)] =
        &commands("/toile/cmd/collision_object", &object(2))[..]
    else {
        panic!("not two obstacles");
    };
    assert_eq!([&a.name[..], &b.name], ["table_0", "table_1"]);
    assert!((a.pose.translation.vector - Vector3::new(1.0, 0.5, 0.0)).norm() < 1e-15);
    let left = UnitQuaternion::from_euler_angles(0.0, 0.0, std::f64::consts::FRAC_PI_2);
    assert!(a.pose.rotation.angle_to(&left) < 1e-7);
}

/// As planners send it: no object pose (a quaternion of zeros), one shape with a pose; then sent again, moved,
/// removed.
#[test]
fn an_object_of_one_shape_is_an_obstacle_of_its_name() {
    let mut sent = object(1);
    sent.pose = geometry_msgs::Pose::default();
    let inlet = "/toile/cmd/collision_object";
    let [Command::AddObstacle(added)] = &commands(inlet, &sent)[..] else {
        panic!("not one obstacle");
    };
    assert_eq!(added.name, "table");
    assert_eq!(added.pose, Pose::translation(0.5, 0.0, 0.0));
    let present = std::slice::from_ref(added);
    let again = ask(inlet, &sent).expect("understood").commands(present);
    assert!(
        matches!(&again[..], [Command::RemoveObstacle { name }, Command::AddObstacle(_)] if name == "table")
    );
    let mut move_it = CollisionObject {
        operation: CollisionObject::MOVE,
        primitives: vec![],
        primitive_poses: vec![],
        ..object(1)
    };
    let [Command::MoveObstacle { name, pose, .. }] = &commands(inlet, &move_it)[..] else {
        panic!("not a move");
    };
    assert_eq!((&name[..], pose.is_some()), ("table", true));
    move_it.operation = CollisionObject::REMOVE;
    assert_eq!(
        commands(inlet, &move_it),
        [Command::RemoveObstacle {
            name: "table".into()
        }]
    );
}

#[test]
fn what_a_collision_object_may_not_have_is_refused() {
    let inlet = "/toile/cmd/collision_object";
    let mut sent = object(1);
    sent.primitive_poses.clear();
    assert!(refusal(inlet, &sent).contains("primitive_poses = 0 poses"));
    sent = object(0);
    assert!(refusal(inlet, &sent).contains("primitives = 0 shapes"));
    sent = object(65);
    assert!(refusal(inlet, &sent).contains("primitives = 65 shapes"));
    sent = object(1);
    sent.meshes = vec![Default::default()];
    assert!(refusal(inlet, &sent).contains("meshes[0] = 0 triangles"));
    sent = object(1);
    sent.operation = CollisionObject::APPEND;
    assert!(refusal(inlet, &sent).contains("operation = \"APPEND\""));
}
