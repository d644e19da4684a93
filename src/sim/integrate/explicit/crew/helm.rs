//! What the first thread of a crew does in a run of substeps.

use std::sync::atomic::Ordering;

use super::super::super::held;
use super::super::super::leap::{kicked, slowed};
use super::super::portion::Portion;
use super::deck::{Board, Deck, Run, four, lock, three};
use crate::sim::carry::Prescribed;
use crate::sim::lanes::{add, dot, scale};

/// The first thread's way to the others.
pub struct Helm<'a> {
    deck: &'a Deck,
    mine: &'a mut Portion,
    homes: &'a [(u32, u32)],
    /// What moving supports hold, and its places in `mine`.
    held: &'a [(u32, u32)],
    substep: u64,
    /// Vertices near obstacles of each portion, with their places there.
    near: Vec<Vec<(u32, u32)>>,
}

impl<'a> Helm<'a> {
    /// At the start of a run: `mine` is what the first thread moves, `homes` the portion of each vertex and its place there,
    /// `held` what moving supports hold and its places in `mine`.
    pub fn new(
        deck: &'a Deck,
        mine: &'a mut Portion,
        homes: &'a [(u32, u32)],
        held: &'a [(u32, u32)],
    ) -> Self {
        Self {
            near: vec![vec![]; deck.boards.len()],
            deck,
            mine,
            homes,
            held,
            substep: 0,
        }
    }

    /// Moves the sheet on; its largest speed \[m/s\]. Of `whole`, vertices near obstacles move, and what supports hold.
    pub fn drift(&mut self, whole: &mut Portion, held: &[Prescribed]) -> f64 {
        let (deck, dt) = (self.deck, self.deck.run.dt);
        if self.substep == 0 {
            self.mine.swing(dt);
        }
        let places = held.iter().zip(self.held);
        let mine = places.map(|(prescribed, &(_, at))| prescribed.at_node(at as usize));
        deck.drift(0, self.mine, &mine.collect::<Vec<_>>(), self.substep);
        deck.barrier.wait();
        held::send(held, &whole.nodes, &mut whole.rates, dt);
        for &(v, _) in self.near.iter().flatten() {
            let v = v as usize;
            whole.nodes[v] = add(whole.nodes[v], scale(whole.rates[v], dt));
        }
        whole.place(held);
        let turn = (self.substep % 2) as usize;
        let fastest = |board: &Board| board.fastest[turn].load(Ordering::Relaxed);
        // Bits are in the order of the numbers, and above them all where one is no number.
        f64::from_bits(deck.boards.iter().map(fastest).max().unwrap_or_default())
    }

    /// Adds the elastic forces. Of `whole`, what is near or held gets them; if `all` is asked for, every vertex, and its
    /// position and rate.
    pub fn pull(&mut self, whole: &mut Portion, all: bool) {
        let deck = self.deck;
        deck.pull(self.mine, self.substep);
        for &(node, at) in self.held {
            whole.forces[node as usize] = self.mine.forces[at as usize];
        }
        if self.substep + 1 == deck.run.count {
            self.mine.keep_rates();
        }
        if !deck.run.asks(self.substep) {
            return self.go_on();
        }
        deck.ask.store(all, Ordering::Relaxed);
        if all {
            deck.boards[0].post_all(self.mine);
        }
        // What is near gets other rates when contacts are settled; the others wait for that.
        self.go_on();
        deck.barrier.wait();
        if all {
            deck.barrier.wait();
            return self.read_all(whole);
        }
        for &(v, at) in &self.near[0] {
            whole.forces[v as usize] = self.mine.forces[at as usize];
        }
        for (board, near) in deck.boards.iter().zip(&self.near).skip(1) {
            for (&(v, _), force) in near.iter().zip(&lock(&board.near).forces) {
                whole.forces[v as usize] = four(force);
            }
        }
    }

    /// Kicks the first portion, and lets its slopes move on.
    fn go_on(&mut self) {
        let run = self.deck.run;
        self.mine.kick(run.dt, run.damped);
        if self.substep + 1 < run.count {
            self.mine.swing(run.dt);
        }
    }

    fn read_all(&self, whole: &mut Portion) {
        let all: Vec<_> = (self.deck.boards.iter().map(|board| lock(&board.all))).collect();
        for (v, &(p, at)) in self.homes.iter().enumerate() {
            let [nodes, rates, forces] = &*all[p as usize];
            whole.nodes[v] = nodes[at as usize];
            whole.rates[v] = rates[at as usize];
            whole.forces[v] = forces[at as usize];
        }
    }

    /// Sets the vertices that are near obstacles from now on, each once.
    pub fn watch(&mut self, near: impl Iterator<Item = u32>) {
        self.near.iter_mut().for_each(Vec::clear);
        for v in near {
            let (p, at) = self.homes[v as usize];
            self.near[p as usize].push((v, at));
        }
        for (board, near) in self.deck.boards.iter().zip(&self.near).skip(1) {
            lock(&board.near).at = near.iter().map(|near| near.1).collect();
        }
    }

    /// Takes the rates of the vertices to the next half step. Of `whole`, those near obstacles.
    pub fn kick(&mut self, whole: &mut Portion) {
        let Run { dt, damped, .. } = self.deck.run;
        for &(v, _) in self.near.iter().flatten() {
            let v = v as usize;
            let (rate, force, inverse) = (whole.rates[v], whole.forces[v], &whole.inverse_mass[v]);
            if damped {
                let drag = whole.drag[v];
                whole.rates[v] = slowed(rate, force, inverse, drag, dt);
                whole.spends[v] = drag * dot(whole.rates[v], whole.rates[v]);
            } else {
                whole.rates[v] = kicked(rate, force, inverse, dt);
            }
        }
    }

    /// Ends a substep: all get the rates that `whole` has near obstacles.
    pub fn end(&mut self, whole: &Portion) {
        if self.deck.run.asks(self.substep) {
            self.hand_out(whole);
        }
        self.substep += 1;
        if self.deck.run.damped {
            self.mine.spend();
        }
    }

    fn hand_out(&mut self, whole: &Portion) {
        for (board, near) in self.deck.boards.iter().zip(&self.near).skip(1) {
            let rates = near.iter().map(|&(v, _)| {
                let [x, y, z] = three(&whole.rates[v as usize]);
                [x, y, z, whole.spends[v as usize]]
            });
            let near = &mut *lock(&board.near);
            near.rates.clear();
            near.rates.extend(rates);
        }
        self.deck.barrier.wait();
        for &(v, at) in &self.near[0] {
            self.mine.rates[at as usize] = whole.rates[v as usize];
            self.mine.spends[at as usize] = whole.spends[v as usize];
        }
    }
}
