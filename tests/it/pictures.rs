//! Pictures: what is in front is seen, what is behind is not, equal input gives equal bytes.

use nalgebra::{Vector2, Vector3};
use toile::chart::{DrawError, Framing, Moment, Picture, Size, Subject, View, draw, draw_strip};
use toile::contact::{Obstacle, Pose, Shape, Velocity};

const SMALL: Size = Size {
    width: 320,
    height: 240,
};

/// A square sheet of 200 mm with n x n vertices.
struct Sheet {
    faces: Vec<[u32; 3]>,
    material: Vec<Vector2<f64>>,
}

impl Sheet {
    fn new(n: u32) -> Self {
        let at = |k: u32| 0.2 * (f64::from(k) / f64::from(n - 1) - 0.5);
        let corners = (0..n - 1).flat_map(|i| (0..n - 1).map(move |j| i * n + j));
        Self {
            faces: corners
                .flat_map(|a| [[a, a + n, a + n + 1], [a, a + n + 1, a + 1]])
                .collect(),
            material: (0..n)
                .flat_map(|i| (0..n).map(move |j| Vector2::new(at(i), at(j))))
                .collect(),
        }
    }

    fn subject(&self) -> Subject<'_> {
        Subject {
            title: "a sheet & <more>",
            subtitle: "",
            faces: &self.faces,
            material: &[],
        }
    }

    /// The sheet mapped into the world.
    fn moment(&self, to: impl Fn(f64, f64) -> Vector3<f64>, obstacles: &[Obstacle]) -> Moment {
        Moment {
            time: 0.25,
            positions: self.material.iter().map(|m| to(m.x, m.y)).collect(),
            obstacles: obstacles.to_vec(),
        }
    }
}

fn obstacle(shape: Shape, at: [f64; 3]) -> Obstacle {
    Obstacle {
        name: "it".into(),
        shape,
        pose: Pose::translation(at[0], at[1], at[2]),
        velocity: Velocity::default(),
        friction: 0.0,
        ..Obstacle::default()
    }
}

/// Looks along -y, horizontally: no imagined floor, the picture is x against z.
fn from_the_front() -> View {
    View {
        azimuth: -90.0,
        elevation: 0.0,
    }
}

fn picture(sheet: &Sheet, moment: &Moment, view: View) -> Picture {
    let mut framing = Framing::new(view);
    framing.include(moment);
    draw(&sheet.subject(), moment, &framing, SMALL).unwrap()
}

fn centre(picture: &Picture) -> [u8; 3] {
    picture.pixel(SMALL.width / 2, SMALL.height / 2)
}

/// Blue outweighs red on the front of the cloth, red outweighs blue on its back, obstacles are grey.
#[derive(Debug, PartialEq)]
enum Seen {
    Paper,
    Front,
    Back,
    Grey,
}

fn seen([r, g, b]: [u8; 3]) -> Seen {
    match (i32::from(b) - i32::from(r), r.min(g).min(b)) {
        (_, 250..) => Seen::Paper,
        (difference, _) if difference > 25 => Seen::Front,
        (difference, _) if difference < -25 => Seen::Back,
        _ => Seen::Grey,
    }
}

/// The middle of a curtain, seen from the front and from behind, and the paper beside it.
#[test]
fn verify_cloth_in_the_middle_and_paper_outside() {
    let sheet = Sheet::new(9);
    let curtain = sheet.moment(|x, y| Vector3::new(x, 0.0, y), &[]);
    let front = picture(&sheet, &curtain, from_the_front());
    assert_eq!(seen(centre(&front)), Seen::Front);
    assert_eq!(seen(front.pixel(20, SMALL.height / 2)), Seen::Paper);
    let behind = View {
        azimuth: 90.0,
        elevation: 0.0,
    };
    assert_eq!(seen(centre(&picture(&sheet, &curtain, behind))), Seen::Back);
}

/// A curtain is hidden by a box before it and hides a box behind it, also one half a millimetre away.
#[test]
fn verify_what_is_in_front_hides_what_is_behind() {
    let sheet = Sheet::new(9);
    let block = Shape::Box {
        size: [0.1, 0.02, 0.1],
    };
    for gap in [0.05, 5e-4] {
        for (y, expected) in [(-0.01 - gap, Seen::Grey), (0.01 + gap, Seen::Front)] {
            let block = obstacle(block.clone(), [0.0, y, 0.0]);
            let curtain = sheet.moment(|x, y| Vector3::new(x, 0.0, y), &[block]);
            let drawn = picture(&sheet, &curtain, from_the_front());
            assert_eq!(seen(centre(&drawn)), expected, "box at y = {y}");
            // 80 mm to the side there is only cloth.
            let scale = f64::from(centre_scale(&sheet, &curtain));
            let side = SMALL.width / 2 + (0.08 * scale) as u32;
            assert_eq!(seen(drawn.pixel(side, SMALL.height / 2)), Seen::Front);
        }
    }
}

/// Pixels per metre, from the width of the cloth in the middle row.
fn centre_scale(sheet: &Sheet, moment: &Moment) -> u32 {
    let bare = Moment {
        obstacles: vec![],
        ..moment.clone()
    };
    let drawn = picture(sheet, &bare, from_the_front());
    let row = (0..SMALL.width).map(|x| drawn.pixel(x, SMALL.height / 2));
    (row.filter(|p| seen(*p) != Seen::Paper).count() as f64 / 0.2) as u32
}

/// A box just under the cloth shows neither its faces nor its edges through it.
#[test]
fn verify_a_table_does_not_show_through_the_cloth_on_it() {
    let sheet = Sheet::new(9);
    let table = obstacle(
        Shape::Box {
            size: [0.1, 0.1, 0.1],
        },
        [0.0, 0.0, -0.05],
    );
    let from_above = View {
        azimuth: -90.0,
        elevation: 90.0,
    };
    for height in [0.0, 5e-5, 3e-4] {
        let laid = sheet.moment(
            |x, y| Vector3::new(x, y, height),
            std::slice::from_ref(&table),
        );
        let drawn = picture(&sheet, &laid, from_above);
        let (x, y) = (SMALL.width / 2, SMALL.height / 2);
        for step in 0..70 {
            let pixel = drawn.pixel(x + step, y);
            assert_eq!(
                seen(pixel),
                Seen::Front,
                "{step} px from the centre at height {height}"
            );
            assert!(
                pixel[2] > 150,
                "a line at {step} px, height {height}: {pixel:?}"
            );
        }
    }
}

/// Every shape leaves its colour where it is.
#[test]
fn verify_every_shape_is_drawn() {
    let sheet = Sheet::new(3);
    let shapes = [
        Shape::Box { size: [0.1; 3] },
        Shape::Sphere { radius: 0.05 },
        Shape::Disc { radius: 0.05 },
        Shape::Cylinder {
            radius: 0.05,
            length: 0.1,
        },
        Shape::Capsule {
            radius: 0.03,
            length: 0.05,
        },
        Shape::Plane,
    ];
    for shape in shapes {
        let body = obstacle(shape.clone(), [0.0; 3]);
        let aside = sheet.moment(|x, y| Vector3::new(x, 0.3 + y, 0.0), &[body]);
        let from_above = View {
            azimuth: -90.0,
            elevation: 90.0,
        };
        let mut framing = Framing::new(from_above);
        framing.include(&aside);
        framing.include(&sheet.moment(|x, y| Vector3::new(x, y - 0.3, 0.0), &[]));
        let drawn = draw(&sheet.subject(), &aside, &framing, SMALL).unwrap();
        assert_eq!(seen(centre(&drawn)), Seen::Grey, "{shape:?}");
    }
}

/// Six moments in six panels, no two alike.
#[test]
fn verify_a_strip_has_a_panel_for_every_moment() {
    let sheet = Sheet::new(5);
    let fallen = |k: u32| {
        let drop = 0.03 * f64::from(k);
        sheet.moment(move |x, y| Vector3::new(x, 0.0, y - drop), &[])
    };
    let moments: Vec<_> = (0..6).map(fallen).collect();
    let mut framing = Framing::new(from_the_front());
    moments.iter().for_each(|m| framing.include(m));
    let strip = draw_strip(&sheet.subject(), &moments, &framing, None).unwrap();
    let Size { width, height } = strip.size();
    let tops: Vec<Vec<u32>> = (0..6)
        .map(|column| {
            let x = (2 * column + 1) * width / 12;
            (0..height)
                .filter(|y| seen(strip.pixel(x, *y)) == Seen::Front)
                .collect()
        })
        .filter(|rows: &Vec<u32>| !rows.is_empty())
        .collect();
    let distinct: std::collections::BTreeSet<_> = tops.iter().collect();
    // Three columns of two rows, or six of one: each column has cloth, and each at other heights.
    assert!(
        tops.len() >= 3 && distinct.len() >= 3,
        "{} columns",
        distinct.len()
    );
    let cloth: usize = (0..height)
        .map(|y| {
            (0..width)
                .filter(|x| seen(strip.pixel(*x, y)) == Seen::Front)
                .count()
        })
        .sum();
    let one = draw_strip(
        &sheet.subject(),
        &moments[..1],
        &framing,
        Some(strip.size()),
    )
    .unwrap();
    assert_ne!(one, strip);
    assert!(cloth > 20_000, "{cloth} pixels of cloth");
}

#[test]
fn consistency_same_input_same_bytes() {
    let sheet = Sheet::new(12);
    let table = [obstacle(
        Shape::Cylinder {
            radius: 0.05,
            length: 0.05,
        },
        [0.0, 0.0, -0.03],
    )];
    let draped = sheet.moment(|x, y| Vector3::new(x, y, -4.0 * (x * x + y * y)), &table);
    let bytes = || picture(&sheet, &draped, View::default()).png().unwrap();
    assert_eq!(bytes(), bytes());
}

#[test]
fn stability_unusable_input_is_refused_by_name() {
    let sheet = Sheet::new(3);
    let mut broken = sheet.moment(|x, y| Vector3::new(x, y, 0.0), &[]);
    broken.positions[4].z = f64::NAN;
    let framing = Framing::new(View::default());
    let refused = |m: &Moment, size| draw(&sheet.subject(), m, &framing, size).unwrap_err();
    assert!(matches!(
        refused(&broken, SMALL),
        DrawError::NotFinite { vertex: 4, .. }
    ));
    broken.positions.truncate(4);
    assert!(matches!(
        refused(&broken, SMALL),
        DrawError::Face { vertices: 4, .. }
    ));
    let giant = Size {
        width: 100_000,
        height: 10,
    };
    assert!(matches!(
        refused(&broken, giant),
        DrawError::Size { width: 100_000, .. }
    ));
    broken.positions.clear();
    assert!(matches!(refused(&broken, SMALL), DrawError::Empty(_)));
}
