//! Whether a run goes on or stands, and how orders change that.

use crate::wire::inbound::{Outcome, Request, RunState};

/// Whether a run goes on or stands.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Mode {
    /// Steps follow each other at the run's pace.
    Running,
    /// No step is taken, and nothing has happened since the start or a stop.
    Stopped,
    /// No step is taken for now.
    Paused,
    /// As fast as the machine can up to this step, then paused.
    Stepping {
        /// Last step to take.
        until: u64,
    },
}

impl Mode {
    /// Whether no step is taken.
    pub(super) fn stands(self) -> bool {
        matches!(self, Mode::Stopped | Mode::Paused)
    }

    /// At the boundary after a step: the steps that were asked for may be over.
    pub(super) fn at(self, step: u64) -> Mode {
        match self {
            Mode::Stepping { until } if until <= step => Mode::Paused,
            other => other,
        }
    }

    /// What the standard verbs call it.
    pub(super) fn state(self) -> RunState {
        match self {
            Mode::Running | Mode::Stepping { .. } => RunState::Playing,
            Mode::Stopped => RunState::Stopped,
            Mode::Paused => RunState::Paused,
        }
    }

    /// Told to pause.
    pub(super) fn pause(&mut self) -> Outcome {
        match self {
            Mode::Running | Mode::Stepping { .. } => self.turn(Mode::Paused),
            Mode::Paused => Outcome::AlreadyThere(self.state()),
            Mode::Stopped => Outcome::WrongState(self.state()),
        }
    }

    /// Told to go on.
    pub(super) fn resume(&mut self) -> Outcome {
        match self {
            Mode::Running => Outcome::AlreadyThere(self.state()),
            _ => self.turn(Mode::Running),
        }
    }

    /// Told, after `step`, to take so many steps.
    pub(super) fn go(&mut self, step: u64, count: u64) -> Outcome {
        let until = step.saturating_add(count);
        match self.stands() {
            true => self.turn(Mode::Stepping { until }),
            false => Outcome::WrongState(self.state()),
        }
    }

    /// After a request that was accepted when `step` had been taken.
    pub(super) fn after(mut self, request: &Request, step: u64) -> Mode {
        match request {
            Request::Pause => drop(self.pause()),
            Request::Resume => drop(self.resume()),
            Request::Step(count) => drop(self.go(step, *count)),
            Request::Stop { .. } => self = Mode::Stopped,
            Request::Features | Request::GetState | Request::GetEntity { .. } => {}
            Request::Command(_) | Request::Object(_) | Request::Spawn { .. } => self.touched(),
        }
        self
    }

    /// The world was changed: it is no longer as at the start.
    pub(super) fn touched(&mut self) {
        if *self == Mode::Stopped {
            *self = Mode::Paused;
        }
    }

    fn turn(&mut self, mode: Mode) -> Outcome {
        *self = mode;
        Outcome::Done
    }
}
