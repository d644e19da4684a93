//! Obstacles that are put into the cloth: refused, or let in with a surface that comes out slowly.

use super::command::Rejected;
use super::model::Model;
use super::state::State;
use super::touch::Touch;
use crate::contact::{Overlap, depth_inside};
use crate::physics::contact::ContactLaw;
use crate::scene::OverlapRule;

/// Depth from which on contact alone would throw the cloth off \[m\].
const SHALLOW: f64 = 1e-5;

/// Lets the obstacle that has just been put at `at` into the cloth, where it was `deep` in it before \[m\]. Returns its
/// contacts.
///
/// # Errors
/// It reaches deeper than before and than half the cloth's thickness, and the scene refuses that.
pub fn enter(model: &Model, state: &mut State, at: usize, deep: f64) -> Result<Touch, Rejected> {
    let Some(law) = &model.contact else {
        return Ok(Touch::default());
    };
    state.obstacles[at].overlap = Overlap::default();
    let touch = Touch::of(model, state, Some(at));
    let depth = touch.deepest(law).max(sunk(model, law, state, at));
    let spec = &model.scene.overlap;
    if spec.rule == OverlapRule::Refuse && depth > law.offset.max(deep) {
        return Err(Rejected::Overlap {
            name: state.obstacles[at].name.clone(),
            depth: 1e3 * depth,
            most: 1e3 * law.offset,
        });
    }
    if depth <= SHALLOW.max(deep) {
        return Ok(touch);
    }
    // What pressed before goes on pressing as it did.
    let depth = depth - deep;
    let time = spec.time.max(depth / spec.speed);
    state.obstacles[at].overlap = Overlap {
        depth,
        speed: depth / time,
    };
    Ok(Touch::of(model, state, Some(at)))
}

/// Lets in all obstacles that stand in the cloth at the start.
///
/// # Errors
/// As [`enter`].
pub fn enter_all(model: &Model, state: &mut State) -> Result<(), Rejected> {
    (0..state.obstacles.len()).try_for_each(|at| enter(model, state, at, 0.0).map(|_| ()))
}

/// Deepest point of the cloth's surface inside an obstacle \[m\], not negative, drawn-in surfaces put back.
pub fn deepest(model: &Model, law: &ContactLaw, state: &State, touch: &Touch) -> f64 {
    let mut deepest = touch.deepest(law);
    for at in 0..state.obstacles.len() {
        if state.obstacles[at].overlap.depth > 0.0 {
            let mut whole = state.clone();
            whole.obstacles[at].overlap = Overlap::default();
            deepest = deepest.max(Touch::of(model, &whole, Some(at)).deepest(law));
            deepest = deepest.max(sunk(model, law, state, at));
        }
    }
    deepest
}

/// Deepest point of the cloth's surface in a solid that only sees cloth near its own surface \[m\], not negative.
fn sunk(model: &Model, law: &ContactLaw, state: &State, at: usize) -> f64 {
    match depth_inside(&model.mesh, &state.positions, &state.obstacles[at]) {
        0.0 => 0.0,
        depth => depth + law.offset,
    }
}
