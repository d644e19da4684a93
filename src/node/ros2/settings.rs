//! Where the bridge speaks and under which name: options, and the environment variables of ROS 2.
//!
//! The DDS library ignores the variables, so they are read here.

use std::env;

use ros2_client::NodeName;

use super::Ros2Error;

/// The largest domain whose ports fit into 16 bits (RTPS 2.5, 9.6.1).
const LARGEST_DOMAIN: u16 = 232;

/// How requests and responses of services are told apart on the wire; both sides must agree.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ServiceMapping {
    /// The request's identity travels beside the message: Fast DDS, Connext, ros2-client.
    #[default]
    Enhanced,
    /// The request's identity is a header of 16 bytes in front of the message: Cyclone DDS.
    Cyclone,
}

/// Where and as whom a participant speaks.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Settings {
    /// `ROS_DOMAIN_ID`, 0 to 232.
    pub domain: u16,
    /// Speak on every network interface instead of the loopback alone.
    pub lan: bool,
    /// Name of the node.
    pub node_name: String,
    /// Namespace of the node, `/` or `/some/where`; the topics and services below `/toile` move into it.
    pub namespace: String,
    /// How services are mapped.
    pub services: ServiceMapping,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            domain: 0,
            lan: false,
            node_name: "toile".to_string(),
            namespace: "/".to_string(),
            services: ServiceMapping::default(),
        }
    }
}

impl Settings {
    /// These settings with what the process's environment says of domain and range, names checked.
    pub fn from_environment(self) -> Result<Self, Ros2Error> {
        self.with(|variable| env::var(variable).ok())
    }

    /// The same with any source of variables. An empty variable counts as unset, as in ROS 2.
    pub fn with(mut self, variable: impl Fn(&str) -> Option<String>) -> Result<Self, Ros2Error> {
        let read = |name| variable(name).filter(|value| !value.is_empty());
        if let Some(value) = read("ROS_DOMAIN_ID") {
            let domain = value.trim().parse().ok();
            let allowed = domain.filter(|&domain| domain <= LARGEST_DOMAIN);
            self.domain = allowed.ok_or(Ros2Error::Variable {
                variable: "ROS_DOMAIN_ID",
                value,
                allowed: "a whole number from 0 to 232",
            })?;
        }
        self.check_range(
            read("ROS_LOCALHOST_ONLY"),
            read("ROS_AUTOMATIC_DISCOVERY_RANGE"),
        )?;
        self.check_names()?;
        Ok(self)
    }

    /// The environment may keep a participant on the machine; only `--allow-lan` lets it out.
    fn check_range(
        &self,
        localhost_only: Option<String>,
        range: Option<String>,
    ) -> Result<(), Ros2Error> {
        let forbidden = |variable, value| match self.lan {
            true => Err(Ros2Error::LanForbidden { variable, value }),
            false => Ok(()),
        };
        match localhost_only.as_deref() {
            None | Some("0") => {}
            Some("1") => forbidden("ROS_LOCALHOST_ONLY", "1".to_string())?,
            Some(other) => {
                return Err(Ros2Error::Variable {
                    variable: "ROS_LOCALHOST_ONLY",
                    value: other.to_string(),
                    allowed: "0 or 1",
                });
            }
        }
        match range.as_deref() {
            None | Some("SUBNET" | "SYSTEM_DEFAULT") => Ok(()),
            Some("LOCALHOST") => {
                forbidden("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST".to_string())
            }
            Some(other) => Err(Ros2Error::Variable {
                variable: "ROS_AUTOMATIC_DISCOVERY_RANGE",
                value: other.to_string(),
                allowed: "LOCALHOST, SUBNET or SYSTEM_DEFAULT (without discovery there is no bridge)",
            }),
        }
    }

    fn check_names(&self) -> Result<(), Ros2Error> {
        match self.name() {
            Some(_) if !self.node_name.contains("__") && !self.namespace.contains("__") => Ok(()),
            _ => Err(Ros2Error::Name {
                name: self.node_name.clone(),
                namespace: self.namespace.clone(),
            }),
        }
    }

    /// The node's name as the graph knows it; nothing if ROS 2 does not allow it.
    pub(super) fn name(&self) -> Option<NodeName> {
        NodeName::new(&self.namespace, &self.node_name).ok()
    }

    /// A topic or service of toile in the namespace: only what lies below `/toile` moves, since `/clock`, `/tf`
    /// and their like are shared by convention.
    pub fn resolve(&self, topic: &str) -> String {
        match topic.starts_with("/toile/") && self.namespace != "/" {
            true => format!("{}{topic}", self.namespace),
            false => topic.to_string(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn with(settings: Settings, variables: &[(&str, &str)]) -> Result<Settings, String> {
        let find = |name: &str| {
            let found = variables.iter().find(|(key, _)| *key == name);
            found.map(|(_, value)| value.to_string())
        };
        settings.with(find).map_err(|error| error.to_string())
    }

    #[test]
    fn domains_from_0_to_232() {
        for (text, domain) in [("0", 0), ("232", 232), ("", 0), (" 7 ", 7)] {
            let settings = with(Settings::default(), &[("ROS_DOMAIN_ID", text)]).unwrap();
            assert_eq!(settings.domain, domain, "{text:?}");
        }
        for text in ["233", "-1", "ten", "65536", "1.0"] {
            let refused = with(Settings::default(), &[("ROS_DOMAIN_ID", text)]).unwrap_err();
            let expected = format!(
                "ROS_DOMAIN_ID={text} is not allowed; it takes a whole number from 0 to 232"
            );
            assert_eq!(refused, expected);
        }
    }

    #[test]
    fn the_lan_needs_the_option_and_the_environment() {
        let lan = || Settings {
            lan: true,
            ..Settings::default()
        };
        for variables in [
            &[("ROS_LOCALHOST_ONLY", "0")][..],
            &[("ROS_AUTOMATIC_DISCOVERY_RANGE", "SUBNET")],
            &[],
        ] {
            assert!(with(lan(), variables).unwrap().lan);
            assert!(!with(Settings::default(), variables).unwrap().lan);
        }
        for variable in [
            ("ROS_LOCALHOST_ONLY", "1"),
            ("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST"),
        ] {
            let refused = with(lan(), &[variable]).unwrap_err();
            let (name, value) = variable;
            assert_eq!(
                refused,
                format!("--allow-lan contradicts {name}={value}; unset one of them")
            );
            assert!(!with(Settings::default(), &[variable]).unwrap().lan);
        }
        for variable in [
            ("ROS_LOCALHOST_ONLY", "yes"),
            ("ROS_AUTOMATIC_DISCOVERY_RANGE", "OFF"),
        ] {
            let refused = with(Settings::default(), &[variable]).unwrap_err();
            assert!(refused.starts_with(&format!("{}={}", variable.0, variable.1)));
        }
    }

    #[test]
    fn names_are_those_of_ros() {
        let named = |name: &str, namespace: &str| Settings {
            node_name: name.to_string(),
            namespace: namespace.to_string(),
            ..Settings::default()
        };
        for (name, namespace) in [("toile", "/"), ("cloth_2", "/rig/left")] {
            assert!(with(named(name, namespace), &[]).is_ok());
        }
        for (name, namespace) in [
            ("", "/"),
            ("2toile", "/"),
            ("a b", "/"),
            ("toile", "rig"),
            ("toile", "/rig/"),
            ("to__ile", "/"),
        ] {
            assert!(
                with(named(name, namespace), &[]).is_err(),
                "{name} {namespace}"
            );
        }
    }

    #[test]
    fn only_topics_of_toile_move_into_the_namespace() {
        let settings = Settings {
            namespace: "/rig".to_string(),
            ..Settings::default()
        };
        assert_eq!(settings.resolve("/toile/state"), "/rig/toile/state");
        assert_eq!(settings.resolve("/clock"), "/clock");
        assert_eq!(Settings::default().resolve("/toile/state"), "/toile/state");
    }
}
