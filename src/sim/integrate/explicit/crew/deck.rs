//! What the threads of a crew share in a run of substeps, and what each but the first does.

use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Mutex, MutexGuard, PoisonError, RwLock};

use super::super::apart::Apart;
use super::super::portion::Portion;
use super::barrier::Barrier;
use crate::sim::carry::Prescribed;
use crate::sim::lanes::Lanes;

/// A run of substeps.
#[derive(Clone, Copy)]
pub struct Run {
    /// Length of a substep \[s\].
    pub dt: f64,
    pub count: u64,
    pub damped: bool,
    /// Whether the sheet may meet obstacles.
    pub contact: bool,
    /// Whether moments of it are kept.
    pub moments: bool,
}

impl Run {
    /// Whether the place that a substep leads to is kept.
    pub fn keeps(&self, substep: u64) -> bool {
        self.moments && Apart::is_moment(substep + 1, self.count)
    }

    /// Whether more is asked of the sheet in a substep than that it moves.
    pub fn asks(&self, substep: u64) -> bool {
        self.contact || self.keeps(substep)
    }
}

/// What a portion shows to others.
#[derive(Default)]
pub struct Board {
    /// Nodes lent, in turns: a portion may be a substep behind.
    pub lent: [RwLock<Vec<Lanes>>; 2],
    pub fastest: [AtomicU64; 2],
    pub near: Mutex<Near>,
    /// Positions, rates and forces of all own vertices, when they are asked for.
    pub all: Mutex<[Vec<Lanes>; 3]>,
}

/// What goes between the first thread and another of the other's vertices near obstacles: no more than must, since every
/// cache line takes as long as some faces.
#[derive(Default)]
pub struct Near {
    pub at: Vec<u32>,
    pub forces: Vec<[f64; 3]>,
    /// With what damping took out in the fourth place.
    pub rates: Vec<[f64; 4]>,
}

/// What the threads share in a run.
pub struct Deck {
    pub run: Run,
    pub barrier: Barrier,
    pub boards: Vec<Board>,
    /// Whether all is asked for in this substep.
    pub ask: AtomicBool,
}

impl Deck {
    /// For so many threads.
    pub fn new(run: Run, threads: usize) -> Self {
        Self {
            run,
            barrier: Barrier::new(threads),
            boards: (0..threads).map(|_| Board::default()).collect(),
            ask: AtomicBool::new(false),
        }
    }

    /// What another thread than the first does.
    pub fn work(&self, p: usize, portion: &mut Portion) {
        let _guard = self.barrier.guard();
        let run = self.run;
        let Run {
            dt, count, damped, ..
        } = run;
        for substep in 0..count {
            let (last, asked) = (substep + 1 == count, run.asks(substep));
            if substep == 0 {
                portion.swing(dt);
            }
            self.drift(p, portion, &[], substep);
            self.barrier.wait();
            self.pull(portion, substep);
            if last {
                portion.keep_rates();
            }
            if asked {
                self.boards[p].post_near(portion);
                self.barrier.wait();
                if self.ask.load(Ordering::Relaxed) {
                    self.boards[p].post_all(portion);
                    self.barrier.wait();
                }
            }
            portion.kick(dt, damped);
            if !last {
                portion.swing(dt);
            }
            if asked {
                self.barrier.wait();
                self.boards[p].read_rates(portion);
            }
            if damped {
                portion.spend();
            }
        }
    }

    /// Moves a portion on, with what moving supports hold of it, and shows it.
    pub fn drift(&self, p: usize, portion: &mut Portion, held: &[Prescribed], substep: u64) {
        let turn = (substep % 2) as usize;
        let fastest = portion.drift(held, self.run.dt);
        let board = &self.boards[p];
        board.fastest[turn].store(fastest.to_bits(), Ordering::Relaxed);
        let mut lent = board.lent[turn]
            .write()
            .unwrap_or_else(PoisonError::into_inner);
        lent.clear();
        lent.extend(portion.lent.iter().map(|&at| portion.nodes[at as usize]));
    }

    /// The elastic forces, once all have moved.
    pub fn pull(&self, portion: &mut Portion, substep: u64) {
        let turn = (substep % 2) as usize;
        for (p, board) in self.boards.iter().enumerate() {
            let lent = board.lent[turn]
                .read()
                .unwrap_or_else(PoisonError::into_inner);
            for &(at, _, place) in portion.copies.iter().filter(|copy| copy.1 == p as u32) {
                portion.nodes[at as usize] = lent[place as usize];
            }
        }
        if substep + 1 == self.run.count {
            portion.read_slope_rates(self.run.dt);
        }
        portion.pull();
    }
}

impl Board {
    fn post_near(&self, portion: &Portion) {
        let near = &mut *lock(&self.near);
        let forces = near
            .at
            .iter()
            .map(|&at| three(&portion.forces[at as usize]));
        near.forces.clear();
        near.forces.extend(forces);
    }

    pub fn post_all(&self, portion: &Portion) {
        let all = &mut *lock(&self.all);
        let own = portion.vertices.clone();
        *all = [&portion.nodes, &portion.rates, &portion.forces].map(|of| of[own.clone()].to_vec());
    }

    fn read_rates(&self, portion: &mut Portion) {
        let near = lock(&self.near);
        for (&at, rate) in near.at.iter().zip(&near.rates) {
            let [x, y, z, spends] = *rate;
            portion.rates[at as usize] = four(&[x, y, z]);
            portion.spends[at as usize] = spends;
        }
    }
}

pub fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

pub fn three(lanes: &Lanes) -> [f64; 3] {
    [lanes[0], lanes[1], lanes[2]]
}

pub fn four(three: &[f64; 3]) -> Lanes {
    Lanes([three[0], three[1], three[2], 0.0])
}
