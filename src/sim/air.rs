//! The air that blows, as part of the state.

use nalgebra::{Matrix3, Vector3};

use super::command::{AirRegion, Airflow};
use super::model::Model;
use super::state::State;
use crate::physics::Load;
use crate::physics::drag::Drag;

/// A prescribed air velocity: uniform in its region, zero outside, on a linear ramp in time.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Air {
    /// C of the air force \[kg/(m²·s)\]; zero is no air.
    pub fluid_damping: f64,
    /// Where it blows; everywhere if not given.
    pub region: Option<AirRegion>,
    /// Velocity before the ramp \[m/s\].
    pub from: Vector3<f64>,
    /// Velocity after the ramp \[m/s\].
    pub to: Vector3<f64>,
    /// Index of the step before which the flow was latched.
    pub since: u64,
    /// Time from there to the ramp \[s\].
    pub delay: f64,
    /// Length of the ramp \[s\].
    pub rise: f64,
    /// Time from the start of the ramp to the end of the flow, which then fades in `rise` \[s\]; endless if not given.
    pub hold: Option<f64>,
}

impl Air {
    /// Velocity within the region, a time after the flow was latched \[m/s\].
    pub fn velocity(&self, elapsed: f64) -> Vector3<f64> {
        let time = elapsed - self.delay;
        match self.hold {
            Some(hold) if time > hold => {
                let faded = share(time - hold, self.rise);
                self.ramp(hold) * (1.0 - faded)
            }
            _ => self.ramp(time),
        }
    }

    fn ramp(&self, time: f64) -> Vector3<f64> {
        if time < 0.0 {
            self.from
        } else {
            self.from.lerp(&self.to, share(time, self.rise))
        }
    }

    /// The flow that a command makes of this one, at the boundary after `step` steps of `dt` \[s\].
    pub fn turned(&self, flow: &Airflow, step: u64, dt: f64) -> Self {
        Self {
            fluid_damping: flow.fluid_damping.unwrap_or(self.fluid_damping),
            region: flow.region,
            from: self.velocity((step - self.since) as f64 * dt),
            to: flow.velocity,
            since: step,
            delay: 0.0,
            rise: flow.rise,
            hold: flow.hold,
        }
    }

    fn blows_at(&self, place: &Vector3<f64>) -> bool {
        self.region.is_none_or(|region| {
            let axis = |i: usize| (region.min[i]..=region.max[i]).contains(&place[i]);
            (0..3).all(axis)
        })
    }
}

/// Share of a ramp that is over after some time, 0 to 1; a ramp of no length is a jump.
fn share(time: f64, rise: f64) -> f64 {
    if time >= rise { 1.0 } else { time / rise }
}

/// Air over the sheet, for one step.
pub struct Breeze<'a> {
    air: Air,
    /// Time from the latching of the flow to the start of the step \[s\].
    elapsed: f64,
    /// Which vertices are in the region, by where they are at the start of the step, shape \[vertices\].
    inside: Vec<bool>,
    faces: &'a [[u32; 3]],
}

impl<'a> Breeze<'a> {
    /// The air of a state; `None` where there is none to speak of.
    pub fn of(model: &'a Model, state: &State) -> Option<Self> {
        let air = &state.air;
        if air.fluid_damping == 0.0 {
            return None;
        }
        Some(Self {
            air: air.clone(),
            elapsed: (state.step - air.since) as f64 * model.scene.method.dt,
            inside: state.positions.iter().map(|x| air.blows_at(x)).collect(),
            faces: &model.mesh.faces,
        })
    }

    /// The load at a time after the start of the step \[s\].
    pub fn at(&self, within: f64) -> Drag<'a> {
        let velocity = self.air.velocity(self.elapsed + within);
        let at = |inside: &bool| if *inside { velocity } else { Vector3::zeros() };
        Drag {
            faces: self.faces,
            fluid_damping: self.air.fluid_damping,
            air: self.inside.iter().map(at).collect(),
        }
    }
}

/// Sum of the resistances of the faces around each node \[N·s/m\].
pub fn resistances(drag: &Drag, nodes: &[Vector3<f64>]) -> Vec<Matrix3<f64>> {
    let mut sum = vec![Matrix3::zeros(); nodes.len()];
    for s in 0..drag.count() {
        let stencil = drag.nodes(s).map(|n| n as usize);
        let of_face = drag.resistance(&stencil.map(|n| nodes[n]));
        stencil.iter().for_each(|&n| sum[n] += of_face);
    }
    sum
}
