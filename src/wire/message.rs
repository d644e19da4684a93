//! The message types: generated structs, and what a reader must know of each.

use serde::Serialize;
use serde::de::DeserializeOwned;

/// What a reader needs to know of a message type.
#[derive(Debug, PartialEq, Eq)]
pub struct MessageType {
    /// Full ROS 2 name, such as `std_msgs/msg/String`.
    pub name: &'static str,
    /// Definition in `ros2msg` form, followed by those of all nested types.
    pub schema: &'static str,
    /// Type hash, `RIHS01_` and 64 hexadecimal digits (REP 2011).
    pub hash: &'static str,
}

/// A struct that mirrors a `.msg`: its serde fields are the message's fields, in order.
pub trait Message: Serialize + DeserializeOwned {
    /// Its ROS 2 type.
    const TYPE: &'static MessageType;
}

/// A service type: what is asked, what is answered.
#[derive(Debug, PartialEq, Eq)]
pub struct ServiceType {
    /// Full ROS 2 name, such as `simulation_interfaces/srv/StepSimulation`.
    pub name: &'static str,
    /// Type of the request.
    pub request: &'static MessageType,
    /// Type of the response.
    pub response: &'static MessageType,
    /// Type hash of the whole service, `RIHS01_` and 64 hexadecimal digits (REP 2011).
    pub hash: &'static str,
}

/// A `.srv`: the two messages and the names of both.
pub trait Service {
    /// What is asked.
    type Request: Message;
    /// What is answered.
    type Response: Message;
    /// Its ROS 2 type.
    const TYPE: &'static ServiceType;
}

/// Structs generated from the `.msg` definitions, a module per ROS 2 package.
pub mod messages {
    include!(concat!(env!("OUT_DIR"), "/messages.rs"));
}
