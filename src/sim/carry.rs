//! What moves by prescription: supports, and obstacles that no command has taken over. Places are functions of the
//! time since the start of the run, never sums of steps.

use nalgebra::Vector3;

use super::model::Model;
use super::state::State;
use crate::contact::{Motion, Obstacle};
use crate::physics::support::Support;
use crate::scene::{Scene, SupportMotion};

/// A part of the sheet that a moving support carries along.
#[derive(Clone, Debug)]
pub struct Carried {
    motion: Motion,
    /// Nodes with the components held and where they are before the motion, from its centre: positions of vertices
    /// \[m\], then slopes of edges \[-\].
    nodes: Vec<(u32, [bool; 3], Vector3<f64>)>,
    vertices: usize,
}

/// A prescribed node: components held, its value and its rate.
pub struct Prescribed {
    /// Vertex, or edge after all vertices.
    pub node: usize,
    /// Components held.
    pub axes: [bool; 3],
    /// Position \[m\] or slope \[-\].
    pub value: Vector3<f64>,
    /// Its rate \[1/s\].
    pub rate: Vector3<f64>,
}

impl Prescribed {
    /// The same of a node with another number.
    pub fn at_node(&self, node: usize) -> Self {
        Self { node, ..*self }
    }
}

impl Carried {
    /// What the scene's moving supports hold, where the nodes start at `nodes`.
    pub fn all(
        scene: &Scene,
        supports: &[Support],
        nodes: &[Vector3<f64>],
        vertices: usize,
    ) -> Vec<Self> {
        let specs = scene.support.values().zip(supports);
        let moving = specs.filter_map(|(spec, support)| Some((spec.motion.as_ref()?, support)));
        let moving = moving.filter(|(_, support)| !support.vertices.is_empty());
        moving
            .map(|(motion, support)| Self::new(motion, support, nodes, vertices))
            .collect()
    }

    fn new(
        motion: &SupportMotion,
        support: &Support,
        nodes: &[Vector3<f64>],
        vertices: usize,
    ) -> Self {
        let held = support.vertices.len();
        let places = support.vertices.iter().map(|&v| nodes[v as usize]);
        let centre = places.sum::<Vector3<f64>>() / held as f64;
        let mut carried = Vec::with_capacity(held + support.edges.len());
        for &v in &support.vertices {
            carried.push((v, support.axes, nodes[v as usize] - centre));
        }
        for &e in &support.edges {
            let node = vertices as u32 + e;
            carried.push((node, [true; 3], nodes[node as usize]));
        }
        Self {
            motion: motion.about(&centre),
            nodes: carried,
            vertices: held,
        }
    }

    /// The nodes held, with the components held.
    pub fn held(&self) -> impl Iterator<Item = (usize, [bool; 3])> {
        self.nodes
            .iter()
            .map(|&(node, axes, _)| (node as usize, axes))
    }

    /// What is prescribed at a time since the start of the run \[s\].
    pub fn at(&self, time: f64) -> impl Iterator<Item = Prescribed> {
        let (pose, velocity) = self.motion.at(time);
        let nodes = self.nodes.iter().enumerate();
        nodes.map(move |(i, &(node, axes, start))| {
            let turned = pose.rotation * start;
            let (value, rate) = (turned, velocity.angular.cross(&turned));
            let is_vertex = i < self.vertices;
            Prescribed {
                node: node as usize,
                axes,
                value: if is_vertex {
                    value + pose.translation.vector
                } else {
                    value
                },
                rate: if is_vertex {
                    rate + velocity.linear
                } else {
                    rate
                },
            }
        })
    }
}

impl Model {
    /// Time since the start of the run, or its last reset, at a time `within` the step that comes \[s\].
    pub fn script_time(&self, state: &State, within: f64) -> f64 {
        let (steps, dt) = (state.step - state.began, self.scene.method.dt);
        // The end of a step is the start of the next to the last bit.
        if within == dt {
            (steps + 1) as f64 * dt
        } else {
            steps as f64 * dt + within
        }
    }

    /// Moves obstacles on by `dt`, to a time since the start of the run \[s\].
    pub fn move_obstacles(&self, obstacles: &mut [Obstacle], time: f64, dt: f64) {
        for obstacle in obstacles {
            let motion = match obstacle.scripted {
                true => self.motions.get(&obstacle.name),
                false => None,
            };
            obstacle.advance(motion.map(|motion| motion.at(time)), dt);
        }
    }

    /// Puts the nodes that moving supports hold where they are at a time since the start of the run \[s\].
    pub fn place_supports(&self, nodes: &mut [Vector3<f64>], time: f64) {
        for held in self.carried.iter().flat_map(|carried| carried.at(time)) {
            set(&mut nodes[held.node], &held.value, held.axes);
        }
    }

    /// The same for positions, slopes and velocities of a state; slopes of implicit schemes have no rates. What is held
    /// needs no past, since it comes from the motion.
    pub fn hold(&self, state: &mut State, time: f64) {
        let vertices = state.positions.len();
        for held in self.carried.iter().flat_map(|carried| carried.at(time)) {
            match held.node.checked_sub(vertices) {
                None => {
                    set(&mut state.positions[held.node], &held.value, held.axes);
                    set(&mut state.velocities[held.node], &held.rate, held.axes);
                    if let Some(past) = state.history.accelerations.get_mut(held.node) {
                        set(past, &Vector3::zeros(), held.axes);
                    }
                }
                Some(edge) => state.slopes[edge] = held.value,
            }
        }
    }

    /// Kinetic energy of what moving supports hold \[J\].
    pub fn held_kinetic(&self, state: &State) -> f64 {
        let held = self.carried.iter().flat_map(Carried::held);
        let vertices = held.filter(|(node, _)| *node < state.positions.len());
        let energy = |(node, axes): (usize, [bool; 3])| {
            let velocity = state.velocities[node];
            let axes = (0..3).filter(|&axis| axes[axis]);
            let square: f64 = axes.map(|axis| velocity[axis] * velocity[axis]).sum();
            0.5 * self.masses[node] * square
        };
        vertices.map(energy).sum()
    }
}

/// Sets some components.
fn set(target: &mut Vector3<f64>, value: &Vector3<f64>, axes: [bool; 3]) {
    for axis in (0..3).filter(|&axis| axes[axis]) {
        target[axis] = value[axis];
    }
}
