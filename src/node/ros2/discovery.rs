//! The ROS 2 graph: names on the wire, and which topics belong to the node.

use ros2_client::builtin_topics::ros_discovery::{QOS_PUB, TOPIC_NAME, TYPE_NAME};
use ros2_client::dds::rustdds::no_key::DataWriterCdr;
use ros2_client::dds::rustdds::{DomainParticipant, GUID, Publisher, RTPSEntity, TopicKind};
use ros2_client::entities_info::{NodeEntitiesInfo, ParticipantEntitiesInfo};

use super::dds::failure;
use super::{Ros2Error, Settings};

/// DDS name of a ROS 2 topic.
pub fn topic(name: &str) -> String {
    format!("rt{name}")
}

/// DDS name of the topic on which a service's requests come.
pub fn requests(service: &str) -> String {
    format!("rq{service}Request")
}

/// DDS name of the topic on which a service's responses go.
pub fn responses(service: &str) -> String {
    format!("rr{service}Reply")
}

/// DDS name of a ROS 2 type: `std_msgs/msg/String` is `std_msgs::msg::dds_::String_`.
pub fn type_name(ros: &str) -> String {
    match ros.rsplit_once('/') {
        Some((package, name)) => format!("{}::dds_::{name}_", package.replace('/', "::")),
        None => format!("{ros}_"),
    }
}

/// Says on `ros_discovery_info` which writers and readers make up the node, so that `ros2 node info` knows.
pub struct Announcement {
    writer: DataWriterCdr<ParticipantEntitiesInfo>,
    participant: GUID,
    node: NodeEntitiesInfo,
    domain: u16,
}

impl Announcement {
    /// A node without topics, not yet announced.
    pub fn new(
        participant: &DomainParticipant,
        publisher: &Publisher,
        settings: &Settings,
    ) -> Result<Self, Ros2Error> {
        let domain = settings.domain;
        let name = settings.name().ok_or_else(|| Ros2Error::Name {
            name: settings.node_name.clone(),
            namespace: settings.namespace.clone(),
        })?;
        let topic = participant
            .create_topic(
                TOPIC_NAME.to_string(),
                TYPE_NAME.to_string(),
                &QOS_PUB,
                TopicKind::NoKey,
            )
            .map_err(failure(domain, TOPIC_NAME))?;
        let writer = publisher
            .create_datawriter_no_key_cdr(&topic, None)
            .map_err(failure(domain, TOPIC_NAME))?;
        Ok(Self {
            writer,
            participant: participant.guid(),
            node: NodeEntitiesInfo::new(name),
            domain,
        })
    }

    pub fn add_writer(&mut self, guid: GUID) {
        self.node.add_writer(guid.into());
    }

    pub fn add_reader(&mut self, guid: GUID) {
        self.node.add_reader(guid.into());
    }

    /// Publishes what has been added so far; late joiners get it too.
    pub fn publish(&self) -> Result<(), Ros2Error> {
        let info = ParticipantEntitiesInfo::new(self.participant.into(), vec![self.node.clone()]);
        self.writer
            .write(info, None)
            .map_err(|error| failure(self.domain, TOPIC_NAME)(error.to_string()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_mangled_as_ros_2_does() {
        assert_eq!(topic("/toile/state"), "rt/toile/state");
        assert_eq!(requests("/toile/step"), "rq/toile/stepRequest");
        assert_eq!(responses("/toile/step"), "rr/toile/stepReply");
        assert_eq!(
            type_name("sensor_msgs/msg/PointCloud2"),
            "sensor_msgs::msg::dds_::PointCloud2_"
        );
    }
}
