//! The loop: step, publish, take orders at the boundary, until the end or until somebody says stop.

use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use super::inbox::Waited;
use super::mode::Mode;
use super::pace::Pacer;
use super::recorder::{Instant, Recorder};
use super::schedule::Schedule;
use super::{Inbox, NodeError, Order};
use crate::sim::{Simulation, StepReport};

/// Orders taken at one boundary: a flood of them slows a run down but does not stop it.
const MOST_ORDERS: usize = 64;
/// How long a paused run waits before it looks at the stop flag again.
const NAP: Duration = Duration::from_millis(50);

/// Why the loop ended without an error of the physics.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum End {
    /// All steps taken, or the recorder gave up (which its own error explains).
    Done,
    /// Told to, by the stop flag or by an order; or paused with nobody left to say go.
    Stopped,
}

/// A run under way.
pub(super) struct Drive<'a> {
    pub simulation: &'a mut Simulation,
    pub recorder: &'a Recorder,
    pub inbox: &'a mut Inbox,
    pub pacer: &'a mut Pacer,
    pub stop: &'a AtomicBool,
    pub schedule: Schedule,
    pub mode: Mode,
    /// The step whose state was published last.
    pub published: Option<u64>,
    /// Whether the recorder still takes what is said.
    pub open: bool,
}

impl Drive<'_> {
    /// Runs to the end. Whatever ends it, the last good state is published.
    pub(super) fn run(
        &mut self,
        after_step: &mut dyn FnMut(&StepReport),
    ) -> Result<End, NodeError> {
        let end = self.advance(after_step);
        self.publish_once();
        end
    }

    fn advance(&mut self, after_step: &mut dyn FnMut(&StepReport)) -> Result<End, NodeError> {
        let stop = self.stop;
        let stopped = || stop.load(Ordering::Relaxed);
        self.publish_once();
        loop {
            if self.step() >= self.schedule.steps || !self.open {
                return Ok(End::Done);
            }
            if !self.serve()? || stopped() {
                return Ok(End::Stopped);
            }
            after_step(self.simulation.step()?);
            if self.mode == Mode::Running {
                self.pacer.wait(self.simulation.report().time, &stopped);
            }
            if self.schedule.output(self.step()) && !stopped() {
                self.publish_once();
            }
        }
    }

    /// Takes the orders of this boundary, and waits for more while the run is paused; false ends the run.
    fn serve(&mut self) -> Result<bool, NodeError> {
        for _ in 0..MOST_ORDERS {
            let Some(order) = self.inbox.take(self.step()) else {
                break;
            };
            if !self.perform(order)? {
                return Ok(false);
            }
        }
        if self.mode != Mode::Paused {
            return Ok(true);
        }
        self.publish_once();
        while self.mode == Mode::Paused && !self.stop.load(Ordering::Relaxed) && self.open {
            let goes_on = match self.inbox.wait(self.step(), NAP) {
                Waited::Order(order) => self.perform(order)?,
                Waited::Nothing => true,
                Waited::Nobody => false,
            };
            if !goes_on {
                return Ok(false);
            }
        }
        self.pacer.restart();
        Ok(true)
    }

    /// One order; false if it ends the run.
    fn perform(&mut self, order: Order) -> Result<bool, NodeError> {
        let _ = order;
        Ok(true)
    }

    fn step(&self) -> u64 {
        self.simulation.state().step
    }

    /// Publishes the present state, unless that has been done.
    fn publish_once(&mut self) {
        let step = self.step();
        if self.published == Some(step) || !self.open {
            return;
        }
        let first_or_last = self.published.is_none() || step >= self.schedule.steps;
        let with_mesh = first_or_last || !self.schedule.output(step) || self.schedule.mesh(step);
        self.open = self.recorder.publish(Instant {
            state: self.simulation.state().clone(),
            report: self.simulation.report().clone(),
            with_mesh: self.schedule.with_mesh && with_mesh,
        });
        self.published = Some(step);
    }
}
