//! The loop: step, publish, take orders at the boundary, until the end or until somebody says stop.

use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use super::inbox::Waited;
use super::mode::Mode;
use super::orders::Awaited;
use super::pace::Pacer;
use super::recorder::{Instant, Recorder, Said};
use super::schedule::Schedule;
use super::{Gauge, Inbox, NodeError, Orders};
use crate::sim::{ContactPoint, Simulation, StepReport};
use crate::wire::{self, Counters, Extras, Level, Packet};

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
    pub inbox: Inbox,
    pub pacer: Pacer,
    pub stop: &'a AtomicBool,
    pub gauges: &'a [Gauge],
    pub schedule: Schedule,
    pub mode: Mode,
    /// What became of the orders so far.
    pub orders: Orders,
    /// Steps that somebody waits for.
    pub awaited: Option<Awaited>,
    /// What is to be published before anything else.
    pub said: Vec<Packet>,
    /// The step whose state was published last.
    pub published: Option<u64>,
    /// Whether the pacer has followed the run since its last pause.
    pub paced: bool,
    /// Whether the recorder still takes what is said.
    pub open: bool,
}

impl<'a> Drive<'a> {
    pub(super) fn new(
        simulation: &'a mut Simulation,
        recorder: &'a Recorder,
        inbox: Inbox,
        pacer: Pacer,
        stop: &'a AtomicBool,
    ) -> Self {
        Self {
            schedule: Schedule::new(&simulation.model().scene),
            simulation,
            recorder,
            inbox,
            pacer,
            stop,
            gauges: &[],
            mode: Mode::Running,
            orders: Orders::default(),
            awaited: None,
            said: vec![],
            published: None,
            paced: false,
            open: true,
        }
    }

    /// Runs to the end. Whatever ends it, the last good state is published and nobody is left waiting.
    pub(super) fn run(
        &mut self,
        after_step: &mut dyn FnMut(&StepReport),
    ) -> Result<End, NodeError> {
        let end = self.advance(after_step);
        if let Err(error) = &end {
            let time = self.simulation.report().time;
            self.said
                .push(wire::log(Level::Error, &error.to_string(), time)?);
        }
        self.publish_once();
        self.orders.dropped = self.inbox.dropped();
        self.orders.late = self.inbox.close();
        self.interrupt()?;
        end
    }

    fn advance(&mut self, after_step: &mut dyn FnMut(&StepReport)) -> Result<End, NodeError> {
        let stop = self.stop;
        let stopped = || stop.load(Ordering::Relaxed);
        self.publish_once();
        loop {
            self.come_to_rest()?;
            if self.step() >= self.schedule.last || !self.open {
                return Ok(End::Done);
            }
            // Orders that came with the stop are left alone: then a replay, which stops at the same boundary, sees
            // what was recorded before it and nothing else.
            let halts = self.schedule.halt == Some(self.step());
            if stopped() || !self.serve()? || stopped() || halts {
                return Ok(End::Stopped);
            }
            self.follow();
            after_step(self.simulation.step()?);
            if self.paced {
                self.pacer.wait(self.simulation.report().time, &stopped);
            }
            if self.schedule.output(self.step()) && !stopped() {
                self.publish_once();
            }
        }
    }

    /// After the last of the steps that were asked for, who asked sees the state and gets an answer.
    fn come_to_rest(&mut self) -> Result<(), NodeError> {
        let mode = self.mode.at(self.step());
        if mode == self.mode {
            return Ok(());
        }
        self.mode = mode;
        self.publish_once();
        self.arrive()
    }

    /// Takes the orders of this boundary, and waits for more while the run stands; false ends the run.
    fn serve(&mut self) -> Result<bool, NodeError> {
        let goes_on = self.take_waiting()?;
        self.say();
        if !goes_on || !self.mode.stands() {
            return Ok(goes_on);
        }
        while self.mode.stands() && !self.stop.load(Ordering::Relaxed) && self.open {
            let goes_on = match self.inbox.wait(self.step(), NAP) {
                // What came with it is published with it.
                Waited::Order(order) => self.perform(order)? && self.take_waiting()?,
                Waited::Nothing => true,
                Waited::Nobody => false,
            };
            self.say();
            if !goes_on {
                return Ok(false);
            }
        }
        self.paced = false;
        Ok(true)
    }

    /// Steps that follow each other are paced, from where they begin; those that were asked for are not.
    fn follow(&mut self) {
        let runs = self.mode == Mode::Running;
        if runs && !self.paced {
            let dt = self.simulation.model().scene.method.dt;
            self.pacer.restart(self.step() as f64 * dt);
        }
        self.paced = runs;
    }

    fn take_waiting(&mut self) -> Result<bool, NodeError> {
        for _ in 0..MOST_ORDERS {
            let Some(order) = self.inbox.take(self.step()) else {
                break;
            };
            if !self.perform(order)? {
                return Ok(false);
            }
        }
        Ok(true)
    }

    /// Steps taken.
    pub(super) fn step(&self) -> u64 {
        self.simulation.state().step
    }

    /// Publishes what became of orders.
    fn say(&mut self) {
        if !self.said.is_empty() && self.open {
            let said = Said::Packets(std::mem::take(&mut self.said));
            self.open = self.recorder.publish(said);
        }
    }

    /// Publishes the present state, unless that has been done.
    pub(super) fn publish_once(&mut self) {
        self.say();
        let step = self.step();
        if self.published == Some(step) || !self.open {
            return;
        }
        let first_or_last = self.published.is_none() || step >= self.schedule.last;
        let with_mesh = first_or_last || !self.schedule.output(step) || self.schedule.mesh(step);
        self.open = self.recorder.publish(Said::Instant(Box::new(Instant {
            state: self.simulation.state().clone(),
            report: self.simulation.report().clone(),
            extras: Extras {
                with_mesh: self.schedule.with_mesh && with_mesh,
                with_keyframe: self.schedule.keyframe(step),
                counters: self.counters(),
                contacts: self.contacts(),
            },
        })));
        self.published = Some(step);
    }

    fn contacts(&self) -> Option<Vec<ContactPoint>> {
        let model = self.simulation.model();
        let has_contact = model.contact.is_some() || model.layers.is_some();
        has_contact.then(|| {
            let mut contacts = self.simulation.contacts();
            contacts.extend(self.simulation.layer_contacts());
            contacts
        })
    }

    fn counters(&self) -> Counters {
        Counters {
            overruns: self.pacer.lateness().overruns,
            dropped_live: self.gauges.iter().map(|g| g.tally().dropped).sum(),
            dropped_commands: self.inbox.dropped(),
            malformed_commands: self.orders.malformed,
        }
    }
}
