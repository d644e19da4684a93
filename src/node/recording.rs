//! Reading a recording back: the scene, the mesh, the states.

use std::collections::BTreeMap;
use std::fs::File;
use std::path::{Path, PathBuf};

use mcap::records::{Record, op};
use nalgebra::Vector3;

use super::NodeError;
use super::bag::Destination;
use super::mcap_file::SCENE_ATTACHMENT;
use super::records::{Span, record, spans, unpack};
use crate::contact::{Obstacle, Velocity};
use crate::scene::Scene;
use crate::wire::cdr::decode;
use crate::wire::channels::{STATE, TF, TOPOLOGY};
use crate::wire::messages::sensor_msgs::PointCloud2;
use crate::wire::messages::tf2_msgs::TFMessage;
use crate::wire::messages::toile_msgs::MeshTopology;
use crate::wire::{self, cloud};

/// A recording on disk, whole or cut short; states are read when asked for.
pub struct Recording {
    path: PathBuf,
    scene: Scene,
    faces: Vec<[u32; 3]>,
    topics: Topics,
    /// Time \[ns\] and chunk of each state.
    states: Vec<(u64, Span)>,
}

/// The world at one instant.
#[derive(Clone, Debug)]
pub struct Frame {
    /// Simulated time \[s\].
    pub time: f64,
    /// Vertex positions \[m\], world frame, shape \[vertices\].
    pub positions: Vec<Vector3<f64>>,
    /// Obstacles where they were; velocities are zero, a recording has only poses.
    pub obstacles: Vec<Obstacle>,
}

/// Topic of each channel number.
type Topics = BTreeMap<u16, String>;

impl Recording {
    /// Opens an MCAP file or a bag directory, and finds all states in it.
    pub fn open(path: &Path) -> Result<Self, NodeError> {
        let path = match path.is_dir() {
            true => Destination::new(path).file().to_path_buf(),
            false => path.to_path_buf(),
        };
        let mut file = File::open(&path).map_err(NodeError::file("open", &path))?;
        let (mut scene, mut topology) = (None, None);
        let (mut topics, mut states) = (Topics::new(), vec![]);
        for span in spans(&mut file, &path)? {
            match span.op {
                op::ATTACHMENT => scene = scene.or(read_scene(&mut file, &path, span)?),
                op::CHUNK => {
                    let chunk = unpack(&mut file, &path, span)?;
                    learn(&chunk, &mut topics);
                    topology = topology.or_else(|| last(&chunk, &topics, TOPOLOGY.topic));
                    let times = messages(&chunk, &topics, STATE.topic).map(|(time, _)| time);
                    states.extend(times.map(|time| (time, span)));
                }
                _ => {}
            }
        }
        let missing = |what| NodeError::unreadable(&path, format!("it holds no {what}"));
        let scene = scene.ok_or_else(|| missing("scene"))?;
        let topology = topology.ok_or_else(|| missing("mesh topology"))?;
        let topology: MeshTopology = decode(&topology)?;
        let (faces, _) = topology.triangles.as_chunks::<3>();
        Ok(Self {
            scene,
            faces: faces.to_vec(),
            topics,
            states,
            path,
        })
    }

    /// The scene that was run.
    pub fn scene(&self) -> &Scene {
        &self.scene
    }

    /// Vertices of each triangle, counter-clockwise.
    pub fn faces(&self) -> &[[u32; 3]] {
        &self.faces
    }

    /// Simulated time of each state \[s\], in order.
    pub fn times(&self) -> Vec<f64> {
        self.states
            .iter()
            .map(|(time, _)| wire::seconds(*time))
            .collect()
    }

    /// The state of an index into [`times`](Self::times), with the obstacles at that time.
    pub fn frame(&self, index: usize) -> Result<Frame, NodeError> {
        let Some(&(stamp, span)) = self.states.get(index) else {
            return Err(NodeError::NoSuchFrame {
                path: self.path.clone(),
                index,
                count: self.states.len(),
            });
        };
        let mut file = File::open(&self.path).map_err(NodeError::file("open", &self.path))?;
        let chunk = unpack(&mut file, &self.path, span)?;
        let at = |topic| {
            let mut found = messages(&chunk, &self.topics, topic).filter(|(t, _)| *t == stamp);
            found.next().map(|(_, bytes)| bytes)
        };
        let state: PointCloud2 = decode(at(STATE.topic).unwrap_or_default())?;
        let positions = cloud::positions(&state)
            .ok_or_else(|| NodeError::unreadable(&self.path, "a state of another layout"))?;
        self.check_faces(positions.len())?;
        let poses = match at(TF.topic) {
            Some(bytes) => decode(bytes)?,
            None => TFMessage::default(),
        };
        Ok(Frame {
            time: wire::seconds(stamp),
            positions,
            obstacles: self.obstacles(&poses),
        })
    }

    /// Whether every triangle has its vertices.
    fn check_faces(&self, vertices: usize) -> Result<(), NodeError> {
        let largest = self.faces.iter().flatten().max();
        match largest.is_some_and(|v| *v as usize >= vertices) {
            true => Err(NodeError::unreadable(
                &self.path,
                format!("a state has {vertices} vertices, the mesh needs more"),
            )),
            false => Ok(()),
        }
    }

    /// The scene's obstacles, moved to the poses that were recorded.
    fn obstacles(&self, poses: &TFMessage) -> Vec<Obstacle> {
        let recorded = |name: &str| {
            let mut transforms = poses.transforms.iter();
            let found = transforms.find(|t| t.child_frame_id == name);
            found.map(|t| wire::pose(&t.transform))
        };
        let placed = self.scene.obstacle.iter().map(|(name, spec)| Obstacle {
            name: name.clone(),
            shape: spec.shape.clone(),
            pose: recorded(name).unwrap_or_else(|| spec.pose()),
            velocity: Velocity::default(),
            friction: spec.friction,
        });
        placed.collect()
    }
}

/// The scene, if the attachment is one.
fn read_scene(file: &mut File, path: &Path, span: Span) -> Result<Option<Scene>, NodeError> {
    let Record::Attachment { header, data, .. } = record(file, path, span)? else {
        return Ok(None);
    };
    if header.name != SCENE_ATTACHMENT {
        return Ok(None);
    }
    let text = std::str::from_utf8(&data).map_err(|e| NodeError::unreadable(path, e))?;
    let scene = toml::from_str(text).map_err(|e| NodeError::unreadable(path, e))?;
    Ok(Some(scene))
}

/// Notes the channels that a chunk announces.
fn learn(chunk: &[Record], topics: &mut Topics) {
    for record in chunk {
        if let Record::Channel(channel) = record {
            topics.insert(channel.id, channel.topic.clone());
        }
    }
}

/// Time \[ns\] and bytes of the messages of a topic in a chunk.
fn messages<'a>(
    chunk: &'a [Record],
    topics: &'a Topics,
    topic: &'static str,
) -> impl Iterator<Item = (u64, &'a [u8])> {
    chunk.iter().filter_map(move |record| match record {
        Record::Message { header, data }
            if topics.get(&header.channel_id).is_some_and(|t| t == topic) =>
        {
            Some((header.log_time, data.as_ref()))
        }
        _ => None,
    })
}

/// Bytes of the last message of a topic in a chunk.
fn last(chunk: &[Record], topics: &Topics, topic: &'static str) -> Option<Vec<u8>> {
    let (_, bytes) = messages(chunk, topics, topic).last()?;
    Some(bytes.to_vec())
}
