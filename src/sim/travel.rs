//! How far cloth and obstacles may move against each other at a time, so that neither passes the other unseen.

use nalgebra::Vector3;

use super::integrate::quickest;
use super::model::Model;
use super::state::State;
use crate::contact::Obstacle;
use crate::physics::contact::ContactLaw;

/// Most of a part of a step that a thick obstacle may travel \[m\].
const THICK: f64 = 5e-3;

/// Travel that an implicit step may take with one obstacle \[m\]: half of what lies between its middle and that of the
/// cloth.
fn room(law: &ContactLaw, body: &Obstacle) -> f64 {
    0.5 * (law.offset + body.shape.inner_radius()).min(THICK)
}

/// Largest motion of the sheet against an obstacle that it may meet in the next `dt`, over the room for it; at most 1 is
/// safe. The speeds are those of the state, or the most that a prescribed motion reaches.
pub fn ahead(model: &Model, state: &State, dt: f64) -> f64 {
    let Some(law) = &model.contact else {
        return 0.0;
    };
    let fall = Vector3::from(model.scene.gravity).norm() * dt;
    let of = |body: &Obstacle| {
        let quick = quickest(model, body, &state.positions);
        let prescribed = body.scripted || body.overlap.depth > 0.0;
        let both = state.positions.iter().zip(&state.velocities);
        let travels = both.filter_map(|(x, v)| {
            let reach = law.offset + model.longest_edge + (v.norm() + quick + fall) * dt;
            (body.distance(x).value < reach).then(|| {
                let speed = match prescribed {
                    true => v.norm() + quick,
                    false => (v - body.velocity_at(x)).norm(),
                };
                (speed + fall) * dt
            })
        });
        travels.fold(0.0, f64::max) / room(law, body)
    };
    state.obstacles.iter().map(of).fold(0.0, f64::max)
}

/// The same for a motion that was solved: from the positions and obstacles at its start to those at its end.
pub fn taken(
    model: &Model,
    [from, to]: [&[Vector3<f64>]; 2],
    [start, end]: [&[Obstacle]; 2],
) -> f64 {
    let Some(law) = &model.contact else {
        return 0.0;
    };
    let of = |(start, end): (&Obstacle, &Obstacle)| {
        let carried = end.pose * start.pose.inverse();
        let travels = from.iter().zip(to).filter_map(|(x, y)| {
            let moved = (y - (carried * nalgebra::Point3::from(*x)).coords).norm();
            let reach = law.offset + model.longest_edge + moved;
            (end.distance(y).value < reach).then_some(moved)
        });
        travels.fold(0.0, f64::max) / room(law, end)
    };
    start.iter().zip(end).map(of).fold(0.0, f64::max)
}
