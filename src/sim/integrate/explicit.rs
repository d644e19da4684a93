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
mod crew;
mod floors;
mod hands;
mod in_air;
mod last;
mod meet;
mod portion;

use nalgebra::Vector3;

use super::folds::Folds;
use super::held::{prescribed, rest_supports, work_of_supports};
use super::stable::{
    TOUCHING, contact_rate, largest_frequency, most_inertia, slope_stiffness, stiffening,
};
use crate::contact::Obstacle;
use crate::sim::air::Breeze;
use crate::sim::lanes::{ZERO, add, lanes, scale, vector};
use crate::sim::model::Model;
use crate::sim::report::Work;
use crate::sim::state::State;
use crate::sim::touch::Touch;
use apart::Apart;
use crew::{Crew, Helm, Run};
use hands::Hands;
use in_air::kick_in_air;
use meet::Meeting;
pub use meet::meet_once;
use portion::Portion;

/// Slope inertia over the least that keeps the slopes' own frequency at that of the membrane.
const INERTIA_MARGIN: f64 = 4.0;
/// What is returned as haste where layers need substeps half as long.
const TOO_LONG: f64 = 1.7;

/// Fewest substeps of a run that are worth starting threads for.
const FEWEST_SHARED: u64 = 8;

/// The explicit integrator: constants and work space.
pub struct Explicit {
    sheet: Portion,
    crew: Option<Crew>,
    /// Square of the largest angular frequency at the start, that as the sheet is stretched in the step, and what contact
    /// with obstacles may add to it \[1/s²\].
    own: f64,
    stretched: f64,
    touching: f64,
    meeting: Meeting,
    folds: Folds,
    apart: Apart,
    /// Whether layers are watched while a run of substeps goes on, or looked at afterwards.
    watching: bool,
}

impl Explicit {
    /// Lays out the model, for so many threads, and finds the stable limit at `nodes` (positions, then slopes).
    pub fn new(model: &Model, nodes: &[Vector3<f64>], threads: usize) -> Self {
        let vertices = model.masses.len();
        let mut inertia = model.masses.clone();
        let stiffest = largest_frequency(model, nodes, &inertia);
        inertia.extend(slope_stiffness(model).iter().enumerate().map(|(e, k)| {
            let enough = INERTIA_MARGIN * k / stiffest.powi(2);
            enough.min(most_inertia(model, e))
        }));
        let sheet = Portion::whole(model, nodes, &inertia[vertices..]);
        let own = largest_frequency(model, nodes, &inertia).powi(2);
        Self {
            crew: Crew::new(model, &sheet, threads),
            sheet,
            own,
            stretched: own,
            touching: 0.0,
            meeting: Meeting::new(vertices),
            folds: Folds::default(),
            apart: Apart::default(),
            watching: true,
        }
    }

    /// Largest stable substep of the sheet at its start, where it touches nothing \[s\].
    pub fn limit(&self) -> f64 {
        2.0 / self.own.sqrt()
    }

    /// Largest stable substep with what the sheet may touch in the step, layers apart \[s\].
    fn limit_now(&self) -> f64 {
        2.0 / (self.stretched + self.touching).sqrt()
    }

    /// The substep for a step of `span` from `state` \[s\]: the wanted one, or less where obstacles or layers meet.
    pub fn substep(&mut self, model: &Model, state: &State, wanted: f64, span: f64) -> f64 {
        let stiffer = stiffening(model, &state.positions);
        self.stretched = self.own * stiffer.powi(2);
        self.touching = contact_rate(model, state, span);
        let limit = self.limit_now();
        let longest = match model.scene.method.substep {
            Some(_) => limit,
            None => TOUCHING * limit,
        };
        let wanted = (wanted / stiffer).min(longest);
        match &model.layers {
            Some(law) if self.watching => {
                let sheet = (&state.positions[..], &state.velocities[..]);
                let (masses, steps) = (&self.sheet.inverse_mass, (wanted, limit));
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
        self.begin(model, state, dt, count);
        let run = Run {
            dt,
            count,
            damped: model.scene.damping != 0.0,
            contact: model.contact.is_some(),
            moments: model.layers.is_some() && !self.watching,
        };
        let mut sheet = std::mem::take(&mut self.sheet);
        let mut crew = self.crew.take();
        match &mut crew {
            Some(crew) if self.can_share(model, state, count) => {
                let lead = |sheet: &mut Portion, helm: Helm| {
                    self.substeps(model, state, (sheet, Hands::Crew(helm)), run)
                };
                crew.take(&mut sheet, run, lead);
            }
            _ => self.substeps(model, state, (&mut sheet, Hands::Alone), run),
        }
        (self.sheet, self.crew) = (sheet, crew);
        if self.watching && self.folds.tripped() {
            return (Touch::default(), TOO_LONG);
        }
        self.end(model, state, run)
    }

    /// Lays out the sheet at the start of a run of substeps.
    fn begin(&mut self, model: &Model, state: &mut State, dt: f64, count: u64) {
        let sheet = &mut self.sheet;
        let nodes = state.positions.iter().chain(&state.slopes);
        let rates = state.velocities.iter().chain(&state.slope_rates);
        let past = &state.history.accelerations;
        let accelerations = past.iter().map(lanes).chain(std::iter::repeat(ZERO));
        let half_step = |(rate, a)| add(lanes(rate), scale(a, 0.5 * dt));
        sheet.nodes.clear();
        sheet.nodes.extend(nodes.map(lanes));
        sheet.rates.clear();
        sheet.rates.extend(rates.zip(accelerations).map(half_step));
        sheet.begin(dt);
        state.ledger.supports -= model.held_kinetic(state);
        self.meeting.begin((2.0 / dt).powi(2) - self.stretched);
        self.watching |= !Apart::pays(count);
        if model.layers.is_none() {
            return;
        }
        let limit = self.limit_now();
        let sheet = (&self.sheet.nodes[..], &self.sheet.rates[..]);
        if self.watching {
            self.folds.begin(model, sheet, dt, limit);
        } else {
            self.apart.begin(sheet.0, model.masses.len());
        }
    }

    /// Whether threads can share a run of substeps: not where air, layers, or what turns an obstacle asks for the whole
    /// sheet in each of them.
    fn can_share(&self, model: &Model, state: &State, count: u64) -> bool {
        count >= FEWEST_SHARED
            && !(model.layers.is_some() && self.watching)
            && !state.obstacles.iter().any(Obstacle::may_turn)
            && Breeze::of(model, state).is_none()
    }

    fn substeps(
        &mut self,
        model: &Model,
        state: &mut State,
        (sheet, mut hands): (&mut Portion, Hands),
        run: Run,
    ) {
        let Run {
            dt, count, damped, ..
        } = run;
        let vertices = model.masses.len();
        let moment = |substep: u64| match substep == count {
            true => model.scene.method.dt,
            false => substep as f64 * dt,
        };
        let breeze = Breeze::of(model, state);
        let watched = model.layers.filter(|_| self.watching);
        for substep in 0..count {
            let time = model.script_time(state, moment(substep + 1));
            let held = prescribed(model, time);
            let fastest = hands.drift(sheet, &held, dt);
            if substep + 1 == count {
                sheet.read_slope_rates(dt);
            }
            let kept = run.keeps(substep);
            let cloth = (&mut *sheet, &mut hands);
            self.meeting
                .meet(model, state, cloth, (time, fastest, dt), kept);
            if let Some(law) = &watched {
                let (moving, masses) = ((&sheet.nodes[..], &sheet.rates[..]), &sheet.inverse_mass);
                let motion = (dt, fastest);
                self.folds
                    .push(model, law, moving, motion, masses, &mut sheet.forces);
                if self.folds.tripped() {
                    return;
                }
            }
            state.ledger.supports += work_of_supports(model, &held, &sheet.forces, dt);
            if substep + 1 == count {
                sheet.keep_rates();
            }
            match &breeze {
                None => hands.kick(sheet, dt, damped),
                Some(breeze) => {
                    let drag = breeze.at((substep + 1) as f64 * dt);
                    let (at, rates) = ((&sheet.nodes[..], &sheet.forces[..]), &mut sheet.rates[..]);
                    let constants = (&sheet.inverse_mass[..], &sheet.drag[..]);
                    let [taken, put] = kick_in_air(&drag, at, rates, constants, dt);
                    state.ledger.damping += taken;
                    state.ledger.air += put;
                }
            }
            self.meeting.brake(model, state, sheet, dt);
            if let Some(law) = &watched {
                let taken = self
                    .folds
                    .rub(law, &sheet.inverse_mass, &mut sheet.rates, dt);
                taken.book(&mut state.ledger);
            }
            if kept {
                self.apart.keep(&sheet.nodes, vertices);
            }
            hands.end(sheet, damped);
        }
    }

    /// Puts the end of a run of substeps into the state: the half-step velocities around it give velocity and acceleration
    /// there; the next run gets back the later one.
    fn end(
        &mut self,
        model: &Model,
        state: &mut State,
        Run { dt, damped, .. }: Run,
    ) -> (Touch, f64) {
        let vertices = model.masses.len();
        let sheet = &mut self.sheet;
        sheet.read_slope_rates(dt);
        if damped {
            let spent = model.masses.iter().zip(&sheet.spent);
            state.ledger.damping += spent.map(|(m, spent)| m * spent).sum::<f64>() * dt;
        }
        let around = sheet.before_last.iter().zip(&sheet.rates);
        let ends = around.map(|(a, b)| (vector(a), vector(b)));
        let (velocities, accelerations): (Vec<_>, Vec<_>) =
            ends.map(|(a, b)| ((a + b) * 0.5, (b - a) / dt)).unzip();
        state.history.accelerations = accelerations;
        state.velocities.copy_from_slice(&velocities[..vertices]);
        state.slope_rates.copy_from_slice(&velocities[vertices..]);
        let (positions, slopes) = sheet.nodes.split_at(vertices);
        state.positions = positions.iter().map(vector).collect();
        state.slopes = slopes.iter().map(vector).collect();
        state.history.dt = dt;
        let time = model.script_time(state, model.scene.method.dt);
        model.hold(state, time);
        rest_supports(model, state);
        state.ledger.supports += model.held_kinetic(state);
        let touch = self.meeting.touch(model, state, &self.sheet.nodes);
        (touch, self.meeting.haste())
    }
}
