//! Unstructured near-equilateral meshes: lattice points, Delaunay (spade), smoothing.

use nalgebra::{Rotation2, Vector2};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;
use spade::{ConstrainedDelaunayTriangulation, Point2, Triangulation};

use super::mesh::Mesh;
use super::outline::Outline;

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

/// Rounds of Delaunay and smoothing; the mean shape quality gains less than 0.1 % after 40.
const SMOOTHING_ROUNDS: usize = 40;

impl Outline {
    fn loops(&self, edge: f64) -> Vec<Vec<Point>> {
        match *self {
            Self::Rectangle { length, width } => vec![rectangle(length, width, edge)],
            Self::Disc { diameter } => vec![circle(diameter, edge)],
            Self::Annulus { outer, inner } => vec![circle(outer, edge), circle(inner, edge)],
        }
    }

    /// The edge length whose mesh has about `triangles` faces (within a few per cent).
    pub fn edge_for(&self, triangles: usize) -> f64 {
        let mut edge = self.equilateral_edge(triangles as f64);
        let mut best = (f64::INFINITY, edge);
        for round in 0..24 {
            let boundary: usize = self.loops(edge).iter().map(Vec::len).sum();
            let holes = self.loops(edge).len() - 1;
            let count = (2 * (lattice(self, edge).len() + holes) + boundary).saturating_sub(2);
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

/// Meshes an outline. The same arguments give the same mesh.
pub fn generate(outline: &Outline, options: &MeshOptions) -> Mesh {
    let mut random = Pcg64::seed_from_u64(options.seed);
    let mut disc = |radius: f64| {
        let (turn, r): (f64, f64) = (random.random(), random.random());
        let (sin, cos) = (std::f64::consts::TAU * turn).sin_cos();
        Point::new(cos, sin) * (radius * r.sqrt())
    };
    let loops = outline.loops(options.edge);
    let mut points: Vec<Point> = loops.iter().flatten().copied().collect();
    let fixed = points.len();
    // A shaken lattice melts into an unstructured mesh; a still one would align hinges with the yarns.
    let lattice = lattice(outline, options.edge);
    points.extend(lattice.iter().map(|p| p + disc(0.25 * options.edge)));
    let mut faces = triangulate(outline, &loops, &points);
    for _ in 0..SMOOTHING_ROUNDS {
        smooth(&mut points, fixed, &faces);
        faces = triangulate(outline, &loops, &points);
    }
    if options.jitter > 0.0 {
        for p in &mut points[fixed..] {
            *p += disc(options.jitter * options.edge);
        }
        faces = triangulate(outline, &loops, &points);
    }
    let to_material = Rotation2::new(-options.warp_angle);
    let material = points.iter().map(|p| to_material * p).collect();
    Mesh::new(points, material, faces)
}

fn rectangle(length: f64, width: f64, edge: f64) -> Vec<Point> {
    let (nx, ny) = (divisions(length, edge), divisions(width, edge));
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
        let n = [nx, ny][side % 2];
        points.extend((0..n).map(|i| from + (to - from) * (i as f64 / n as f64)));
    }
    points
}

fn circle(diameter: f64, edge: f64) -> Vec<Point> {
    let n = divisions(std::f64::consts::PI * diameter, edge).max(6);
    (0..n)
        .map(|i| {
            let (sin, cos) = (std::f64::consts::TAU * i as f64 / n as f64).sin_cos();
            Point::new(cos, sin) * (0.5 * diameter)
        })
        .collect()
}

fn divisions(length: f64, edge: f64) -> usize {
    ((length / edge).round() as usize).max(1)
}

/// Interior points of the equilateral lattice, half an edge or more from the boundary.
fn lattice(outline: &Outline, edge: f64) -> Vec<Point> {
    let half = outline.half_extent();
    let rise = edge * 0.75f64.sqrt();
    let (rows, columns) = (
        (half.y / rise).ceil() as i64,
        (half.x / edge).ceil() as i64 + 1,
    );
    let mut points = vec![];
    for row in -rows..=rows {
        let shift = if row % 2 == 0 { 0.0 } else { 0.5 };
        for column in -columns..=columns {
            let p = Point::new((column as f64 + shift) * edge, row as f64 * rise);
            if outline.depth(&p) > 0.6 * edge {
                points.push(p);
            }
        }
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

/// Moves each interior vertex to the area-weighted centre of its faces (Du, Faber, Gunzburger 1999, lumped).
fn smooth(points: &mut [Point], fixed: usize, faces: &[[u32; 3]]) {
    let mut sums = vec![(Point::zeros(), 0.0); points.len()];
    for face in faces {
        let [a, b, c] = face.map(|v| points[v as usize]);
        let area = (b - a).perp(&(c - a));
        for &v in face {
            sums[v as usize].0 += (a + b + c) * (area / 3.0);
            sums[v as usize].1 += area;
        }
    }
    for (point, (sum, area)) in points.iter_mut().zip(sums).skip(fixed) {
        if area > 0.0 {
            *point = sum / area;
        }
    }
}
