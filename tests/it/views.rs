//! What viewers draw: the cloud, the surface, the obstacles.

use toile::contact::{Obstacle, Pose, Shape, Velocity};
use toile::sim::Simulation;
use toile::wire::messages::sensor_msgs::PointCloud2;
use toile::wire::{cloud, markers, robot_description};

use crate::recording::scene;

/// The simulation of the scene after some steps.
fn stepped(steps: usize) -> Simulation {
    let mut simulation = Simulation::new(&scene(), 1).expect("a checked scene");
    for _ in 0..steps {
        simulation.step().expect("steps");
    }
    simulation
}

/// FLOAT32 value of a named field of a point, read as a viewer does: by the field table.
fn value(cloud: &PointCloud2, point: usize, name: &str) -> f32 {
    let field = cloud
        .fields
        .iter()
        .find(|f| f.name == name)
        .expect("the field");
    assert_eq!((field.datatype, field.count), (7, 1));
    let at = point * cloud.point_step as usize + field.offset as usize;
    f32::from_le_bytes(cloud.data[at..at + 4].try_into().expect("4 bytes"))
}

#[test]
fn cloud_holds_positions_and_velocities_by_its_field_table() {
    let simulation = stepped(3);
    let state = simulation.state();
    let cloud = cloud::encode(state, 0.015);
    assert_eq!(cloud.header.frame_id, "world");
    assert_eq!(
        (cloud.header.stamp.sec, cloud.header.stamp.nanosec),
        (0, 15_000_000)
    );
    assert_eq!(
        (cloud.height, cloud.width as usize),
        (1, state.positions.len())
    );
    assert_eq!(cloud.data.len(), cloud.row_step as usize);
    for (i, (x, v)) in state.positions.iter().zip(&state.velocities).enumerate() {
        let read = ["x", "y", "z", "vx", "vy", "vz"].map(|name| value(&cloud, i, name));
        let truth = [x.x, x.y, x.z, v.x, v.y, v.z].map(|c| c as f32);
        assert_eq!(read, truth, "vertex {i}");
    }
}

#[test]
fn surface_runs_through_the_vertices_in_face_order() {
    let simulation = stepped(3);
    let (mesh, positions) = (&simulation.model().mesh, &simulation.state().positions);
    let surface = markers(mesh, positions, 0.015);
    let [marker] = &surface.markers[..] else {
        panic!("one marker");
    };
    assert_eq!(
        (marker.r#type, marker.header.frame_id.as_str()),
        (11, "world")
    );
    assert_eq!(marker.points.len(), 3 * mesh.faces.len());
    for (point, vertex) in marker.points.iter().zip(mesh.faces.iter().flatten()) {
        let truth = positions[*vertex as usize].map(|c| f64::from(c as f32));
        assert_eq!([point.x, point.y, point.z], [truth.x, truth.y, truth.z]);
    }
}

fn urdf(shape: Shape) -> String {
    let obstacle = Obstacle {
        name: "thing".into(),
        shape,
        pose: Pose::identity(),
        velocity: Velocity::default(),
        friction: 0.0,
        ..Obstacle::default()
    };
    robot_description(&[obstacle])
}

#[test]
fn urdf_of_each_shape() {
    let cases = [
        (
            Shape::Plane,
            vec!["0 0 -0.005\" rpy=\"0 0 0\"/><geometry><box size=\"2 2 0.01\"/>"],
        ),
        (
            Shape::Box {
                size: [0.1, 0.2, 0.3],
            },
            vec!["<box size=\"0.1 0.2 0.3\"/>"],
        ),
        (
            Shape::Sphere { radius: 0.05 },
            vec!["<sphere radius=\"0.05\"/>"],
        ),
        (
            Shape::Disc { radius: 0.09 },
            vec!["<cylinder radius=\"0.09\" length=\"0.0002\"/>"],
        ),
        (
            Shape::Cylinder {
                radius: 0.02,
                length: 0.5,
            },
            vec!["<cylinder radius=\"0.02\" length=\"0.5\"/>"],
        ),
        (
            Shape::Capsule {
                radius: 0.02,
                length: 0.5,
            },
            vec![
                "0 0 0\" rpy=\"0 0 0\"/><geometry><cylinder radius=\"0.02\" length=\"0.5\"/>",
                "0 0 0.25\" rpy=\"0 0 0\"/><geometry><sphere radius=\"0.02\"/>",
                "0 0 -0.25\" rpy=\"0 0 0\"/><geometry><sphere radius=\"0.02\"/>",
            ],
        ),
    ];
    for (shape, expected) in cases {
        let xml = urdf(shape.clone());
        assert_eq!(xml.matches("<visual>").count(), expected.len(), "{shape:?}");
        for part in expected {
            assert!(xml.contains(part), "{shape:?}: no {part} in {xml}");
        }
        assert!(xml.contains("<parent link=\"world\"/><child link=\"thing\"/>"));
    }
}
