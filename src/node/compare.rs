//! A carrier that carries nothing: it compares what a run publishes with what was recorded.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};

use nalgebra::Vector3;

use super::difference::{Difference, What};
use super::scan::{Message, Scan};
use super::{Carrier, NodeError};
use crate::wire::cdr::decode;
use crate::wire::channels::{
    APPLIED, CONTACT_MARKERS, CONTACTS, Channel, DIAGNOSTICS, LOG, MESH, REPORT, ROBOT_DESCRIPTION,
    STATE, TF,
};
use crate::wire::messages::sensor_msgs::PointCloud2;
use crate::wire::messages::tf2_msgs::TFMessage;
use crate::wire::messages::toile_msgs::{AppliedCommand, StepReport};
use crate::wire::{Packet, cloud, pose, seconds};

/// Positions and readings of another build or processor may differ by this \[m\].
pub const TOLERANCE: f64 = 1e-5;

/// What a comparison has come to.
#[derive(Clone, Debug, Default)]
pub(super) struct Verdict {
    /// States compared.
    pub states: u64,
    /// Commands compared.
    pub commands: u64,
    /// The first place where the bits differ.
    pub bits: Option<Difference>,
    /// The first place where it is more than may be.
    pub difference: Option<Difference>,
    /// Largest distance between a vertex and its recorded position \[m\].
    pub largest: f64,
}

/// Compares packets with recorded messages, one by one.
pub(super) struct Comparer {
    pub recorded: Scan,
    /// Whether every bit must be the same; if not, what has a [`TOLERANCE`].
    pub strict: bool,
    /// Time at which the replay starts \[ns\].
    pub from: u64,
    /// Step of the run \[s\].
    pub dt: f64,
    pub verdict: Arc<Mutex<Verdict>>,
    /// Set when the comparison is over: there is no use in going on.
    pub stop: Arc<AtomicBool>,
    /// The recording has ended.
    pub ended: bool,
}

/// What depends on the wall, or draws the state.
const NOT_JUDGED: [&Channel; 4] = [&MESH, &CONTACT_MARKERS, &DIAGNOSTICS, &LOG];
/// What is said when it is others than before: at the first instant of a replay there is no before.
const FROM_BEFORE: [&Channel; 2] = [&CONTACTS, &ROBOT_DESCRIPTION];

/// Whether a distance is more than another; one that is not a number is more than any.
fn further(distance: f64, other: f64) -> bool {
    distance > other || distance.is_nan()
}

impl Comparer {
    fn next_recorded(&mut self) -> Result<Option<Message>, NodeError> {
        while let Some(message) = self.recorded.next()? {
            if self.is_judged(&message.topic, message.stamp) {
                return Ok(Some(message));
            }
        }
        Ok(None)
    }

    /// Whether a message follows from scene and commands alone and says more than others do.
    fn is_judged(&self, topic: &str, stamp: u64) -> bool {
        let one_of = |channels: &[&Channel]| channels.iter().any(|c| c.topic == topic);
        let starts = self.from > 0 && stamp <= self.from;
        // A contact that hardly touches is there or not by the last bits.
        let may_fail = !self.strict && topic == CONTACTS.topic;
        let preamble = stamp < self.from;
        let earlier = starts && one_of(&FROM_BEFORE);
        !(one_of(&NOT_JUDGED) || earlier || may_fail || preamble)
    }

    fn with<T>(&self, action: impl FnOnce(&mut Verdict) -> T) -> T {
        action(&mut self.verdict.lock().unwrap_or_else(PoisonError::into_inner))
    }

    /// Notes a difference; `fatal` if it is more than may be.
    fn note(&mut self, stamp: u64, what: What, fatal: bool) {
        let time = seconds(stamp);
        let difference = Difference {
            step: (time / self.dt).round() as u64,
            time,
            what,
        };
        let fatal = fatal || self.strict;
        self.with(|verdict| {
            verdict.bits.get_or_insert_with(|| difference.clone());
            if fatal {
                verdict.difference.get_or_insert(difference);
            }
        });
        if fatal {
            self.ended = true;
            self.stop.store(true, Ordering::Relaxed);
        }
    }

    fn judge(&mut self, packet: &Packet, recorded: &Message) -> Result<(), NodeError> {
        let topic = packet.topic();
        if recorded.topic != *topic || recorded.stamp != packet.stamp {
            let what = What::Order {
                recorded: recorded.topic.clone(),
                recorded_time: seconds(recorded.stamp),
                found: topic.into_owned(),
            };
            self.note(packet.stamp, what, true);
            return Ok(());
        }
        let is = |channel: &'static Channel| std::ptr::eq(packet.channel, channel);
        if is(&STATE) {
            self.with(|verdict| verdict.states += 1);
            return self.judge_state(packet, recorded);
        }
        if is(&APPLIED) {
            self.with(|verdict| verdict.commands += 1);
        }
        if is(&REPORT) {
            return self.judge_report(packet, recorded);
        }
        if packet.bytes == recorded.bytes {
            return Ok(());
        }
        if is(&APPLIED) {
            return self.judge_command(packet, recorded);
        }
        if is(&TF) {
            return self.judge_poses(packet, recorded);
        }
        let topic = recorded.topic.clone();
        self.note(packet.stamp, What::Message { topic }, false);
        Ok(())
    }

    fn judge_state(&mut self, packet: &Packet, recorded: &Message) -> Result<(), NodeError> {
        if packet.bytes == recorded.bytes {
            return Ok(());
        }
        let here: PointCloud2 = decode(&packet.bytes)?;
        let there: PointCloud2 = decode(&recorded.bytes)?;
        let (Some(found), Some(expected)) = (cloud::positions(&here), cloud::positions(&there))
        else {
            return self.misfit(packet.stamp, "a state of another layout");
        };
        if found.len() != expected.len() {
            return self.misfit(packet.stamp, "another number of vertices");
        }
        let size = here.point_step.max(1) as usize;
        let mut points = here.data.chunks(size).zip(there.data.chunks(size));
        let first = points.position(|(a, b)| a != b).unwrap_or(0);
        let distance = |v: usize| (found[v] - expected[v]).norm();
        let mut furthest = first;
        for v in 0..found.len() {
            if further(distance(v), distance(furthest)) {
                furthest = v;
            }
        }
        let largest = distance(furthest);
        let what = What::State {
            vertex: first,
            distance: distance(first),
            furthest,
            largest,
        };
        self.with(|verdict| verdict.largest = verdict.largest.max(largest));
        self.note(packet.stamp, what, further(largest, TOLERANCE));
        Ok(())
    }

    fn judge_report(&mut self, packet: &Packet, recorded: &Message) -> Result<(), NodeError> {
        let here: StepReport = decode(&packet.bytes)?;
        let there: StepReport = decode(&recorded.bytes)?;
        if here.digest != there.digest {
            let what = What::Digest {
                recorded: there.digest,
                found: here.digest,
            };
            self.note(packet.stamp, what, false);
        }
        let pairs = here.reading_values.iter().zip(&there.reading_values);
        for ((found, expected), name) in pairs.zip(&there.reading_names) {
            if found.to_bits() != expected.to_bits() {
                let what = What::Reading {
                    name: name.clone(),
                    recorded: *expected,
                    found: *found,
                };
                self.note(
                    packet.stamp,
                    what,
                    further((found - expected).abs(), TOLERANCE),
                );
            }
        }
        Ok(())
    }

    /// Reasons may be worded otherwise by another version; what was done may not differ.
    fn judge_command(&mut self, packet: &Packet, recorded: &Message) -> Result<(), NodeError> {
        let here: AppliedCommand = decode(&packet.bytes)?;
        let there: AppliedCommand = decode(&recorded.bytes)?;
        let said = |c: &AppliedCommand| match c.accepted {
            true => "accepted".to_string(),
            false => format!("rejected ({})", c.reason),
        };
        let fatal = here.accepted != there.accepted || here.channel != there.channel;
        let what = What::Command {
            channel: there.channel.clone(),
            recorded: said(&there),
            found: said(&here),
        };
        self.note(packet.stamp, what, fatal);
        Ok(())
    }

    fn judge_poses(&mut self, packet: &Packet, recorded: &Message) -> Result<(), NodeError> {
        let here: TFMessage = decode(&packet.bytes)?;
        let there: TFMessage = decode(&recorded.bytes)?;
        let (here, there) = (&here.transforms, &there.transforms);
        let same = here.len() == there.len();
        let near = here.iter().zip(there).all(|(a, b)| {
            let (p, q) = (pose(&a.transform), pose(&b.transform));
            let moved: Vector3<f64> = p.translation.vector - q.translation.vector;
            let turned = p.rotation.angle_to(&q.rotation);
            a.child_frame_id == b.child_frame_id && moved.norm() <= TOLERANCE && turned <= TOLERANCE
        });
        let topic = recorded.topic.clone();
        self.note(packet.stamp, What::Message { topic }, !(same && near));
        Ok(())
    }

    fn misfit(&mut self, stamp: u64, reason: &str) -> Result<(), NodeError> {
        self.note(stamp, What::Misfit(reason.to_string()), true);
        Ok(())
    }
}

impl Carrier for Comparer {
    fn publish(&mut self, packet: &Packet) -> Result<(), NodeError> {
        if self.ended || !self.is_judged(&packet.topic(), packet.stamp) {
            return Ok(());
        }
        match self.next_recorded()? {
            Some(recorded) => self.judge(packet, &recorded),
            // What follows the end of a recording that was cut short has nothing to be compared with.
            None => {
                self.ended = true;
                Ok(())
            }
        }
    }

    fn commit(&mut self) -> Result<(), NodeError> {
        Ok(())
    }

    /// What was recorded must have been published.
    fn close(&mut self) -> Result<(), NodeError> {
        if self.ended {
            return Ok(());
        }
        if let Some(left) = self.next_recorded()? {
            let what = What::Missing {
                topic: left.topic.clone(),
            };
            self.note(left.stamp, what, true);
        }
        Ok(())
    }
}
