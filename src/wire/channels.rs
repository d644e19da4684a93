//! Every channel: topic, type, quality of service and rate, in one table.
//!
//! There is no `/tf_static`: a command may move any obstacle at any time, and a frame may not change from static
//! to moving.

use super::messages::{
    diagnostic_msgs::DiagnosticArray,
    geometry_msgs::WrenchStamped,
    rcl_interfaces::Log,
    rosgraph_msgs::Clock,
    sensor_msgs::PointCloud2,
    std_msgs::String as Text,
    tf2_msgs::TFMessage,
    toile_msgs::{AppliedCommand, ContactEvents, Keyframe, MeshTopology, StepReport},
    visualization_msgs::MarkerArray,
};
use super::{Message, MessageType};

/// How a channel is delivered over DDS; a recording says it to whoever plays the file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Qos {
    /// Best effort, volatile, keep last 1: only the newest state matters.
    Newest,
    /// Reliable, volatile, keep last 10: every message matters to who is there.
    Reliable,
    /// Reliable, transient local, keep last 1: a late joiner gets it too.
    Latched,
}

impl Qos {
    /// rosbag2's `offered_qos_profiles`: a YAML list with numeric policies, all that Humble reads.
    pub fn offered_profiles(self) -> String {
        // history 1 = keep last; reliability 1 = reliable, 2 = best effort; durability 1 = transient local,
        // 2 = volatile; liveliness 1 = automatic; the times are rmw's infinity.
        let (depth, reliability, durability) = match self {
            Qos::Newest => (1, 2, 2),
            Qos::Reliable => (10, 1, 2),
            Qos::Latched => (1, 1, 1),
        };
        let forever = "    sec: 9223372036\n    nsec: 854775807\n";
        format!(
            "- history: 1\n  depth: {depth}\n  reliability: {reliability}\n  durability: {durability}\n  \
             deadline:\n{forever}  lifespan:\n{forever}  liveliness: 1\n  \
             liveliness_lease_duration:\n{forever}  avoid_ros_namespace_conventions: false"
        )
    }
}

/// When a channel speaks.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Rate {
    /// Once, before the first state; what the obstacles look like again when that changes.
    Once,
    /// At the scene's `output.rate`.
    Output,
    /// At the scene's `output.mesh_rate`.
    Mesh,
    /// When something happens.
    Event,
    /// Every simulated second.
    Second,
    /// When the node is told to keep the state.
    Keyframe,
}

/// A channel.
#[derive(Debug, PartialEq, Eq)]
pub struct Channel {
    /// ROS 2 topic; [`OBSTACLE`] in it stands for the name of an obstacle, each of which has a topic of its own.
    pub topic: &'static str,
    /// Type of its messages.
    pub message: &'static MessageType,
    /// Delivery.
    pub qos: Qos,
    /// When it speaks.
    pub rate: Rate,
}

/// Place of an obstacle's name in a topic.
pub const OBSTACLE: &str = "NAME";

impl Channel {
    /// Whether each obstacle has a topic of its own on this channel.
    pub fn is_per_obstacle(&self) -> bool {
        self.topic.split('/').any(|token| token == OBSTACLE)
    }
}

const fn channel<M: Message>(topic: &'static str, qos: Qos, rate: Rate) -> Channel {
    Channel {
        topic,
        message: M::TYPE,
        qos,
        rate,
    }
}

/// The mesh's constant part.
pub static TOPOLOGY: Channel = channel::<MeshTopology>("/toile/topology", Qos::Latched, Rate::Once);
/// URDF of the obstacles.
pub static ROBOT_DESCRIPTION: Channel =
    channel::<Text>("/robot_description", Qos::Latched, Rate::Once);
/// The obstacles that a URDF cannot hold: triangle meshes.
pub static OBSTACLE_MARKERS: Channel =
    channel::<MarkerArray>("/toile/obstacle_markers", Qos::Latched, Rate::Once);
/// Simulated time, for `use_sim_time`.
pub static CLOCK: Channel = channel::<Clock>("/clock", Qos::Newest, Rate::Output);
/// Poses of the obstacles.
pub static TF: Channel = channel::<TFMessage>("/tf", Qos::Reliable, Rate::Output);
/// Vertex positions and velocities.
pub static STATE: Channel = channel::<PointCloud2>("/toile/state", Qos::Newest, Rate::Output);
/// What the step says of itself.
pub static REPORT: Channel = channel::<StepReport>("/toile/report", Qos::Reliable, Rate::Output);
/// The surface, for viewers.
pub static MESH: Channel = channel::<MarkerArray>("/toile/mesh", Qos::Newest, Rate::Mesh);

/// Every command that came in, and what became of it.
pub static APPLIED: Channel =
    channel::<AppliedCommand>("/toile/applied", Qos::Reliable, Rate::Event);

/// What touches, what begins and ceases to.
pub static CONTACTS: Channel =
    channel::<ContactEvents>("/toile/contacts", Qos::Reliable, Rate::Event);
/// What the cloth does to each obstacle.
pub static WRENCH: Channel =
    channel::<WrenchStamped>("/toile/obstacles/NAME/wrench", Qos::Reliable, Rate::Output);
/// Contacts, for viewers.
pub static CONTACT_MARKERS: Channel =
    channel::<MarkerArray>("/toile/contact_markers", Qos::Newest, Rate::Mesh);
/// The whole state, to resume from.
pub static KEYFRAME: Channel =
    channel::<Keyframe>("/toile/keyframe", Qos::Reliable, Rate::Keyframe);
/// How the run does.
pub static DIAGNOSTICS: Channel =
    channel::<DiagnosticArray>("/diagnostics", Qos::Reliable, Rate::Second);
/// The log.
pub static LOG: Channel = channel::<Log>("/rosout", Qos::Latched, Rate::Event);

/// All of them, in the order in which they are published.
pub static ALL: [&Channel; 15] = [
    &TOPOLOGY,
    &ROBOT_DESCRIPTION,
    &OBSTACLE_MARKERS,
    &CLOCK,
    &TF,
    &STATE,
    &REPORT,
    &MESH,
    &CONTACTS,
    &WRENCH,
    &CONTACT_MARKERS,
    &APPLIED,
    &KEYFRAME,
    &DIAGNOSTICS,
    &LOG,
];
