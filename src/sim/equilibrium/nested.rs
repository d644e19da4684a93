//! Nested iteration: rest on a coarse mesh first, then on meshes of twice as many triangles up to the scene's own, each
//! from the shape on the one before.
//!
//! Where a sheet may fold in many ways, which one it takes is then chosen once, on the coarsest mesh: finer ones follow it,
//! so that what is observed comes together as the mesh is refined.

use super::super::implicit::Implicit;
use super::super::model::Model;
use super::super::report::Work;
use super::super::slopes::SlopeSolver;
use super::super::start::start;
use super::super::state::State;
use super::super::step::{Diverged, failure};
use super::rest_at;
use crate::scene::Scene;
use crate::sheet::interpolate;

/// Brings a flat sheet near to rest by coarser meshes, if the scene asks for them; `time` is that of its supports \[s\].
pub(super) fn approach(
    model: &Model,
    state: &mut State,
    time: f64,
    work: &mut Work,
) -> Result<(), Diverged> {
    let Some(scene) = coarser(&model.scene) else {
        return Ok(());
    };
    let coarse = Model::new(&scene, model.fabric.clone());
    let (mut below, _) =
        start(&coarse).map_err(|rejected| failure(model, state, (0.0, 0), rejected.to_string()))?;
    below.step = state.step;
    below.began = state.began;
    below.obstacles.clone_from(&state.obstacles);
    below.air = state.air.clone();
    coarse.hold(&mut below, time);
    rest_at(
        &coarse,
        &mut Implicit::new(&coarse, 1),
        &mut below,
        time,
        work,
    )?;
    carry_over(&coarse, &below, model, state);
    Ok(())
}

/// The scene on half as many triangles, if that is no coarser than it may be.
fn coarser(scene: &Scene) -> Option<Scene> {
    let half = scene.triangles() / 2;
    let coarsest = scene.method.coarsest?;
    (half >= coarsest).then(|| scene.on_mesh(half))
}

/// Says of which mesh an error is, where there may be several.
pub(super) fn on_mesh(model: &Model, mut diverged: Diverged) -> Diverged {
    if model.scene.method.coarsest.is_some() {
        let triangles = model.mesh.faces.len();
        diverged.advice += &format!("; the vertex is one of the mesh of {triangles} triangles");
    }
    diverged
}

/// Lays the sheet into the shape that it has on another mesh, but for what is held.
fn carry_over(coarse: &Model, from: &State, model: &Model, state: &mut State) {
    let shape = interpolate(&coarse.mesh, &from.positions, &model.mesh.material);
    let vertices = shape.len();
    let mut nodes = state.nodes();
    for (v, place) in shape.iter().enumerate() {
        let moved = place - nodes[v];
        nodes[v] += model.dofs.free(v, moved);
    }
    SlopeSolver::new(model).relax(model, &mut nodes);
    state.slopes = nodes.split_off(vertices);
    state.positions = nodes;
}
