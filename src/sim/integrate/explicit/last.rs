//! The last substep once more, for the forces of contact in it: the state holds the half-step velocities around its end.

use nalgebra::Vector3;

use super::super::leap::slow;
use super::super::{folds, impulse};
use super::Explicit;
use super::in_air::kick_in_air;
use crate::contact::Proximity;
use crate::contact::layers::Pair;
use crate::sim::air::Breeze;
use crate::sim::lanes::{Lanes, ZERO, add, lanes, scale};
use crate::sim::layers::LayerTouch;
use crate::sim::model::Model;
use crate::sim::state::State;
use crate::sim::touch::Touch;

/// Normal force and friction of contacts in a substep \[N\].
#[derive(Clone, Debug, Default)]
pub struct Loads {
    /// On obstacles, by key.
    pub obstacles: Vec<(u64, f64, Vector3<f64>)>,
    /// Of layers on the first feature of each pair, in the order of the pairs.
    pub layers: Vec<(f64, Vector3<f64>)>,
}

impl Explicit {
    /// The loads of what touches in a state, in the substep of `dt` that led to it.
    pub fn loads(
        &self,
        model: &Model,
        state: &State,
        (touch, pairs): (&Touch, &[Pair]),
        dt: f64,
    ) -> Loads {
        let nodes: Vec<Lanes> = state.nodes().iter().map(lanes).collect();
        let past = &state.history.accelerations;
        let accelerations = past.iter().map(lanes).chain(std::iter::repeat(ZERO));
        let mut rates: Vec<Lanes> = (state.velocities.iter())
            .zip(accelerations)
            .map(|(v, a)| add(lanes(v), scale(a, -0.5 * dt)))
            .collect();
        let forces = self.forces(model, state, &nodes, (touch, pairs));
        let (masses, drag) = (&self.sheet.inverse_mass, &self.sheet.drag);
        match Breeze::of(model, state) {
            None => slow(&mut rates, &forces, masses, drag, dt),
            Some(breeze) => {
                kick_in_air(
                    &breeze.at(0.0),
                    (&nodes, &forces),
                    &mut rates,
                    (masses, drag),
                    dt,
                );
            }
        }
        let mut loads = Loads::default();
        if let Some(law) = &model.contact {
            let spots: Vec<_> = touch.proximities.iter().map(Proximity::spot).collect();
            let touching = (&touch.obstacles[..], &spots[..]);
            loads.obstacles =
                impulse::loads(model, law, touching, (masses, &nodes), &mut rates, dt);
        }
        if let Some(law) = &model.layers {
            loads.layers = folds::loads(law, pairs, masses, &mut rates, dt);
        }
        loads
    }

    fn forces(
        &self,
        model: &Model,
        state: &State,
        nodes: &[Lanes],
        (touch, pairs): (&Touch, &[Pair]),
    ) -> Vec<Lanes> {
        let mut forces = self.sheet.weight.clone();
        forces.resize(nodes.len(), ZERO);
        self.sheet.kernel.add_forces(nodes, &mut forces);
        let mut pushes = vec![];
        if let Some(law) = &model.contact {
            pushes.extend(touch.pushes(model, law, &state.positions));
        }
        if let Some(law) = &model.layers {
            pushes.extend(LayerTouch::presses(law, pairs));
        }
        for (v, push) in pushes {
            forces[v as usize] = add(forces[v as usize], lanes(&push));
        }
        forces
    }
}
