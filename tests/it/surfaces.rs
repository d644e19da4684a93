//! Obstacles that are triangle meshes: they act as the shapes that they approach, from both sides where they are open.

use nalgebra::Vector3;
use toile::contact::surface::Triangles;
use toile::contact::{Obstacle, Pose, Shape, Surface};
use toile::scene::Scene;
use toile::sim::Simulation;

use crate::friction::{SLOPE, incline};
use crate::lab::{scene, simulation};

/// A surface over a square of parameters 0 to 1, `n` x `m` quadrilaterals cut in two; closed in u or both if they say so.
pub fn grid(n: u32, m: u32, closed: [bool; 2], at: impl Fn(f64, f64) -> [f64; 3]) -> Triangles {
    let (rows, columns) = (n + u32::from(!closed[0]), m + u32::from(!closed[1]));
    let points = (0..rows).flat_map(|i| (0..columns).map(move |j| (i, j)));
    let vertices =
        points.map(|(i, j)| at(f64::from(i) / f64::from(n), f64::from(j) / f64::from(m)));
    let index = |i: u32, j: u32| (i % rows) * columns + j % columns;
    let cells = (0..n).flat_map(|i| (0..m).map(move |j| (i, j)));
    let halves = cells.flat_map(|(i, j)| {
        let [a, b, c, d] = [
            index(i, j),
            index(i + 1, j),
            index(i + 1, j + 1),
            index(i, j + 1),
        ];
        [[a, b, c], [a, c, d]]
    });
    Triangles {
        triangles: halves.collect(),
        vertices: vertices.collect(),
    }
}

/// A ball: the eight sides of an octahedron, each cut into `cuts` squared triangles, with corners on the sphere.
pub fn ball(radius: f64, cuts: u32) -> Shape {
    let mut all = Triangles {
        vertices: vec![],
        triangles: vec![],
    };
    for octant in 0..8u32 {
        let sign = |bit: u32| if octant >> bit & 1 == 1 { -1.0 } else { 1.0 };
        let mut vertex = |i: u32, j: u32| {
            let k = cuts - i - j;
            let [x, y, z] = [i, j, k].map(f64::from);
            let p = Vector3::new(sign(0) * x, sign(1) * y, sign(2) * z).normalize() * radius;
            let p = p.map(|c| c + 0.0).into();
            let known = all.vertices.iter().position(|q| *q == p);
            known.unwrap_or_else(|| {
                all.vertices.push(p);
                all.vertices.len() - 1
            }) as u32
        };
        let cells = (0..cuts).flat_map(|i| (0..cuts - i).map(move |j| (i, j)));
        let mut triangles = vec![];
        for (i, j) in cells {
            triangles.push([vertex(i, j), vertex(i + 1, j), vertex(i, j + 1)]);
            if i + j + 1 < cuts {
                triangles.push([vertex(i + 1, j), vertex(i + 1, j + 1), vertex(i, j + 1)]);
            }
        }
        all.triangles.extend(triangles);
    }
    mesh(all)
}

/// A box, corners and sides as in an OBJ.
pub fn cuboid(size: [f64; 3]) -> Shape {
    let half = size.map(|length| 0.5 * length);
    let mut obj = String::new();
    for i in 0..8 {
        let sign = |bit: u32| if i >> bit & 1 == 1 { 1.0 } else { -1.0 };
        obj += &format!(
            "v {} {} {}\n",
            sign(0) * half[0],
            sign(1) * half[1],
            sign(2) * half[2]
        );
    }
    for side in [
        "1 3 4 2", "5 6 8 7", "1 2 6 5", "3 7 8 4", "1 5 7 3", "2 4 8 6",
    ] {
        obj += &format!("f {side}\n");
    }
    Shape::Mesh(Surface::read(obj.as_bytes(), 1.0).expect("an OBJ"))
}

pub fn mesh(triangles: Triangles) -> Shape {
    Shape::Mesh(Surface::try_from(triangles).expect("a surface"))
}

/// A flat plate without thickness.
fn plate(size: f64, cells: u32) -> Shape {
    mesh(grid(cells, cells, [false; 2], |u, v| {
        [size * (u - 0.5), size * (v - 0.5), 0.0]
    }))
}

/// A scene with the shape of one obstacle replaced.
fn with(mut scene: Scene, name: &str, shape: Shape) -> Scene {
    scene.obstacle.get_mut(name).expect("an obstacle").shape = shape;
    scene.check().unwrap_or_else(|e| panic!("{e}"));
    scene
}

fn sheet(scheme: &str, dt: f64, triangles: usize, duration: f64, rest: &str) -> Scene {
    scene(&format!(
        "name = \"mesh\"\ndescription = \"Obstacles of triangles\"\nduration = {duration}\ndamping = 0.5\n\
         [sheet]\noutline = {{ kind = \"rectangle\", length = 0.1, width = 0.1 }}\ntriangles = {triangles}\n\
         [fabric]\nname = \"F1\"\n[method]\nscheme = \"{scheme}\"\ndt = {dt}\n{rest}"
    ))
}

const PINNED: &str = "[support.edge]\nkind = \"pin\"\nregion = { kind = \"boundary\" }\n";
/// Half the thickness of F1 \[m\]: deeper, and its middle surface would be in the obstacle.
const HALF: f64 = 2.45e-4;

/// Force of the sheet on its only obstacle \[N\].
fn force(simulation: &Simulation) -> Vector3<f64> {
    -simulation
        .contacts()
        .iter()
        .map(|c| c.force())
        .sum::<Vector3<f64>>()
}

/// Steps to the end; the deepest penetration on the way.
fn run(simulation: &mut Simulation, what: &str) -> f64 {
    let mut deepest: f64 = 0.0;
    for _ in 0..simulation.model().scene.steps() {
        let report = simulation.step().unwrap_or_else(|e| panic!("{what}: {e}"));
        deepest = deepest.max(report.deepest_penetration);
        let positions = simulation.state().positions.iter().flatten();
        assert!(positions.into_iter().all(|c| c.is_finite()), "{what}");
    }
    deepest
}

/// Lifts a pinned sheet by some millimetres and holds it; force and places at the end.
fn pressed(scheme: &str, shape: Shape) -> (f64, Vec<Vector3<f64>>) {
    let rest = format!(
        "{PINNED}[obstacle.it]\nshape = {{ kind = \"sphere\", radius = 0.02 }}\nrotation = [20.0, 30.0, 10.0]\n\
         [obstacle.it.motion]\nlaw = \"smooth\"\ntimes = [0.0, 0.06]\n\
         positions = [[0.0, 0.0, -0.021], [0.001, 0.002, -0.014]]\n"
    );
    let mut scene = with(sheet(scheme, 4e-3, 200, 0.16, &rest), "it", shape);
    scene.damping = 20.0;
    let mut simulation = simulation(&scene);
    let deepest = run(&mut simulation, scheme);
    assert!(deepest < HALF, "{scheme}: {deepest}");
    (force(&simulation).z, simulation.state().positions.clone())
}

/// A ball of flat triangles carries what a ball carries, within the error of its facets: a hundredth on 24 cuts of a quarter of the equator.
#[test]
fn verify_a_ball_of_triangles_carries_as_a_ball_does() {
    for scheme in ["bdf2", "central-difference"] {
        let (exact, _) = pressed(scheme, Shape::Sphere { radius: 0.02 });
        let errors = [6, 12, 24, 48].map(|cuts| pressed(scheme, ball(0.02, cuts)).0 / exact - 1.0);
        println!("{scheme}: {exact:.4} N, off by {errors:.4?}");
        assert!(exact < -0.05, "{scheme}: {exact} N");
        let most = [0.25, 0.05, 0.01, 0.005];
        let fine = errors
            .iter()
            .zip(most)
            .all(|(error, most)| error.abs() < most);
        assert!(fine, "{scheme}: {errors:?}");
    }
}

/// A box of twelve triangles, edge and corner first, is the box.
#[test]
fn verify_a_box_of_triangles_is_the_box() {
    let size = [0.022, 0.022, 0.02];
    // Implicit steps do not converge where sharp rims press on flat cloth, with either.
    let scheme = "central-difference";
    let (exact, places) = pressed(scheme, Shape::Box { size });
    let (ours, others) = pressed(scheme, cuboid(size));
    let apart = places.iter().zip(&others).map(|(a, b)| (a - b).norm());
    let apart = apart.fold(0.0, f64::max);
    println!("{exact:.6} N, {ours:.6} N, {apart:.1e} m apart");
    assert!((ours / exact - 1.0).abs() < 1e-6 && apart < 1e-6);
}

/// On a slope of triangles the sheet slides and sticks as on a plane, and what it weighs rests on the slope.
#[test]
fn verify_friction_on_triangles_is_that_on_a_plane() {
    for scheme in ["central-difference", "bdf2"] {
        let slope = |friction: f64, seconds: f64| {
            with(incline(scheme, friction, seconds), "plane", plate(0.6, 37))
        };
        let friction = 0.5 * SLOPE.tan();
        let mut sliding = simulation(&slope(friction, 0.2));
        let speed = |s: &Simulation| {
            let all = &s.state().velocities;
            all.iter().map(|v| v.x).sum::<f64>() / all.len() as f64
        };
        let mut speeds = vec![];
        for _ in 0..100 {
            sliding.step().unwrap_or_else(|e| panic!("{e}"));
            speeds.push(speed(&sliding));
        }
        let acceleration = (speeds[99] - speeds[49]) / 0.1;
        let expected = 9.81 * (SLOPE.sin() - friction * SLOPE.cos());
        println!("{scheme}: slides with {acceleration:.4} m/s² of {expected:.4}");
        assert!((acceleration / expected - 1.0).abs() < 0.01, "{scheme}");

        let mut sticking = simulation(&slope(1.2 * SLOPE.tan(), 1.0));
        let middle = |s: &Simulation| {
            let all = &s.state().positions;
            all.iter().map(|p| p.x).sum::<f64>() / all.len() as f64
        };
        let mut x = vec![];
        for _ in 0..500 {
            sticking.step().unwrap_or_else(|e| panic!("{e}"));
            x.push(middle(&sticking));
        }
        let creep = (x[499] - x[399]) / 0.2;
        let weight = 9.81 * sticking.model().masses.iter().sum::<f64>();
        let carried = force(&sticking) / weight;
        println!("{scheme}: creeps with {creep:.1e} m/s, presses with {carried:?} of its weight");
        assert!(creep.abs() < 1e-6, "{scheme}");
        let expected = Vector3::new(SLOPE.sin(), 0.0, -SLOPE.cos());
        assert!((carried - expected).norm() < 1e-3, "{scheme}");
    }
}

const STEPS: [f64; 2] = [1.0 / 60.0, 1.0 / 240.0];

/// A ball of triangles comes at 10 m/s, 10 mm into a sheet that is held all around, and stops there.
#[test]
fn a_ball_of_triangles_at_10_m_per_s_does_not_pass() {
    for scheme in ["bdf2", "central-difference"] {
        for dt in STEPS {
            let what = format!("{scheme} {dt}");
            let rest = format!(
                "{PINNED}[obstacle.ball]\nshape = {{ kind = \"plane\" }}\n[obstacle.ball.motion]\n\
                 times = [0.005, 0.01]\npositions = [[0.0, 0.0, -0.06], [0.0, 0.0, -0.01]]\n"
            );
            let scene = sheet(scheme, dt, 80, 0.035, &rest);
            let mut simulation = simulation(&with(scene, "ball", ball(0.02, 6)));
            let deepest = run(&mut simulation, &what);
            let state = simulation.state();
            let centre = state.obstacles[0].pose.translation.vector;
            let above = state.positions.iter().filter(|p| p.xy().norm() < 0.012);
            let over: Vec<f64> = above.map(|p| p.z - centre.z).collect();
            println!("{what}: {:.3} mm deep, {over:?}", 1e3 * deepest);
            assert!(!over.is_empty() && over.iter().all(|z| *z > 0.01), "{what}");
            assert!(deepest < HALF, "{what}: {deepest}");
        }
    }
}

/// A plate of no thickness stops a sheet at 3 m/s from above and from below.
#[test]
fn an_open_plate_of_triangles_is_not_passed_from_either_side() {
    for scheme in ["bdf2", "central-difference"] {
        for (dt, side) in [(STEPS[0], 1.0), (STEPS[1], 1.0), (STEPS[1], -1.0)] {
            let what = format!("{scheme} {dt} {side}");
            let [from, to] = [-0.012 * side, 0.024 * side];
            let rest = format!(
                "[obstacle.plate]\nshape = {{ kind = \"plane\" }}\nfriction = 0.3\n[obstacle.plate.motion]\n\
                 times = [0.0, 0.012]\npositions = [[0.0, 0.0, {from}], [0.0, 0.0, {to}]]\n"
            );
            let scene = sheet(scheme, dt, 60, 0.035, &rest);
            let mut simulation = simulation(&with(scene, "plate", plate(0.2, 3)));
            let deepest = run(&mut simulation, &what);
            let state = simulation.state();
            let height = state.obstacles[0].pose.translation.vector.z;
            let passed = state
                .positions
                .iter()
                .filter(|p| (p.z - height) * side < 0.0);
            println!("{what}: {:.3} mm deep", 1e3 * deepest);
            assert_eq!(passed.count(), 0, "{what}");
            assert!(deepest < HALF, "{what}: {deepest}");
        }
    }
}

/// A sheet falls into an open bowl and stays on its inner side; its weight ends up on the bowl.
#[test]
fn a_sheet_lies_in_an_open_bowl() {
    let radius = 0.05;
    let bowl = grid(14, 40, [false, true], |u, v| {
        let (polar, turn) = (0.02 + 1.45 * u, std::f64::consts::TAU * v);
        let around = radius * polar.sin();
        [
            around * turn.cos(),
            around * turn.sin(),
            -radius * polar.cos(),
        ]
    });
    let rest = "[obstacle.bowl]\nshape = { kind = \"plane\" }\nfriction = 0.3\nposition = [0.0, 0.0, 0.0]\n";
    let text = sheet("central-difference", 4e-3, 150, 1.0, rest);
    let mut scene = with(text, "bowl", mesh(bowl));
    scene.sheet.outline = toile::scene::Outline::Disc { diameter: 0.07 };
    scene.sheet.position = [0.002, 0.001, -0.01];
    scene.damping = 5.0;
    let mut simulation = simulation(&scene);
    let deepest = run(&mut simulation, "bowl");
    let outside = simulation
        .state()
        .positions
        .iter()
        .filter(|p| p.norm() > radius);
    assert_eq!(outside.count(), 0);
    let weight = 9.81 * simulation.model().masses.iter().sum::<f64>();
    let carried = force(&simulation).z / weight;
    println!(
        "{:.3} mm deep, carries {carried:.4} of the weight",
        1e3 * deepest
    );
    assert!(
        deepest < HALF && (carried + 1.0).abs() < 0.02,
        "{deepest} {carried}"
    );
}

/// What stands in the cloth at the start is pushed out, from deep inside a solid too.
#[test]
fn a_solid_of_triangles_put_into_the_cloth_pushes_it_out() {
    for scheme in ["bdf2", "central-difference"] {
        let rest = format!(
            "{PINNED}[obstacle.ball]\nshape = {{ kind = \"plane\" }}\nposition = [0.002, 0.001, -0.012]\n"
        );
        let scene = with(sheet(scheme, 2e-3, 200, 0.08, &rest), "ball", ball(0.02, 8));
        let mut simulation = simulation(&scene);
        let overlap = simulation.state().obstacles[0].overlap;
        assert!(
            (7e-3..9e-3).contains(&overlap.depth),
            "{scheme}: {overlap:?}"
        );
        assert!(simulation.contacts().iter().all(|c| c.overlap));
        run(&mut simulation, scheme);
        let report = simulation.report();
        println!(
            "{scheme}: {:.3} mm deep, strain {:.3}",
            1e3 * report.deepest_penetration,
            report.largest_strain
        );
        assert!(
            report.deepest_penetration < HALF && report.largest_strain < 0.1,
            "{scheme}"
        );
    }
}

/// The copies of an obstacle share its triangles.
#[test]
fn a_surface_is_not_copied_with_its_obstacle() {
    let shape = ball(0.02, 4);
    let obstacle = Obstacle {
        shape: shape.clone(),
        pose: Pose::identity(),
        ..Obstacle::default()
    };
    let (Shape::Mesh(a), Shape::Mesh(b)) = (&shape, &obstacle.shape) else {
        panic!("meshes");
    };
    assert!(std::ptr::eq(a.vertices(), b.vertices()));
}

/// A square at rest over a ball, with the ball and with triangles in its place: the corners hang alike, and both states
/// are minima. A larger one has folds, and many states.
#[test]
fn validate_rest_over_a_ball_of_triangles() {
    let rest = "[sheet]\noutline = { kind = \"rectangle\", length = 0.1, width = 0.1 }\ntriangles = 400\n\
                position = [0.0, 0.0, 0.0503]\n[fabric]\nname = \"F1\"\n[perturbation]\namplitude = 1e-4\n\
                [obstacle.ball]\nshape = { kind = \"sphere\", radius = 0.05 }\nfriction = 0.3\n\
                [method]\nscheme = \"equilibrium\"\ndt = 5e-3\n[observe.corner]\n\
                points = [[-0.05, -0.05], [0.05, -0.05], [0.05, 0.05], [-0.05, 0.05]]\naxis = \"z\"\n";
    let round = scene(&format!(
        "name = \"ball\"\ndescription = \"A square over a ball\"\nduration = 5e-3\n{rest}"
    ));
    let corner = |scene: &Scene| {
        let mut simulation = simulation(scene);
        let report = simulation.step().unwrap_or_else(|e| panic!("{e}"));
        assert!(report.converged && report.work.tests > 0);
        report.readings[0]
    };
    let exact = corner(&round);
    let faceted = corner(&with(round, "ball", ball(0.05, 24)));
    println!(
        "corners at {:.3} mm, over triangles {:.3} mm",
        1e3 * exact,
        1e3 * faceted
    );
    assert!(exact < -0.01, "the corners hang at {exact} m");
    assert!(
        (faceted / exact - 1.0).abs() < 0.02,
        "{faceted} m, over a ball {exact} m"
    );
}
