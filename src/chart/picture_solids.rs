//! Obstacles as surfaces to draw: each shape is a few grids of quadrilaterals.

use std::f64::consts::{PI, TAU};

use nalgebra::{Point3, Vector3};

use super::picture_cloth::{Kind, Surface};
use crate::contact::{Obstacle, Shape, Surface as Mesh};

/// Sides of a full circle.
const ROUND: usize = 96;

/// Tessellates an obstacle with cells near `cell`; a plane becomes a patch of `radius` about `centre`.
pub(super) fn solid(obstacle: &Obstacle, cell: f64, centre: Vector3<f64>, radius: f64) -> Surface {
    let mut grids = Grids {
        surface: empty(Kind::Solid),
        cell,
    };
    match obstacle.shape {
        Shape::Plane => {
            let local = obstacle.pose.inverse_transform_point(&Point3::from(centre));
            grids.surface.kind = Kind::Ground;
            grids.patch(Vector3::new(local.x, local.y, 0.0), radius);
        }
        Shape::Box { size } => grids.cuboid(size),
        Shape::Sphere { radius } => grids.lathe(&arc(radius, 0.0, -0.5 * PI, 0.5 * PI, 48)),
        Shape::Disc { radius } => {
            grids.lathe(&[(0.0, 0.0), (radius, 0.0)]);
            grids.ring(radius, 0.0);
        }
        Shape::Cylinder { radius, length } => {
            let h = 0.5 * length;
            grids.lathe(&[(0.0, -h), (radius, -h)]);
            grids.lathe(&[(radius, -h), (radius, h)]);
            grids.lathe(&[(radius, h), (0.0, h)]);
            grids.ring(radius, -h);
            grids.ring(radius, h);
        }
        Shape::Capsule { radius, length } => {
            let h = 0.5 * length;
            grids.lathe(&arc(radius, -h, -0.5 * PI, 0.0, 24));
            grids.lathe(&[(radius, -h), (radius, h)]);
            grids.lathe(&arc(radius, h, 0.0, 0.5 * PI, 24));
        }
        Shape::Mesh(ref mesh) => grids.triangles(mesh),
    }
    place(grids.surface, obstacle)
}

/// The imagined floor under a scene: takes shadow, has no colour of its own.
pub(super) fn floor(centre: Vector3<f64>, radius: f64, cell: f64) -> Surface {
    let mut grids = Grids {
        surface: empty(Kind::Floor),
        cell,
    };
    grids.patch(centre, radius);
    grids.surface
}

fn empty(kind: Kind) -> Surface {
    Surface {
        kind,
        points: vec![],
        normals: vec![],
        faces: vec![],
        material: vec![],
        cover: vec![],
        lines: vec![],
    }
}

fn place(mut surface: Surface, obstacle: &Obstacle) -> Surface {
    let pose = &obstacle.pose;
    let world = |p: &Vector3<f64>| pose.rotation * p + pose.translation.vector;
    surface.points.iter_mut().for_each(|p| *p = world(p));
    surface
        .normals
        .iter_mut()
        .for_each(|n| *n = pose.rotation * *n);
    surface
        .lines
        .iter_mut()
        .flatten()
        .for_each(|p| *p = world(p));
    surface
}

/// Profile points (radius, z) of part of a circle.
fn arc(radius: f64, z: f64, from: f64, to: f64, n: usize) -> Vec<(f64, f64)> {
    let angle = |i: usize| from + (to - from) * i as f64 / n as f64;
    (0..=n)
        .map(|i| {
            (
                radius * angle(i).cos().max(0.0),
                z + radius * angle(i).sin(),
            )
        })
        .collect()
}

struct Grids {
    surface: Surface,
    cell: f64,
}

impl Grids {
    /// Adds an (n+1) x (m+1) grid of points with normals.
    fn grid(&mut self, n: usize, m: usize, at: impl Fn(f64, f64) -> (Vector3<f64>, Vector3<f64>)) {
        let base = self.surface.points.len() as u32;
        for i in 0..=n {
            for j in 0..=m {
                let (point, normal) = at(i as f64 / n as f64, j as f64 / m as f64);
                self.surface.points.push(point);
                self.surface.normals.push(normal);
            }
        }
        let id = |i: usize, j: usize| base + (i * (m + 1) + j) as u32;
        for i in 0..n {
            for j in 0..m {
                let [a, b, c, d] = [id(i, j), id(i + 1, j), id(i + 1, j + 1), id(i, j + 1)];
                self.surface.faces.push([a, b, c]);
                self.surface.faces.push([a, c, d]);
            }
        }
    }

    /// Flat triangles, and lines where they are folded.
    fn triangles(&mut self, mesh: &Mesh) {
        for (t, corners) in mesh.outward().enumerate() {
            let base = self.surface.points.len() as u32;
            let places = corners.map(|v| mesh.vertices()[v as usize]);
            self.surface.points.extend(places);
            self.surface.normals.extend([mesh.normal(t); 3]);
            self.surface.faces.push([base, base + 1, base + 2]);
        }
        self.surface.lines.extend(mesh.ridges());
    }

    fn steps(&self, length: f64) -> usize {
        ((length / self.cell).ceil() as usize).clamp(1, 120)
    }

    /// A horizontal disc of paint that fades out from 60 % of its radius on.
    fn patch(&mut self, centre: Vector3<f64>, radius: f64) {
        let n = self.steps(2.0 * radius).max(40);
        let at = |u: f64, v: f64| {
            let offset = Vector3::new(2.0 * u - 1.0, 2.0 * v - 1.0, 0.0) * radius;
            (centre + offset, Vector3::z())
        };
        self.grid(n, n, at);
        let fade = |p: &Vector3<f64>| {
            let s = (((p - centre).norm() / radius - 0.55) / 0.42).clamp(0.0, 1.0);
            1.0 - s * s * (3.0 - 2.0 * s)
        };
        self.surface.cover = self.surface.points.iter().map(fade).collect();
    }

    fn cuboid(&mut self, size: [f64; 3]) {
        let half = Vector3::from(size) * 0.5;
        for axis in 0..3 {
            let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
            for sign in [-1.0, 1.0] {
                let mut normal = Vector3::zeros();
                normal[axis] = sign;
                let at = |s: f64, t: f64| {
                    let mut p = Vector3::zeros();
                    p[axis] = sign * half[axis];
                    p[u] = sign * (2.0 * s - 1.0) * half[u];
                    p[v] = (2.0 * t - 1.0) * half[v];
                    (p, normal)
                };
                self.grid(self.steps(size[u]), self.steps(size[v]), at);
            }
            for (s, t) in [(-1.0, -1.0), (-1.0, 1.0), (1.0, -1.0), (1.0, 1.0)] {
                let end = |w: f64| {
                    let mut p = Vector3::zeros();
                    p[axis] = w * half[axis];
                    p[u] = s * half[u];
                    p[v] = t * half[v];
                    p
                };
                self.surface.lines.push([end(-1.0), end(1.0)]);
            }
        }
    }

    /// Turns a profile of (radius, z), listed so that its outside is on the right, about the z axis.
    fn lathe(&mut self, profile: &[(f64, f64)]) {
        let round = profile.len() > 2;
        for (pair, k) in profile.windows(2).zip(0..) {
            let ((r0, z0), (r1, z1)) = (pair[0], pair[1]);
            let slope = Vector3::new(z1 - z0, 0.0, r0 - r1).normalize();
            let tilt = |s: f64| {
                if round {
                    profile_normal(profile, k, s)
                } else {
                    slope
                }
            };
            let at = |u: f64, v: f64| {
                let (sin, cos) = (u * TAU).sin_cos();
                let n = tilt(v);
                let r = r0 + (r1 - r0) * v;
                let z = z0 + (z1 - z0) * v;
                (
                    Vector3::new(r * cos, r * sin, z),
                    Vector3::new(n.x * cos, n.x * sin, n.z),
                )
            };
            let m = if round {
                1
            } else {
                self.steps((r1 - r0).hypot(z1 - z0))
            };
            self.grid(ROUND, m, at);
        }
    }

    fn ring(&mut self, radius: f64, z: f64) {
        let at = |k: usize| {
            let (sin, cos) = (k as f64 * TAU / ROUND as f64).sin_cos();
            Vector3::new(radius * cos, radius * sin, z)
        };
        self.surface
            .lines
            .extend((0..ROUND).map(|k| [at(k), at(k + 1)]));
    }
}

/// Normal of a smooth profile at one end (v = 0 or 1) of segment k: the mean of its neighbours.
fn profile_normal(profile: &[(f64, f64)], k: usize, v: f64) -> Vector3<f64> {
    let i = if v < 0.5 { k } else { k + 1 };
    let (before, after) = (
        profile[i.saturating_sub(1)],
        profile[(i + 1).min(profile.len() - 1)],
    );
    Vector3::new(after.1 - before.1, 0.0, before.0 - after.0)
        .try_normalize(0.0)
        .unwrap_or_else(Vector3::z)
}
