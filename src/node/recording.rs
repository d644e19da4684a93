//! Reading a recording back: the scene, the mesh, the states, the commands.

use std::fs::File;
use std::path::{Path, PathBuf};

use mcap::records::{Record, op};
use nalgebra::Vector3;

use super::bag::Destination;
use super::cast::Cast;
use super::mcap_file::{SCENE_ATTACHMENT, TOILE};
use super::records::{Span, record, spans};
use super::scan::{Message, Scan, Topics};
use super::{About, NodeError};
use crate::contact::Obstacle;
use crate::scene::Scene;
use crate::sim::State;
use crate::wire::cdr::decode;
use crate::wire::channels::{APPLIED, KEYFRAME, STATE, TF, TOPOLOGY};
use crate::wire::messages::sensor_msgs::PointCloud2;
use crate::wire::messages::tf2_msgs::TFMessage;
use crate::wire::messages::toile_msgs::{AppliedCommand, Keyframe, MeshTopology};
use crate::wire::{self, cloud, keyframe};

/// A recording on disk, whole or cut short; states are read when asked for.
pub struct Recording {
    path: PathBuf,
    about: About,
    scene: Scene,
    faces: Vec<[u32; 3]>,
    /// Topics of the whole file.
    topics: Topics,
    /// All chunks, in their order.
    chunks: Vec<Span>,
    /// Time \[ns\] and chunk of each state.
    states: Vec<(u64, Span)>,
    /// Time \[ns\] and chunk of each keyframe.
    keyframes: Vec<(u64, Span)>,
    commands: Vec<AppliedCommand>,
    cast: Cast,
    /// Time of the last message \[ns\].
    end: u64,
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

impl Recording {
    /// Opens an MCAP file or a bag directory, and finds all states and commands in it.
    pub fn open(path: &Path) -> Result<Self, NodeError> {
        let path = file_of(path);
        let mut file = File::open(&path).map_err(NodeError::file("open", &path))?;
        let (mut about, mut scene) = (About::default(), None);
        let spans = spans(&mut file, &path)?;
        for span in &spans {
            match span.op {
                op::METADATA => about = read_about(&mut file, &path, *span)?.unwrap_or(about),
                op::ATTACHMENT => scene = scene.or(read_scene(&mut file, &path, *span)?),
                _ => {}
            }
        }
        let missing = |what| NodeError::unreadable(&path, format!("it holds no {what}"));
        let scene: Scene = scene.ok_or_else(|| missing("scene"))?;
        let chunks: Vec<_> = spans.into_iter().filter(|s| s.op == op::CHUNK).collect();
        let mut scan = Scan::new(&path, chunks.clone(), Topics::new())?;
        let (mut topology, mut commands, mut end) = (None, vec![], 0);
        let (mut states, mut keyframes) = (vec![], vec![]);
        while let Some((span, messages)) = scan.next_chunk()? {
            for message in messages {
                end = end.max(message.stamp);
                match message.topic.as_str() {
                    topic if topic == TOPOLOGY.topic => topology = Some(message.bytes),
                    topic if topic == STATE.topic => states.push((message.stamp, span)),
                    topic if topic == KEYFRAME.topic => keyframes.push((message.stamp, span)),
                    topic if topic == APPLIED.topic => commands.push(decode(&message.bytes)?),
                    _ => {}
                }
            }
        }
        let topology: MeshTopology = decode(&topology.ok_or_else(|| missing("mesh topology"))?)?;
        let (faces, _) = topology.triangles.as_chunks::<3>();
        Ok(Self {
            about,
            faces: faces.to_vec(),
            topics: scan.topics().clone(),
            chunks,
            states,
            keyframes,
            cast: Cast::new(&scene, &commands),
            scene,
            commands,
            end,
            path,
        })
    }

    /// The file.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// How it was made.
    pub fn about(&self) -> &About {
        &self.about
    }

    /// The scene that was run.
    pub fn scene(&self) -> &Scene {
        &self.scene
    }

    /// Vertices of each triangle, counter-clockwise.
    pub fn faces(&self) -> &[[u32; 3]] {
        &self.faces
    }

    /// Everything that came in, in its order.
    pub fn commands(&self) -> &[AppliedCommand] {
        &self.commands
    }

    /// The last step of which there is a message.
    pub fn last_step(&self) -> u64 {
        self.step_at(self.end)
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
        let chunk = self.chunk(span)?;
        let at = |topic| {
            let mut found = chunk.iter();
            let found = found.find(|m| m.topic == topic && m.stamp == stamp);
            found.map(|m| m.bytes.as_slice())
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
            obstacles: self.cast.placed(stamp, &poses),
        })
    }

    /// Steps of which the whole state was kept, in order.
    pub fn keyframes(&self) -> Vec<u64> {
        let steps = self.keyframes.iter();
        steps.map(|(stamp, _)| self.step_at(*stamp)).collect()
    }

    /// The last state that was kept at or before a step, and the chunk of its instant.
    pub(super) fn kept(&self, step: u64) -> Result<Option<(State, Span)>, NodeError> {
        let before = |(stamp, _): &&(u64, Span)| self.step_at(*stamp) <= step;
        let last = self.keyframes.iter().rfind(before);
        // A reset while the run stands says the same step again; the first is the one that came of a step.
        let first = last.and_then(|(stamp, _)| self.keyframes.iter().find(|(s, _)| s == stamp));
        let Some(&(_, span)) = first else {
            return Ok(None);
        };
        let chunk = self.chunk(span)?;
        let bytes = chunk.iter().find(|m| m.topic == KEYFRAME.topic);
        let message: Keyframe = decode(bytes.map(|m| m.bytes.as_slice()).unwrap_or_default())?;
        let state = keyframe::state(&message).map_err(|e| NodeError::unreadable(&self.path, e))?;
        if state.digest() != message.digest {
            let reason = format!("the digest of the keyframe of step {}", message.step);
            return Err(NodeError::unreadable(&self.path, reason + " is another"));
        }
        Ok(Some((state, span)))
    }

    /// All messages from a chunk on, or from the first.
    pub(super) fn scan(&self, from: Option<Span>) -> Result<Scan, NodeError> {
        let start = from.map_or(0, |span| span.start);
        let chunks = self.chunks.iter().filter(|span| span.start >= start);
        Scan::new(&self.path, chunks.copied(), self.topics.clone())
    }

    /// The step that a time \[ns\] belongs to.
    pub(super) fn step_at(&self, stamp: u64) -> u64 {
        (wire::seconds(stamp) / self.scene.method.dt).round() as u64
    }

    fn chunk(&self, span: Span) -> Result<Vec<Message>, NodeError> {
        let mut scan = Scan::new(&self.path, [span], self.topics.clone())?;
        Ok(scan.next_chunk()?.map_or_else(Vec::new, |(_, chunk)| chunk))
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
}

/// The MCAP file of a path, which may be a bag directory.
pub(super) fn file_of(path: &Path) -> PathBuf {
    match path.is_dir() {
        true => Destination::new(path).file().to_path_buf(),
        false => path.to_path_buf(),
    }
}

/// How the recording was made, if the metadata say that.
fn read_about(file: &mut File, path: &Path, span: Span) -> Result<Option<About>, NodeError> {
    Ok(match record(file, path, span)? {
        Record::Metadata(m) if m.name == TOILE => Some(About::from_metadata(&m.metadata)),
        _ => None,
    })
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
