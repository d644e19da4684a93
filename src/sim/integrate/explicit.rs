//! The paper's explicit scheme (16): central differences with lumped mass, substepping at its own stable limit.
//!
//! ```text
//! (rho/dt² + mu/2dt) x_(n+1) = f_n + 2 rho/dt² x_n - (rho/dt² - mu/2dt) x_(n-1)
//! ```
//!
//! in its half-step velocity form, which gives the same positions. Slopes get a rotary inertia J just large enough
//! that they do not lower the stable limit, and never above what nothing notices or a solid sheet has, so they follow the
//! positions.

mod apart;
mod floors;
mod last;
mod meet;

use apart::Apart;
pub use meet::Meeting;
use nalgebra::{Matrix3, Vector3};

use super::folds::Folds;
use super::held::{place, prescribed, rest_supports, work_of_supports};
use super::leap::{drift, kicked, swing};
use super::stable::{
    Limits, SAFETY, largest_frequency, layers, most_inertia, slope_stiffness, stiffening,
};
use crate::math::sparse::NO_SLOT;
use crate::physics::Potential;
use crate::physics::drag::Drag;
use crate::sim::air::{Breeze, resistances};
use crate::sim::kernel::Kernel;
use crate::sim::lanes::{Lanes, add, dot, lanes, scale, vector};
use crate::sim::model::Model;
use crate::sim::report::Work;
use crate::sim::state::State;
use crate::sim::touch::Touch;

/// Slope inertia over the least that keeps the slopes' own frequency at that of the membrane.
const INERTIA_MARGIN: f64 = 4.0;
/// What is returned as haste where layers need substeps half as long.
const TOO_LONG: f64 = 1.7;

/// The explicit integrator: constants and work space.
pub struct Explicit {
    kernel: Kernel,
    /// 1/m and 1/J by component, zero where prescribed, shape \[nodes\].
    inverse_mass: Vec<Lanes>,
    /// mu A / m \[1/s\], shape \[vertices\].
    drag: Vec<f64>,
    /// m g \[N\], shape \[vertices\].
    weight: Vec<Lanes>,
    limits: Limits,
    meeting: Meeting,
    folds: Folds,
    apart: Apart,
    /// Whether layers are watched while a run of substeps goes on, or looked at afterwards.
    watching: bool,
}

impl Explicit {
    /// Lays out the model and finds the stable limit at `nodes` (positions, then slopes).
    pub fn new(model: &Model, nodes: &[Vector3<f64>]) -> Self {
        let kernel = Kernel::new(model);
        let vertices = model.masses.len();
        let mut inertia = model.masses.clone();
        let stiffest = largest_frequency(model, nodes, &inertia, 1);
        inertia.extend(slope_stiffness(model).iter().enumerate().map(|(e, k)| {
            let enough = INERTIA_MARGIN * k / stiffest.powi(2);
            enough.min(most_inertia(model, e))
        }));
        let drag = model.damping.coefficients.iter().zip(&model.masses);
        let weight = |v: usize| lanes(&-model.gravity.gradient(v, &[nodes[v]])[0]);
        Self {
            kernel,
            inverse_mass: inverse_masses(model, &inertia),
            drag: drag.map(|(c, m)| c / m).collect(),
            weight: (0..vertices).map(weight).collect(),
            limits: Limits::new(nodes, inertia),
            meeting: Meeting::new(vertices),
            folds: Folds::default(),
            apart: Apart::default(),
            watching: true,
        }
    }

    /// Largest stable substep where the sheet touches one obstacle at a place \[s\].
    pub fn limit(&mut self, model: &Model) -> f64 {
        self.limits.under(model, 1)
    }

    /// The substep for a step of `span` from `state` \[s\]: the wanted one, or less where obstacles or layers meet.
    pub fn substep(&mut self, model: &Model, state: &State, wanted: f64, span: f64) -> f64 {
        let layers = layers(model, state, span);
        let stiffer = stiffening(model, &state.positions);
        let limit = self.limits.under(model, layers) / stiffer;
        let wanted = match layers {
            1 => wanted / stiffer,
            _ => (wanted / stiffer).min(SAFETY * limit),
        };
        match &model.layers {
            Some(law) if self.watching => {
                let sheet = (&state.positions[..], &state.velocities[..]);
                let (masses, steps) = (&self.inverse_mass, (wanted, limit));
                self.folds.substep(model, law, sheet, masses, steps)
            }
            _ => wanted,
        }
    }

    /// Says whether layers are near where a step of `span` starts \[s\]: if not, and they do not go to meet either, they
    /// are looked at when it is over.
    pub fn expect_layers(&mut self, model: &Model, state: &State, near: bool, span: f64) {
        self.apart.forget();
        self.watching = near || model.layers.is_some() && self.apart.ahead(model, state, span);
    }

    /// Watches layers while the next run of substeps goes on.
    pub fn watch_layers(&mut self) {
        self.watching = true;
    }

    /// Whether layers met in the last run of substeps while nothing watched them: what it led to is void.
    pub fn missed_layers(&mut self, model: &Model) -> bool {
        model.layers.is_some() && !self.watching && !self.apart.held(model)
    }

    /// What layers took in the last run of substeps; `None` if those were too long, and what they led to is void.
    pub fn layer_work(&self) -> Option<Work> {
        let mut work = match self.watching {
            true if self.folds.tripped() => return None,
            true => self.folds.work(),
            false => Work::default(),
        };
        work.layer_searches += self.apart.looks();
        Some(work)
    }

    /// Takes `count` substeps of `dt` and returns the contacts at the end, with the largest motion of the sheet against an
    /// obstacle near it in one substep, over half the thickness of the cloth.
    pub fn advance(
        &mut self,
        model: &Model,
        state: &mut State,
        dt: f64,
        count: u64,
    ) -> (Touch, f64) {
        let vertices = model.masses.len();
        self.meeting.begin();
        let mut nodes: Vec<Lanes> = state
            .positions
            .iter()
            .chain(&state.slopes)
            .map(lanes)
            .collect();
        let mut rates: Vec<Lanes> = state
            .velocities
            .iter()
            .chain(&state.slope_rates)
            .map(lanes)
            .collect();
        let past = &state.history.accelerations;
        let accelerations = past.iter().map(lanes).chain(std::iter::repeat([0.0; 4]));
        for (rate, a) in rates.iter_mut().zip(accelerations) {
            *rate = add(*rate, scale(a, 0.5 * dt));
        }
        state.ledger.supports -= model.held_kinetic(state);
        let moment = |substep: u64| match substep == count {
            true => model.scene.method.dt,
            false => substep as f64 * dt,
        };
        let breeze = Breeze::of(model, state);
        let mut forces = vec![[0.0; 4]; nodes.len()];
        let mut before_last = vec![];
        self.watching |= !Apart::pays(count);
        let watched = model.layers.filter(|_| self.watching);
        let passed = model.layers.is_some() && !self.watching;
        if watched.is_some() {
            let limit = self.limits.under(model, 1);
            self.folds.begin(model, (&nodes, &rates), dt, limit);
        }
        if passed {
            self.apart.begin(&nodes, vertices);
        }
        for substep in 0..count {
            let time = model.script_time(state, moment(substep + 1));
            let held = prescribed(model, time, &nodes, &mut rates, dt);
            // Slopes feel their own bending only, so they are kicked when they move on.
            let slopes = vertices..;
            let fastest = drift(&mut nodes, &rates, &self.weight, &mut forces, dt);
            swing(
                &mut nodes[slopes.clone()],
                &mut rates[slopes.clone()],
                &mut forces[slopes.clone()],
                &self.inverse_mass[slopes],
                dt,
            );
            place(&held, &mut nodes);
            self.kernel.add_forces(&nodes, &mut forces);
            let (moving, masses) = ((&nodes[..], &rates[..]), &self.inverse_mass[..]);
            let motion = (time, fastest, dt);
            self.meeting
                .push(model, state, moving, masses, motion, &mut forces);
            if let Some(law) = &watched {
                let motion = (dt, fastest);
                self.folds
                    .push(model, law, moving, motion, masses, &mut forces);
                if self.folds.tripped() {
                    return (Touch::default(), TOO_LONG);
                }
            }
            state.ledger.supports += work_of_supports(model, &held, &forces, dt);
            if substep + 1 == count {
                before_last.clone_from(&rates);
            }
            match &breeze {
                None => state.ledger.damping += self.kick(model, &mut rates, &forces, dt),
                Some(breeze) => {
                    let drag = breeze.at((substep + 1) as f64 * dt);
                    let [taken, put] = self.kick_in_air(&drag, &nodes, &mut rates, &forces, dt);
                    state.ledger.damping += taken;
                    state.ledger.air += put;
                }
            }
            let sheet = (&self.inverse_mass[..], &nodes[..]);
            self.meeting.brake(model, state, sheet, &mut rates, dt);
            if let Some(law) = &watched {
                let taken = self.folds.rub(law, &self.inverse_mass, &mut rates, dt);
                taken.book(&mut state.ledger);
            }
            if passed {
                self.apart.pass(&nodes, vertices, (substep + 1, count));
            }
        }
        for n in vertices..nodes.len() {
            rates[n] = kicked(rates[n], forces[n], &self.inverse_mass[n], dt);
        }
        // The half-step velocities around the end give velocity and acceleration there; the next run of substeps
        // gets back the later one.
        let around = before_last.iter().zip(&rates);
        let ends = around.map(|(a, b)| (vector(a), vector(b)));
        let (velocities, accelerations): (Vec<_>, Vec<_>) =
            ends.map(|(a, b)| ((a + b) * 0.5, (b - a) / dt)).unzip();
        state.history.accelerations = accelerations;
        state.velocities.copy_from_slice(&velocities[..vertices]);
        state.slope_rates.copy_from_slice(&velocities[vertices..]);
        for (v, x) in nodes.iter().enumerate() {
            if v < vertices {
                state.positions[v] = vector(x);
            } else {
                state.slopes[v - vertices] = vector(x);
            }
        }
        state.history.dt = dt;
        model.hold(state, model.script_time(state, moment(count)));
        rest_supports(model, state);
        state.ledger.supports += model.held_kinetic(state);
        let touch = self.meeting.touch(model, state, &nodes);
        (touch, self.meeting.haste())
    }

    /// Takes the vertices' rates from one half step to the next. Returns what damping took out \[J\].
    fn kick(&self, model: &Model, rates: &mut [Lanes], forces: &[Lanes], dt: f64) -> f64 {
        let half = 0.5 * dt;
        let vertices = rates.iter_mut().zip(forces);
        let vertices = vertices.zip(self.inverse_mass.iter().zip(&self.drag));
        if model.scene.damping == 0.0 {
            vertices.for_each(|((rate, force), (inverse, _))| {
                *rate = kicked(*rate, *force, inverse, dt);
            });
            return 0.0;
        }
        for ((rate, force), (inverse, drag)) in vertices {
            let kept = scale(*rate, 1.0 - drag * half);
            *rate = scale(kicked(kept, *force, inverse, dt), 1.0 / (1.0 + drag * half));
        }
        let drag = &model.damping.coefficients;
        let power = |(c, v): (&f64, &Lanes)| c * dot(*v, *v);
        drag.iter().zip(&*rates).map(power).sum::<f64>() * dt
    }

    /// The same with air on the faces, whose force is linear in the velocity, too: with R the sum of the faces'
    /// resistances at a vertex, (I + B dt/2) dv = (M^-1 (f + R u) - B v) dt and B = M^-1 R + mu A/m. Returns what
    /// damping took out and what the air put in \[J\].
    fn kick_in_air(
        &self,
        drag: &Drag,
        nodes: &[Lanes],
        rates: &mut [Lanes],
        forces: &[Lanes],
        dt: f64,
    ) -> [f64; 2] {
        let vertices = self.drag.len();
        let places: Vec<_> = nodes[..vertices].iter().map(vector).collect();
        let resistance = resistances(drag, &places);
        let (mut taken, mut put) = (0.0, 0.0);
        for (n, r) in resistance.iter().enumerate() {
            let u = drag.air[n];
            let (v, inverse) = (vector(&rates[n]), vector(&self.inverse_mass[n]));
            let braking = Matrix3::from_diagonal(&inverse) * r + Matrix3::identity() * self.drag[n];
            let pull = (vector(&forces[n]) + r * u).component_mul(&inverse) - braking * v;
            let inertia = Matrix3::identity() + braking * (0.5 * dt);
            let change = inertia.try_inverse().unwrap_or_default() * pull * dt;
            let mean = v + change * 0.5;
            rates[n] = lanes(&(v + change));
            // What air and damping do to a part that is held, its support bears.
            if inverse.max() == 0.0 {
                continue;
            }
            put += (r * (u - mean)).dot(&mean) * dt;
            if self.drag[n] > 0.0 {
                taken += self.drag[n] / inverse.max() * mean.norm_squared() * dt;
            }
        }
        [taken, put]
    }
}

/// 1/m and 1/J by component, zero where prescribed, shape \[nodes\].
pub fn inverse_masses(model: &Model, inertia: &[f64]) -> Vec<Lanes> {
    let inverse = |(index, inertia): (&[u32; 3], &f64)| {
        let [x, y, z] = index.map(|slot| if slot == NO_SLOT { 0.0 } else { 1.0 / inertia });
        [x, y, z, 0.0]
    };
    model.dofs.index.iter().zip(inertia).map(inverse).collect()
}
