//! How near two patches of the sheet may have come since they were searched.
//!
//! What was at least a distance apart stays so but for the motion of one patch against the other. Most patches move and
//! turn along with those that are near them; where two do not, they alone are searched again.

use nalgebra::Vector3;

use super::patches::{Motion, Stand};
use super::tiles::Tiles;

type Point = Vector3<f64>;

/// Searches that are remembered at a time; with one more, what is left of the oldest counts from there on.
const MOST_BASES: usize = 4;

/// Two patches, the smaller first.
pub(super) type Two = [u32; 2];

/// What a search has left between two patches.
#[derive(Clone, Copy, Debug)]
struct Room {
    /// In which search.
    base: u32,
    /// How much nearer they may come before something unseen may touch \[m\].
    size: f64,
}

/// Room between all patches.
#[derive(Clone, Debug, Default)]
pub(super) struct Rooms {
    /// Where the sheet was in the searches.
    bases: Vec<Stand>,
    now: Stand,
    rooms: Vec<Room>,
    /// What is left of each at the last judgement \[m\].
    left: Vec<f64>,
    stale: Vec<bool>,
    motions: Vec<Motion>,
}

/// Place of a pair of patches in a list of all.
fn number([a, b]: Two) -> usize {
    let (a, b) = (a.min(b) as usize, a.max(b) as usize);
    b * (b + 1) / 2 + a
}

impl Rooms {
    /// Forgets all searches; everything is to be searched at `positions`.
    pub fn reset(&mut self, tiles: &Tiles, positions: &[Point]) {
        let count = tiles.patches.len();
        self.bases.truncate(1);
        self.bases.resize(1, Stand::default());
        self.bases[0].take(tiles, positions);
        let nothing = Room { base: 0, size: 0.0 };
        self.rooms.clear();
        self.rooms.resize(count * (count + 1) / 2, nothing);
        self.stale.clear();
        self.stale.resize(self.rooms.len(), true);
    }

    /// Finds which patches have, at `positions`, less room than `wanted` left, and have to be searched again there.
    /// Returns how many, and the least room of the others \[m\].
    pub fn judge(&mut self, tiles: &Tiles, positions: &[Point], wanted: f64) -> (usize, f64) {
        self.move_all(tiles, positions);
        let (patches, grid) = (tiles.patches.len(), tiles.levels[tiles.patch_level]);
        let (mut count, mut least) = (0, f64::INFINITY);
        self.left.resize(self.rooms.len(), 0.0);
        let mut n = 0;
        for b in 0..patches {
            for a in 0..=b {
                let room = self.rooms[n];
                let motions = &self.motions[room.base as usize * patches..];
                let (first, second) = (&motions[a], &motions[b]);
                let nearer = match grid.beside([a, b]) {
                    true => first.turning(second),
                    false => first.sliding(second),
                };
                let left = room.size - nearer;
                // What is not a number is stale, too.
                let enough = left >= wanted;
                self.left[n] = left;
                self.stale[n] = !enough;
                count += usize::from(!enough);
                least = if enough && left < least { left } else { least };
                n += 1;
            }
        }
        (count, least)
    }

    /// Begins another search, of what was judged stale, where it was judged.
    pub fn begin(&mut self) {
        let mut base = Stand::default();
        if self.bases.len() == MOST_BASES {
            base = self.bases.remove(0);
            let newest = MOST_BASES as u32 - 1;
            for (room, left) in self.rooms.iter_mut().zip(&self.left) {
                match room.base {
                    0 => {
                        *room = Room {
                            base: newest,
                            size: *left,
                        }
                    }
                    _ => room.base -= 1,
                }
            }
        }
        base.clone_from(&self.now);
        self.bases.push(base);
    }

    /// Whether two patches have to be searched.
    pub fn is_stale(&self, two: Two) -> bool {
        self.stale[number(two)]
    }

    /// Which patches have to be searched with some other or with themselves.
    pub fn stale_patches(&self, tiles: &Tiles) -> Vec<bool> {
        let mut stale = vec![false; tiles.patches.len()];
        let mut n = 0;
        for b in 0..stale.len() {
            for a in 0..=b {
                stale[a] |= self.stale[n];
                stale[b] |= self.stale[n];
                n += 1;
            }
        }
        stale
    }

    /// Enters what the newest search has left between two patches \[m\].
    pub fn enter(&mut self, two: Two, size: f64) {
        let base = self.bases.len() as u32 - 1;
        self.rooms[number(two)] = Room { base, size };
    }

    /// Motions of patches since the searches that left them room.
    fn move_all(&mut self, tiles: &Tiles, positions: &[Point]) {
        let patches = tiles.patches.len();
        let mut needed = vec![false; self.bases.len() * patches];
        let mut n = 0;
        for b in 0..patches {
            for a in 0..=b {
                let first = self.rooms[n].base as usize * patches;
                (needed[first + a], needed[first + b]) = (true, true);
                n += 1;
            }
        }
        self.now.take(tiles, positions);
        self.motions.clear();
        for (base, needed) in self.bases.iter().zip(needed.chunks_exact(patches)) {
            self.now.motions(base, needed, &mut self.motions, tiles);
        }
    }
}
