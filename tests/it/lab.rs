//! What the verification tests share: scenes, tables of reference values, slopes of log error.

use nalgebra::Vector3;
use toile::physics::Potential;
use toile::scene::{Override, Scene, library, parse};
use toile::sim::Simulation;

/// A scene from TOML.
pub fn scene(text: &str) -> Scene {
    parse(text, &[]).unwrap_or_else(|e| panic!("{e}\n{text}")).0
}

/// A built-in scene with `KEY=VALUE` put in.
pub fn built_in(name: &str, set: &[&str]) -> Scene {
    let text = library::text(name).unwrap();
    let overrides: Vec<Override> = set.iter().map(|s| Override::parse(s).unwrap()).collect();
    parse(text, &overrides).unwrap_or_else(|e| panic!("{e}")).0
}

pub fn simulation(scene: &Scene) -> Simulation {
    Simulation::new(scene, 1).unwrap_or_else(|e| panic!("{e}"))
}

/// Steps to the end of the scene.
pub fn run(scene: &Scene) -> Simulation {
    let mut simulation = simulation(scene);
    for _ in 0..scene.steps() {
        simulation.step().unwrap_or_else(|e| panic!("{e}"));
    }
    simulation
}

/// A reading of the scene by name \[m\].
pub fn reading(simulation: &Simulation, name: &str) -> f64 {
    let readings = &simulation.model().readings;
    let index = readings.iter().position(|r| r.name == name).unwrap();
    simulation.report().readings[index]
}

/// Derivative of the membrane and bending energy by each vertex \[N\]: what supports must hold at rest.
pub fn internal_forces(simulation: &Simulation) -> Vec<Vector3<f64>> {
    let mut forces = node_forces(simulation);
    forces.truncate(simulation.model().masses.len());
    forces
}

/// The same with the moments \[N·m\] on the slopes after the forces on the vertices.
pub fn node_forces(simulation: &Simulation) -> Vec<Vector3<f64>> {
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

/// A table of comma-separated values with one line of names; lines with `#` are comments.
pub struct Table {
    names: Vec<&'static str>,
    rows: Vec<Vec<&'static str>>,
}

impl Table {
    pub fn new(text: &'static str) -> Self {
        let mut lines = text.lines().filter(|line| !line.starts_with('#'));
        let cells = |line: &'static str| line.split(',').collect::<Vec<_>>();
        let names = cells(lines.next().unwrap());
        Self {
            names,
            rows: lines.map(cells).collect(),
        }
    }

    fn column(&self, name: &str) -> usize {
        let names = &self.names;
        names
            .iter()
            .position(|n| *n == name)
            .unwrap_or_else(|| panic!("no column {name}"))
    }

    /// The number in column `name` of the row whose first column reads `key`.
    pub fn get(&self, key: &str, name: &str) -> f64 {
        let column = self.column(name);
        let row = self.rows.iter().find(|row| row[0] == key);
        row.unwrap_or_else(|| panic!("no row {key}"))[column]
            .parse()
            .unwrap()
    }

    /// Where column `of` first reaches a value, in column `wanted`: linear between the rows around it.
    pub fn inverse(&self, of: &str, wanted: &str, value: f64) -> f64 {
        let pair = |row: Row<'_>| [row.get(of), row.get(wanted)];
        let rows: Vec<[f64; 2]> = self.rows(&[]).map(pair).collect();
        let around = |p: &&[[f64; 2]]| p[0][0] <= value && value <= p[1][0];
        let found = rows.windows(2).find(around).unwrap();
        let [[a, from], [b, to]] = [found[0], found[1]];
        from + (to - from) * (value - a) / (b - a)
    }

    /// The rows whose cells read as given.
    pub fn rows(&self, wanted: &[(&str, &str)]) -> impl Iterator<Item = Row<'_>> {
        let wanted: Vec<_> = wanted
            .iter()
            .map(|(name, cell)| (self.column(name), cell.to_string()))
            .collect();
        self.rows
            .iter()
            .filter(move |row| wanted.iter().all(|(column, cell)| row[*column] == cell))
            .map(|cells| Row { table: self, cells })
    }
}

pub struct Row<'a> {
    table: &'a Table,
    cells: &'a [&'static str],
}

impl Row<'_> {
    pub fn get(&self, name: &str) -> f64 {
        self.cells[self.table.column(name)].parse().unwrap()
    }
}

/// Slopes of log error over log size between neighbours.
pub fn slopes(sizes: &[f64], errors: &[f64]) -> Vec<f64> {
    let pair = |i: usize| (errors[i] / errors[i + 1]).ln() / (sizes[i] / sizes[i + 1]).ln();
    (0..sizes.len() - 1).map(pair).collect()
}
