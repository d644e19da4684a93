//! Signed distance to the obstacle shapes, with exact first and second derivatives.

use nalgebra::{Matrix3, Vector3};

use super::obstacle::{Obstacle, Shape};
use super::surface::Part;

/// Signed distance at a point and its derivatives.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Distance {
    /// Distance, negative inside \[m\].
    pub value: f64,
    /// Gradient: the outward unit normal \[-\].
    pub normal: Vector3<f64>,
    /// Second derivative \[1/m\]; zero in the plane of the normal.
    pub curvature: Matrix3<f64>,
}

/// Lengths below this count as zero when a direction is wanted \[m\].
const TINY: f64 = 1e-12;

impl Obstacle {
    /// Distance from a point in the world to the surface that acts (see [`Overlap`](super::Overlap)).
    pub fn distance(&self, point: &Vector3<f64>) -> Distance {
        self.to_world(&self.shape.distance(&self.to_local(point)))
    }

    /// The same from one part of a triangle mesh, prolonged, if it is one and a part is given.
    pub fn distance_to(&self, part: Option<Part>, point: &Vector3<f64>) -> Distance {
        match (&self.shape, part) {
            (Shape::Mesh(surface), Some(part)) => {
                self.to_world(&surface.distance_to(part, &self.to_local(point)))
            }
            _ => self.distance(point),
        }
    }

    /// A point of the world in the obstacle's frame.
    fn to_local(&self, point: &Vector3<f64>) -> Vector3<f64> {
        self.pose.inverse_transform_point(&(*point).into()).coords
    }

    /// Points of the world in the obstacle's frame.
    pub fn all_to_local<'a>(
        &self,
        points: impl Iterator<Item = &'a Vector3<f64>>,
    ) -> Vec<Vector3<f64>> {
        let frame = self.frame();
        points.map(frame).collect()
    }

    /// What takes a point of the world to the obstacle's frame.
    pub(super) fn frame(&self) -> impl Fn(&Vector3<f64>) -> Vector3<f64> + use<> {
        let turn = self.pose.rotation.to_rotation_matrix();
        let turn = turn.into_inner().transpose();
        let origin = self.pose.translation.vector;
        move |p| turn * (p - origin)
    }

    /// A distance found in the obstacle's frame, with its derivatives turned to the world's, from the surface that acts.
    pub(super) fn to_world(&self, d: &Distance) -> Distance {
        let turn = self.pose.rotation.to_rotation_matrix();
        Distance {
            value: d.value + self.overlap.depth,
            normal: turn * d.normal,
            curvature: turn.matrix() * d.curvature * turn.matrix().transpose(),
        }
    }
}

impl Shape {
    /// Value and normal alone: the compiler drops the rest of [`Shape::distance`].
    #[inline]
    pub(super) fn first_order(&self, p: &Vector3<f64>) -> (f64, Vector3<f64>) {
        if let Self::Box { size } = self
            && let Some(first) = beyond_cuboid(p, &(Vector3::from(*size) * 0.5))
        {
            return first;
        }
        let d = self.distance(p);
        (d.value, d.normal)
    }

    /// How far a point may move before the normal there can turn \[m\]; not positive where it turns with any motion.
    pub(super) fn straight(&self, p: &Vector3<f64>) -> f64 {
        // From a side at distance `ahead`, where the next one is at `beside`, outside or inside of the shape.
        let within = |ahead: f64, beside: f64, depth: f64| {
            let leave = (-beside).min(0.5 * (ahead - beside));
            leave.min(depth)
        };
        match *self {
            Self::Plane => f64::INFINITY,
            Self::Box { size } => {
                let mut sides = p.abs() - Vector3::from(size) * 0.5;
                let axis = sides.imax();
                let ahead = std::mem::replace(&mut sides[axis], f64::NEG_INFINITY);
                within(ahead, sides.max(), p[axis].abs())
            }
            Self::Disc { radius } => within(p.z.abs(), p.x.hypot(p.y) - radius, p.z.abs()),
            Self::Cylinder { radius, length } => {
                let cap = p.z.abs() - 0.5 * length;
                within(cap, p.x.hypot(p.y) - radius, p.z.abs())
            }
            Self::Sphere { .. } | Self::Capsule { .. } | Self::Mesh(_) => 0.0,
        }
    }

    /// How far the flat side with such a normal is from the origin of the shape \[m\].
    pub(super) fn level(&self, normal: &Vector3<f64>) -> f64 {
        match *self {
            Self::Box { size } => 0.5 * Vector3::from(size).dot(&normal.abs()),
            Self::Cylinder { length, .. } => 0.5 * length,
            Self::Plane
            | Self::Disc { .. }
            | Self::Sphere { .. }
            | Self::Capsule { .. }
            | Self::Mesh(_) => 0.0,
        }
    }

    /// Radius of a ball inside \[m\]: the largest; zero for a disc and a mesh, which may be thin; infinite for a plane.
    pub fn inner_radius(&self) -> f64 {
        match *self {
            Self::Plane => f64::INFINITY,
            Self::Box { size: [x, y, z] } => 0.5 * x.min(y).min(z),
            Self::Sphere { radius } | Self::Capsule { radius, .. } => radius,
            Self::Disc { .. } | Self::Mesh(_) => 0.0,
            Self::Cylinder { radius, length } => radius.min(0.5 * length),
        }
    }

    /// Depth below the surface of the point or axis about which the shape is round \[m\]; zero where it is sharp.
    pub(super) fn core(&self) -> f64 {
        match *self {
            Self::Sphere { radius } | Self::Capsule { radius, .. } => radius,
            Self::Plane
            | Self::Box { .. }
            | Self::Disc { .. }
            | Self::Cylinder { .. }
            | Self::Mesh(_) => 0.0,
        }
    }

    /// Distance from a point in the shape's frame: a convex function, but for meshes.
    #[inline(always)]
    pub fn distance(&self, p: &Vector3<f64>) -> Distance {
        match *self {
            Self::Plane => flat(p.z, Vector3::z()),
            Self::Box { size } => cuboid(p, &(Vector3::from(size) * 0.5)),
            Self::Sphere { radius } => round(p, radius, &Matrix3::identity()),
            Self::Disc { radius } => cylinder(p, radius, 0.0),
            Self::Cylinder { radius, length } => cylinder(p, radius, 0.5 * length),
            Self::Capsule { radius, length } => {
                let half = 0.5 * length;
                let on_axis = Vector3::new(0.0, 0.0, p.z.clamp(-half, half));
                let beside = p.z.abs() < half;
                let free = if beside {
                    across_z()
                } else {
                    Matrix3::identity()
                };
                round(&(p - on_axis), radius, &free)
            }
            Self::Mesh(ref surface) => surface.distance(p),
        }
    }
}

#[inline(always)]
fn across_z() -> Matrix3<f64> {
    Matrix3::from_diagonal(&Vector3::new(1.0, 1.0, 0.0))
}

#[inline(always)]
fn flat(value: f64, normal: Vector3<f64>) -> Distance {
    let curvature = Matrix3::zeros();
    Distance {
        value,
        normal,
        curvature,
    }
}

/// Distance |d| - radius, where `free` projects on the directions in which d changes with the point.
#[inline(always)]
fn round(d: &Vector3<f64>, radius: f64, free: &Matrix3<f64>) -> Distance {
    let length = d.norm();
    if length < TINY {
        return flat(-radius, Vector3::z());
    }
    let normal = d / length;
    Distance {
        value: length - radius,
        normal,
        curvature: (free - normal * normal.transpose()) / length,
    }
}

#[inline(always)]
fn cuboid(p: &Vector3<f64>, half: &Vector3<f64>) -> Distance {
    let sign = p.map(|c| if c < 0.0 { -1.0 } else { 1.0 });
    let q = p.abs() - half;
    let outside = q.map(|c| c.max(0.0));
    if outside.norm_squared() > TINY * TINY {
        let active = q.map(|c| f64::from(c > 0.0));
        return round(
            &outside.component_mul(&sign),
            0.0,
            &Matrix3::from_diagonal(&active),
        );
    }
    let axis = q.imax();
    let mut normal = Vector3::zeros();
    normal[axis] = sign[axis];
    flat(q[axis], normal)
}

/// What [`cuboid`] finds outside, without a branch for the sides that the point is beyond.
#[inline(always)]
fn beyond_cuboid(p: &Vector3<f64>, half: &Vector3<f64>) -> Option<(f64, Vector3<f64>)> {
    let away = p.zip_map(half, |c, half| (c.abs() - half).max(0.0).copysign(c));
    let length = away.norm();
    (length > TINY).then(|| (length, away / length))
}

/// Cylinder about z of half length `half`; with `half` zero, a disc with two sides.
#[inline(always)]
fn cylinder(p: &Vector3<f64>, radius: f64, half: f64) -> Distance {
    let rho = p.x.hypot(p.y);
    let radial = if rho > TINY {
        Vector3::new(p.x / rho, p.y / rho, 0.0)
    } else {
        Vector3::x()
    };
    let up = if p.z < 0.0 {
        -Vector3::z()
    } else {
        Vector3::z()
    };
    let (beyond_side, beyond_cap) = (rho - radius, p.z.abs() - half);
    let around = Vector3::z().cross(&radial);
    let around = around * around.transpose();
    if beyond_side > 0.0 && beyond_cap > 0.0 {
        let d = radial * beyond_side + up * beyond_cap;
        let length = d.norm();
        let normal = d / length;
        let meridian = Matrix3::identity() - around - normal * normal.transpose();
        let curvature = meridian / length + around * (normal.dot(&radial) / rho);
        return Distance {
            value: length,
            normal,
            curvature,
        };
    }
    if beyond_cap > beyond_side {
        return flat(beyond_cap, up);
    }
    let curvature = around / rho.max(TINY);
    Distance {
        value: beyond_side,
        normal: radial,
        curvature,
    }
}
