//! A supersampled z-buffer: triangles with colours at their vertices, thread lines, edge lines.

use std::sync::OnceLock;

use nalgebra::{Vector2, Vector3};

use super::picture_light::Rgb;

/// Samples along each side of a pixel.
pub(super) const SUPER: usize = 3;

/// Colour and depth of every sample.
pub(super) struct Canvas {
    width: usize,
    height: usize,
    depth: Vec<f32>,
    colour: Vec<[u8; 3]>,
}

/// Thread lines drawn on a triangle.
pub(super) struct Weave {
    /// Warp and weft coordinates of the corners \[m\].
    pub material: [Vector2<f64>; 3],
    /// Distance between lines \[m\].
    pub spacing: f64,
}

/// Calls `visit(index, weights)` for every sample centre inside a triangle.
pub(super) fn spans(
    corners: &[Vector3<f64>; 3],
    width: usize,
    height: usize,
    mut visit: impl FnMut(usize, [f64; 3]),
) {
    let [a, b, c] = corners.map(|p| p.xy());
    let area = (b - a).perp(&(c - a));
    if area == 0.0 || !area.is_finite() {
        return;
    }
    let (low, high) = (a.inf(&b).inf(&c), a.sup(&b).sup(&c));
    let first = |x: f64| (x - 0.5).ceil().max(0.0) as usize;
    let end = |x: f64, n: usize| ((x - 0.5).floor() + 1.0).clamp(0.0, n as f64) as usize;
    let column = |e: Vector2<f64>| -e.y / area;
    let (d0, d1) = (column(c - b), column(a - c));
    for y in first(low.y)..end(high.y, height) {
        let x0 = first(low.x);
        let p = Vector2::new(x0 as f64 + 0.5, y as f64 + 0.5);
        let (w0, w1) = ((c - b).perp(&(p - b)) / area, (a - c).perp(&(p - c)) / area);
        for x in x0..end(high.x, width) {
            let s = (x - x0) as f64;
            let w = [
                w0 + s * d0,
                w1 + s * d1,
                1.0 - (w0 + s * d0) - (w1 + s * d1),
            ];
            if w.iter().all(|w| *w >= 0.0) {
                visit(y * width + x, w);
            }
        }
    }
}

impl Canvas {
    /// A white canvas of `width` x `height` pixels.
    pub fn new(width: usize, height: usize) -> Self {
        let (width, height) = (width * SUPER, height * SUPER);
        Self {
            width,
            height,
            depth: vec![f32::NEG_INFINITY; width * height],
            colour: vec![[255; 3]; width * height],
        }
    }

    /// Draws a triangle with corners in pixels and depth.
    pub fn triangle(&mut self, corners: [Vector3<f64>; 3], light: [Rgb; 3], weave: Option<&Weave>) {
        let corners = corners.map(samples);
        let thread = weave.map(|w| Thread::new(w, &corners));
        let (depth, colour) = (&mut self.depth, &mut self.colour);
        spans(&corners, self.width, self.height, |at, w| {
            let z = (w[0] * corners[0].z + w[1] * corners[1].z + w[2] * corners[2].z) as f32;
            if z <= depth[at] {
                return;
            }
            depth[at] = z;
            let factor = thread.as_ref().map_or(1.0, |t| t.factor(w));
            let w = w.map(|w| w as f32);
            colour[at] = [0, 1, 2].map(|k| {
                let c = w[0] * light[0][k] + w[1] * light[1][k] + w[2] * light[2][k];
                encode(c * factor)
            });
        });
    }

    /// Draws a line `width` pixels wide on the surface it lies on; what is within `lift` metres in front of it
    /// does not hide it.
    pub fn line(&mut self, ends: [Vector3<f64>; 2], width: f64, lift: f64, ink: Rgb) {
        let [a, b] = ends.map(samples);
        let half = 0.5 * width * SUPER as f64;
        let Some(along) = (b - a).xy().try_normalize(1e-9) else {
            return;
        };
        let side = Vector3::new(-along.y, along.x, 0.0) * half;
        let cap = Vector3::new(along.x, along.y, 0.0) * (0.5 * half);
        let [a, b] = [a - cap, b + cap];
        let quad = [a - side, b - side, b + side, a + side];
        let ink = ink.map(encode);
        let (depth, colour) = (&mut self.depth, &mut self.colour);
        for corners in [[quad[0], quad[1], quad[2]], [quad[0], quad[2], quad[3]]] {
            spans(&corners, self.width, self.height, |at, w| {
                let z = (0..3).map(|k| w[k] * corners[k].z).sum::<f64>();
                if (z + lift) as f32 > depth[at] {
                    // A line is no surface: what lies on the same face covers it.
                    if depth[at] == f32::NEG_INFINITY {
                        depth[at] = z as f32;
                    }
                    colour[at] = ink;
                }
            });
        }
    }

    /// Averages samples into opaque pixels, RGBA.
    pub fn resolve(&self) -> Vec<u8> {
        let (width, height) = (self.width / SUPER, self.height / SUPER);
        let mut out = Vec::with_capacity(4 * width * height);
        let table = decode();
        for y in 0..height {
            for x in 0..width {
                let mut sum = [0.0f32; 3];
                for dy in 0..SUPER {
                    let row = (y * SUPER + dy) * self.width + x * SUPER;
                    for sample in &self.colour[row..row + SUPER] {
                        (0..3).for_each(|k| sum[k] += table[usize::from(sample[k])]);
                    }
                }
                out.extend(sum.map(|s| encode(s / (SUPER * SUPER) as f32)));
                out.push(255);
            }
        }
        out
    }
}

fn samples(p: Vector3<f64>) -> Vector3<f64> {
    Vector3::new(p.x * SUPER as f64, p.y * SUPER as f64, p.z)
}

/// Where the lines of one triangle run, in its barycentric weights.
struct Thread {
    material: [Vector2<f64>; 3],
    spacing: f64,
    half: [f64; 2],
    strength: [f64; 2],
}

impl Thread {
    fn new(weave: &Weave, corners: &[Vector3<f64>; 3]) -> Self {
        let m = weave.material;
        let (p, q) = (
            (corners[1] - corners[0]).xy(),
            (corners[2] - corners[0]).xy(),
        );
        let area = p.perp(&q);
        let slope = |k: usize| {
            let (dp, dq) = (m[1][k] - m[0][k], m[2][k] - m[0][k]);
            ((q * dp - p * dq) / area).norm()
        };
        let slopes = [slope(0), slope(1)].map(|s| s.max(1e-12));
        let pixel = SUPER as f64;
        Self {
            material: m,
            spacing: weave.spacing,
            half: slopes.map(|s| (0.55 * pixel * s).max(0.012 * weave.spacing)),
            strength: slopes.map(|s| ((weave.spacing / (s * pixel) - 4.0) / 8.0).clamp(0.0, 1.0)),
        }
    }

    fn factor(&self, w: [f64; 3]) -> f32 {
        let mut factor = 1.0;
        for k in 0..2 {
            let a: f64 = (0..3).map(|i| w[i] * self.material[i][k]).sum();
            let from_line = (a - (a / self.spacing).round() * self.spacing).abs();
            if from_line < self.half[k] {
                factor *= 1.0 - 0.24 * self.strength[k];
            }
        }
        factor as f32
    }
}

fn decode() -> &'static [f32; 256] {
    static TABLE: OnceLock<[f32; 256]> = OnceLock::new();
    TABLE.get_or_init(|| {
        std::array::from_fn(|k| {
            let s = k as f32 / 255.0;
            if s <= 0.04045 {
                s / 12.92
            } else {
                ((s + 0.055) / 1.055).powf(2.4)
            }
        })
    })
}

/// Linear light to an sRGB byte.
fn encode(linear: f32) -> u8 {
    static TABLE: OnceLock<Vec<u8>> = OnceLock::new();
    const FINE: usize = 8192;
    let table = TABLE.get_or_init(|| {
        let byte = |k: usize| {
            let c = k as f32 / FINE as f32;
            let s = if c <= 0.003_130_8 {
                12.92 * c
            } else {
                1.055 * c.powf(1.0 / 2.4) - 0.055
            };
            (255.0 * s + 0.5) as u8
        };
        (0..=FINE).map(byte).collect()
    });
    table[(linear.clamp(0.0, 1.0) * FINE as f32 + 0.5) as usize]
}
