//! What the parts of a step cost: `cargo bench`, or `cargo bench -- step` for one of them.
//!
//! Stopwatches are for people; what a slowdown must not pass is counted in `tests/it/work.rs`.

use divan::Bencher;
use nalgebra::Vector3;
use toile::contact::Nearby;
use toile::math::cholesky::Cholesky;
use toile::scene::{Override, Scene, library, parse};
use toile::sim::{Assembly, Model, Simulation};
use toile::wire::{Encoder, Extras};

/// Sizes of the sheet \[triangles\].
const SIZES: [usize; 2] = [1400, 5750];

fn main() {
    divan::main();
}

fn built_in(name: &str, set: &[&str]) -> Scene {
    let text = library::text(name).expect("built in");
    let set: Vec<_> = set
        .iter()
        .map(|s| Override::parse(s).expect("an override"))
        .collect();
    parse(text, &set).expect("a scene").0
}

/// The drape over the table after `time` \[s\], with a method.
fn drape(triangles: usize, scheme: &str, time: f64) -> Simulation {
    let set = [
        &*format!("sheet.triangles={triangles}"),
        &format!("method.scheme={scheme}"),
        "method.dt=2e-3",
    ];
    let mut simulation = Simulation::new(&built_in("drape-table", &set), 1).expect("a simulation");
    for _ in 0..(time / 2e-3).round() as u64 {
        simulation.step().expect("a step");
    }
    simulation
}

/// Tangent of a state as the assembly and the Cholesky factorisation see it.
struct Tangent {
    simulation: Simulation,
    assembly: Assembly,
    nodes: Vec<Vector3<f64>>,
    values: Vec<f64>,
}

impl Tangent {
    fn new(triangles: usize, threads: usize) -> Self {
        let simulation = drape(triangles, "central-difference", 0.1);
        let assembly = Assembly::new(simulation.model(), threads);
        let mut tangent = Self {
            nodes: simulation.state().nodes(),
            values: vec![0.0; assembly.pattern().entries()],
            simulation,
            assembly,
        };
        tangent.assemble();
        tangent
    }

    fn model(&self) -> &Model {
        self.simulation.model()
    }

    /// At a step of 5 ms, without the stress of the membrane: positive definite.
    fn assemble(&mut self) {
        let model = self.simulation.model();
        let stresses = vec![Vector3::zeros(); model.mesh.faces.len()];
        let weights = (1.0 / 5e-3_f64.powi(2), 0.0);
        self.assembly.tangent(
            model,
            &self.nodes,
            &stresses,
            weights,
            0.0,
            &mut self.values,
        );
    }
}

#[divan::bench(args = SIZES, consts = [1, 2])]
fn assembly_of_forces<const THREADS: usize>(bencher: Bencher, triangles: usize) {
    let mut tangent = Tangent::new(triangles, THREADS);
    let mut forces = vec![Vector3::zeros(); tangent.nodes.len()];
    bencher.bench_local(|| {
        let model = tangent.simulation.model();
        tangent
            .assembly
            .internal(model, &tangent.nodes, &mut forces);
    });
}

#[divan::bench(args = SIZES, consts = [1, 2])]
fn assembly_of_tangent<const THREADS: usize>(bencher: Bencher, triangles: usize) {
    let mut tangent = Tangent::new(triangles, THREADS);
    bencher.bench_local(|| tangent.assemble());
}

#[divan::bench(args = SIZES)]
fn factorisation(bencher: Bencher, triangles: usize) {
    let tangent = Tangent::new(triangles, 1);
    let mut cholesky = Cholesky::new(tangent.assembly.pattern().clone());
    bencher.bench_local(|| {
        cholesky
            .factorise(&tangent.values)
            .expect("positive definite")
    });
}

#[divan::bench(args = SIZES)]
fn solve(bencher: Bencher, triangles: usize) {
    let tangent = Tangent::new(triangles, 1);
    let mut cholesky = Cholesky::new(tangent.assembly.pattern().clone());
    cholesky
        .factorise(&tangent.values)
        .expect("positive definite");
    let mut rhs = vec![1.0; tangent.model().dofs.size];
    bencher.bench_local(|| cholesky.solve(&mut rhs, 1));
}

/// Collecting what is near the table, over the whole sheet.
#[divan::bench(args = SIZES)]
fn contact(bencher: Bencher, triangles: usize) {
    let simulation = drape(triangles, "central-difference", 0.1);
    let (model, state) = (simulation.model(), simulation.state());
    let offset = model.contact.expect("a table").offset;
    bencher.bench_local(|| {
        Nearby::find(
            &model.mesh,
            &state.positions,
            &state.obstacles[0],
            offset,
            1e-3,
        )
    });
}

/// All that goes out of one instant: state, report, mesh, contacts.
#[divan::bench(args = SIZES)]
fn encode(bencher: Bencher, triangles: usize) {
    let simulation = drape(triangles, "central-difference", 0.1);
    let contacts = simulation.contacts();
    bencher.bench_local(|| {
        let extras = Extras {
            with_mesh: true,
            contacts: Some(contacts.clone()),
            ..Extras::default()
        };
        let (model, state) = (simulation.model(), simulation.state());
        Encoder::default().instant(model, state, simulation.report(), extras)
    });
}

/// Whole steps of 2 ms, one after the other, from where the corners fall freely.
#[divan::bench(args = ["central-difference", "bdf2"], sample_count = 20, sample_size = 1)]
fn step(bencher: Bencher, scheme: &str) {
    let mut simulation = drape(1400, scheme, 0.02);
    bencher.bench_local(|| simulation.step().expect("a step").digest);
}
