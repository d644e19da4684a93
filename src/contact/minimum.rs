//! Minima of the distance to a convex shape over edges and faces of the sheet, in the shape's frame.

use nalgebra::{Matrix2, Vector2, Vector3};

use super::detect::LEAD;
use super::distance::Distance;
use super::obstacle::Shape;

/// Distance and normal.
pub(super) type First = (f64, Vector3<f64>);

/// Least weight of a corner inside of a face.
const INSIDE: f64 = 1e-6;
/// Golden sections across a face: 1e-3 of its width.
const SECTIONS: usize = 14;
/// Newton steps after the sections.
const POLISHES: usize = 6;
/// The golden ratio's inverse.
const GOLDEN: f64 = 0.618_033_988_749_895;
/// Most steps of a line minimisation.
const ITERATIONS: usize = 60;
/// Slope of the distance, or fraction of the line, at which a line minimisation stops.
const FLAT: f64 = 1e-9;

/// What the distance is not below on an edge, from its tangents at both ends, which a convex function lies above.
#[inline]
pub(super) fn least_on_edge(ends: [Vector3<f64>; 2], values: [&First; 2]) -> f64 {
    match downhill_from_both(ends, values) {
        Some(slopes) => crossing(values, slopes).1,
        None => values[0].0.min(values[1].0),
    }
}

/// The same on a face, from the tangent at one place of it.
#[inline]
pub(super) fn least_on_face(
    corners: &[Vector3<f64>; 3],
    (at, first): (&Vector3<f64>, &First),
) -> f64 {
    let rise = corners.map(|corner| first.1.dot(&(corner - at)));
    first.0 + rise[0].min(rise[1]).min(rise[2])
}

/// The same from the tangents at the minima of its sides: that minimum itself, if it is on a side.
pub(super) fn least_from_sides(
    shape: &Shape,
    corners: &[Vector3<f64>; 3],
    values: [&First; 3],
) -> f64 {
    let on_side = |k: usize| {
        let [i, j] = [(k + 1) % 3, (k + 2) % 3];
        let (t, first) = minimum_of_side([corners[i], corners[j]], [values[i], values[j]], shape)?;
        let at = corners[i] + (corners[j] - corners[i]) * t;
        Some(least_on_face(corners, (&at, &first)))
    };
    (0..3).filter_map(on_side).fold(f64::NEG_INFINITY, f64::max)
}

/// Minimum of the distance strictly inside an edge, wherever it is.
fn minimum_of_side(
    ends: [Vector3<f64>; 2],
    values: [&First; 2],
    shape: &Shape,
) -> Option<(f64, First)> {
    let slopes = downhill_from_both(ends, values)?;
    let (start, _) = crossing(values, slopes);
    Some(minimum_on_line(shape, ends, start))
}

/// Minimum of the distance strictly inside an edge, at a fraction of the way; `None` also where it is so far out of reach
/// that a face with less has its full share.
#[inline]
pub(super) fn within_edge(
    shape: &Shape,
    ends: [Vector3<f64>; 2],
    values: [&First; 2],
    reach: f64,
) -> Option<(f64, First)> {
    let slopes = downhill_from_both(ends, values)?;
    let (t, least) = crossing(values, slopes);
    (least < reach + LEAD).then(|| minimum_on_line(shape, ends, t))
}

/// Derivatives of the distance along the way from the first point, at both, if it has a minimum strictly between.
#[inline]
fn downhill_from_both(ends: [Vector3<f64>; 2], values: [&First; 2]) -> Option<[f64; 2]> {
    let along = ends[1] - ends[0];
    let slopes = values.map(|first| first.1.dot(&along));
    (slopes[0] < 0.0 && slopes[1] > 0.0).then_some(slopes)
}

/// Where the tangents at both ends cross, as a fraction of the way, and at what distance.
#[inline]
fn crossing(values: [&First; 2], slopes: [f64; 2]) -> (f64, f64) {
    let rise = values[1].0 - values[0].0;
    let t = ((rise - slopes[1]) / (slopes[0] - slopes[1])).clamp(0.0, 1.0);
    (t, values[0].0 + slopes[0] * t)
}

/// Minimum of the distance strictly between two points where it falls from both, at a fraction of the way. The search
/// begins where the tangents cross: near a sharp edge of the shape that is above it.
#[inline]
fn minimum_on_line(shape: &Shape, ends: [Vector3<f64>; 2], start: f64) -> (f64, First) {
    let beside = core_box(shape).and_then(|half| beside_box(&half, ends, start));
    match beside {
        Some(t) => (t, shape.first_order(&(ends[0] + (ends[1] - ends[0]) * t))),
        None => newton_on_line(shape, ends, start),
    }
}

/// The same outside of a box, `None` where the way leads into it. The square of the distance is quadratic as long as
/// the way is beyond the same sides.
fn beside_box(half: &Vector3<f64>, ends: [Vector3<f64>; 2], start: f64) -> Option<f64> {
    let along = ends[1] - ends[0];
    let (mut low, mut high, mut t) = (0.0, 1.0, start);
    let mut sides = [0.0; 3];
    for _ in 0..ITERATIONS {
        let (mut slope, mut bend, mut now) = (0.0, 0.0, [0.0; 3]);
        for k in 0..3 {
            let c = ends[0][k] + along[k] * t;
            let beyond = c.abs() - half[k];
            now[k] = if beyond > 0.0 { 1f64.copysign(c) } else { 0.0 };
            let outward = along[k] * now[k];
            slope += outward * beyond;
            bend += outward * outward;
        }
        if bend == 0.0 {
            return None;
        }
        if now == sides || high - low <= FLAT {
            return Some(t);
        }
        if slope < 0.0 {
            low = t
        } else {
            high = t
        }
        let newton = t - slope / bend;
        if newton > low && newton < high {
            (t, sides) = (newton, now);
        } else {
            // Not where the square of these sides is least.
            (t, sides) = (0.5 * (low + high), [0.0; 3]);
        }
    }
    Some(t)
}

/// Newton kept inside a bracket.
fn newton_on_line(shape: &Shape, ends: [Vector3<f64>; 2], start: f64) -> (f64, First) {
    let along = ends[1] - ends[0];
    let (mut low, mut high, mut t) = (0.0, 1.0, start);
    let mut distance = shape.distance(&(ends[0] + along * t));
    for _ in 0..ITERATIONS {
        let slope = distance.normal.dot(&along);
        if slope < 0.0 {
            low = t
        } else {
            high = t
        }
        if slope.abs() <= FLAT * along.norm() || high - low <= FLAT {
            break;
        }
        // On the square of the distance to what the shape is round about: it is quadratic beside a sharp edge too.
        let radius = shape.core() + distance.value;
        let bend = along.dot(&(distance.curvature * along));
        let newton = t - radius * slope / (slope * slope + radius * bend);
        let inside = newton > low && newton < high;
        t = if inside { newton } else { 0.5 * (low + high) };
        distance = shape.distance(&(ends[0] + along * t));
    }
    (t, (distance.value, distance.normal))
}

/// Minimum of the distance strictly inside a face, as barycentric weights and its lead over the rim, if it is
/// below `reach`.
///
/// On a convex function a point of the rim from which no way into the face leads down is the minimum of the face,
/// so only faces whose rim has no such point are searched.
///
/// `rim` gives the minimum of the side opposite to a corner, where it has been looked for already: the fraction of the
/// way from the next corner, distance and normal there.
#[inline]
pub(super) fn within_face(
    shape: &Shape,
    corners: &[Vector3<f64>; 3],
    values: [&First; 3],
    rim: impl Fn(usize) -> Option<(f64, First)>,
    reach: f64,
) -> Option<([f64; 3], f64)> {
    if values[0].1 == values[1].1 && values[1].1 == values[2].1 {
        // The same slope at all corners of a convex function: it is linear between them.
        return None;
    }
    for k in 0..3 {
        let (value, normal) = values[k];
        let rise = |other: usize| normal.dot(&(corners[other] - corners[k]));
        let least = rise((k + 1) % 3).min(rise((k + 2) % 3));
        // Lowest of all at this corner, or, as a convex function lies above its tangents, out of reach.
        if least >= 0.0 || value + least > reach {
            return None;
        }
    }
    let above = above(shape, corners);
    if above.is_some_and(|(weights, _)| !is_inside(&weights)) {
        return None;
    }
    let side = |k: usize| {
        let [i, j] = [(k + 1) % 3, (k + 2) % 3];
        let ends = [corners[i], corners[j]];
        rim(k).or_else(|| minimum_of_side(ends, [values[i], values[j]], shape))
    };
    let mut lowest = values[0].0.min(values[1].0).min(values[2].0);
    for k in 0..3 {
        let [a, b] = [corners[(k + 1) % 3], corners[(k + 2) % 3]];
        let Some((t, (value, normal))) = side(k) else {
            continue;
        };
        if normal.dot(&(corners[k] - a - (b - a) * t)) >= 0.0 {
            return None;
        }
        lowest = lowest.min(value);
    }
    let (weights, value) = above.unwrap_or_else(|| minimum_inside(shape, corners));
    (is_inside(&weights) && value < reach).then_some((weights, lowest - value))
}

fn is_inside(weights: &[f64; 3]) -> bool {
    weights.iter().all(|&w| w > INSIDE)
}

/// Minimum over the plane of a face, as weights of the corners and distance, where that plane passes what a shape is round
/// about: the foot of the point that is farthest that way.
fn above(shape: &Shape, corners: &[Vector3<f64>; 3]) -> Option<([f64; 3], f64)> {
    let [along, across] = [corners[1] - corners[0], corners[2] - corners[0]];
    let normal = along.cross(&across);
    let level = normal.dot(&corners[0]);
    let outward = normal * 1f64.copysign(level);
    let tip = farthest(shape, &outward)?;
    let rise = level.abs() - tip.dot(&outward);
    if rise <= 0.0 {
        return None;
    }
    let from = tip - corners[0];
    let square = normal.norm_squared();
    let weight = [from.cross(&across), along.cross(&from)].map(|part| part.dot(&normal) / square);
    let weights = [1.0 - weight[0] - weight[1], weight[0], weight[1]];
    Some((weights, rise / square.sqrt() - shape.core()))
}

/// The point of what a shape is round about that is farthest along a direction, if one is.
fn farthest(shape: &Shape, direction: &Vector3<f64>) -> Option<Vector3<f64>> {
    let on_rim = |radius: f64, height: f64| {
        let flat = direction.xy().try_normalize(0.0)? * radius;
        Some(flat.push(height.copysign(direction.z)))
    };
    match *shape {
        Shape::Disc { radius } => on_rim(radius, 0.0),
        Shape::Cylinder { radius, length } => on_rim(radius, 0.5 * length),
        _ => core_box(shape).map(|half| half.zip_map(direction, f64::copysign)),
    }
}

/// Half the edges of the box that a shape is round about, if it is one: a point for a ball, the axis for a capsule.
fn core_box(shape: &Shape) -> Option<Vector3<f64>> {
    match *shape {
        Shape::Box { size } => Some(Vector3::from(size) * 0.5),
        Shape::Sphere { .. } => Some(Vector3::zeros()),
        Shape::Capsule { length, .. } => Some(Vector3::new(0.0, 0.0, 0.5 * length)),
        _ => None,
    }
}

/// Minimum over a face as the minimum over s of the minima on the lines from a + s (b - a) to c: the envelope of a
/// convex function is convex.
fn minimum_inside(shape: &Shape, corners: &[Vector3<f64>; 3]) -> ([f64; 3], f64) {
    let [a, b, c] = *corners;
    let at_c = shape.first_order(&c);
    let on_line = |s: f64| {
        let foot = a + (b - a) * s;
        let at_foot = shape.first_order(&foot);
        match downhill_from_both([foot, c], [&at_foot, &at_c]) {
            Some(slopes) => {
                let (start, _) = crossing([&at_foot, &at_c], slopes);
                minimum_on_line(shape, [foot, c], start)
            }
            None if at_foot.0 < at_c.0 => (0.0, at_foot),
            None => (1.0, at_c),
        }
    };
    // Golden section on the values: the derivative says nothing where a line has its minimum at c.
    let (mut low, mut high) = (0.0, 1.0);
    let cut = |low: f64, high: f64| high - GOLDEN * (high - low);
    let (mut left, mut right) = (cut(low, high), cut(high, low));
    let (mut at_left, mut at_right) = (on_line(left), on_line(right));
    for _ in 0..SECTIONS {
        if at_left.1.0 <= at_right.1.0 {
            (high, right, at_right) = (right, left, at_left);
            left = cut(low, high);
            at_left = on_line(left);
        } else {
            (low, left, at_left) = (left, right, at_right);
            right = cut(high, low);
            at_right = on_line(right);
        }
    }
    let best = if at_left.1.0 <= at_right.1.0 {
        (left, at_left)
    } else {
        (right, at_right)
    };
    let (s, (t, _)) = best;
    polish(shape, corners, [(1.0 - s) * (1.0 - t), s * (1.0 - t), t])
}

/// Newton from a point near the minimum over a face, where the distance is smooth there.
fn polish(shape: &Shape, corners: &[Vector3<f64>; 3], mut weights: [f64; 3]) -> ([f64; 3], f64) {
    let point = |w: &[f64; 3]| corners[0] * w[0] + corners[1] * w[1] + corners[2] * w[2];
    let along = [corners[1] - corners[0], corners[2] - corners[0]];
    let slope = |d: &Distance| Vector2::from_fn(|a, _| d.normal.dot(&along[a]));
    let mut best = shape.distance(&point(&weights));
    for _ in 0..POLISHES {
        let second = Matrix2::from_fn(|a, b| along[a].dot(&(best.curvature * along[b])));
        let Some(inverse) = second.try_inverse() else {
            break;
        };
        let step = inverse * slope(&best);
        let trial = [
            weights[0] + step.x + step.y,
            weights[1] - step.x,
            weights[2] - step.y,
        ];
        let distance = shape.distance(&point(&trial));
        let inside = trial.iter().all(|w| (0.0..=1.0).contains(w));
        // Near the minimum the slope still tells better from worse when the values no longer do.
        if !inside || slope(&distance).norm() >= slope(&best).norm() {
            break;
        }
        (weights, best) = (trial, distance);
    }
    (weights, best.value)
}
