//! Patches of the sheet, and how near two of them may have come since they were searched.
//!
//! What was at least a distance apart stays so but for the motion of one patch against the other, which is at most that
//! of their means and the farthest departures from these; or, since a rigid motion of both changes no distance, what is
//! left of that when the one has turned with the other. Most patches move along with those that are near them; where two
//! do not, they alone are searched again.

use nalgebra::{Matrix3, Vector3};

use super::tiles::Tiles;

type Point = Vector3<f64>;

/// Searches that are remembered at a time; with one more, what is left of the oldest is searched again.
const MOST_BASES: usize = 16;

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
    bases: Vec<Vec<Point>>,
    rooms: Vec<Room>,
    stale: Vec<bool>,
    motions: Vec<Motion>,
}

/// How a patch has moved since a search.
#[derive(Clone, Copy, Debug, Default)]
struct Motion {
    /// Where its middle was, and how that has moved \[m\].
    middle: Point,
    shift: Point,
    /// Farthest departure from that shift \[m\].
    astray: f64,
    /// How it has turned, about.
    turn: Matrix3<f64>,
    /// Farthest departure from that turn \[m\].
    bent: f64,
    /// Its farthest point from the middle \[m\].
    size: f64,
}

impl Motion {
    fn of((patch, corners): (&[u32], &[u32; 3]), from: &[Point], to: &[Point]) -> Self {
        let at = |list: &[Point], v: u32| list[v as usize];
        let [before, after] = [from, to].map(|list| frame(corners.map(|v| at(list, v))));
        let turn = after * before.transpose();
        let mut sums = [Point::zeros(); 2];
        for &v in patch {
            sums[0] += at(from, v);
            sums[1] += at(to, v);
        }
        let [middle, end] = sums.map(|sum| sum / patch.len().max(1) as f64);
        let shift = end - middle;
        let mut most = [0.0f64; 3];
        for &v in patch {
            let (x, y) = (at(from, v) - middle, at(to, v) - end);
            for (most, away) in most.iter_mut().zip([y - x, y - turn * x, x]) {
                let square = away.norm_squared();
                // `f64::max` would pass over what is not a number.
                *most = if square <= *most { *most } else { square };
            }
        }
        let [astray, bent, size] = most.map(f64::sqrt);
        Self {
            middle,
            shift,
            astray,
            turn,
            bent,
            size,
        }
    }

    /// How much nearer two patches may have come, not caring that they have turned \[m\].
    fn nearer(&self, other: &Self) -> f64 {
        (self.shift - other.shift).norm() + self.astray + other.astray
    }

    /// The same, seen from this patch as it has turned.
    fn nearer_turned(&self, other: &Self) -> f64 {
        let apart = other.middle - self.middle;
        let off = apart + other.shift - self.shift - self.turn * apart;
        off.norm() + (other.turn - self.turn).norm() * other.size + self.bent + other.bent
    }
}

/// Axes along a triangle; those of the world where it has no area.
fn frame([a, b, c]: [Point; 3]) -> Matrix3<f64> {
    let axes = || {
        let x = (b - a).try_normalize(0.0)?;
        let z = x.cross(&(c - a)).try_normalize(1e-12)?;
        Some(Matrix3::from_columns(&[x, z.cross(&x), z]))
    };
    axes().unwrap_or_else(Matrix3::identity)
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
        self.bases.resize(1, vec![]);
        positions.clone_into(&mut self.bases[0]);
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
        let full = self.bases.len() == MOST_BASES;
        let patches = tiles.patches.len();
        let (mut count, mut least) = (0, f64::INFINITY);
        let mut n = 0;
        for b in 0..patches {
            for a in 0..=b {
                let room = self.rooms[n];
                let motions = &self.motions[room.base as usize * patches..];
                let (one, other) = (&motions[a], &motions[b]);
                let mut left = room.size - one.nearer(other);
                if left < wanted {
                    left = left.max(room.size - one.nearer_turned(other));
                }
                // What is not a number is stale, too.
                let enough = left >= wanted && !(full && room.base == 0);
                self.stale[n] = !enough;
                count += usize::from(!enough);
                least = if enough && left < least { left } else { least };
                n += 1;
            }
        }
        (count, least)
    }

    /// Begins another search at `positions`, of what is stale.
    pub fn begin(&mut self, positions: &[Point]) {
        if self.bases.len() == MOST_BASES {
            self.bases.remove(0);
            let rooms = self.rooms.iter_mut();
            rooms.for_each(|room| room.base = room.base.saturating_sub(1));
        }
        self.bases.push(positions.to_vec());
    }

    /// Whether two patches have to be searched.
    pub fn is_stale(&self, two: Two) -> bool {
        self.stale[number(two)]
    }

    /// Which patches have to be searched with some other or with themselves; and between which of them, those beside
    /// each other, tiles touch.
    pub fn stale_patches(&self, tiles: &Tiles) -> [Vec<bool>; 2] {
        let grid = tiles.levels[tiles.patch_level];
        let (mut all, mut touching) = (vec![false; grid.len()], vec![false; grid.len()]);
        let mut n = 0;
        for b in 0..grid.len() {
            for a in 0..=b {
                if self.stale[n] {
                    (all[a], all[b]) = (true, true);
                    let around = grid.around([a, b]).into_iter().flatten();
                    around.for_each(|t| touching[t] = true);
                }
                n += 1;
            }
        }
        [all, touching]
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
        self.motions.clear();
        for (n, needed) in needed.into_iter().enumerate() {
            let (base, patch) = (&self.bases[n / patches], n % patches);
            let patch = (&tiles.patches[patch][..], &tiles.patch_corners[patch]);
            self.motions.push(match needed {
                true => Motion::of(patch, base, positions),
                false => Motion::default(),
            });
        }
    }
}
