//! Light, baked into vertices: an overcast sky and a soft key light, both with shadows.
//!
//! Irradiance is a sum over a fixed set of directions d: E(n) = sum_d L(d) V(x, d) max(0, n·d), where V comes
//! from one depth map per direction. Many directions make the shadow's edges soft and folds dark inside.

use std::f64::consts::TAU;

use nalgebra::{Vector2, Vector3};

use super::picture_camera::Camera;
use super::picture_cloth::{Kind, Surface};
use super::raster::spans;

/// Linear red, green, blue.
pub(super) type Rgb = [f32; 3];

/// Colours of a vertex seen from its front and from its back.
pub(super) type TwoSided = [Rgb; 2];

const SKY_DIRECTIONS: usize = 128;
const KEY_DIRECTIONS: usize = 48;
const MAP: usize = 512;
const SKY_SHARE: f64 = 0.56;
const KEY_SHARE: f64 = 0.52;
/// Light from the viewer, without shadow, so that no side is black.
const FILL_SHARE: f64 = 0.16;

/// A direction of light with its share of the irradiance.
struct Ray {
    toward: Vector3<f64>,
    radiance: f64,
}

/// Colours of every vertex of every surface.
pub(super) fn light(surfaces: &[Surface], camera: &Camera) -> Vec<Vec<TwoSided>> {
    let casters: Vec<&Surface> = surfaces
        .iter()
        .filter(|s| matches!(s.kind, Kind::Cloth | Kind::Solid))
        .collect();
    let mut sums: Vec<Vec<[f64; 2]>> = surfaces
        .iter()
        .map(|s| vec![[0.0; 2]; s.points.len()])
        .collect();
    for ray in rays(camera) {
        let map = DepthMap::new(&casters, ray.toward);
        for (surface, sums) in surfaces.iter().zip(&mut sums) {
            for ((point, normal), sum) in surface.points.iter().zip(&surface.normals).zip(sums) {
                gather(&map, &ray, point, normal, sum);
            }
        }
    }
    for (surface, sums) in surfaces.iter().zip(&mut sums) {
        smooth(surface, sums);
        fill(surface, camera, sums);
    }
    let open = open_sky(camera);
    let colours = surfaces.iter().zip(&sums);
    colours
        .map(|(s, sums)| {
            (0..sums.len())
                .map(|i| paint(s, i, sums[i], open))
                .collect()
        })
        .collect()
}

fn gather(map: &DepthMap, ray: &Ray, p: &Vector3<f64>, n: &Vector3<f64>, sum: &mut [f64; 2]) {
    let cosine = n.dot(&ray.toward);
    let lit = cosine.abs() > 1e-3 && map.sees(p + n * (cosine.signum() * map.texel), cosine.abs());
    if lit {
        sum[usize::from(cosine < 0.0)] += ray.radiance * cosine.abs();
    }
}

/// Averages over neighbours: what is left of the grain of a finite set of rays goes.
fn smooth(surface: &Surface, sums: &mut Vec<[f64; 2]>) {
    let passes = match surface.kind {
        Kind::Floor | Kind::Ground => 6,
        Kind::Cloth | Kind::Solid => 1,
    };
    for _ in 0..passes {
        let mut next: Vec<[f64; 3]> = sums.iter().map(|s| [2.0 * s[0], 2.0 * s[1], 2.0]).collect();
        for face in &surface.faces {
            for k in 0..3 {
                let (from, to) = (face[k] as usize, face[(k + 1) % 3] as usize);
                let sum = [sums[from][0], sums[from][1], 1.0];
                (0..3).for_each(|i| next[to][i] += sum[i]);
            }
        }
        *sums = next.iter().map(|n| [n[0] / n[2], n[1] / n[2]]).collect();
    }
}

fn fill(surface: &Surface, camera: &Camera, sums: &mut [[f64; 2]]) {
    for (normal, sum) in surface.normals.iter().zip(sums) {
        let cosine = normal.dot(&camera.toward);
        sum[usize::from(cosine < 0.0)] += FILL_SHARE * cosine.abs();
    }
}

/// Sky rays over the whole sphere (dim below: light from the ground), key rays in a narrow cone.
fn rays(camera: &Camera) -> Vec<Ray> {
    let golden = TAU * (2.0 - 1.618_033_988_749_895);
    let mut rays = vec![];
    for k in 0..SKY_DIRECTIONS {
        let z = 1.0 - (2 * k + 1) as f64 / SKY_DIRECTIONS as f64;
        let (sin, cos) = (golden * k as f64).sin_cos();
        let r = (1.0 - z * z).sqrt();
        let s = ((z + 0.4) / 1.4).clamp(0.0, 1.0);
        let radiance = 0.42 + 0.58 * s * s * (3.0 - 2.0 * s);
        rays.push(Ray {
            toward: Vector3::new(r * cos, r * sin, z),
            radiance,
        });
    }
    let up: f64 = rays.iter().map(|r| r.radiance * r.toward.z.max(0.0)).sum();
    rays.iter_mut().for_each(|r| r.radiance *= SKY_SHARE / up);
    let level = camera.right.cross(&Vector3::z());
    let key = (Vector3::z() * 0.92 - camera.right * 0.60 + level * 0.42).normalize();
    let (a, b) = axes(&key);
    for k in 0..KEY_DIRECTIONS {
        let r = 0.16 * ((k as f64 + 0.5) / KEY_DIRECTIONS as f64).sqrt();
        let (sin, cos) = (golden * k as f64).sin_cos();
        let toward = (key + a * (r * cos) + b * (r * sin)).normalize();
        rays.push(Ray {
            toward,
            radiance: KEY_SHARE / KEY_DIRECTIONS as f64,
        });
    }
    rays
}

/// Irradiance on an open horizontal floor.
fn open_sky(camera: &Camera) -> f64 {
    let rays: f64 = rays(camera)
        .iter()
        .map(|r| r.radiance * r.toward.z.max(0.0))
        .sum();
    rays + FILL_SHARE * camera.toward.z
}

fn paint(surface: &Surface, vertex: usize, irradiance: [f64; 2], open: f64) -> TwoSided {
    let albedo: TwoSided = match surface.kind {
        Kind::Cloth => [[0.245, 0.405, 0.625], [0.800, 0.520, 0.300]],
        Kind::Solid => [[0.66, 0.65, 0.63]; 2],
        Kind::Ground => [[0.80, 0.80, 0.79]; 2],
        Kind::Floor => [[1.0; 3]; 2],
    };
    let cover = surface.cover.get(vertex).copied().unwrap_or(1.0);
    let mut out = albedo;
    for (colour, e) in out.iter_mut().zip(irradiance) {
        let shadow = 1.0 - (e / open).min(1.0);
        for c in colour {
            *c = match surface.kind {
                Kind::Floor | Kind::Ground => {
                    let shaded = f64::from(*c) * (1.0 - 0.62 * shadow);
                    (1.0 - cover * (1.0 - shaded)) as f32
                }
                Kind::Cloth | Kind::Solid => *c * e as f32,
            };
        }
    }
    out
}

fn axes(direction: &Vector3<f64>) -> (Vector3<f64>, Vector3<f64>) {
    let helper = if direction.z.abs() < 0.9 {
        Vector3::z()
    } else {
        Vector3::x()
    };
    let u = direction.cross(&helper).normalize();
    (u, direction.cross(&u))
}

/// The first surface met by parallel light.
struct DepthMap {
    toward: Vector3<f64>,
    u: Vector3<f64>,
    v: Vector3<f64>,
    low: Vector2<f64>,
    texel: f64,
    depth: Vec<f32>,
}

impl DepthMap {
    fn new(casters: &[&Surface], toward: Vector3<f64>) -> Self {
        let (u, v) = axes(&toward);
        let flat = |p: &Vector3<f64>| Vector2::new(u.dot(p), v.dot(p));
        let mut low = Vector2::repeat(f64::INFINITY);
        let mut high = Vector2::repeat(f64::NEG_INFINITY);
        for p in casters.iter().flat_map(|s| &s.points).map(flat) {
            low = low.inf(&p);
            high = high.sup(&p);
        }
        let texel = (high - low).max().max(1e-6) / (MAP - 2) as f64;
        let low = low - Vector2::repeat(texel);
        let depth = vec![f32::NEG_INFINITY; MAP * MAP];
        let mut map = Self {
            toward,
            u,
            v,
            low,
            texel,
            depth,
        };
        for surface in casters {
            map.cast(surface);
        }
        map
    }

    fn texels(&self, p: &Vector3<f64>) -> Vector3<f64> {
        let flat = (Vector2::new(self.u.dot(p), self.v.dot(p)) - self.low) / self.texel;
        Vector3::new(flat.x, flat.y, self.toward.dot(p))
    }

    fn cast(&mut self, surface: &Surface) {
        for face in &surface.faces {
            let corners = face.map(|v| self.texels(&surface.points[v as usize]));
            spans(&corners, MAP, MAP, |at, w| {
                let z = (0..3).map(|k| w[k] * corners[k].z).sum::<f64>() as f32;
                self.depth[at] = self.depth[at].max(z);
            });
        }
    }

    /// Whether the light reaches a point on a surface inclined by `cosine` to it.
    fn sees(&self, point: Vector3<f64>, cosine: f64) -> bool {
        let p = self.texels(&point);
        let inside = |x: f64| x >= 0.0 && x < MAP as f64;
        if !inside(p.x) || !inside(p.y) {
            return true;
        }
        let steep = (1.0 - cosine * cosine).max(0.0).sqrt() / cosine;
        let bias = self.texel * (1.0 + 0.8 * steep.min(8.0));
        f64::from(self.depth[p.y as usize * MAP + p.x as usize]) <= p.z + bias
    }
}
