//! Contacts: as events, as markers, and as the wrench that a force sensor in the obstacle would read.

use std::collections::BTreeMap;

use nalgebra::Vector3;

use super::cdr::CdrError;
use super::messages::geometry_msgs::{Point, Pose, Quaternion, Wrench, WrenchStamped};
use super::messages::std_msgs::{ColorRGBA, Header};
use super::messages::toile_msgs::{ContactEvent, ContactEvents};
use super::messages::visualization_msgs::{Marker, MarkerArray};
use super::obstacles::{wire_point, wire_vector};
use super::packets::{Packet, packet, packet_of};
use super::{channels, header};
use crate::contact::Obstacle;
use crate::sim::{ContactPoint, SHEET};

/// Length at which the largest contact force is drawn \[m\].
const LONGEST_ARROW: f64 = 0.03;
/// Diameter at which a contact point is drawn \[m\].
const DOT: f64 = 0.002;

/// How often it is said that contacts persist, in simulated time \[Hz\].
const PERSIST_RATE: f64 = 10.0;

/// Remembers the contacts of the output before, to tell what begins, persists and ends.
#[derive(Clone, Debug, Default)]
pub struct ContactWatch {
    before: Vec<ContactPoint>,
    /// Time of the output before, in turns of [`PERSIST_RATE`]; `None` before the first.
    turn: Option<f64>,
}

impl ContactWatch {
    /// What is said of the contacts at an output at a simulated time \[s\]: events if something touches or has
    /// ceased to, a wrench for each obstacle, and markers if they are to be drawn.
    pub fn packets(
        &mut self,
        obstacles: &[Obstacle],
        contacts: Vec<ContactPoint>,
        time: f64,
        with_markers: bool,
    ) -> Result<Vec<Packet>, CdrError> {
        let mut packets = vec![];
        let turn = Some((time * PERSIST_RATE).floor());
        let all = self.turn != turn;
        self.turn = turn;
        let (events, persisting) = events(&self.before, &contacts, all);
        if !events.is_empty() {
            let header = header(time);
            let message = ContactEvents {
                header,
                events,
                persisting,
            };
            packets.push(packet(&channels::CONTACTS, time, &message)?);
        }
        for obstacle in obstacles {
            let message = wrench(obstacle, &contacts, time);
            packets.push(packet_of(obstacle, &channels::WRENCH, time, &message)?);
        }
        if with_markers {
            let message = markers(&contacts, time);
            packets.push(packet(&channels::CONTACT_MARKERS, time, &message)?);
        }
        self.before = contacts;
        Ok(packets)
    }
}

/// The obstacle of a contact, or the sheet itself, whichever of its triangles that is now.
fn body(contact: &ContactPoint) -> &str {
    match contact.obstacle.starts_with(SHEET) {
        true => SHEET,
        false => &contact.obstacle,
    }
}

/// Contacts by obstacle and key.
fn by_key(contacts: &[ContactPoint]) -> BTreeMap<(&str, u64), &ContactPoint> {
    let keyed = contacts.iter().map(|c| ((body(c), c.key), c));
    keyed.collect()
}

/// What begins and ends, with all that persists or how many those are.
fn events(
    before: &[ContactPoint],
    now: &[ContactPoint],
    with_persisting: bool,
) -> (Vec<ContactEvent>, u32) {
    let mut persisting = 0;
    let (before, now) = (by_key(before), by_key(now));
    let mut events: BTreeMap<(&str, u64), ContactEvent> = BTreeMap::new();
    for (key, contact) in &now {
        let phase = match before.contains_key(key) {
            true if !with_persisting => {
                persisting += 1;
                continue;
            }
            true => ContactEvent::PERSIST,
            false => ContactEvent::BEGIN,
        };
        events.insert(*key, event(phase, contact));
    }
    let ended = before.iter().filter(|(key, _)| !now.contains_key(key));
    events.extend(ended.map(|(key, contact)| (*key, event(ContactEvent::END, contact))));
    (events.into_values().collect(), persisting)
}

fn event(phase: u8, contact: &ContactPoint) -> ContactEvent {
    ContactEvent {
        phase,
        obstacle: contact.obstacle.clone(),
        face: contact.face,
        key: contact.key,
        point: wire_point(&contact.point),
        normal: wire_vector(&contact.normal),
        normal_force: contact.normal_force,
        friction_force: wire_vector(&contact.friction_force),
        slip_velocity: wire_vector(&contact.slip_velocity),
        overlap: contact.overlap,
    }
}

/// What the cloth does to an obstacle, about the origin of the obstacle's frame and in its axes: what a force
/// sensor there reads.
pub fn wrench(obstacle: &Obstacle, contacts: &[ContactPoint], time: f64) -> WrenchStamped {
    let (mut force, mut torque) = (Vector3::zeros(), Vector3::zeros());
    for contact in contacts.iter().filter(|c| c.obstacle == obstacle.name) {
        let push = -contact.force();
        let arm = contact.point - obstacle.pose.translation.vector;
        force += push;
        torque += arm.cross(&push);
    }
    let into = obstacle.pose.rotation.inverse();
    WrenchStamped {
        header: Header {
            frame_id: obstacle.name.clone(),
            ..header(time)
        },
        wrench: Wrench {
            force: wire_vector(&(into * force)),
            torque: wire_vector(&(into * torque)),
        },
    }
}

/// Contact points as dots and the forces on the cloth as lines, the largest of them 3 cm long.
fn markers(contacts: &[ContactPoint], time: f64) -> MarkerArray {
    let largest = contacts
        .iter()
        .map(|c| c.force().norm())
        .fold(0.0, f64::max);
    let scale = LONGEST_ARROW / largest.max(f64::MIN_POSITIVE);
    let dots = contacts.iter().map(|c| wire_point(&c.point)).collect();
    let lines = contacts.iter().flat_map(|c| {
        let tip = c.point + c.force() * scale;
        [wire_point(&c.point), wire_point(&tip)]
    });
    let lines = lines.collect();
    MarkerArray {
        markers: vec![
            marker(0, Marker::SPHERE_LIST, DOT, dots, time),
            marker(1, Marker::LINE_LIST, 0.25 * DOT, lines, time),
        ],
    }
}

/// A marker, or none in its place if there are no points.
fn marker(id: i32, kind: i32, size: f64, points: Vec<Point>, time: f64) -> Marker {
    Marker {
        header: header(time),
        ns: "contacts".to_string(),
        id,
        r#type: kind,
        action: match points.is_empty() {
            true => Marker::DELETE,
            false => Marker::ADD,
        },
        pose: Pose {
            orientation: Quaternion {
                w: 1.0,
                ..Quaternion::default()
            },
            ..Pose::default()
        },
        scale: wire_vector(&Vector3::repeat(size)),
        color: ColorRGBA {
            r: 0.85,
            g: 0.25,
            b: 0.15,
            a: 1.0,
        },
        points,
        ..Marker::default()
    }
}
