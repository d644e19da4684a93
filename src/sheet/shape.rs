//! The shape of an even mesh's triangles: those next to the boundary come out of smoothing narrow, and one narrow
//! triangle sets the step of an explicit scheme for all.
//!
//! A triangle of sides l and area A bears a step in proportion to the root of A² / (l1² + l2² + l3²): the trace of its
//! stiffness over its mass (Flanagan and Belytschko 1984, doi:10.1115/1.3167600, bound the step by it). A high power
//! of that, summed over the mesh and lowered vertex by vertex, moves mostly what is worst.

use nalgebra::Vector2;

type Point = Vector2<f64>;

/// Power of the sum: the higher, the more the worst triangle counts. With 4 in its place the step gains a sixth less.
const POWER: i32 = 8;
/// Sweeps over the vertices.
const SWEEPS: usize = 30;
/// First step of a vertex, over the shortest side at it, and how often it is halved.
const STEP: f64 = 0.05;
const HALVINGS: usize = 6;

/// Moves the vertices from `fixed` on to where the triangles at them are rounder.
pub fn round_off(points: &mut [Point], fixed: usize, faces: &[[u32; 3]]) {
    let mut around = vec![vec![]; points.len()];
    for &[a, b, c] in faces {
        for [v, next, last] in [[a, b, c], [b, c, a], [c, a, b]] {
            around[v as usize].push([next as usize, last as usize]);
        }
    }
    // Powers of lengths are harmless only near one.
    let area = |&[a, b, c]: &[u32; 3]| doubled_area(&[a, b, c].map(|v| points[v as usize]));
    let unit = faces.iter().map(area).sum::<f64>() / faces.len() as f64;
    for _ in 0..SWEEPS {
        for v in fixed..points.len() {
            points[v] = rounder(points, points[v], &around[v], unit);
        }
    }
}

fn doubled_area([a, b, c]: &[Point; 3]) -> f64 {
    (b - a).perp(&(c - a))
}

/// A place for a vertex that lowers the sum over the triangles at it, or where it is.
fn rounder(points: &[Point], from: Point, around: &[[usize; 2]], unit: f64) -> Point {
    let (now, slope) = narrowness(points, from, around, unit);
    let sides = around.iter().map(|&[b, _]| (points[b] - from).norm());
    let mut step = slope.normalize() * (STEP * sides.fold(f64::INFINITY, f64::min));
    if !step.iter().all(|c| c.is_finite()) {
        return from;
    }
    for _ in 0..HALVINGS {
        let to = from - step;
        if narrowness(points, to, around, unit).0 < now {
            return to;
        }
        step *= 0.5;
    }
    from
}

/// Sum over the triangles at a vertex, infinite if one is turned over, and its gradient.
fn narrowness(points: &[Point], at: Point, around: &[[usize; 2]], unit: f64) -> (f64, Point) {
    let (mut sum, mut slope) = (0.0, Point::zeros());
    for &[b, c] in around {
        let (b, c) = (points[b], points[c]);
        let area = doubled_area(&[at, b, c]);
        if area <= 0.0 {
            return (f64::INFINITY, slope);
        }
        let squares = (at - b).norm_squared() + (at - c).norm_squared() + (b - c).norm_squared();
        let term = (squares * unit / (area * area)).powi(POWER);
        let by_squares = (at * 2.0 - b - c) * (2.0 / squares);
        let by_area = Point::new(b.y - c.y, c.x - b.x) * (2.0 / area);
        sum += term;
        slope += (by_squares - by_area) * (f64::from(POWER) * term);
    }
    (sum, slope)
}
