//! A run under way that a test talks to, as a robot would.

use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::sync::mpsc::{Receiver, channel};
use std::thread::{self, JoinHandle};
use std::time::Duration;

use toile::node::{Inbox, Mailbox, Memory, NodeError, Order, Pace, RunOptions, Summary, run};
use toile::scene::Scene;
use toile::wire::channels::Channel;
use toile::wire::messages::geometry_msgs::{Point, Pose, Quaternion};
use toile::wire::messages::shape_msgs::SolidPrimitive;
use toile::wire::messages::simulation_interfaces::{
    Result as Reply, SetSimulationStateRequest, SetSimulationStateResponse, SimulationState,
    StepSimulationRequest, StepSimulationResponse,
};
use toile::wire::messages::toile_msgs::{AppliedCommand, ObstacleCommand};
use toile::wire::{Message, cdr, inbound};

/// Longer than any answer takes.
const PATIENCE: Duration = Duration::from_secs(60);

pub const STATE: &str = "/toile/set_simulation_state";
pub const STEP: &str = "/toile/step_simulation";
pub const OBSTACLE: &str = "/toile/cmd/obstacle";

/// A message as it comes in, nobody waiting for an answer.
pub fn order<M: Message>(inlet: &str, message: &M) -> Order {
    Order {
        inlet: inbound::find(inlet).expect("an inlet"),
        bytes: cdr::encode(message).expect("encodes"),
        reply: None,
    }
}

/// A wish for a state, by its code.
pub fn wish(state: u8) -> SetSimulationStateRequest {
    SetSimulationStateRequest {
        state: SimulationState { state },
    }
}

pub fn pose(x: f64, y: f64, z: f64) -> Pose {
    Pose {
        position: Point { x, y, z },
        orientation: Quaternion {
            x: 0.0,
            y: 0.0,
            z: 0.0,
            w: 1.0,
        },
    }
}

pub fn move_to(name: &str, [x, y, z]: [f64; 3]) -> ObstacleCommand {
    ObstacleCommand {
        operation: ObstacleCommand::MOVE,
        name: name.to_string(),
        set_pose: true,
        pose: pose(x, y, z),
        ..ObstacleCommand::default()
    }
}

pub fn add_ball(name: &str, radius: f64, [x, y, z]: [f64; 3]) -> ObstacleCommand {
    ObstacleCommand {
        operation: ObstacleCommand::ADD,
        name: name.to_string(),
        shape: ObstacleCommand::SOLID,
        solid: SolidPrimitive {
            r#type: SolidPrimitive::SPHERE,
            dimensions: vec![radius],
            ..SolidPrimitive::default()
        },
        friction: 0.3,
        pose: pose(x, y, z),
        ..ObstacleCommand::default()
    }
}

pub struct Session {
    pub mailbox: Mailbox,
    memory: Memory,
    worker: JoinHandle<Result<Summary, NodeError>>,
}

impl Session {
    pub fn start(scene: Scene, pace: Pace, stop: Arc<AtomicBool>) -> Self {
        let (mailbox, inbox) = Inbox::with_mailbox();
        let memory = Memory::default();
        let options = RunOptions {
            carriers: vec![Box::new(memory.clone())],
            inbox,
            pace,
            stop,
            ..RunOptions::default()
        };
        Self {
            mailbox,
            memory,
            worker: thread::spawn(move || run(&scene, options, &mut |_| {})),
        }
    }

    pub fn lockstep(scene: Scene) -> Self {
        Self::start(scene, Pace::Lockstep, Arc::default())
    }

    /// Posts a request; the answer comes some time.
    pub fn ask<M: Message>(&self, inlet: &str, request: &M) -> Receiver<Vec<u8>> {
        let (reply, answer) = channel();
        let order = Order {
            reply: Some(reply),
            ..order(inlet, request)
        };
        self.mailbox.post(order).expect("there is room");
        answer
    }

    /// Calls a service.
    pub fn call<Q: Message, A: Message>(&self, inlet: &str, request: &Q) -> A {
        let bytes = self.ask(inlet, request).recv_timeout(PATIENCE);
        cdr::decode(&bytes.expect("an answer")).expect("decodes")
    }

    /// Sends a command; what became of it.
    pub fn tell<M: Message>(&self, inlet: &str, command: &M) -> AppliedCommand {
        self.call(inlet, command)
    }

    pub fn step(&self, steps: u64) -> Reply {
        let answer: StepSimulationResponse = self.call(STEP, &StepSimulationRequest { steps });
        answer.result
    }

    pub fn set(&self, state: u8) -> Reply {
        let answer: SetSimulationStateResponse = self.call(STATE, &wish(state));
        answer.result
    }

    /// What has been published on a channel so far.
    pub fn heard<M: Message>(&self, channel: &Channel) -> Vec<M> {
        let packets = self.memory.packets();
        let packets = packets.iter().filter(|p| p.channel == channel);
        packets
            .map(|p| cdr::decode(&p.bytes).expect("decodes"))
            .collect()
    }

    /// Waits for the end of the run.
    pub fn finish(self) -> (Summary, Memory) {
        let summary = self.worker.join().expect("no panic");
        (summary.expect("no error"), self.memory)
    }
}
