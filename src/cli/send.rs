//! `toile send`: a command to a running simulation, and what became of it.

mod air;
mod obstacle;

use std::time::Duration;

use clap::{Args, Subcommand};
use serde_json::Value;

use super::transport::TransportArgs;
use super::{CliError, output};
use crate::node::NodeError;
use crate::wire::cdr::{CdrError, decode, encode};
use crate::wire::inbound;
use crate::wire::messages::simulation_interfaces as verbs;
use crate::wire::messages::simulation_interfaces::{
    EntityState, ResetSimulationRequest, Result as Outcome, SimulationState,
};
use crate::wire::messages::toile_msgs::AppliedCommand;
use crate::wire::{Message, Service};

/// Arguments of `toile send`.
#[derive(Args)]
pub(super) struct SendArgs {
    #[command(subcommand)]
    what: What,
    #[command(flatten)]
    transport: TransportArgs,
    /// How long to wait for what becomes of it [s].
    #[arg(long, value_name = "S", global = true, default_value_t = 10.0, value_parser = super::watch::seconds)]
    timeout: f64,
    /// The whole answer as a JSON object.
    #[arg(long, global = true)]
    json: bool,
}

#[derive(Subcommand)]
enum What {
    /// Add, move or remove an obstacle.
    Obstacle(obstacle::ObstacleArgs),
    /// Make the air flow.
    Air(air::AirArgs),
    /// Take no more steps.
    Pause,
    /// Take steps again.
    Resume,
    /// Take so many steps, while paused; answered when they are taken.
    Step {
        /// How many.
        #[arg(default_value_t = 1)]
        count: u64,
    },
    /// Sheet, obstacles and air as at the start; time goes on.
    Reset,
    /// Reset and pause.
    Stop,
    /// End the run, its recording closed.
    Quit,
    /// Say whether the simulation runs.
    State,
    /// Say what can be asked of it.
    Features,
    /// Say where an obstacle is.
    Entity {
        /// Name of the obstacle.
        obstacle: String,
    },
}

/// Reads an answer.
type Reader = Box<dyn Fn(&[u8]) -> Result<Answer, CdrError>>;

/// A message for an inlet, and how to read what comes back.
struct Parcel {
    inlet: &'static str,
    message: Result<Vec<u8>, CdrError>,
    read: Reader,
}

/// What became of it.
struct Answer {
    /// In words; why not, if it was not done.
    said: Result<String, String>,
    /// All of it.
    whole: Value,
}

impl SendArgs {
    pub(super) fn run(&self) -> Result<(), CliError> {
        let Parcel {
            inlet,
            message,
            read,
        } = self.what.parcel()?;
        let inlet = inbound::find(inlet)
            .ok_or_else(|| CliError::Input(format!("there is no inlet {inlet}")))?;
        let message = message.map_err(NodeError::from)?;
        let timeout = Duration::from_secs_f64(self.timeout);
        let answer = self.transport.open()?.call(inlet, &message, timeout)?;
        let Some(answer) = answer else {
            return output::print("sent\n");
        };
        let answer = read(&answer).map_err(NodeError::from)?;
        if self.json {
            output::print_json(&answer.whole)?;
        }
        match answer.said {
            Ok(said) if !self.json => output::print(&format!("{said}\n")),
            Ok(_) => Ok(()),
            Err(reason) => Err(CliError::Refused(reason)),
        }
    }
}

impl What {
    fn parcel(&self) -> Result<Parcel, CliError> {
        Ok(match self {
            What::Obstacle(args) => topic("/toile/cmd/obstacle", &args.command()?),
            What::Air(args) => topic("/toile/cmd/airflow", &args.command()),
            What::Pause => set_state(SimulationState::STATE_PAUSED),
            What::Resume => set_state(SimulationState::STATE_PLAYING),
            What::Stop => set_state(SimulationState::STATE_STOPPED),
            What::Quit => set_state(SimulationState::STATE_QUITTING),
            What::Step { count } => service::<verbs::StepSimulation>(
                "/toile/step_simulation",
                &verbs::StepSimulationRequest { steps: *count },
                |answer| (answer.result, "done".to_string()),
            ),
            What::Reset => service::<verbs::ResetSimulation>(
                "/toile/reset_simulation",
                &verbs::ResetSimulationRequest {
                    scope: ResetSimulationRequest::SCOPE_DEFAULT,
                },
                |answer| (answer.result, "done".to_string()),
            ),
            What::State => service::<verbs::GetSimulationState>(
                "/toile/get_simulation_state",
                &Default::default(),
                |answer| (answer.result, state_name(answer.state.state)),
            ),
            What::Features => service::<verbs::GetSimulatorFeatures>(
                "/toile/get_simulator_features",
                &Default::default(),
                |answer| {
                    let features = answer.features;
                    let outcome = Outcome {
                        result: Outcome::OK,
                        ..Outcome::default()
                    };
                    (outcome, format!("features {:?}", features.features))
                },
            ),
            What::Entity { obstacle } => service::<verbs::GetEntityState>(
                "/toile/get_entity_state",
                &verbs::GetEntityStateRequest {
                    entity: obstacle.clone(),
                },
                |answer| (answer.result, place(&answer.state)),
            ),
        })
    }
}

/// A command on a topic; an AppliedCommand says what became of it.
fn topic<M: Message>(inlet: &'static str, message: &M) -> Parcel {
    let read = |bytes: &[u8]| {
        let applied: AppliedCommand = decode(bytes)?;
        let said = match applied.accepted {
            true => Ok(format!("applied after step {}", applied.step)),
            false => Err(applied.reason.clone()),
        };
        let whole = serde_json::to_value(&applied).unwrap_or_default();
        Ok(Answer { said, whole })
    };
    Parcel {
        inlet,
        message: encode(message),
        read: Box::new(read),
    }
}

/// A verb; `pick` takes its result and what is to be said out of the answer.
fn service<S: Service<Response: 'static>>(
    inlet: &'static str,
    request: &S::Request,
    pick: fn(S::Response) -> (Outcome, String),
) -> Parcel {
    let read = move |bytes: &[u8]| {
        let response: S::Response = decode(bytes)?;
        let whole = serde_json::to_value(&response).unwrap_or_default();
        let (outcome, said) = pick(response);
        let said = match outcome.result {
            Outcome::OK => Ok(said),
            _ => Err(outcome.error_message),
        };
        Ok(Answer { said, whole })
    };
    Parcel {
        inlet,
        message: encode(request),
        read: Box::new(read),
    }
}

fn set_state(state: u8) -> Parcel {
    service::<verbs::SetSimulationState>(
        "/toile/set_simulation_state",
        &verbs::SetSimulationStateRequest {
            state: SimulationState { state },
        },
        |answer| (answer.result, "done".to_string()),
    )
}

fn state_name(state: u8) -> String {
    let name = match state {
        SimulationState::STATE_STOPPED => "stopped",
        SimulationState::STATE_PLAYING => "playing",
        SimulationState::STATE_PAUSED => "paused",
        SimulationState::STATE_QUITTING => "quitting",
        other => return format!("state {other}"),
    };
    name.to_string()
}

/// Where an obstacle is \[m\] and how it moves \[m/s\].
fn place(state: &EntityState) -> String {
    let (at, speed) = (&state.pose.position, &state.twist.linear);
    format!(
        "at {} {} {} m, moving at {} {} {} m/s",
        at.x, at.y, at.z, speed.x, speed.y, speed.z
    )
}

/// Three numbers with commas between them.
fn vector(text: &str) -> Result<[f64; 3], String> {
    numbers(text)
}

/// So many numbers with commas between them.
fn numbers<const N: usize>(text: &str) -> Result<[f64; N], String> {
    let parsed: Result<Vec<f64>, _> = text.split(',').map(|part| part.trim().parse()).collect();
    let parsed = parsed.ok().and_then(|numbers| numbers.try_into().ok());
    parsed.ok_or_else(|| format!("must be {N} numbers with commas between them"))
}
