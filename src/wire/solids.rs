//! Obstacles that are triangle meshes, as markers: a URDF can only name their files.

use super::header;
use super::messages::geometry_msgs::Point;
use super::messages::std_msgs::{ColorRGBA, Header};
use super::messages::visualization_msgs::{Marker, MarkerArray};
use super::sheet::triangles;
use crate::contact::{Obstacle, Shape, Surface};

/// Colour of obstacles, as in their URDF.
const COLOUR: ColorRGBA = ColorRGBA {
    r: 0.45,
    g: 0.50,
    b: 0.56,
    a: 1.0,
};
/// Action of a marker that takes all others away.
const DELETE_ALL: i32 = 3;

/// Triangle lists of the obstacles that are meshes, each in the frame of its obstacle, with which it moves. The first
/// marker takes those away that were there before.
pub fn solids(obstacles: &[Obstacle], time: f64) -> MarkerArray {
    let clear = Marker {
        header: header(time),
        action: DELETE_ALL,
        ..Marker::default()
    };
    let meshes = obstacles
        .iter()
        .filter_map(|obstacle| match &obstacle.shape {
            Shape::Mesh(surface) => Some(marker(obstacle, surface, time)),
            _ => None,
        });
    MarkerArray {
        markers: std::iter::once(clear).chain(meshes).collect(),
    }
}

fn marker(obstacle: &Obstacle, surface: &Surface, time: f64) -> Marker {
    let corner = |vertex: u32| {
        let p = surface.vertices()[vertex as usize];
        Point {
            x: p.x,
            y: p.y,
            z: p.z,
        }
    };
    Marker {
        header: Header {
            frame_id: obstacle.name.clone(),
            ..header(time)
        },
        ns: obstacle.name.clone(),
        frame_locked: true,
        ..triangles(COLOUR, surface.outward().flatten().map(corner).collect())
    }
}
