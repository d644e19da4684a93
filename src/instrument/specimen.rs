//! A specimen at rest in its instrument.

use nalgebra::{Vector2, Vector3};

use super::{Direction, MeasureError};
use crate::physics::Potential;
use crate::scene::{FabricSpec, parse};
use crate::sim::{Simulation, State};

/// Sum of residual forces over the weight at which a specimen is at rest \[-\].
const REST: f64 = 1e-8;

/// A rectangular cut of fabric.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cut {
    pub direction: Direction,
    /// Along sheet x \[m\].
    pub length: f64,
    /// Along sheet y \[m\].
    pub width: f64,
    /// Edge length of the mesh \[m\].
    pub edge: f64,
    /// Seed of the mesh.
    pub seed: u64,
}

impl Cut {
    /// A scene of the cut: `held` are its tables of supports and what else differs between instruments. No specimen is
    /// held so that it meets itself, so none looks for layers.
    pub fn scene(&self, name: &str, fabric: &FabricSpec, gravity: f64, held: &str) -> String {
        let Cut {
            length,
            width,
            edge,
            seed,
            ..
        } = *self;
        let fabric = toml::to_string(fabric).expect("a fabric is TOML");
        let angle = self.direction.warp_angle();
        format!(
            "name = \"{name}\"\ndescription = \"A specimen in an instrument\"\nduration = 1.0\n\
             gravity = [0.0, 0.0, {:?}]\n\
             [sheet]\noutline = {{ kind = \"rectangle\", length = {length:?}, width = {width:?} }}\n\
             edge = {edge:?}\nmesh_seed = {seed}\nwarp_angle = {angle:?}\n\
             [layers]\ncontact = \"off\"\n\
             [fabric]\n{fabric}\n{held}",
            -gravity
        )
    }

    /// Refuses a cut with fewer than two edges across it.
    pub fn check(&self) -> Result<(), MeasureError> {
        for (field, size) in [("length", self.length), ("width", self.width)] {
            if size < 2.0 * self.edge {
                // Sizes that suit the fabric have more digits than a reader wants.
                let edge = (1e6 * self.edge).round() * 1e-6;
                let size = (1e6 * size).round() * 1e-6;
                let allowed = format!(
                    "at least {} m, two edges of the mesh (edge = {edge} m)",
                    2.0 * edge
                );
                return Err(MeasureError::setting(field, size, allowed));
            }
        }
        Ok(())
    }
}

/// A specimen at rest.
pub struct Rest {
    simulation: Simulation,
    /// Derivative of the energies by every node \[N\].
    forces: Vec<Vector3<f64>>,
}

impl Rest {
    /// Brings a scene to rest, from the given state if there is one and it fits.
    pub fn find(scene: &str, from: Option<State>) -> Result<Self, MeasureError> {
        let (scene, _) = parse(scene, &[])?;
        let mut simulation = Simulation::new(&scene, 1)?;
        if let Some(state) = from {
            // Another mesh: the flat start will do.
            let _ = simulation.resume(state);
        }
        let tolerance = REST.max(rounding(&simulation));
        simulation.settle(tolerance)?;
        let forces = internal_forces(&simulation);
        Ok(Self { simulation, forces })
    }

    pub fn simulation(&self) -> &Simulation {
        &self.simulation
    }

    pub fn triangles(&self) -> usize {
        self.simulation.model().mesh.faces.len()
    }

    /// Force with which what holds these vertices pulls at them \[N\]; `inside` takes sheet coordinates.
    pub fn force(&self, inside: impl Fn(&Vector2<f64>) -> bool) -> Vector3<f64> {
        let held = self.vertices(inside);
        held.iter().map(|&v| self.forces[v]).sum()
    }

    /// Mean position of the vertices of a place \[m\].
    pub fn place(&self, inside: impl Fn(&Vector2<f64>) -> bool) -> Vector3<f64> {
        let vertices = self.vertices(inside);
        let positions = &self.simulation.state().positions;
        vertices.iter().map(|&v| positions[v]).sum::<Vector3<f64>>() / vertices.len() as f64
    }

    fn vertices(&self, inside: impl Fn(&Vector2<f64>) -> bool) -> Vec<usize> {
        let outline = &self.simulation.model().mesh.outline;
        (0..outline.len())
            .filter(|&v| inside(&outline[v]))
            .collect()
    }

    /// Sum of the unbalanced forces over the weight, the moments on slopes over their edge's length \[-\].
    pub fn residual(&self) -> f64 {
        let (model, state) = (self.simulation.model(), self.simulation.state());
        let vertices = model.masses.len();
        let unbalanced = |node: usize, force: &Vector3<f64>| match node < vertices {
            true => {
                let weight = model.gravity.gradient(node, &[state.positions[node]])[0];
                model.dofs.free(node, force + weight).norm()
            }
            false => {
                let length = model.mesh.edge_length(node - vertices);
                model.dofs.free(node, *force).norm() / length
            }
        };
        let forces = self.forces.iter().enumerate();
        forces
            .map(|(node, force)| unbalanced(node, force))
            .sum::<f64>()
            / model.weight
    }
}

/// The residual below which rounding leaves nothing to gain \[-\]: membrane forces are differences of positions times
/// a stiffness that is large against the weight, more so for a fine mesh.
fn rounding(simulation: &Simulation) -> f64 {
    let model = simulation.model();
    let stiffness = model.fabric.membrane();
    let stiffness = stiffness.c11.max(stiffness.c22);
    let size = 2.0 * model.scene.sheet.outline.half_extent().norm();
    let each = f64::EPSILON * stiffness * size / model.weight;
    each * model.masses.len() as f64
}

/// Derivative of the membrane and bending energy by each node \[N\].
fn internal_forces(simulation: &Simulation) -> Vec<Vector3<f64>> {
    let (model, nodes) = (simulation.model(), simulation.state().nodes());
    let mut forces = vec![Vector3::zeros(); nodes.len()];
    add(&model.stretch, &nodes, &mut forces);
    add(&model.bend, &nodes, &mut forces);
    forces
}

fn add<const N: usize>(
    term: &impl Potential<N>,
    nodes: &[Vector3<f64>],
    forces: &mut [Vector3<f64>],
) {
    for s in 0..term.count() {
        let stencil = term.nodes(s);
        let gradient = term.gradient(s, &stencil.map(|n| nodes[n as usize]));
        for (n, g) in stencil.iter().zip(gradient) {
            forces[*n as usize] += g;
        }
    }
}
