//! Patches of the sheet: where they are, and how they have moved as if rigid.

use nalgebra::{Matrix3, Vector2, Vector3};

use super::bounds::max;
use super::tiles::Tiles;
use crate::sheet::Mesh;

type Point = Vector3<f64>;

/// The vertices of some faces, with their coordinates in the flat sheet from their middle.
#[derive(Clone, Debug, Default)]
pub(super) struct Patch {
    vertices: Vec<u32>,
    levers: Vec<Vector2<f64>>,
}

impl Patch {
    /// Of all vertices of the faces.
    pub fn new(mesh: &Mesh, faces: &[u32]) -> Self {
        let corners = faces.iter().flat_map(|&f| mesh.faces[f as usize]);
        let mut vertices: Vec<u32> = corners.collect();
        vertices.sort_unstable();
        vertices.dedup();
        let place = |v: &u32| mesh.material[*v as usize];
        let middle = vertices.iter().map(place).sum::<Vector2<f64>>() / vertices.len() as f64;
        Self {
            levers: vertices.iter().map(|v| place(v) - middle).collect(),
            vertices,
        }
    }

    /// Its middle and its axes, which turn with it: along the warp, in its mean plane, and across.
    fn frame(&self, positions: &[Point]) -> Frame {
        let (mut sum, mut warp, mut weft) = (Point::zeros(), Point::zeros(), Point::zeros());
        for (&v, lever) in self.vertices.iter().zip(&self.levers) {
            let p = positions[v as usize];
            sum += p;
            warp += p * lever.x;
            weft += p * lever.y;
        }
        let (along, up) = (warp.normalize(), warp.cross(&weft).normalize());
        let axes = Matrix3::from_columns(&[along, up.cross(&along), up]).transpose();
        Frame {
            middle: sum / self.vertices.len().max(1) as f64,
            // Any axes will do where the patch has none.
            axes: match axes.iter().all(|a| a.is_finite()) {
                true => axes,
                false => Matrix3::identity(),
            },
            radius: 0.0,
        }
    }
}

/// Where a patch is.
#[derive(Clone, Copy, Debug)]
struct Frame {
    middle: Point,
    /// Its axes, as rows.
    axes: Matrix3<f64>,
    /// Distance of its farthest vertex from the middle \[m\].
    radius: f64,
}

/// Where all patches are, and their vertices as seen from there.
#[derive(Clone, Debug, Default)]
pub(super) struct Stand {
    frames: Vec<Frame>,
    seen: Vec<Point>,
}

impl Stand {
    /// Takes the patches where the sheet is.
    pub fn take(&mut self, tiles: &Tiles, positions: &[Point]) {
        self.frames.clear();
        self.seen.clear();
        for patch in &tiles.patches {
            let mut frame = patch.frame(positions);
            let mut square = 0.0;
            for &v in &patch.vertices {
                let seen = frame.axes * (positions[v as usize] - frame.middle);
                square = max(square, seen.norm_squared());
                self.seen.push(seen);
            }
            frame.radius = square.sqrt();
            self.frames.push(frame);
        }
    }

    /// How the patches that are `needed` have come here from where they stood before.
    pub fn motions(
        &self,
        before: &Self,
        needed: &[bool],
        motions: &mut Vec<Motion>,
        tiles: &Tiles,
    ) {
        let mut first = 0;
        for (n, patch) in tiles.patches.iter().enumerate() {
            let range = first..first + patch.vertices.len();
            first = range.end;
            if !needed[n] {
                motions.push(Motion::default());
                continue;
            }
            let (from, to) = (&before.frames[n], &self.frames[n]);
            let pairs = self.seen[range.clone()].iter().zip(&before.seen[range]);
            // Bits of squares are in the order of the squares, and above them all where one is no number.
            let squares = pairs.map(|(a, b)| (a - b).norm_squared().to_bits());
            let square = f64::from_bits(squares.max().unwrap_or_default());
            motions.push(Motion {
                from: from.middle,
                to: to.middle,
                turn: to.axes.tr_mul(&from.axes),
                radius: from.radius,
                off: square.sqrt(),
            });
        }
    }
}

/// How a patch has moved: as if rigid, but for a rest.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Motion {
    from: Point,
    to: Point,
    turn: Matrix3<f64>,
    radius: f64,
    /// The most by which a vertex has moved otherwise \[m\].
    off: f64,
}

impl Motion {
    /// Bound on how much nearer points of two patches have come \[m\], seen from the first as it turns: good for patches
    /// that turn together.
    pub fn turning(&self, other: &Self) -> f64 {
        let carried = self.turn * (other.from - self.from);
        let turned = angle(&(other.turn - self.turn)) * other.radius;
        (other.to - self.to - carried).norm() + turned + self.off + other.off
    }

    /// The same without turning along: good for patches far from each other.
    pub fn sliding(&self, other: &Self) -> f64 {
        let moved = (self.to - self.from) - (other.to - other.from);
        moved.norm() + self.away() + other.away()
    }

    /// The most by which a vertex has moved otherwise than the middle \[m\].
    fn away(&self) -> f64 {
        angle(&(self.turn - Matrix3::identity())) * self.radius + self.off
    }
}

/// Spectral norm of the difference of two rotations: its singular values are 2 sin(t/2), twice, and zero.
fn angle(difference: &Matrix3<f64>) -> f64 {
    (0.5 * difference.norm_squared()).sqrt()
}
