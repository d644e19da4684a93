//! How simulated time goes against the wall. The physics does not know.

use std::fmt;
use std::str::FromStr;

use super::clock::{Lateness, Metronome};

/// Slowest and fastest factor.
const FACTORS: std::ops::RangeInclusive<f64> = 1e-3..=1e3;

/// How simulated time goes against the wall.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Pace {
    /// As fast as the machine can.
    #[default]
    Free,
    /// So many simulated seconds per second; 1 is real time. A step that takes longer is an overrun, counted.
    Factor(f64),
    /// Starts paused and takes steps only when told how many.
    Lockstep,
}

/// A pace that is none.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error(
    "pace = {0:?} must be free, real, lockstep, or simulated seconds per second from 0.001 to 1000"
)]
pub struct BadPace(String);

impl FromStr for Pace {
    type Err = BadPace;

    fn from_str(text: &str) -> Result<Self, BadPace> {
        match text {
            "free" => Ok(Pace::Free),
            "real" => Ok(Pace::Factor(1.0)),
            "lockstep" => Ok(Pace::Lockstep),
            other => match other.parse() {
                Ok(factor) if FACTORS.contains(&factor) => Ok(Pace::Factor(factor)),
                _ => Err(BadPace(text.to_string())),
            },
        }
    }
}

impl fmt::Display for Pace {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Pace::Free => f.write_str("free"),
            Pace::Factor(1.0) => f.write_str("real"),
            Pace::Factor(factor) => write!(f, "{factor}"),
            Pace::Lockstep => f.write_str("lockstep"),
        }
    }
}

/// Holds a run to its pace.
pub(super) struct Pacer(Option<Metronome>);

impl Pacer {
    pub(super) fn new(pace: Pace) -> Self {
        Self(match pace {
            Pace::Factor(factor) => Some(Metronome::new(factor)),
            Pace::Free | Pace::Lockstep => None,
        })
    }

    /// Waits until the boundary at a simulated time \[s\] is due, or `stopped`.
    pub(super) fn wait(&mut self, time: f64, stopped: &dyn Fn() -> bool) {
        if let Some(metronome) = &mut self.0 {
            metronome.wait(time, stopped);
        }
    }

    /// The run goes on from a simulated time \[s\] now; whatever passed on the wall before does not count.
    pub(super) fn restart(&mut self, time: f64) {
        if let Some(metronome) = &mut self.0 {
            metronome.restart(time);
        }
    }

    pub(super) fn lateness(&self) -> Lateness {
        self.0
            .as_ref()
            .map_or_else(Lateness::default, Metronome::lateness)
    }
}
