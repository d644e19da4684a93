//! Stage 1: a command changes the state between two steps, whole or not at all.

use super::admit::{admit, refusal};
use super::command::{Command, Rejected};
use super::measure;
use super::report::StepReport;
use super::simulation::Simulation;
use super::touch::Touch;
use crate::contact::{Obstacle, Pose, Velocity};
use crate::scene::Accept;

/// Most obstacles at a time: each costs a look at the sheet in every step.
const MOST_OBSTACLES: usize = 256;

impl Simulation {
    /// Takes a command; it holds from the next step on.
    ///
    /// # Errors
    /// The scene does not accept the kind of command, a value is not finite or out of its range, the obstacle is
    /// not there, or its name is taken. The state is then untouched.
    pub fn apply(&mut self, command: &Command) -> Result<(), Rejected> {
        self.accept(command)?;
        match admit(command)? {
            Command::AddObstacle(obstacle) => self.add(obstacle),
            Command::MoveObstacle {
                name,
                pose,
                velocity,
            } => self.put(&name, pose, velocity),
            Command::RemoveObstacle { name } => self.remove(&name),
            Command::Blow(_) => Err(not_accepted(Accept::Air)),
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
        if self.state.find_obstacle(&obstacle.name).is_some() {
            let name = obstacle.name;
            return Err(Rejected::NameTaken { name });
        }
        let count = self.state.obstacles.len();
        if count == MOST_OBSTACLES {
            let range = format!("at most {MOST_OBSTACLES} at a time");
            return Err(refusal("number of obstacles", count + 1, range));
        }
        let at = self.state.add_obstacle(obstacle);
        self.jump(None, Some(at));
        Ok(())
    }

    fn remove(&mut self, name: &str) -> Result<(), Rejected> {
        let at = self.known(name)?;
        let before = Touch::of(&self.model, &self.state, Some(at));
        self.state.remove_obstacle(at);
        self.jump(Some(&before), None);
        Ok(())
    }

    /// Bonds ride along: what sticks to an obstacle is pulled after it, as far as friction can.
    fn put(
        &mut self,
        name: &str,
        pose: Option<Pose>,
        velocity: Option<Velocity>,
    ) -> Result<(), Rejected> {
        let at = self.known(name)?;
        if let Some(pose) = pose {
            let before = Touch::of(&self.model, &self.state, Some(at));
            before.ride(&pose, &mut self.state);
            self.state.obstacles[at].pose = pose;
            self.jump(Some(&before), Some(at));
        }
        if let Some(velocity) = velocity {
            self.state.obstacles[at].velocity = velocity;
        }
        Ok(())
    }

    /// Enters in ledger and scheme history that the contacts `before` have made way for those with the obstacle
    /// `after`: work is done, and the force jumps.
    fn jump(&mut self, before: Option<&Touch>, after: Option<usize>) {
        let (model, state) = (&self.model, &mut self.state);
        let Some(law) = &model.contact else { return };
        let after = after.map(|at| Touch::of(model, state, Some(at)));
        let mut touches = [false; 2];
        let sides = [(before, -1.0), (after.as_ref(), 1.0)];
        for (side, (touch, sign)) in sides.into_iter().enumerate() {
            let Some(touch) = touch else { continue };
            touches[side] = !touch.proximities.is_empty();
            state.ledger.supports += sign * touch.potential(model, law, &state.positions);
            for (v, push) in touch.pushes(model, law, &state.positions) {
                let free = model.dofs.free(v as usize, push);
                state.history.accelerations[v as usize] += free * (sign / model.masses[v as usize]);
            }
        }
        if touches[0] != touches[1] {
            // A two-step scheme would carry the force before into the steps after: half a step of velocity.
            state.history.dt = 0.0;
        }
    }

    fn known(&self, name: &str) -> Result<usize, Rejected> {
        let obstacles = &self.state.obstacles;
        self.state.find_obstacle(name).ok_or_else(|| {
            let names: Vec<_> = obstacles.iter().map(|o| o.name.as_str()).collect();
            let known = match names.is_empty() {
                true => "none".to_string(),
                false => names.join(", "),
            };
            let name = name.to_string();
            Rejected::UnknownObstacle { name, known }
        })
    }

    /// The start state bit for bit, but time goes on: a recording has one time line.
    fn reset(&mut self) {
        let step = self.state.step;
        self.state.clone_from(&self.start);
        self.state.step = step;
        self.look();
    }

    /// Makes the report describe the state as it stands, with no work done.
    pub(super) fn look(&mut self) {
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
