//! Folds of a drape as its shadow shows them: a fold is a rise and fall of the outline by more than a part of the
//! overhang.

use super::shadow::{DIRECTIONS, Shadow};

/// Rise and fall that make a fold, over the overhang.
pub const PROMINENCE: f64 = 0.05;

/// One fold.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fold {
    /// Radius of its tip \[m\].
    pub tip: f64,
    /// Distance between the valleys on its two sides \[m\].
    pub width: f64,
    /// Radius of the tip less the mean radius of the two valleys \[m\].
    pub depth: f64,
}

/// Finds the folds of an outline, `overhang` \[m\] beyond the plate when flat.
pub fn find(shadow: &Shadow, overhang: f64) -> Vec<Fold> {
    let radii = &shadow.radii;
    let least = PROMINENCE * overhang;
    let lowest = (0..DIRECTIONS)
        .min_by(|a, b| radii[*a].total_cmp(&radii[*b]))
        .expect("there are directions");
    // Once around from the deepest valley to itself: tips and valleys by turns.
    let mut turns = vec![lowest];
    let (mut tip, mut valley, mut rising) = (lowest, lowest, true);
    for k in lowest + 1..=lowest + DIRECTIONS {
        let at = k % DIRECTIONS;
        if rising {
            if radii[at] > radii[tip] {
                tip = at;
            } else if radii[at] < radii[tip] - least && radii[tip] > radii[valley] + least {
                turns.push(tip);
                (valley, rising) = (at, false);
            }
        } else if radii[at] < radii[valley] || at == lowest {
            valley = at;
        } else if radii[at] > radii[valley] + least {
            turns.push(valley);
            (tip, rising) = (at, true);
        }
    }
    if !rising {
        turns.push(lowest);
    }
    let fold = |k: usize| {
        let [before, tip, after] = [turns[k - 1], turns[k], turns[k + 1]];
        Fold {
            tip: radii[tip],
            width: (shadow.place(after) - shadow.place(before)).norm(),
            depth: radii[tip] - 0.5 * (radii[before] + radii[after]),
        }
    };
    (1..turns.len().saturating_sub(1))
        .step_by(2)
        .map(fold)
        .collect()
}
