//! Which steps are published.

use crate::scene::Scene;

/// Which steps are published.
#[derive(Clone, Copy, Debug)]
pub(super) struct Schedule {
    /// The step after which the run is over.
    pub last: u64,
    /// The step after which a stop was asked for, if it is known beforehand.
    pub halt: Option<u64>,
    /// Steps between outputs.
    output: u64,
    /// Steps between surfaces.
    mesh: u64,
    /// Steps between keyframes, if there are any.
    keyframe: Option<u64>,
    /// Whether surfaces are published at all.
    pub with_mesh: bool,
}

impl Schedule {
    pub(super) fn new(scene: &Scene) -> Self {
        let output = scene.output_steps();
        let per_output = scene.method.dt * output as f64;
        let outputs = |interval: f64| ((interval / per_output).round() as u64).max(1);
        let keyframes = scene.output.keyframe_interval;
        Self {
            last: scene.steps(),
            halt: None,
            output,
            mesh: output.saturating_mul(outputs(1.0 / scene.output.mesh_rate)),
            keyframe: (keyframes > 0.0).then(|| output.saturating_mul(outputs(keyframes))),
            with_mesh: scene.output.mesh_rate > 0.0,
        }
    }

    pub(super) fn output(&self, step: u64) -> bool {
        step.is_multiple_of(self.output)
    }

    pub(super) fn mesh(&self, step: u64) -> bool {
        step.is_multiple_of(self.mesh)
    }

    /// The start needs none: it follows from the scene.
    pub(super) fn keyframe(&self, step: u64) -> bool {
        step > 0
            && self
                .keyframe
                .is_some_and(|steps| step.is_multiple_of(steps))
    }
}
