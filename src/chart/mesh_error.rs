//! How far what is observed on the finest of some meshes is from what ever finer ones would show: the grid convergence
//! index of Roache (1994), doi:10.1115/1.2910291, with its order measured on the courses of all readings together.
//!
//! Two readings may agree by chance and one moment says little, so differences are taken over whole courses: their root
//! mean square tells how they fall with the element size, their maximum how large the error is.

/// Order of the elements in their size: membrane and bending are of second order in displacements.
const FORMAL_ORDER: f64 = 2.0;
/// Lowest order that is believed; a slower fall is taken for this one.
const LOWEST_ORDER: f64 = 0.5;
/// Highest order with which differences are believed to fall: that of what coarse triangles lock.
const HIGHEST_ORDER: f64 = 4.0;
/// Order where meshes do not come together regularly: between those that are measured, 0.5 to 1.5, where sheets fold.
pub const IRREGULAR_ORDER: f64 = 1.0;
/// Order above which the first of three meshes counts as too coarse to tell any: the factor is then that of two (Eça and
/// Hoekstra 2014, doi:10.1016/j.jcp.2014.01.006, who say so from 2.1 on).
const CREDIBLE_ORDER: f64 = 3.0;
/// Roache's factors of safety: with three meshes, and with two.
const OF_THREE: f64 = 1.25;
const OF_TWO: f64 = 3.0;

/// What was read on a mesh.
#[derive(Clone, Copy, Debug)]
pub struct OnMesh<'a> {
    /// Its triangles.
    pub triangles: usize,
    /// Readings, shape \[moments\]\[readings\].
    pub readings: &'a [Vec<f64>],
}

impl OnMesh<'_> {
    /// Size of its elements, with that of a mesh of one triangle as the unit \[-\].
    fn size(&self) -> f64 {
        (self.triangles as f64).sqrt().recip()
    }
}

/// Estimated error of the finest mesh.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MeshError {
    /// Largest error of any reading at any moment, over the largest reading \[-\].
    pub error: f64,
    /// Order in the element size, 0.5 to 2, if the meshes tell one \[-\].
    pub order: Option<f64>,
}

impl MeshError {
    /// Estimates the error of the last of the meshes, which are ordered from coarse to fine; none if there is only one.
    pub fn of(meshes: &[OnMesh]) -> Option<Self> {
        let [.., coarse, fine] = meshes else {
            return None;
        };
        let change = apart(coarse.readings, fine.readings);
        let left = |from: &OnMesh, order: f64| remainder([from.size(), fine.size()], order);
        let of_two = OF_TWO * change * left(coarse, FORMAL_ORDER);
        let [.., coarsest, _, _] = meshes else {
            return Some(Self {
                error: of_two,
                order: None,
            });
        };
        let sizes = [coarsest.size(), coarse.size(), fine.size()];
        let before = apart(coarsest.readings, coarse.readings) * largest(coarse.readings);
        let before = before / largest(fine.readings);
        // Two meshes that agree much better than those before them do so by chance.
        let least = before / fall(sizes, HIGHEST_ORDER);
        let too_coarse = change < before / fall(sizes, CREDIBLE_ORDER);
        let change = change.max(least);
        let order = order(meshes);
        let error = match order {
            Some(order) => change * left(coarse, order),
            // Neighbouring meshes then differ by chance as much as by their size: looked at is what both changed.
            None => {
                let both = apart(coarsest.readings, fine.readings);
                change.max(both * left(coarsest, IRREGULAR_ORDER))
            }
        };
        let of_three = OF_THREE * error;
        let error = if too_coarse {
            of_three.max(of_two)
        } else {
            of_three
        };
        Some(Self { error, order })
    }
}

/// Error of a mesh of which another, of so many times the triangles, is this far apart at an order, over that
/// difference \[-\].
pub fn error_of_change(times: f64, order: Option<f64>) -> f64 {
    1.0 + remainder([1.0, times.sqrt().recip()], order.unwrap_or(FORMAL_ORDER))
}

/// Largest difference at any moment over the largest reading \[-\].
pub fn apart(ours: &[Vec<f64>], truth: &[Vec<f64>]) -> f64 {
    let pairs = ours.iter().flatten().zip(truth.iter().flatten());
    let worst = pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    worst / largest(truth)
}

fn largest(readings: &[Vec<f64>]) -> f64 {
    let all = readings.iter().flatten().map(|v| v.abs());
    all.fold(f64::MIN_POSITIVE, f64::max)
}

/// Sum over moments and readings of the product of what two refinements changed.
fn product(first: &[OnMesh], second: &[OnMesh]) -> f64 {
    let changes = |pair: &[OnMesh]| -> Vec<f64> {
        let (a, b) = (pair[0].readings, pair[1].readings);
        let both = a.iter().flatten().zip(b.iter().flatten());
        both.map(|(a, b)| b - a).collect()
    };
    let (first, second) = (changes(first), changes(second));
    first.iter().zip(&second).map(|(a, b)| a * b).sum()
}

/// Order that the last three meshes show, or the last four where all of their differences fall; none where the last two
/// differences point against each other or do not fall.
fn order(meshes: &[OnMesh]) -> Option<f64> {
    let last = meshes.len().checked_sub(2)?;
    let norm = |k: usize| product(&meshes[k..], &meshes[k..]).sqrt();
    let fell = |k: usize| {
        let sizes = [k, k + 1, k + 2].map(|m| meshes[m].size());
        let same_way = product(&meshes[k..], &meshes[k + 1..]) >= 0.0;
        same_way && norm(k + 1) * fall(sizes, 0.0) < norm(k)
    };
    let first = last.checked_sub(1).filter(|k| fell(*k))?;
    let first = first.checked_sub(1).filter(|k| fell(*k)).unwrap_or(first);
    let change = |pair: usize, order: f64| {
        let [coarse, fine] = [pair, pair + 1].map(|m| meshes[m].size());
        difference([coarse, fine], order)
    };
    let shows = |order: f64| norm(last) * change(first, order) < norm(first) * change(last, order);
    let (mut low, mut high) = (LOWEST_ORDER, FORMAL_ORDER);
    for _ in 0..40 {
        let middle = 0.5 * (low + high);
        match shows(middle) {
            true => low = middle,
            false => high = middle,
        }
    }
    Some(0.5 * (low + high))
}

/// What an error of an order changes by from one element size to a smaller one, but for a factor; at order 0 the limit.
fn difference([coarse, fine]: [f64; 2], order: f64) -> f64 {
    match order > 0.0 {
        true => coarse.powf(order) - fine.powf(order),
        false => (coarse / fine).ln(),
    }
}

/// Difference of the first two of three meshes over that of the last two, at an order.
fn fall([coarse, middle, fine]: [f64; 3], order: f64) -> f64 {
    difference([coarse, middle], order) / difference([middle, fine], order)
}

/// Error of the finer of two meshes over their difference, at an order.
fn remainder([coarse, fine]: [f64; 2], order: f64) -> f64 {
    fine.powf(order) / difference([coarse, fine], order)
}
