use nalgebra::{Matrix2, Matrix3, Vector2, Vector3};

use super::{Contact, ContactLaw, weighted};
use crate::contact::surface::test::cuboid;
use crate::contact::{
    Features, Nearby, Obstacle, Pose, Proximity, Shape, Surface, Velocity, detect,
};
use crate::physics::suite::{self, Chance};
use crate::physics::{Gradient, Hessian, Nodes, Potential};
use crate::sheet::Mesh;

/// Contact reaches 1 mm off the obstacle, so that its rounded edges are part of the game.
const LAW: ContactLaw = ContactLaw {
    stiffness: 2e3,
    grip: 2e2,
    offset: 1e-3,
    firm: f64::INFINITY,
};

fn mesh() -> Mesh {
    let points: Vec<Vector2<f64>> = [[0.0, 0.0], [5e-3, 0.0], [2e-3, 4e-3]]
        .map(Vector2::from)
        .into();
    Mesh::new(points.clone(), points, vec![[0, 1, 2]])
}

fn shapes() -> [(&'static str, Shape); 7] {
    let (radius, length) = (3e-3, 8e-3);
    let size = [8e-3, 9e-3, 10e-3];
    let surface = Surface::try_from(cuboid(size)).expect("a surface");
    [
        ("plane", Shape::Plane),
        ("box", Shape::Box { size }),
        ("sphere", Shape::Sphere { radius }),
        ("disc", Shape::Disc { radius }),
        ("cylinder", Shape::Cylinder { radius, length }),
        ("capsule", Shape::Capsule { radius, length }),
        ("mesh", Shape::Mesh(surface)),
    ]
}

fn obstacle(shape: &Shape, pose: Pose) -> Obstacle {
    Obstacle {
        name: "body".to_string(),
        shape: shape.clone(),
        pose,
        velocity: Velocity::default(),
        friction: 0.3,
        ..Obstacle::default()
    }
}

/// The same energy with the nearest point of the feature found anew: what the contact Hessian is exact for.
struct Sliding<'a>(&'a Contact<'a>);

impl Sliding<'_> {
    /// Weights at the minimum of the distance over the feature of proximity `s`, by Newton on its slope.
    fn weights(&self, s: usize, x: &Nodes<3>) -> [f64; 3] {
        let near = &self.0.proximities[s];
        let (slides, freedom) = (near.slides(), near.freedom());
        let along = slides.map(|slide| weighted(&slide, x));
        let mut weights = near.weights;
        for _ in 0..30 {
            let d = self.0.obstacles[0].distance(&weighted(&weights, x));
            let slope = Vector2::from_fn(|a, _| along[a].dot(&d.normal));
            let second = Matrix2::from_fn(|a, b| along[a].dot(&(d.curvature * along[b])));
            let step = match freedom {
                0 => return weights,
                1 => Vector2::new(-slope.x / second.m11, 0.0),
                _ => -second.try_inverse().expect("the minimum is a point") * slope,
            };
            for k in 0..3 {
                weights[k] += step.x * slides[0][k] + step.y * slides[1][k];
            }
        }
        weights
    }

    fn psi(&self, s: usize, x: &Nodes<3>) -> ([f64; 3], Vector3<f64>, [f64; 3]) {
        let weights = self.weights(s, x);
        let d = self.0.obstacles[0].distance(&weighted(&weights, x));
        let psi = self.0.law.psi(d.value - self.0.law.offset);
        let share = self.0.proximities[s].share;
        (weights, d.normal, psi.map(|v| v * share))
    }
}

impl Potential<3> for Sliding<'_> {
    fn count(&self) -> usize {
        self.0.count()
    }
    fn nodes(&self, s: usize) -> [u32; 3] {
        self.0.nodes(s)
    }
    fn value(&self, s: usize, x: &Nodes<3>) -> f64 {
        self.psi(s, x).2[0]
    }
    fn gradient(&self, s: usize, x: &Nodes<3>) -> Gradient<3> {
        let (weights, normal, psi) = self.psi(s, x);
        weights.map(|w| normal * (w * psi[1]))
    }
    fn hessian(&self, _: usize, _: &Nodes<3>) -> Hessian<3> {
        [[Matrix3::zeros(); 3]; 3]
    }
    fn hessian_projected(&self, s: usize, x: &Nodes<3>) -> Hessian<3> {
        self.hessian(s, x)
    }
}

/// How far the nodes can move before a minimum at a corner or on a crease of the obstacle starts to slide: the
/// distance is twice differentiable within one region of its nearest features only.
fn smooth_range(contact: &Contact, s: usize, x: &Nodes<3>) -> bool {
    let near = &contact.proximities[s];
    let at = weighted(&near.weights, x);
    let body = &contact.obstacles[0];
    let mut chance = Chance::new(99);
    (0..60).all(|_| {
        let there = body.distance(&(at + chance.vector(4e-4)));
        let rank = |d: &Matrix3<f64>| d.trace() > 1e-6;
        let turned = there.normal.dot(&near.distance.normal) < 0.5;
        rank(&there.curvature) == rank(&near.distance.curvature) && !turned
    })
}

/// Gap in the quadratic branch of psi, clear of its knots at 0 and 10 um, and of the obstacle's inside.
fn clear(near: &Proximity) -> bool {
    let gap = near.distance.value - LAW.offset;
    gap < -2e-4 && near.distance.value > 2e-4
}

/// Random placements of one face beside each shape: every kind of feature must come up where it can.
#[test]
fn derivatives_hold_for_every_shape_and_feature() {
    let (mesh, mut chance) = (mesh(), Chance::new(21));
    let features = Features::new(&mesh);
    for (name, shape) in shapes() {
        let pose = Pose::from_parts(chance.vector(5e-3).into(), chance.rotation().into());
        let bodies = [obstacle(&shape, pose)];
        let mut seen = [0; 3];
        for _ in 0..3000 {
            if seen.iter().all(|&n| n >= 6) {
                break;
            }
            let turn = chance.rotation();
            let shift = pose.translation.vector + chance.vector(7e-3);
            let x: Nodes<3> = std::array::from_fn(|k| turn * mesh.material[k].push(0.0) + shift);
            let mut proximities = vec![];
            detect(
                &mesh,
                &features,
                &x,
                (0, &bodies[0]),
                &Nearby::find(&mesh, &x, &bodies[0], LAW.offset, 0.0),
                LAW.offset,
                &mut proximities,
            );
            let contact = Contact {
                law: LAW,
                mesh: &mesh,
                obstacles: &bodies,
                proximities: &proximities,
            };
            for (s, near) in proximities.iter().enumerate() {
                let enough = seen[near.freedom()] >= 6 || near.share < 0.05;
                if enough || !clear(near) || !smooth_range(&contact, s, &x) || flat(&contact, s, &x)
                {
                    continue;
                }
                seen[near.freedom()] += 1;
                let name = format!("{name}, freedom {}", near.freedom());
                suite::against(&contact, &Sliding(&contact), s, &x, 2e-4, &name);
                suite::projection(
                    &contact.hessian(s, &x),
                    &contact.hessian_projected(s, &x),
                    &name,
                );
            }
        }
        // On a plane the nearest point is a corner, and a sharp crease is met within edges only.
        let expected = match shape {
            Shape::Plane => [6, 0, 0],
            Shape::Box { .. } | Shape::Disc { .. } | Shape::Cylinder { .. } | Shape::Mesh(_) => {
                [6, 6, 0]
            }
            _ => [6, 6, 6],
        };
        for kind in 0..3 {
            assert!(
                seen[kind] >= expected[kind],
                "{name}: features seen {seen:?}"
            );
        }
    }
}

/// Whether the minimum is so flat along its feature that its sliding cannot be differenced.
fn flat(contact: &Contact, s: usize, x: &Nodes<3>) -> bool {
    let near = &contact.proximities[s];
    let along = near.slides().map(|slide| weighted(&slide, x));
    let curvature = near.distance.curvature;
    let second = Matrix2::from_fn(|a, b| along[a].dot(&(curvature * along[b])));
    let scale = along[0].norm_squared() * curvature.norm();
    match near.freedom() {
        0 => false,
        1 => second.m11 < 0.05 * scale,
        _ => second.determinant() < 0.05 * scale * scale,
    }
}

/// psi against its own differences in both branches, and smooth across the knots.
#[test]
fn the_law_is_twice_differentiable() {
    for gap in [-3e-6, -8e-6, -2e-5, -5e-4] {
        let h = 1e-3 * -gap;
        let [ahead, here, behind] = [gap + h, gap, gap - h].map(|g| LAW.psi(g));
        let first = (ahead[0] - behind[0]) / (2.0 * h);
        let second = (ahead[1] - behind[1]) / (2.0 * h);
        assert!((first / here[1] - 1.0).abs() < 1e-5, "psi' at {gap}");
        assert!((second / here[2] - 1.0).abs() < 1e-5, "psi'' at {gap}");
        assert!(here[0] > 0.0 && here[1] < 0.0 && here[2] > 0.0);
    }
    for knot in [0.0, -super::ONSET] {
        let (left, right) = (
            LAW.psi(knot * (1.0 + 1e-9) - 1e-18),
            LAW.psi(knot * (1.0 - 1e-9)),
        );
        for k in 0..3 {
            let size = LAW.psi(-super::ONSET)[k].abs();
            assert!((left[k] - right[k]).abs() < 1e-7 * size, "psi at {knot}");
        }
    }
    assert_eq!(LAW.psi(1e-9), [0.0; 3], "no force at a distance");
}

/// The whole weight on one contact sinks in by DEPTH, unless the membrane is stiffer.
#[test]
fn stiffness_carries_the_weight() {
    let law = ContactLaw::new(0.08, 100.0, 4.9e-4);
    assert_eq!((law.stiffness, law.offset), (0.08 / super::DEPTH, 2.45e-4));
    assert_eq!(ContactLaw::new(0.08, 2e3, 4.9e-4).stiffness, 2e3);
}

/// The law that stiffens is as smooth as the other, the same where that is shallow, and a hundred times as stiff deep.
#[test]
fn a_stiffening_law_has_its_derivatives_and_keeps_the_shallow_ones() {
    let firm = LAW.stiffening();
    let limit = firm.limit();
    for depth in [0.2, 0.9, 1.1, 1.3, 1.49, 1.51, 3.0].map(|part| part * limit) {
        let e = 1e-5 * limit;
        let [below, at, above] = [depth + e, depth, depth - e].map(|d| firm.psi(-d));
        for k in 0..2 {
            let slope = (above[k] - below[k]) / (2.0 * e);
            assert!(
                (slope / at[k + 1] - 1.0).abs() < 1e-3,
                "{depth} {k}: {slope} {at:?}"
            );
        }
        if depth < limit {
            assert_eq!(at, LAW.psi(-depth));
        }
    }
    assert!((firm.psi(-2.0 * limit)[2] / LAW.stiffness - 101.0).abs() < 1e-9);
}
