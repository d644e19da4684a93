//! Where two features are nearest to each other.

use nalgebra::{Matrix2, Vector2, Vector3};

type Point = Vector3<f64>;

/// Two features of the sheet where they are nearest: their offset is `sum_i weights_i x_i`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pair {
    /// Stable identity.
    pub key: u64,
    /// A vertex and the corners of a face; or the ends of an edge, then those of another.
    pub nodes: [u32; 4],
    /// Positive on the first feature, negative on the second, zero at corners that do not count; they sum to zero.
    pub weights: [f64; 4],
    /// How often the pair counts: where a vertex is nearest to a rim that faces share, each of them has found it.
    pub share: f64,
    /// Distance of the middle surfaces \[m\].
    pub distance: f64,
    /// From the second feature to the first, of length 1.
    pub normal: Point,
}

impl Pair {
    /// Whether it is of two edges.
    pub fn of_edges(&self) -> bool {
        self.weights[0] < 1.0
    }

    /// In how many ways the nearest points can slide, and the changes of the weights that slide them.
    pub fn slides(&self) -> (usize, [[f64; 4]; 2]) {
        if self.of_edges() {
            return (2, [[-1.0, 1.0, 0.0, 0.0], [0.0, 0.0, -1.0, 1.0]]);
        }
        let mut slides = [[0.0; 4]; 2];
        let mut corners = (1..4).filter(|&k| self.weights[k] != 0.0);
        let first = corners.next().unwrap_or(1);
        let mut freedom = 0;
        for corner in corners {
            slides[freedom][first] = 1.0;
            slides[freedom][corner] = -1.0;
            freedom += 1;
        }
        (freedom, slides)
    }

    /// The weights at which the features, prolonged to lines and planes, are nearest at other positions.
    pub fn weights_at(&self, x: &[Point; 4]) -> [f64; 4] {
        let (freedom, slides) = self.slides();
        let offset = combine(&self.weights, x);
        let along = slides.map(|slide| combine(&slide, x));
        let slope = Vector2::from_fn(|a, _| along[a].dot(&offset));
        let second = Matrix2::from_fn(|a, b| along[a].dot(&along[b]));
        let step = match freedom {
            0 => Vector2::zeros(),
            1 => Vector2::new(-slope.x / second.m11, 0.0),
            _ => -second.try_inverse().unwrap_or_default() * slope,
        };
        std::array::from_fn(|k| self.weights[k] + step.x * slides[0][k] + step.y * slides[1][k])
    }
}

/// `sum_i weights_i x_i`.
pub fn combine(weights: &[f64; 4], x: &[Point; 4]) -> Point {
    x[0] * weights[0] + x[1] * weights[1] + x[2] * weights[2] + x[3] * weights[3]
}

/// Barycentric coordinates of the point of a triangle that is nearest to `p`, exactly zero at corners that do not
/// count (Ericson, Real-Time Collision Detection, 2005, 5.1.5).
#[inline]
pub fn point_to_face(p: &Point, [a, b, c]: [&Point; 3]) -> [f64; 3] {
    let (ab, ac, ap) = (b - a, c - a, p - a);
    let (d1, d2) = (ab.dot(&ap), ac.dot(&ap));
    if d1 <= 0.0 && d2 <= 0.0 {
        return [1.0, 0.0, 0.0];
    }
    let bp = p - b;
    let (d3, d4) = (ab.dot(&bp), ac.dot(&bp));
    if d3 >= 0.0 && d4 <= d3 {
        return [0.0, 1.0, 0.0];
    }
    let vc = d1 * d4 - d3 * d2;
    if vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0 {
        return on_side(d1 / (d1 - d3), 0, 1);
    }
    let cp = p - c;
    let (d5, d6) = (ab.dot(&cp), ac.dot(&cp));
    if d6 >= 0.0 && d5 <= d6 {
        return [0.0, 0.0, 1.0];
    }
    let vb = d5 * d2 - d1 * d6;
    if vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0 {
        return on_side(d2 / (d2 - d6), 0, 2);
    }
    let va = d3 * d6 - d5 * d4;
    if va <= 0.0 && d4 >= d3 && d5 >= d6 {
        return on_side((d4 - d3) / ((d4 - d3) + (d5 - d6)), 1, 2);
    }
    let scale = 1.0 / (va + vb + vc);
    let (v, w) = (vb * scale, vc * scale);
    let u = 1.0 - v - w;
    if u > 0.0 && v > 0.0 && w > 0.0 {
        [u, v, w]
    } else {
        // Rounding at a rim, or a triangle without area.
        let rim = [(0, 1), (1, 2), (2, 0)].map(|(i, j)| {
            let q = [a, b, c];
            let t = point_to_segment(p, q[i], q[j]);
            ((p - q[i] - (q[j] - q[i]) * t).norm_squared(), t, i, j)
        });
        let (_, t, i, j) = rim
            .into_iter()
            .min_by(|a, b| a.0.total_cmp(&b.0))
            .expect("a triangle has three sides");
        on_side(t, i, j)
    }
}

fn on_side(t: f64, from: usize, to: usize) -> [f64; 3] {
    let mut weights = [0.0; 3];
    weights[from] = 1.0 - t;
    weights[to] = t;
    weights
}

/// Parameter from `a` to `b` of the point of the segment nearest to `p`, 0 to 1.
#[inline]
pub fn point_to_segment(p: &Point, a: &Point, b: &Point) -> f64 {
    let along = b - a;
    let square = along.norm_squared();
    if square > 0.0 {
        (along.dot(&(p - a)) / square).clamp(0.0, 1.0)
    } else {
        0.0
    }
}

/// Parameters of the points where the segments from `a` to `b` and from `c` to `d` are nearest, each 0 to 1
/// (Ericson, 5.1.9).
#[inline]
pub fn segment_to_segment(a: &Point, b: &Point, c: &Point, d: &Point) -> [f64; 2] {
    let (u, v, w) = (b - a, d - c, a - c);
    let (uu, vv, uv) = (u.norm_squared(), v.norm_squared(), u.dot(&v));
    let (uw, vw) = (u.dot(&w), v.dot(&w));
    let determinant = uu * vv - uv * uv;
    // Parallel edges are nearest all along; any point will do, and an end is one.
    let s = if determinant > 1e-14 * uu * vv {
        ((uv * vw - uw * vv) / determinant).clamp(0.0, 1.0)
    } else {
        0.0
    };
    let t = if vv > 0.0 { (uv * s + vw) / vv } else { 0.0 };
    if t < 0.0 {
        [(-uw / uu).clamp(0.0, 1.0), 0.0]
    } else if t > 1.0 {
        [((uv - uw) / uu).clamp(0.0, 1.0), 1.0]
    } else {
        [s, t]
    }
}

/// Distance \[m\] of a vertex and a face (`edges` false) or of two edges, their four nodes given.
#[inline]
pub fn between(edges: bool, x: &[Point; 4]) -> f64 {
    offset(edges, x).norm()
}

/// From the second feature to the first where they are nearest.
#[inline]
pub fn offset(edges: bool, x: &[Point; 4]) -> Point {
    if edges {
        let [s, t] = segment_to_segment(&x[0], &x[1], &x[2], &x[3]);
        x[0] + (x[1] - x[0]) * s - x[2] - (x[3] - x[2]) * t
    } else {
        let [u, v, w] = point_to_face(&x[0], [&x[1], &x[2], &x[3]]);
        x[0] - x[1] * u - x[2] * v - x[3] * w
    }
}
