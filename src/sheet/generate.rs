//! Unstructured near-equilateral meshes: lattice points, Delaunay (spade), smoothing.

use nalgebra::{Rotation2, Vector2};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;
use spade::{ConstrainedDelaunayTriangulation, Point2, Triangulation};

use super::mesh::Mesh;
use super::outline::Outline;
use super::shape::round_off;

type Point = Vector2<f64>;

/// How fine, how regular, and how the yarns lie.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MeshOptions {
    /// Edge length \[m\].
    pub edge: f64,
    /// Random displacement of interior vertices over the edge length \[-\].
    pub jitter: f64,
    /// Seed of the unstructured start and of the jitter.
    pub seed: u64,
    /// Angle from sheet x to the warp \[rad\].
    pub warp_angle: f64,
}

/// Edge length wanted at a point of the sheet \[m\].
pub type Size<'a> = &'a dyn Fn(&Point) -> f64;

/// Rounds of Delaunay and smoothing; the mean shape quality gains less than 0.1 % after 40.
const SMOOTHING_ROUNDS: usize = 40;

impl Outline {
    fn loops(&self, size: Size) -> Vec<Vec<Point>> {
        match *self {
            Self::Rectangle { length, width } => vec![rectangle(length, width, size)],
            Self::Disc { diameter } => vec![circle(diameter, size)],
            Self::Annulus { outer, inner } => vec![circle(outer, size), circle(inner, size)],
            Self::Sector {
                outer,
                inner,
                angle,
            } => vec![sector(outer, inner, angle.to_radians(), size)],
        }
    }

    /// The edge length whose even mesh has about `triangles` faces (within a few per cent).
    pub fn edge_for(&self, triangles: usize) -> f64 {
        self.edge_for_graded(triangles, |edge, _| edge)
    }

    /// The longest edge whose graded mesh has about `triangles` faces (within a few per cent): `size` maps the longest
    /// edge and a point to the edge length wanted there \[m\].
    pub fn edge_for_graded(
        &self,
        triangles: usize,
        size: impl Fn(f64, &Vector2<f64>) -> f64,
    ) -> f64 {
        let mut edge = self.equilateral_edge(triangles as f64);
        let mut best = (f64::INFINITY, edge);
        for round in 0..24 {
            let size = |p: &Point| size(edge, p).min(edge);
            let loops = self.loops(&size);
            let boundary: usize = loops.iter().map(Vec::len).sum();
            let inner = lattice(self, edge, &size).len();
            let count = (2 * (inner + loops.len() - 1) + boundary).saturating_sub(2);
            let ratio = count as f64 / triangles as f64;
            let off = (ratio - 1.0).abs();
            if off < best.0 {
                best = (off, edge);
            }
            if round >= 6 && off < 0.04 {
                return edge;
            }
            // The count jumps where a row of the lattice comes in, so full steps may go to and fro for ever.
            edge *= ratio.powf(if round < 6 { 0.5 } else { 0.15 });
        }
        best.1
    }
}

/// Meshes an outline evenly. The same arguments give the same mesh.
pub fn generate(outline: &Outline, options: &MeshOptions) -> Mesh {
    generate_graded(outline, options, &|_| options.edge)
}

/// Meshes an outline with edges of the length that `size` wants, never longer than `options.edge`. It should vary by
/// no more than a quarter of the way that one goes.
pub fn generate_graded(outline: &Outline, options: &MeshOptions, size: Size) -> Mesh {
    let mut random = Pcg64::seed_from_u64(options.seed);
    let size = &|p: &Point| size(p).min(options.edge);
    let mut disc = |radius: f64| {
        let (turn, r): (f64, f64) = (random.random(), random.random());
        let (sin, cos) = (std::f64::consts::TAU * turn).sin_cos();
        Point::new(cos, sin) * (radius * r.sqrt())
    };
    let loops = outline.loops(size);
    let mut points: Vec<Point> = loops.iter().flatten().copied().collect();
    let fixed = points.len();
    // A shaken lattice melts into an unstructured mesh; a still one would align hinges with the yarns.
    let lattice = lattice(outline, options.edge, size);
    points.extend(lattice.iter().map(|p| p + disc(0.25 * size(p))));
    let mut faces = triangulate(outline, &loops, &points);
    for _ in 0..SMOOTHING_ROUNDS {
        smooth(&mut points, fixed, &faces, options.edge, size);
        faces = triangulate(outline, &loops, &points);
    }
    if points.iter().all(|p| size(p) == options.edge) {
        round_off(&mut points, fixed, &faces);
    }
    if options.jitter > 0.0 {
        for p in &mut points[fixed..] {
            *p += disc(options.jitter * size(p));
        }
        faces = triangulate(outline, &loops, &points);
    }
    let to_material = Rotation2::new(-options.warp_angle);
    let material = points.iter().map(|p| to_material * p).collect();
    Mesh::new(points, material, faces)
}

fn rectangle(length: f64, width: f64, size: Size) -> Vec<Point> {
    let (x, y) = (0.5 * length, 0.5 * width);
    let corners = [
        Point::new(-x, -y),
        Point::new(x, -y),
        Point::new(x, y),
        Point::new(-x, y),
    ];
    let mut points = vec![];
    for side in 0..4 {
        let (from, to) = (corners[side], corners[(side + 1) % 4]);
        let at = |part: f64| from + (to - from) * part;
        points.extend(divide([length, width][side % 2], 1, at, size));
    }
    points
}

fn circle(diameter: f64, size: Size) -> Vec<Point> {
    use std::f64::consts::{PI, TAU};
    let at = |part: f64| {
        let (sin, cos) = (TAU * part).sin_cos();
        Point::new(cos, sin) * (0.5 * diameter)
    };
    divide(PI * diameter, 6, at, size)
}

fn sector(outer: f64, inner: f64, angle: f64, size: Size) -> Vec<Point> {
    let place = |diameter: f64, turn: f64| {
        let (sin, cos) = turn.sin_cos();
        Point::new(cos, sin) * (0.5 * diameter)
    };
    let side = 0.5 * (outer - inner);
    let from_to = |a: f64, b: f64, part: f64| a + (b - a) * part;
    let outside = divide(0.5 * outer * angle, 2, |t| place(outer, t * angle), size);
    let end = divide(side, 1, |t| place(from_to(outer, inner, t), angle), size);
    let inside = divide(
        0.5 * inner * angle,
        2,
        |t| place(inner, (1.0 - t) * angle),
        size,
    );
    let start = divide(side, 1, |t| place(from_to(inner, outer, t), 0.0), size);
    [outside, end, inside, start].concat()
}

/// Parts into which a curve is cut to see how its edges grow along it.
const SAMPLES: usize = 1000;

/// Points along a curve of a length \[m\], the end left out, as far apart as `size` wants; at least `least` of them.
fn divide(length: f64, least: usize, at: impl Fn(f64) -> Point, size: Size) -> Vec<Point> {
    let wanted = |k: usize| size(&at((k as f64 + 0.5) / SAMPLES as f64));
    let (first, even) = (wanted(0), (1..SAMPLES).all(|k| wanted(k) == wanted(0)));
    if even {
        let n = ((length / first).round() as usize).max(least);
        return (0..n).map(|i| at(i as f64 / n as f64)).collect();
    }
    // How many edges lie before each sample.
    let mut edges = vec![0.0];
    for k in 0..SAMPLES {
        edges.push(edges[k] + length / SAMPLES as f64 / wanted(k));
    }
    let n = (edges[SAMPLES].round() as usize).max(least);
    let place = |i: usize| {
        let goal = edges[SAMPLES] * i as f64 / n as f64;
        let k = edges.partition_point(|e| *e <= goal).clamp(1, SAMPLES);
        let within = (goal - edges[k - 1]) / (edges[k] - edges[k - 1]);
        at((k as f64 - 1.0 + within) / SAMPLES as f64)
    };
    (0..n).map(place).collect()
}

/// Ratio of the spacings of lattices that follow each other where the mesh gets finer.
const RATIO: f64 = std::f64::consts::SQRT_2;

/// Interior points of equilateral lattices, each where its spacing is nearest to the wanted size, a little more than
/// half an edge from the boundary.
fn lattice(outline: &Outline, edge: f64, size: Size) -> Vec<Point> {
    let half = outline.half_extent();
    let mut points = vec![];
    let (mut spacing, mut finest) = (edge, false);
    while !finest {
        finest = true;
        let rise = spacing * 0.75f64.sqrt();
        let (rows, columns) = (
            (half.y / rise).ceil() as i64,
            (half.x / spacing).ceil() as i64 + 1,
        );
        for row in -rows..=rows {
            let shift = if row % 2 == 0 { 0.0 } else { 0.5 };
            for column in -columns..=columns {
                let p = Point::new((column as f64 + shift) * spacing, row as f64 * rise);
                if outline.depth(&p) <= 0.6 * size(&p).min(spacing) {
                    continue;
                }
                let wanted = size(&p) / spacing;
                finest &= wanted >= RATIO.sqrt().recip();
                let coarsest = spacing == edge;
                if wanted >= RATIO.sqrt().recip() && (coarsest || wanted < RATIO.sqrt()) {
                    points.push(p);
                }
            }
        }
        spacing /= RATIO;
    }
    points
}

/// Constrained Delaunay faces inside the outline, counter-clockwise, in a fixed order.
fn triangulate(outline: &Outline, loops: &[Vec<Point>], points: &[Point]) -> Vec<[u32; 3]> {
    let vertices = points.iter().map(|p| Point2::new(p.x, p.y)).collect();
    let mut constraints = vec![];
    let mut start = 0;
    for ring in loops {
        constraints.extend((0..ring.len()).map(|i| [start + i, start + (i + 1) % ring.len()]));
        start += ring.len();
    }
    let triangulation =
        ConstrainedDelaunayTriangulation::<Point2<f64>>::bulk_load_cdt(vertices, constraints)
            .expect("finite points inside a finite outline");
    let mut faces: Vec<[u32; 3]> = triangulation
        .inner_faces()
        .map(|face| face.vertices().map(|v| v.index() as u32))
        .filter(|face| {
            let centre: Point = face.iter().map(|&v| points[v as usize]).sum::<Point>() / 3.0;
            outline.depth(&centre) > 0.0
        })
        .map(rotate_smallest_first)
        .collect();
    faces.sort_unstable();
    faces
}

fn rotate_smallest_first(face: [u32; 3]) -> [u32; 3] {
    let [a, b, c] = face;
    if a < b && a < c {
        [a, b, c]
    } else if b < c {
        [b, c, a]
    } else {
        [c, a, b]
    }
}

/// Moves each interior vertex to the centre of its faces, weighted by their area over the fourth power of the wanted
/// size (Du, Faber, Gunzburger 1999, lumped).
fn smooth(points: &mut [Point], fixed: usize, faces: &[[u32; 3]], edge: f64, size: Size) {
    let mut sums = vec![(Point::zeros(), 0.0); points.len()];
    for face in faces {
        let [a, b, c] = face.map(|v| points[v as usize]);
        let centre = a + b + c;
        let finer = edge / size(&(centre / 3.0));
        let weight = (b - a).perp(&(c - a)) * (finer * finer) * (finer * finer);
        for &v in face {
            sums[v as usize].0 += centre * (weight / 3.0);
            sums[v as usize].1 += weight;
        }
    }
    for (point, (sum, weight)) in points.iter_mut().zip(sums).skip(fixed) {
        if weight > 0.0 {
            *point = sum / weight;
        }
    }
}
