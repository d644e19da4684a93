//! How far cloth and obstacles may move against each other at a time, so that neither passes the other unseen.

use nalgebra::{Point3, Vector3};

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
        let along = along(start, end);
        let travels = from.iter().zip(to).filter_map(|(x, y)| {
            let moved = (y - along(x)).norm();
            let reach = law.offset + model.longest_edge + moved;
            (end.distance(y).value < reach).then_some(moved)
        });
        travels.fold(0.0, f64::max) / room(law, end)
    };
    start.iter().zip(end).map(of).fold(0.0, f64::max)
}

/// A point that moves with an obstacle from one pose to the next.
fn along(start: &Obstacle, end: &Obstacle) -> impl Fn(&Vector3<f64>) -> Vector3<f64> + use<> {
    let carried = end.pose * start.pose.inverse();
    move |x| (carried * Point3::from(*x)).coords
}

/// Halvings by which a moment of a motion is found.
const HALVINGS: usize = 30;

/// Share of a straight motion of the sheet, seen from each obstacle, that leaves it on the side on which it is: up to where
/// a vertex or the middle of a face is as deep as it may travel, if further on it would come out behind. 1 where none
/// does. It may miss what is thinner than half a face.
pub fn before_passing(
    model: &Model,
    [from, to]: [&[Vector3<f64>]; 2],
    [start, end]: [&[Obstacle]; 2],
) -> f64 {
    let Some(law) = &model.contact else {
        return 1.0;
    };
    let middle = |x: &[Vector3<f64>], f: &[u32; 3]| f.map(|v| x[v as usize] / 3.0).iter().sum();
    let of = |(start, end): (&Obstacle, &Obstacle)| {
        let along = along(start, end);
        let deep = law.offset - room(law, end);
        let vertices = from.iter().copied().zip(to.iter().copied());
        let faces = model.mesh.faces.iter();
        let middles = faces.map(|f| (middle(from, f), middle(to, f)));
        let ways = vertices.chain(middles);
        let shares = ways.map(|(x, y)| entry(end, (along(&x), y), deep));
        shares.fold(1.0, f64::min)
    };
    start.iter().zip(end).map(of).fold(1.0, f64::min)
}

/// Where on its way a point is as near to a convex obstacle as `deep` \[m\], if it comes out behind; else 1.
fn entry(body: &Obstacle, (from, to): (Vector3<f64>, Vector3<f64>), deep: f64) -> f64 {
    let way = to - from;
    let at = |share: f64| body.distance(&(from + way * share));
    let start = at(0.0);
    let comes_out = start.value - way.norm() < deep
        && start.normal.dot(&way) < 0.0
        && at(1.0).normal.dot(&way) > 0.0;
    if !comes_out {
        return 1.0;
    }
    let last = |end: f64, holds: &dyn Fn(f64) -> bool| {
        let (mut low, mut high) = (0.0, end);
        for _ in 0..HALVINGS {
            let share = 0.5 * (low + high);
            match holds(share) {
                true => low = share,
                false => high = share,
            }
        }
        low
    };
    let deepest = last(1.0, &|share| at(share).normal.dot(&way) < 0.0);
    if at(deepest).value >= deep {
        return 1.0;
    }
    match start.value > deep {
        true => last(deepest, &|share| at(share).value > deep),
        false => 0.5 * deepest,
    }
}
