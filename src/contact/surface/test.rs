use nalgebra::Vector3;

use super::{Surface, SurfaceError, Triangles};
use crate::contact::{Features, Nearby, Obstacle, Proximity, Shape, detect};
use crate::sheet::Mesh;

type Point = Vector3<f64>;

/// The surface of a box about the origin: two triangles a side.
pub fn cuboid([x, y, z]: [f64; 3]) -> Triangles {
    let corner = |i: u32| {
        let side = |bit: u32, length: f64| {
            if i >> bit & 1 == 1 {
                0.5 * length
            } else {
                -0.5 * length
            }
        };
        [side(0, x), side(1, y), side(2, z)]
    };
    let sides = [
        [0, 2, 3, 1],
        [4, 5, 7, 6],
        [0, 1, 5, 4],
        [2, 6, 7, 3],
        [0, 4, 6, 2],
        [1, 3, 7, 5],
    ];
    Triangles {
        vertices: (0..8).map(corner).collect(),
        triangles: sides
            .iter()
            .flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]])
            .collect(),
    }
}

/// A ball of triangles whose corners are on the sphere: an octahedron, each side cut into `cuts` squared triangles.
pub fn ball(radius: f64, cuts: u32) -> Triangles {
    let mut given = Triangles {
        vertices: vec![],
        triangles: vec![],
    };
    for octant in 0..8u32 {
        let sign = |bit: u32| if octant >> bit & 1 == 1 { -1.0 } else { 1.0 };
        let odd = octant.count_ones() % 2 == 1;
        let mut vertex = |i: u32, j: u32| {
            let p = Point::new(
                sign(0) * f64::from(i),
                sign(1) * f64::from(j),
                sign(2) * f64::from(cuts - i - j),
            );
            let p = (p.normalize() * radius).map(|c| c + 0.0).into();
            let known = given.vertices.iter().position(|q| *q == p);
            known.unwrap_or_else(|| {
                given.vertices.push(p);
                given.vertices.len() - 1
            }) as u32
        };
        let mut triangles = vec![];
        for i in 0..cuts {
            for j in 0..cuts - i {
                triangles.push([vertex(i, j), vertex(i + 1, j), vertex(i, j + 1)]);
                if i + j + 1 < cuts {
                    triangles.push([vertex(i + 1, j), vertex(i + 1, j + 1), vertex(i, j + 1)]);
                }
            }
        }
        let turned = |[a, b, c]: [u32; 3]| if odd { [a, c, b] } else { [a, b, c] };
        given.triangles.extend(triangles.into_iter().map(turned));
    }
    given
}

/// Two long plates that meet in the y axis, the second turned up by `fold` \[rad\].
fn folded(fold: f64) -> Surface {
    let (l, w) = (0.1, 0.1);
    let vertices = vec![
        [-l, -w, 0.0],
        [0.0, -w, 0.0],
        [0.0, w, 0.0],
        [-l, w, 0.0],
        [l * fold.cos(), -w, l * fold.sin()],
        [l * fold.cos(), w, l * fold.sin()],
    ];
    let triangles = vec![[0, 1, 2], [0, 2, 3], [1, 4, 5], [1, 5, 2]];
    surface(Triangles {
        vertices,
        triangles,
    })
}

fn surface(given: Triangles) -> Surface {
    Surface::try_from(given).expect("a surface")
}

fn obstacle(surface: &Surface) -> Obstacle {
    Obstacle {
        shape: Shape::Mesh(surface.clone()),
        ..Obstacle::default()
    }
}

/// A face of the sheet one corner of which is at `p`, the others far `away`.
fn probe(p: Point, away: Point) -> (Mesh, Vec<Point>) {
    let flat: Vec<_> = [[0.0, 0.0], [0.1, 0.0], [0.0, 0.1]]
        .map(nalgebra::Vector2::from)
        .into();
    let mesh = Mesh::new(flat.clone(), flat, vec![[0, 1, 2]]);
    let across = away.cross(&Point::new(0.3, 0.9, 0.2)).normalize() * 0.02;
    (
        mesh,
        vec![p, p + away * 0.5 + across, p + away * 0.5 - across],
    )
}

fn found(mesh: &Mesh, positions: &[Point], body: &Obstacle, reach: f64) -> Vec<Proximity> {
    let near = Nearby::find(mesh, positions, body, reach, 0.0);
    let mut found = vec![];
    let features = Features::new(mesh);
    detect(
        mesh,
        &features,
        positions,
        (0, body),
        &near,
        reach,
        &mut found,
    );
    found
}

const REACH: f64 = 2.5e-4;

/// Sum of linear forces on a corner of the sheet at `p`.
fn force(body: &Obstacle, p: Point, away: Point) -> Point {
    let (mesh, positions) = probe(p, away);
    let near = found(&mesh, &positions, body, REACH);
    let push =
        |near: &Proximity| near.distance.normal * (near.share * (REACH - near.distance.value));
    near.iter().map(push).sum()
}

#[test]
fn solids_are_closed_whichever_way_their_triangles_turn() {
    let given = cuboid([0.02, 0.03, 0.04]);
    let mut turned = given.clone();
    for (t, corners) in turned.triangles.iter_mut().enumerate() {
        if t % 3 != 1 {
            corners.swap(0, 1);
        }
    }
    let inside_out = Triangles {
        triangles: given.triangles.iter().map(|&[a, b, c]| [a, c, b]).collect(),
        ..given.clone()
    };
    let exact = Shape::Box {
        size: [0.02, 0.03, 0.04],
    };
    for given in [given, turned, inside_out] {
        let surface = surface(given);
        assert!(surface.is_closed());
        assert_eq!(surface.ridges().count(), 12);
        for (t, corners) in surface.outward().enumerate() {
            let [a, b, c] = corners.map(|v| surface.vertices()[v as usize]);
            let turns = (b - a).cross(&(c - a)).normalize();
            assert!((turns - surface.normal(t)).norm() < 1e-12 && turns.dot(&a) > 0.0);
        }
        for k in 0..500 {
            let at = |prime: f64| 0.06 * ((f64::from(k) * prime).fract() - 0.5);
            let p = Point::new(at(0.754_877), at(0.569_840), at(0.324_718));
            let (ours, exact) = (surface.distance(&p), exact.distance(&p));
            assert!((ours.value - exact.value).abs() < 1e-12, "at {p}");
        }
    }
    assert!(!folded(1.0).is_closed());
}

/// Over flat or convex parts, and over edges of thin plates, one contact; in a deep valley two; nowhere a jump.
#[test]
fn contact_has_no_jump_on_the_way_over_a_fold() {
    for degrees in [
        -150.0, -90.0, -20.0, -1.0, 0.0, 1.0, 10.0, 30.0, 50.0, 80.0, 100.0f64,
    ] {
        let fold = degrees.to_radians();
        let body = obstacle(&folded(fold));
        // At one height over the first plate, around or into the fold, at one height over the second.
        let height = 1.5e-4;
        let half = Point::new(-(0.5 * fold).sin(), 0.0, (0.5 * fold).cos());
        let (steps, mut before, mut worst, mut least) = (8000, None, 0.0f64, f64::INFINITY);
        for k in 0..=steps {
            let s = 2e-3 * (f64::from(k) / f64::from(steps) - 0.5);
            let along = if s < 0.0 {
                Point::x()
            } else {
                Point::new(fold.cos(), 0.0, fold.sin())
            };
            let p = along * s + half * height + Point::new(0.0, 1.234e-3, 0.0);
            let push = force(&body, p, half);
            least = least.min(push.norm());
            if let Some(before) = before.replace(push) {
                worst = worst.max((push - before).norm());
            }
        }
        assert!(
            worst < 0.02 * REACH,
            "{degrees} degrees: a jump of {worst:e}"
        );
        assert!(
            least > 0.3 * (REACH - height),
            "{degrees} degrees: {least:e} left"
        );
    }
}

#[test]
fn shared_edges_and_corners_count_once() {
    // A fan of coplanar triangles about the origin.
    let rim = |k: u32| {
        let angle = f64::from(k) * std::f64::consts::TAU / 7.0;
        [0.02 * angle.cos(), 0.02 * angle.sin(), 0.0]
    };
    let fan = surface(Triangles {
        vertices: std::iter::once([0.0; 3]).chain((0..7).map(rim)).collect(),
        triangles: (0..7).map(|k| [0, 1 + k, 1 + (k + 1) % 7]).collect(),
    });
    let body = obstacle(&fan);
    for p in [
        [0.0, 0.0],
        [1e-9, 0.0],
        [0.01, 0.0],
        [3e-3, 1e-3],
        [-2e-3, -1e-5],
    ] {
        for side in [1.0, -1.0] {
            let push = force(
                &body,
                Point::new(p[0], p[1], side * 1e-4),
                Point::z() * side,
            );
            let exact = Point::new(0.0, 0.0, side * (REACH - 1e-4));
            assert!((push - exact).norm() < 1e-15, "at {p:?}: {push}");
        }
    }
    // A corner pushed into a right angle is held by both walls.
    let corner = obstacle(&folded(std::f64::consts::FRAC_PI_2));
    let push = force(
        &corner,
        Point::new(-1e-4, 2e-3, 2e-4),
        Point::new(-0.7, 0.0, 0.7),
    );
    assert!(
        (push - Point::new(-1.5e-4, 0.0, 5e-5)).norm() < 1e-15,
        "{push}"
    );
}

/// The lower side of a box that is thinner than the reach does not pull in what lies on it.
#[test]
fn the_far_side_of_a_thin_wall_does_not_count() {
    let wall = obstacle(&surface(cuboid([0.05, 0.05, 1e-4])));
    let push = force(&wall, Point::new(2e-3, 1e-3, 1e-4), Point::z());
    assert!(
        (push - Point::z() * (REACH - 5e-5)).norm() < 1e-15,
        "{push}"
    );
    let beside = force(&wall, Point::new(0.025 + 1e-4, 1e-3, 0.0), Point::x());
    assert!(
        (beside - Point::x() * (REACH - 1e-4)).norm() < 1e-15,
        "{beside}"
    );
}

#[test]
fn a_ball_of_triangles_is_near_a_ball() {
    let radius = 0.02;
    for cuts in [4, 8, 16] {
        let surface = surface(ball(radius, cuts));
        assert!(surface.is_closed());
        let sagitta = 1.1 * radius / f64::from(cuts * cuts);
        for k in 0..300 {
            let at = |prime: f64| 0.06 * ((f64::from(k) * prime).fract() - 0.5);
            let p = Point::new(at(0.754_877), at(0.569_840), at(0.324_718));
            let off = surface.distance(&p).value - (p.norm() - radius);
            assert!(
                (-1e-12..sagitta).contains(&off),
                "{cuts}: {off:e} of {sagitta:e}"
            );
        }
    }
}

/// The three kinds of file hold the same box; polygons are cut up, corners in one place are one vertex.
#[test]
fn files_are_read() {
    let given = cuboid([2.0, 4.0, 8.0]);
    let corner = |v: u32| given.vertices[v as usize].map(|c| c as f32);
    let triangles: Vec<stl_io::Triangle> = given
        .triangles
        .iter()
        .map(|t| stl_io::Triangle {
            normal: stl_io::Normal::new([0.0; 3]),
            vertices: t.map(|v| stl_io::Vertex::new(corner(v))),
        })
        .collect();
    let mut binary = vec![];
    stl_io::write_stl(&mut binary, triangles.iter()).expect("writes");
    let mut text = "solid box\n".to_string();
    for t in &given.triangles {
        text += "facet normal 0 0 0\nouter loop\n";
        for v in t {
            let [x, y, z] = corner(*v);
            text += &format!("vertex {x} {y} {z}\n");
        }
        text += "endloop\nendfacet\n";
    }
    text += "endsolid box\n";
    let mut obj = "# a box\no box\n".to_string();
    for [x, y, z] in &given.vertices {
        obj += &format!("v {x} {y} {z}\n");
    }
    for side in [
        "1 3 4 2", "5 6 8 7", "1 2 6 5", "3 7 8 4", "1 5 7 3", "2 4 8 6",
    ] {
        obj += &format!("f {side}\n");
    }
    for bytes in [binary, text.into_bytes(), obj.into_bytes()] {
        let surface = Surface::read(&bytes, 1e-3).expect("reads");
        assert!(surface.is_closed());
        assert_eq!(
            (surface.vertices().len(), surface.triangles().len()),
            (8, 12)
        );
        let value = surface.distance(&Point::new(0.0, 0.0, 5e-3)).value;
        assert!((value - 1e-3).abs() < 1e-9, "{value}");
    }
}

#[test]
fn what_is_no_surface_is_refused() {
    let given = cuboid([0.02; 3]);
    let with = |change: fn(&mut Triangles)| {
        let mut given = given.clone();
        change(&mut given);
        Surface::try_from(given).expect_err("refused")
    };
    let empty = with(|given| given.triangles.clear());
    assert_eq!(empty, SurfaceError::Empty);
    let far = with(|given| given.vertices[3][1] = f64::NAN);
    assert!(
        matches!(far, SurfaceError::Place { vertex: 3, .. }),
        "{far}"
    );
    let index = with(|given| given.triangles[5][1] = 8);
    assert_eq!(
        index,
        SurfaceError::Index {
            triangle: 5,
            index: 8,
            last: 7
        }
    );
    let flat = with(|given| given.triangles[2] = [1, 1, 2]);
    assert_eq!(flat, SurfaceError::Degenerate { triangle: 2 });
    let bytes: [&[u8]; 6] = [
        b"",
        b"hello",
        b"solid x\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\n",
        b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 4\n",
        b"v 0 0 0\nv 1 zero 0\n",
        &[0u8; 84],
    ];
    for bytes in bytes {
        let error = Surface::read(bytes, 1.0).expect_err("refused").to_string();
        assert!(!error.contains('\n') && error.len() > 20, "{error}");
    }
}

/// A vertex of the sheet keeps the identity of its contact while it slides over triangles of a smooth part.
#[test]
fn a_contact_keeps_its_key_on_a_smooth_part() {
    let body = obstacle(&surface(ball(0.02, 12)));
    let mut keys = vec![];
    for k in 0..200 {
        let angle = 0.005 * f64::from(k);
        let p = Point::new(
            angle.sin() * angle.cos(),
            angle.sin() * angle.sin(),
            angle.cos(),
        );
        let (mesh, positions) = probe(p * 0.0201, p);
        keys.extend(
            found(&mesh, &positions, &body, REACH)
                .iter()
                .map(|near| near.key),
        );
    }
    keys.dedup();
    assert_eq!(keys.len(), 1, "{keys:?}");
}
