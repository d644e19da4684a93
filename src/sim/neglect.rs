//! What a scene leaves out, measured while it runs: an omission is a number, not a hope.

use nalgebra::Vector3;

use super::simulation::Simulation;
use crate::scene::Term;

/// Density of air, 20 °C, sea level \[kg/m³\].
const AIR_DENSITY: f64 = 1.2;
/// Force of air on a plate across the flow over the dynamic pressure \[-\] (Hoerner 1965).
const PLATE: f64 = 1.17;
/// What the paper damps with \[kg/(m²·s)\].
const PAPER_DAMPING: f64 = 0.1;
/// Friction of cloth on a smooth solid, at the low end \[-\].
const FRICTION: f64 = 0.2;

/// Something left out, and how much it would have been.
#[derive(Clone, Debug, PartialEq)]
pub struct Neglect {
    /// The term, or what is none yet.
    pub name: &'static str,
    /// Largest ratio of the run \[-\]: a tolerance below it needs what is left out. Nothing, if it can have no effect.
    pub ratio: Option<f64>,
    /// What the ratio is, in words.
    pub measure: &'static str,
}

/// Watches a run for what it leaves out.
#[derive(Clone, Debug, Default)]
pub struct Neglects {
    drag: f64,
    damping: f64,
    friction: f64,
    inertia: f64,
    gap: f64,
}

impl Neglects {
    /// Nothing seen.
    pub fn new() -> Self {
        Self {
            gap: f64::INFINITY,
            ..Self::default()
        }
    }

    /// Looks at the present state.
    pub fn look(&mut self, simulation: &Simulation) {
        let (model, state) = (simulation.model(), simulation.state());
        let mesh = &model.mesh;
        let mut drag = 0.0;
        for face in &mesh.faces {
            let [a, b, c] = face.map(|v| state.positions[v as usize]);
            let velocity: Vector3<f64> = face
                .iter()
                .map(|&v| state.velocities[v as usize])
                .sum::<Vector3<f64>>()
                / 3.0;
            let normal = (b - a).cross(&(c - a));
            let (twice_area, across) = (normal.norm(), normal.dot(&velocity));
            if twice_area > 0.0 {
                let speed = across / twice_area;
                drag += 0.5 * AIR_DENSITY * PLATE * speed * speed * 0.5 * twice_area;
            }
        }
        let speeds = state.velocities.iter().zip(&mesh.vertex_areas);
        let damping: f64 = speeds
            .map(|(v, area)| PAPER_DAMPING * area * v.norm())
            .sum();
        self.drag = self.drag.max(drag / model.weight);
        self.damping = self.damping.max(damping / model.weight);
        let pressed: f64 = simulation.contacts().iter().map(|c| c.normal_force).sum();
        self.friction = self.friction.max(FRICTION * pressed / model.weight);
        let energies = &simulation.report().energies;
        let strain = energies.stretch + energies.bend;
        if strain > 0.0 {
            self.inertia = energies.kinetic / strain;
        }
        let report = simulation.report();
        let gap = match report.crossings {
            0 => report.layer_gap / model.tiles.thickness(),
            _ => 0.0,
        };
        self.gap = self.gap.min(gap);
    }

    /// What the run left out.
    pub fn found(&self, simulation: &Simulation) -> Vec<Neglect> {
        let model = simulation.model();
        let on = |term: Term| match term {
            Term::Drag => model.drag,
            Term::Damping => model.scene.damping > 0.0,
            Term::Gravity => model.gravity.total() > 0.0,
            Term::Contact => model.contact.is_some(),
            Term::Friction => model.scene.obstacle.values().any(|o| o.friction > 0.0),
            Term::Support => !model.supports.is_empty(),
            Term::Layers => model.layers.is_some(),
            Term::Stretch | Term::Bend => true,
        };
        let left_out = Term::ALL.into_iter().filter(|term| !on(*term));
        left_out.map(|term| self.of(term, simulation)).collect()
    }

    fn of(&self, term: Term, simulation: &Simulation) -> Neglect {
        let (ratio, measure) = match term {
            Term::Drag => (
                Some(self.drag),
                "force of air at rest on a plate of the speed of each face, over the weight",
            ),
            Term::Damping => (
                Some(self.damping),
                "force of the paper's damping, 0.1 kg/(m²·s), over the weight",
            ),
            Term::Friction => (
                simulation.model().contact.map(|_| self.friction),
                "a fifth of the normal force, over the weight; nothing where there is no obstacle",
            ),
            Term::Gravity => (
                Some(bending_number(simulation)),
                "weight over bending, areal density x 9.81 m/s² x size³ / rigidity",
            ),
            Term::Contact => (None, "there is no obstacle, and no command may add one"),
            Term::Support => (None, "nothing is held"),
            Term::Layers => (
                (self.gap < 1.0).then_some(1.0),
                "cloth on cloth: 1 where layers come within a thickness of each other, or cross",
            ),
            Term::Stretch | Term::Bend => (None, "every fabric has it"),
        };
        Neglect {
            name: term.name(),
            ratio,
            measure,
        }
    }

    /// Smallest distance of two layers over the thickness of the cloth \[-\]: 1 if none are nearer, 0 if they cross.
    pub fn gap(&self) -> f64 {
        self.gap
    }

    /// Kinetic over strain energy at the last look \[-\]: near nothing, a transient has become an equilibrium.
    pub fn inertia(&self) -> f64 {
        self.inertia
    }
}

/// (size / bending length)³ in the stiffer direction.
fn bending_number(simulation: &Simulation) -> f64 {
    let (model, fabric) = (simulation.model(), &simulation.model().fabric);
    let rigidity = fabric.bending().c11.max(fabric.bending().c22);
    fabric.areal_density * 9.81 * model.mesh.area().powf(1.5) / rigidity
}
