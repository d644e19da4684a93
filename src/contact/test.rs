use nalgebra::{Matrix3, Vector2, Vector3};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;

use super::surface::test::{ball, cuboid};
use super::{Features, Nearby, Obstacle, Pose, Proximity, Shape, Surface, detect};
use crate::sheet::{Mesh, MeshOptions, Outline, generate};

struct Chance(Pcg64);

impl Chance {
    fn vector(&mut self, size: f64) -> Vector3<f64> {
        Vector3::from_fn(|_, _| {
            let unit: f64 = self.0.random();
            size * (2.0 * unit - 1.0)
        })
    }
}

fn chance(seed: u64) -> Chance {
    Chance(Pcg64::seed_from_u64(seed))
}

fn shapes() -> [Shape; 6] {
    let (radius, length) = (0.02, 0.05);
    let size = [0.04, 0.05, 0.06];
    [
        Shape::Plane,
        Shape::Box { size },
        Shape::Sphere { radius },
        Shape::Disc { radius },
        Shape::Cylinder { radius, length },
        Shape::Capsule { radius, length },
    ]
}

/// Those, and meshes: a box, and a ball of flat triangles.
fn all_shapes() -> Vec<Shape> {
    let surface = |given| Shape::Mesh(Surface::try_from(given).expect("a surface"));
    let meshes = [cuboid([0.04, 0.05, 0.06]), ball(0.02, 6)].map(surface);
    shapes().into_iter().chain(meshes).collect()
}

fn placed(shape: Shape, chance: &mut Chance) -> Obstacle {
    let turn = nalgebra::UnitQuaternion::from_scaled_axis(chance.vector(3.0));
    Obstacle {
        name: "body".to_string(),
        shape,
        pose: Pose::from_parts(chance.vector(0.05).into(), turn),
        ..Obstacle::default()
    }
}

/// Normal and curvature against differences of the value, where no crease of the field is near.
#[test]
fn derivatives_of_distance_hold_for_every_shape() {
    let mut chance = chance(1);
    for shape in all_shapes() {
        let body = placed(shape, &mut chance);
        let mut checked = 0;
        while checked < 200 {
            let p = body.pose.translation.vector + chance.vector(0.06);
            let d = body.distance(&p);
            let h = 1e-5;
            let at = |axis: usize, step: f64| body.distance(&(p + Vector3::ith(axis, step)));
            let ahead: [_; 3] = std::array::from_fn(|axis| at(axis, h));
            let behind: [_; 3] = std::array::from_fn(|axis| at(axis, -h));
            let smooth = ahead
                .iter()
                .chain(&behind)
                .all(|e| (e.curvature - d.curvature).norm() < 0.03 * d.curvature.norm() + 1e-6);
            if !smooth || d.value.abs() < 1e-3 {
                continue;
            }
            checked += 1;
            let normal = Vector3::from_fn(|a, _| (ahead[a].value - behind[a].value) / (2.0 * h));
            let curvature = Matrix3::from_columns(&std::array::from_fn::<_, 3, _>(|a| {
                (ahead[a].normal - behind[a].normal) / (2.0 * h)
            }));
            let (name, size) = (format!("{:?} at {p}", body.shape), d.curvature.norm());
            assert!((normal - d.normal).norm() < 1e-4, "{name}: normal");
            assert!((d.normal.norm() - 1.0).abs() < 1e-12, "{name}: unit normal");
            assert!(
                (curvature - d.curvature).norm() < 1e-3 * size + 1e-9,
                "{name}: curvature {curvature} {}",
                d.curvature
            );
        }
    }
}

/// Values where they are known: beside faces, edges, corners, caps and rims, and inside.
#[test]
fn distances_are_known_at_special_points() {
    let at = |shape: &Shape, p: [f64; 3]| shape.distance(&p.into()).value;
    let close = |a: f64, b: f64| assert!((a - b).abs() < 1e-15, "{a} is not {b}");
    let [plane, cuboid, sphere, disc, cylinder, capsule] = &shapes();
    close(at(plane, [0.3, -0.2, 0.1]), 0.1);
    close(at(plane, [0.3, -0.2, -0.1]), -0.1);
    close(at(cuboid, [0.03, 0.0, 0.0]), 0.01);
    close(at(cuboid, [0.023, 0.029, 0.0]), 0.005);
    close(at(cuboid, [0.021, 0.027, 0.032]), 0.003);
    close(at(cuboid, [0.015, 0.0, 0.0]), -0.005);
    close(at(sphere, [0.0, -0.03, 0.0]), 0.01);
    close(at(sphere, [0.0, 0.0, 0.0]), -0.02);
    close(at(disc, [0.01, 0.0, -0.003]), 0.003);
    close(at(disc, [0.023, 0.0, 0.004]), 0.005);
    close(at(cylinder, [0.0, 0.023, 0.029]), 0.005);
    close(at(cylinder, [0.0, 0.015, 0.0]), -0.005);
    close(at(cylinder, [0.001, 0.0, 0.024]), -0.001);
    close(at(capsule, [0.0, 0.03, 0.01]), 0.01);
    close(at(capsule, [0.0, 0.0, 0.05]), 0.005);
}

fn coarse() -> Mesh {
    let outline = Outline::Rectangle {
        length: 0.06,
        width: 0.05,
    };
    let options = MeshOptions {
        edge: 0.02,
        jitter: 0.2,
        seed: 2,
        warp_angle: 0.0,
    };
    generate(&outline, &options)
}

/// Least distance over a face by dense sampling: a grid of barycentric points, refined about the best one.
fn sampled(body: &Obstacle, corners: [Vector3<f64>; 3]) -> f64 {
    let at = |u: f64, v: f64| {
        let y = corners[0] * (1.0 - u - v) + corners[1] * u + corners[2] * v;
        body.distance(&y).value
    };
    let (mut best, mut centre, mut width) = (f64::INFINITY, [1.0 / 3.0; 2], 1.0);
    const GRID: i32 = 12;
    for _ in 0..14 {
        let about = centre;
        for i in -GRID..=GRID {
            for j in -GRID..=GRID {
                let u = (about[0] + width * f64::from(i) / f64::from(GRID)).clamp(0.0, 1.0);
                let v = (about[1] + width * f64::from(j) / f64::from(GRID)).clamp(0.0, 1.0 - u);
                let value = at(u, v);
                if value < best {
                    (best, centre) = (value, [u, v]);
                }
            }
        }
        width *= 0.4;
    }
    best
}

/// The deepest point of every face is found to a micrometre, wherever it lies: no point of the surface is left
/// out, at the edges, corners and rims of the obstacles least of all. Contact begins half a thickness outside
/// the obstacle, where its distance is smooth; within a box it has creases, on which the search over a face can
/// stop early, so there only that something is found counts.
#[test]
fn detection_covers_the_whole_surface() {
    const REACH: f64 = 5e-4;
    let (mesh, mut chance) = (coarse(), chance(3));
    let features = Features::new(&mesh);
    for shape in all_shapes() {
        let (mut kinds, mut worst) = ([0; 3], 0.0f64);
        for _ in 0..60 {
            let body = placed(shape.clone(), &mut chance);
            let turn = nalgebra::Rotation3::new(chance.vector(3.0));
            let shift = body.pose.translation.vector + chance.vector(0.03);
            // Not flat: a sheet that bends over the obstacle by some millimetres.
            let positions: Vec<Vector3<f64>> = mesh
                .material
                .iter()
                .map(|p| turn * p.push(0.0) + shift + chance.vector(2e-3))
                .collect();
            let mut found = vec![];
            let nearby = Nearby::find(&mesh, &positions, &body, REACH, 0.0);
            detect(
                &mesh,
                &features,
                &positions,
                (0, &body),
                &nearby,
                REACH,
                &mut found,
            );
            let deepest = |face: &[u32; 3]| sampled(&body, face.map(|v| positions[v as usize]));
            let exact: Vec<f64> = mesh.faces.iter().map(deepest).collect();
            // Where it is far inside of a mesh, more than what is nearest is found.
            let apart = exact.iter().all(|depth| *depth >= 0.0);
            let strict = apart || !matches!(body.shape, Shape::Mesh(_));
            check_points(&mesh, &positions, &body, (&found, strict));
            for near in &found {
                kinds[near.freedom()] += 1;
            }
            for (face, exact) in mesh.faces.iter().zip(exact) {
                let ours = found
                    .iter()
                    .filter(|near| within(&mesh, near, face))
                    .fold(REACH, |m: f64, near| m.min(near.distance.value));
                if exact >= 0.0 {
                    worst = worst.max(ours - exact.min(REACH));
                } else if !matches!(body.shape, Shape::Mesh(_)) {
                    assert!(ours < 0.0, "{:?}: {exact} deep is not seen", body.shape);
                }
            }
        }
        assert!(
            worst < 1e-6,
            "{shape:?}: a point is {worst:e} m deeper than any found"
        );
        assert!(kinds[0] > 5, "{shape:?}: features found {kinds:?}");
        let least = match shape {
            Shape::Plane => [0, 0],
            Shape::Mesh(_) => [4, 1],
            _ => [21, 3],
        };
        assert!(
            kinds[1] >= least[0] && kinds[2] >= least[1],
            "{shape:?}: features found {kinds:?}"
        );
    }
}

/// Whether a proximity's feature belongs to the face.
fn within(mesh: &Mesh, near: &Proximity, face: &[u32; 3]) -> bool {
    let own = mesh.faces[near.face as usize];
    (0..3).all(|k| near.weights[k] == 0.0 || face.contains(&own[k]))
}

/// What a proximity says of itself holds: its weights, its distance at its point, its unique key.
fn check_points(
    mesh: &Mesh,
    positions: &[Vector3<f64>],
    body: &Obstacle,
    (found, strict): (&[Proximity], bool),
) {
    let mut keys: Vec<u64> = found.iter().map(|near| near.key).collect();
    keys.sort_unstable();
    keys.dedup();
    assert_eq!(keys.len(), found.len(), "keys repeat");
    for near in found {
        let x = mesh.faces[near.face as usize].map(|v| positions[v as usize]);
        let y = x[0] * near.weights[0] + x[1] * near.weights[1] + x[2] * near.weights[2];
        assert!((near.weights.iter().sum::<f64>() - 1.0).abs() < 1e-12);
        let off = near.distance.value - body.distance(&y).value;
        let tie = if near.part.is_some() { 2e-5 } else { 1e-12 };
        assert!(off.abs() < tie || (off > 0.0 && !strict), "{off:e}");
        assert!((0.0..=1.0).contains(&near.share), "share {}", near.share);
    }
}

/// A box's corner under the middle of one face, far from every vertex and edge, 0.05 mm from touching it.
#[test]
fn a_corner_under_a_face_is_found() {
    let points: Vec<Vector2<f64>> = [[-0.1, -0.1], [0.1, -0.1], [0.0, 0.15]]
        .map(Vector2::from)
        .into();
    let mesh = Mesh::new(points.clone(), points, vec![[0, 1, 2]]);
    let size = [0.1; 3];
    // A space diagonal upright, its upper corner 0.05 mm below the sheet.
    let up = Vector3::repeat(1.0).normalize();
    let turn = nalgebra::UnitQuaternion::rotation_between(&up, &Vector3::z()).unwrap();
    let top = 0.05 * 3f64.sqrt();
    let body = Obstacle {
        name: "box".to_string(),
        shape: Shape::Box { size },
        pose: Pose::from_parts(Vector3::new(0.0, 0.0, -5e-5 - top).into(), turn),
        ..Obstacle::default()
    };
    let positions: Vec<_> = mesh.material.iter().map(|p| p.push(0.0)).collect();
    let mut found = vec![];
    detect(
        &mesh,
        &Features::new(&mesh),
        &positions,
        (0, &body),
        &Nearby::find(&mesh, &positions, &body, 1e-4, 0.0),
        1e-4,
        &mut found,
    );
    let exact = sampled(&body, [positions[0], positions[1], positions[2]]);
    assert!((exact - 5e-5).abs() < 1e-9, "{exact}");
    let deepest = found
        .iter()
        .fold(1e-4, |m: f64, near| m.min(near.distance.value));
    assert!(
        (deepest - exact).abs() < 1e-6,
        "{deepest} instead of {exact}"
    );
}

/// What is collected with a margin serves until something has moved that far: the same points are found, to the bit.
#[test]
fn what_is_near_holds_within_its_margin() {
    const REACH: f64 = 5e-4;
    const MARGIN: f64 = 1e-3;
    let (mesh, mut chance) = (coarse(), chance(5));
    let features = Features::new(&mesh);
    for shape in all_shapes() {
        let mut touched = 0;
        for _ in 0..60 {
            let body = placed(shape.clone(), &mut chance);
            let turn = nalgebra::Rotation3::new(chance.vector(3.0));
            let shift = body.pose.translation.vector + chance.vector(0.03);
            let mut positions: Vec<Vector3<f64>> = mesh
                .material
                .iter()
                .map(|p| turn * p.push(0.0) + shift + chance.vector(2e-3))
                .collect();
            let near = Nearby::find(&mesh, &positions, &body, REACH, MARGIN);
            for x in &mut positions {
                let way = chance.vector(1.0);
                *x += way * (0.99 * MARGIN / way.norm().max(1.0));
            }
            let found = |near: &Nearby| {
                let (mut found, body) = (vec![], (0, &body));
                detect(&mesh, &features, &positions, body, near, REACH, &mut found);
                found
            };
            let afresh = found(&Nearby::find(&mesh, &positions, &body, REACH, 0.0));
            assert_eq!(found(&near), afresh, "{shape:?}");
            touched += afresh.len();
        }
        assert!(touched > 20, "{shape:?}: {touched} points");
    }
}
