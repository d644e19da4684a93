//! The state as a `PointCloud2`: point i is vertex i, with x y z \[m\] and vx vy vz \[m/s\] as FLOAT32.

use nalgebra::Vector3;

use super::header;
use super::messages::sensor_msgs::{PointCloud2, PointField};
use crate::sim::State;

/// Names of the six fields, in their order.
const FIELDS: [&str; 6] = ["x", "y", "z", "vx", "vy", "vz"];
/// `sensor_msgs/msg/PointField` code of a 32-bit float.
const FLOAT32: u8 = 7;
/// Size of one point \[bytes\].
const POINT_STEP: usize = FIELDS.len() * size_of::<f32>();

/// Positions and velocities of a state at a simulated time \[s\].
pub fn encode(state: &State, time: f64) -> PointCloud2 {
    let count = state.positions.len();
    let mut data = Vec::with_capacity(count * POINT_STEP);
    for (position, velocity) in state.positions.iter().zip(&state.velocities) {
        for value in position.iter().chain(velocity.iter()) {
            data.extend_from_slice(&(*value as f32).to_le_bytes());
        }
    }
    let field = |(i, name): (usize, &&str)| PointField {
        name: name.to_string(),
        offset: (i * size_of::<f32>()) as u32,
        datatype: FLOAT32,
        count: 1,
    };
    PointCloud2 {
        header: header(time),
        height: 1,
        width: count as u32,
        fields: FIELDS.iter().enumerate().map(field).collect(),
        is_bigendian: false,
        point_step: POINT_STEP as u32,
        row_step: (count * POINT_STEP) as u32,
        data,
        is_dense: true,
    }
}

/// Positions \[m\] of a cloud as written by [`encode`]; nothing if it has another layout.
pub fn positions(cloud: &PointCloud2) -> Option<Vec<Vector3<f64>>> {
    let names = cloud.fields.iter().map(|f| f.name.as_str());
    let ours = names.eq(FIELDS)
        && cloud.fields.iter().all(|f| f.datatype == FLOAT32)
        && cloud.point_step as usize == POINT_STEP
        && cloud.data.len() == cloud.width as usize * POINT_STEP
        && !cloud.is_bigendian;
    let coordinate = |point: &[u8], axis: usize| {
        let at = axis * size_of::<f32>();
        f64::from(f32::from_le_bytes([
            point[at],
            point[at + 1],
            point[at + 2],
            point[at + 3],
        ]))
    };
    let position = |point: &[u8]| Vector3::from_fn(|axis, _| coordinate(point, axis));
    ours.then(|| cloud.data.chunks_exact(POINT_STEP).map(position).collect())
}
