//! Several threads on one sheet: each moves a portion of its own all the time, since nodes that go from one core's cache
//! to another's cost more than the work on them. The first thread also has what moving supports hold, and meets the
//! obstacles, for which the others send it the forces on what is near and get back its rates. Bits are those of one thread.

mod barrier;
mod deck;
mod helm;

use std::sync::Arc;
use std::sync::mpsc::{Receiver, Sender, channel};
use std::thread;

use super::portion::Portion;
use crate::sim::carry::Carried;
use crate::sim::lanes::Lanes;
use crate::sim::model::Model;
use deck::Deck;
pub use deck::Run;
pub use helm::Helm;

/// Fewest faces for each thread; with less, meeting costs more than is shared.
const FEWEST_FACES: usize = 700;
/// What it costs to find and settle contacts, over the work on all nodes: the first thread moves as much less of the sheet.
const CONTACT: f64 = 0.3;
/// Least share of the first thread.
const LEAST: f64 = 0.02;

/// The threads that share a sheet. They live as long as it and sleep between runs: one that begins may have to wait for a
/// core longer than a run takes.
pub struct Crew {
    /// What the first thread moves.
    mine: Portion,
    others: Vec<Mate>,
    /// Portion of each vertex, and its place there.
    homes: Vec<(u32, u32)>,
    /// Nodes that moving supports hold, and their places in `mine`.
    held: Vec<(u32, u32)>,
}

/// Another thread than the first, and what it moves, while that is here.
struct Mate {
    portion: Option<Portion>,
    orders: Sender<(Arc<Deck>, Portion)>,
    done: Receiver<Portion>,
}

impl Mate {
    fn new(p: usize, portion: Portion) -> Self {
        let (orders, ordered) = channel::<(Arc<Deck>, Portion)>();
        let (finished, done) = channel();
        thread::spawn(move || {
            while let Ok((deck, mut portion)) = ordered.recv() {
                deck.work(p, &mut portion);
                drop(deck);
                // Nobody waits for it if the first thread panicked.
                let _ = finished.send(portion);
            }
        });
        Self {
            portion: Some(portion),
            orders,
            done,
        }
    }

    fn start(&mut self, deck: &Arc<Deck>, whole: &Portion) {
        let mut portion = self.portion.take().expect("it came back from the last run");
        portion.load(whole, deck.run.dt);
        let sent = self.orders.send((Arc::clone(deck), portion));
        sent.expect("the thread waits for orders");
    }

    fn finish(&mut self, whole: &mut Portion) {
        let portion = self.done.recv().expect("the thread has finished its run");
        portion.unload(whole);
        self.portion = Some(portion);
    }
}

impl Crew {
    /// Cuts `whole` for so many threads, if it is worth that.
    pub fn new(model: &Model, whole: &Portion, threads: usize) -> Option<Self> {
        let threads = threads.min(model.mesh.faces.len() / FEWEST_FACES);
        if threads < 2 {
            return None;
        }
        let mut portions = whole.cut(model, &shares(model, threads)).into_iter();
        let mine = portions.next()?;
        let others: Vec<Mate> = (1..)
            .zip(portions)
            .map(|(p, own)| Mate::new(p, own))
            .collect();
        let mut homes = vec![(0, 0); model.masses.len()];
        let others_own = others.iter().filter_map(|mate| mate.portion.as_ref());
        for (p, portion) in (0..).zip(std::iter::once(&mine).chain(others_own)) {
            for at in portion.vertices.clone() {
                homes[portion.names[at] as usize] = (p, at as u32);
            }
        }
        let mut places = vec![0; whole.names.len()];
        for (at, &name) in mine.names.iter().enumerate() {
            places[name as usize] = at as u32;
        }
        let held = model.carried.iter().flat_map(Carried::held);
        let held = held.map(|(node, _)| (node as u32, places[node]));
        Some(Self {
            held: held.collect(),
            mine,
            others,
            homes,
        })
    }

    /// Takes a run of substeps of the sheet at `whole` that `lead` directs; then `whole` is where it ends.
    pub fn take(&mut self, whole: &mut Portion, run: Run, lead: impl FnOnce(&mut Portion, Helm)) {
        let threads = 1 + self.others.len();
        let deck = Arc::new(Deck::new(run, threads));
        for mate in &mut self.others {
            mate.start(&deck, whole);
        }
        self.mine.load(whole, run.dt);
        let guard = deck.barrier.guard();
        let helm = Helm::new(&deck, &mut self.mine, &self.homes, &self.held);
        lead(whole, helm);
        drop(guard);
        self.mine.unload(whole);
        for mate in &mut self.others {
            mate.finish(whole);
        }
    }
}

/// The share of the nodes that each thread moves.
fn shares(model: &Model, threads: usize) -> Vec<f64> {
    let besides = if model.contact.is_some() {
        CONTACT
    } else {
        0.0
    };
    let first = ((1.0 + besides) / threads as f64 - besides).max(LEAST);
    let other = (1.0 - first) / (threads - 1) as f64;
    (0..threads)
        .map(|p| if p == 0 { first } else { other })
        .collect()
}

impl Portion {
    fn load(&mut self, whole: &Self, dt: f64) {
        let of = |all: &[Lanes]| self.names.iter().map(|&n| all[n as usize]).collect();
        (self.nodes, self.rates) = (of(&whole.nodes), of(&whole.rates));
        self.begin(dt);
    }

    fn unload(&self, whole: &mut Self) {
        for at in self.vertices.clone().chain(self.slopes.clone()) {
            let name = self.names[at] as usize;
            whole.nodes[name] = self.nodes[at];
            whole.rates[name] = self.rates[at];
            whole.forces[name] = self.forces[at];
            whole.before_last[name] = self.before_last[at];
        }
        for (at, spent) in self.spent.iter().enumerate() {
            whole.spent[self.names[at] as usize] = *spent;
        }
    }
}
