//! Orders, one at a time: read, done or refused, recorded, answered.

use std::sync::mpsc::Sender;

use super::drive::Drive;
use super::mode::Mode;
use super::recorder::Said;
use super::{NodeError, Order};
use crate::scene::Accept;
use crate::sim::{Command, Rejected};
use crate::wire::inbound::{self, Inlet, Outcome, Request};
use crate::wire::{self, Level, Packet};

/// Steps that somebody asked for and waits for.
pub(super) struct Awaited {
    inlet: &'static Inlet,
    reply: Sender<Vec<u8>>,
    /// The step before the first of them.
    from: u64,
    count: u64,
}

impl Drive<'_> {
    /// One order; false if it ends the run.
    pub(super) fn perform(&mut self, order: Order) -> Result<bool, NodeError> {
        let request = match inbound::decode(order.inlet, &order.bytes) {
            Ok(request) => request,
            Err(malformed) => {
                self.orders.malformed += 1;
                let outcome = Outcome::Malformed(malformed);
                let answer = self.conclude(&order, &outcome)?;
                self.answer(&order, answer);
                return Ok(true);
            }
        };
        if let Some(found) = self.look_up(&request) {
            let answer = inbound::answer(order.inlet, &found)?;
            self.answer(&order, answer);
            return Ok(true);
        }
        let outcome = self.obey(&request);
        match outcome.reason() {
            None => self.orders.applied += 1,
            Some(_) => self.orders.rejected += 1,
        }
        let steps = match (&request, &outcome) {
            (Request::Step(count), Outcome::Done) => Some(*count),
            _ => None,
        };
        let answer = match (steps, &order.reply) {
            (Some(count), Some(reply)) => {
                self.awaited = Some(Awaited {
                    inlet: order.inlet,
                    reply: reply.clone(),
                    from: self.step(),
                    count,
                });
                self.note(&order, &outcome)?;
                None
            }
            _ => Some(self.conclude(&order, &outcome)?),
        };
        self.settle(&request, &outcome)?;
        if let Some(answer) = answer {
            self.answer(&order, answer);
        }
        let quits = matches!(request, Request::Stop { quit: true });
        Ok(!quits)
    }

    /// What a question finds; nothing if it is none. Questions change nothing, so they are not recorded.
    fn look_up(&self, request: &Request) -> Option<Outcome> {
        let scene = &self.simulation.model().scene;
        match request {
            Request::Features => Some(Outcome::Features {
                obstacles: scene.accepts(Accept::Obstacles),
            }),
            Request::GetState => Some(Outcome::State(self.mode.state())),
            Request::GetEntity { name } => Some(self.find(name)),
            Request::Command(_)
            | Request::Object(_)
            | Request::Spawn { .. }
            | Request::Pause
            | Request::Resume
            | Request::Stop { .. }
            | Request::Step(_) => None,
        }
    }

    fn find(&self, name: &str) -> Outcome {
        let state = self.simulation.state();
        let time = state.step as f64 * self.simulation.model().scene.method.dt;
        match state.obstacles.iter().find(|o| o.name == name) {
            Some(obstacle) => Outcome::Entity {
                obstacle: obstacle.clone(),
                time,
            },
            None => {
                let names: Vec<_> = state.obstacles.iter().map(|o| o.name.as_str()).collect();
                Outcome::Rejected(Rejected::UnknownObstacle {
                    name: name.to_string(),
                    known: names.join(", "),
                })
            }
        }
    }

    /// Does what is asked, or says why not.
    fn obey(&mut self, request: &Request) -> Outcome {
        let step = self.step();
        match request {
            Request::Pause => self.mode.pause(),
            Request::Resume => self.mode.resume(),
            Request::Step(count) => self.mode.go(step, *count),
            Request::Stop { quit: true } => Outcome::Done,
            Request::Stop { quit: false } if self.mode == Mode::Stopped => {
                Outcome::AlreadyThere(self.mode.state())
            }
            _ => self.change(request),
        }
    }

    /// Changes the world, all that is asked or nothing.
    fn change(&mut self, request: &Request) -> Outcome {
        let commands = request.commands(&self.simulation.state().obstacles);
        let before = (commands.len() > 1).then(|| self.simulation.state().clone());
        for command in &commands {
            if let Err(rejected) = self.simulation.apply(command) {
                if let Some(Err(mismatch)) = before.map(|state| self.simulation.resume(state)) {
                    return Outcome::Failed(format!("{rejected}; going back failed: {mismatch}"));
                }
                return Outcome::Rejected(rejected);
            }
        }
        self.mode.touched();
        match (request, &commands[..]) {
            (Request::Spawn { .. }, [Command::AddObstacle(obstacle)]) => Outcome::Spawned {
                name: obstacle.name.clone(),
            },
            (Request::Stop { .. }, _) => {
                self.mode = Mode::Stopped;
                Outcome::Done
            }
            _ => Outcome::Done,
        }
    }

    /// What follows from an order that was done: the state of a run that has come to stand is seen, and steps that
    /// are no longer taken are no longer waited for.
    fn settle(&mut self, request: &Request, outcome: &Outcome) -> Result<(), NodeError> {
        if outcome.reason().is_some() {
            return Ok(());
        }
        let resets = request.commands(&[]).contains(&Command::Reset);
        if self.mode.stands() && resets {
            self.published = None;
        }
        if self.mode.stands() {
            self.publish_once();
        }
        if !matches!(self.mode, Mode::Stepping { .. }) {
            self.interrupt()?;
        }
        Ok(())
    }

    /// The steps that somebody waits for have been taken.
    pub(super) fn arrive(&mut self) -> Result<(), NodeError> {
        self.release(&Outcome::Done)
    }

    /// The steps that somebody waits for will not all be taken.
    pub(super) fn interrupt(&mut self) -> Result<(), NodeError> {
        let Some(awaited) = &self.awaited else {
            return Ok(());
        };
        let (taken, count) = (self.step() - awaited.from, awaited.count);
        let reason = format!("ended after {taken} of {count} steps");
        self.release(&Outcome::Failed(reason))
    }

    fn release(&mut self, outcome: &Outcome) -> Result<(), NodeError> {
        if let Some(awaited) = self.awaited.take() {
            let answer = inbound::answer(awaited.inlet, outcome)?;
            // By way of the recorder: when it comes, the state is published.
            self.open &= self.recorder.publish(Said::Answer(awaited.reply, answer));
        }
        Ok(())
    }

    /// Records what became of an order; the answer to it.
    fn conclude(&mut self, order: &Order, outcome: &Outcome) -> Result<Vec<u8>, NodeError> {
        let packet = self.note(order, outcome)?;
        Ok(match order.inlet.kind {
            inbound::InletKind::Service => inbound::answer(order.inlet, outcome)?,
            inbound::InletKind::Topic => packet.bytes,
        })
    }

    /// Answers an order, if somebody waits for that. While the run stands, what was published before is out by then.
    fn answer(&mut self, order: &Order, bytes: Vec<u8>) {
        match &order.reply {
            Some(reply) if self.mode.stands() => {
                let answer = Said::Answer(reply.clone(), bytes);
                self.open &= self.recorder.publish(answer);
            }
            // Who no longer waits does not mind.
            Some(reply) => drop(reply.send(bytes)),
            None => {}
        }
    }

    /// Records what became of an order.
    fn note(&mut self, order: &Order, outcome: &Outcome) -> Result<Packet, NodeError> {
        let step = self.step();
        let time = step as f64 * self.simulation.model().scene.method.dt;
        let reason = outcome.reason().map_or(Ok(()), Err);
        let mut packet = wire::applied(order.inlet, &order.bytes, step, time, reason)?;
        packet.step = step;
        self.said.push(packet.clone());
        if let Some(reason) = outcome.reason() {
            let text = format!("{}: {reason}", order.inlet.name);
            self.said.push(wire::log(Level::Warning, &text, time)?);
        }
        Ok(packet)
    }
}
