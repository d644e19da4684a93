//! Stage 1: a command changes the state between two steps, whole or not at all.

use nalgebra::Vector3;

use super::admit::{admit, refusal};
use super::air::Breeze;
use super::command::{Airflow, Command, Rejected};
use super::measure;
use super::model::Model;
use super::overlap;
use super::report::StepReport;
use super::simulation::{Engine, Simulation};
use super::sleep;
use super::state::State;
use super::touch::Touch;
use crate::contact::{Obstacle, Overlap, Pose, Velocity};
use crate::scene::Accept;
use crate::scene::ranges::FLUID_DAMPING;

/// Most obstacles at a time: each costs a look at the sheet in every step.
const MOST_OBSTACLES: usize = 256;

/// Most names in a message.
const MOST_NAMES: usize = 12;

/// Change of the air's force, in weights of the sheet, from which on it cuts the past off. Less is part of a flow
/// that is sent in small steps.
const GUST: f64 = 0.1;

impl Simulation {
    /// Takes a command; it holds from the next step on.
    ///
    /// # Errors
    /// The scene does not accept the kind of command, a value is not finite or out of its range, the obstacle is
    /// not there, its name is taken, or it would stand in the sheet. The state is then untouched.
    pub fn apply(&mut self, command: &Command) -> Result<(), Rejected> {
        self.accept(command)?;
        let asleep = sleep::sleeps(&self.model, &self.engine, &self.state);
        self.obey(admit(command)?)?;
        self.asleep = false;
        // Explicit steps know what a command changes by the jump of the accelerations; implicit ones look again.
        if asleep && matches!(self.engine, Engine::Implicit(..)) {
            self.state.history.restart();
        }
        Ok(())
    }

    fn obey(&mut self, command: Command) -> Result<(), Rejected> {
        match command {
            Command::AddObstacle(obstacle) => self.add(obstacle),
            Command::MoveObstacle {
                name,
                pose,
                velocity,
            } => self.put(&name, pose, velocity),
            Command::RemoveObstacle { name } => self.remove(&name),
            Command::Blow(flow) => self.blow(&flow),
            Command::Reset => {
                self.reset();
                Ok(())
            }
        }
    }

    fn accept(&self, command: &Command) -> Result<(), Rejected> {
        let kind = match command {
            Command::AddObstacle(_)
            | Command::MoveObstacle { .. }
            | Command::RemoveObstacle { .. } => Accept::Obstacles,
            Command::Blow(_) => Accept::Air,
            Command::Reset => return Ok(()),
        };
        match self.model.scene.accepts(kind) {
            true => Ok(()),
            false => Err(not_accepted(kind)),
        }
    }

    fn add(&mut self, obstacle: Obstacle) -> Result<(), Rejected> {
        let obstacle = Obstacle {
            scripted: false,
            overlap: Overlap::default(),
            ..obstacle
        };
        if self.state.find_obstacle(&obstacle.name).is_some() {
            let name = obstacle.name;
            return Err(Rejected::NameTaken { name });
        }
        let count = self.state.obstacles.len();
        if count == MOST_OBSTACLES {
            let range = format!("at most {MOST_OBSTACLES} at a time");
            return Err(refusal("number of obstacles", count + 1, range));
        }
        self.change(None, |state| Some(state.add_obstacle(obstacle)))
    }

    fn remove(&mut self, name: &str) -> Result<(), Rejected> {
        let at = self.known(name)?;
        self.change(Some(at), |state| {
            state.remove_obstacle(at);
            None
        })
    }

    fn put(
        &mut self,
        name: &str,
        pose: Option<Pose>,
        velocity: Option<Velocity>,
    ) -> Result<(), Rejected> {
        let at = self.known(name)?;
        if let Some(pose) = pose {
            self.change(Some(at), |state| {
                state.obstacles[at].pose = pose;
                Some(at)
            })?;
        }
        let obstacle = &mut self.state.obstacles[at];
        // A motion that the scene prescribes ends here, and leaves no velocity behind.
        if std::mem::take(&mut obstacle.scripted) {
            obstacle.velocity = Velocity::default();
        }
        if let Some(velocity) = velocity {
            obstacle.velocity = velocity;
        }
        Ok(())
    }

    /// Changes one obstacle: the one at `at` before, the one that `change` names after. Work and the jump of the
    /// force go into ledger and scheme history.
    fn change(
        &mut self,
        at: Option<usize>,
        change: impl FnOnce(&mut State) -> Option<usize>,
    ) -> Result<(), Rejected> {
        let model = &self.model;
        let Some(law) = &model.contact else {
            return Err(not_accepted(Accept::Obstacles));
        };
        let contacts = |state: &State, at: Option<usize>| match at {
            Some(at) => Touch::of(model, state, Some(at)),
            None => Touch::default(),
        };
        let before = contacts(&self.state, at);
        let mut next = self.state.clone();
        let at = change(&mut next);
        let after = match at {
            Some(at) => overlap::enter(model, &mut next, at, before.deepest(law))?,
            None => Touch::default(),
        };
        for (touch, sign) in [(&before, -1.0), (&after, 1.0)] {
            next.ledger.supports += sign * touch.potential(model, law, &next.positions);
            if let Engine::Explicit(..) = self.engine {
                let pushes = touch.pushes(model, law, &next.positions).into_iter();
                let jumps = pushes.map(|(v, push)| (v as usize, push * sign));
                add_jumps(model, &mut next, jumps);
            }
        }
        let made_or_lost = before.proximities.is_empty() != after.proximities.is_empty();
        if made_or_lost && matches!(self.engine, Engine::Implicit(..)) {
            next.history.restart();
        }
        self.state = next;
        Ok(())
    }

    fn blow(&mut self, flow: &Airflow) -> Result<(), Rejected> {
        let air = &self.state.air;
        if air.fluid_damping == 0.0 && flow.fluid_damping.is_none() {
            let range = format!("the air has none yet: give one {FLUID_DAMPING}");
            return Err(refusal("fluid_damping", "none", range));
        }
        let mut next = self.state.clone();
        next.air = air.turned(flow, next.step, self.model.scene.method.dt);
        let force = |state: &State| match Breeze::of(&self.model, state) {
            Some(breeze) => breeze.at(0.0).forces(&state.positions, &state.velocities),
            None => vec![Vector3::zeros(); state.positions.len()],
        };
        let pairs = force(&self.state).into_iter().zip(force(&next));
        let jumps: Vec<_> = pairs.map(|(before, after)| after - before).collect();
        if let Engine::Explicit(..) = self.engine {
            add_jumps(&self.model, &mut next, jumps.into_iter().enumerate());
        } else if jumps.iter().map(|jump| jump.norm()).sum::<f64>() > GUST * self.model.weight {
            next.history.restart();
        }
        self.state = next;
        Ok(())
    }

    fn known(&self, name: &str) -> Result<usize, Rejected> {
        let obstacles = &self.state.obstacles;
        self.state.find_obstacle(name).ok_or_else(|| {
            let names = obstacles.iter().map(|o| o.name.as_str());
            let mut known: Vec<_> = names.take(MOST_NAMES).collect();
            match obstacles.len() {
                0 => known.push("none"),
                count if count > MOST_NAMES => known.push("..."),
                _ => {}
            }
            let known = known.join(", ");
            let name = name.to_string();
            Rejected::UnknownObstacle { name, known }
        })
    }

    /// The start state bit for bit, but time goes on: a recording has one time line.
    fn reset(&mut self) {
        let step = self.state.step;
        self.state.clone_from(&self.start);
        self.state.step = step;
        self.state.began = step;
        self.state.air.since = step;
        self.look();
    }

    /// Makes the report describe the state as it stands, with no work done.
    pub(super) fn look(&mut self) {
        self.asleep = false;
        self.report = StepReport {
            converged: true,
            ..StepReport::default()
        };
        let touch = Touch::of(&self.model, &self.state, None);
        measure::measure(&self.model, &self.state, &touch, &mut self.report);
    }
}

fn not_accepted(kind: Accept) -> Rejected {
    let commands = kind.name();
    Rejected::NotAccepted { commands }
}

/// Adds jumps of the force on vertices to the accelerations that the explicit scheme starts its next step with.
fn add_jumps(model: &Model, state: &mut State, jumps: impl Iterator<Item = (usize, Vector3<f64>)>) {
    for (v, jump) in jumps {
        state.history.accelerations[v] += model.dofs.free(v, jump) / model.masses[v];
    }
}
