//! The mesh: its constant topology, and the surface that viewers draw.

use nalgebra::Vector3;

use super::header;
use super::messages::geometry_msgs::{Point, Pose, Quaternion, Vector3 as WireVector};
use super::messages::std_msgs::ColorRGBA;
use super::messages::toile_msgs::MeshTopology;
use super::messages::visualization_msgs::{Marker, MarkerArray};
use crate::sheet::Mesh;

/// `visualization_msgs/msg/Marker` code of a triangle list.
const TRIANGLE_LIST: i32 = 11;
/// Colour of the cloth: a natural linen.
const CLOTH: ColorRGBA = ColorRGBA {
    r: 0.86,
    g: 0.80,
    b: 0.68,
    a: 1.0,
};

/// Triangles and both charts of the rest shape.
pub fn topology(mesh: &Mesh) -> MeshTopology {
    let flat = |points: &[nalgebra::Vector2<f64>]| points.iter().flat_map(|p| [p.x, p.y]).collect();
    MeshTopology {
        header: header(0.0),
        triangles: mesh.faces.iter().flatten().copied().collect(),
        outline: flat(&mesh.outline),
        material: flat(&mesh.material),
    }
}

/// The surface at a simulated time \[s\]: one triangle list through the vertices, which lie on the cloth's
/// mid-surface. Coordinates are rounded to `f32` first: the zeros compress.
pub fn markers(mesh: &Mesh, positions: &[Vector3<f64>], time: f64) -> MarkerArray {
    let round = |value: f64| f64::from(value as f32);
    let corner = |vertex: &u32| {
        let p = positions[*vertex as usize];
        Point {
            x: round(p.x),
            y: round(p.y),
            z: round(p.z),
        }
    };
    let marker = Marker {
        header: header(time),
        ns: "sheet".to_string(),
        ..triangles(CLOTH, mesh.faces.iter().flatten().map(corner).collect())
    };
    MarkerArray {
        markers: vec![marker],
    }
}

/// Triangles of one colour, three points each, where their frame is.
pub(super) fn triangles(color: ColorRGBA, points: Vec<Point>) -> Marker {
    Marker {
        r#type: TRIANGLE_LIST,
        pose: Pose {
            orientation: Quaternion {
                w: 1.0,
                ..Quaternion::default()
            },
            ..Pose::default()
        },
        scale: WireVector {
            x: 1.0,
            y: 1.0,
            z: 1.0,
        },
        color,
        points,
        ..Marker::default()
    }
}
