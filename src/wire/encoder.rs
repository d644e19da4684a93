//! From model, state and report to encoded messages, and what is only said when it changes.

use super::cdr::CdrError;
use super::messages::{rosgraph_msgs::Clock, std_msgs::String as Text};
use super::packets::{Packet, packet};
use super::{
    ContactWatch, Counters, channels, cloud, diagnostics, keyframe, markers, report,
    robot_description, solids, stamp, topology, transforms,
};
use crate::contact::{Obstacle, Shape};
use crate::sim::{ContactPoint, Model, State, StepReport};

/// What is said of a state beside the state itself.
#[derive(Clone, Debug, Default)]
pub struct Extras {
    /// Whether surface and contacts are to be drawn.
    pub with_mesh: bool,
    /// Whether the whole state is to be kept.
    pub with_keyframe: bool,
    /// What the node has counted.
    pub counters: Counters,
    /// Where the sheet touches; nothing in a scene without contact.
    pub contacts: Option<Vec<ContactPoint>>,
}

/// Encodes the instants of a run, one after the other.
#[derive(Clone, Debug, Default)]
pub struct Encoder {
    contacts: ContactWatch,
    /// Obstacles whose shapes have been said.
    described: Vec<(String, Shape)>,
    /// Simulated second of the next diagnostics.
    second: f64,
}

impl Encoder {
    /// What is said once, before the first state: mesh and shapes.
    pub fn preamble(
        &mut self,
        model: &Model,
        obstacles: &[Obstacle],
    ) -> Result<Vec<Packet>, CdrError> {
        let mut packets = vec![packet(&channels::TOPOLOGY, 0.0, &topology(&model.mesh))?];
        packets.extend(self.describe(obstacles, 0.0)?);
        Ok(packets)
    }

    /// What is said of one state; the shapes too, if they are others than before.
    pub fn instant(
        &mut self,
        model: &Model,
        state: &State,
        step: &StepReport,
        extras: Extras,
    ) -> Result<Vec<Packet>, CdrError> {
        let time = step.time;
        let mut packets = vec![];
        if !self.described.iter().eq(&shapes(&state.obstacles)) {
            packets.extend(self.describe(&state.obstacles, time)?);
        }
        let clock = Clock { clock: stamp(time) };
        packets.push(packet(&channels::CLOCK, time, &clock)?);
        if !state.obstacles.is_empty() {
            let poses = transforms(&state.obstacles, time);
            packets.push(packet(&channels::TF, time, &poses)?);
        }
        packets.push(packet(&channels::STATE, time, &cloud::encode(state, time))?);
        let said = report(model, step, &extras.counters);
        packets.push(packet(&channels::REPORT, time, &said)?);
        if extras.with_mesh {
            let surface = markers(&model.mesh, &state.positions, time);
            packets.push(packet(&channels::MESH, time, &surface)?);
        }
        if let Some(contacts) = extras.contacts {
            let watch = &mut self.contacts;
            packets.extend(watch.packets(&state.obstacles, contacts, time, extras.with_mesh)?);
        }
        if extras.with_keyframe {
            let whole = keyframe::keyframe(state, state.digest(), time);
            packets.push(packet(&channels::KEYFRAME, time, &whole)?);
        }
        if time >= self.second {
            packets.push(diagnostics(step, &extras.counters)?);
            self.second = time.floor() + 1.0;
        }
        for packet in &mut packets {
            packet.step = step.step;
            packet.digest = step.digest;
        }
        Ok(packets)
    }

    fn describe(&mut self, obstacles: &[Obstacle], time: f64) -> Result<Vec<Packet>, CdrError> {
        let mesh = |(_, shape): &(String, Shape)| matches!(shape, Shape::Mesh(_));
        let before = self.described.iter().any(mesh);
        self.described = shapes(obstacles);
        let urdf = Text {
            data: robot_description(obstacles),
        };
        let mut packets = vec![packet(&channels::ROBOT_DESCRIPTION, time, &urdf)?];
        if before || self.described.iter().any(mesh) {
            let drawn = solids(obstacles, time);
            packets.push(packet(&channels::OBSTACLE_MARKERS, time, &drawn)?);
        }
        Ok(packets)
    }
}

fn shapes(obstacles: &[Obstacle]) -> Vec<(String, Shape)> {
    let shapes = obstacles.iter().map(|o| (o.name.clone(), o.shape.clone()));
    shapes.collect()
}
