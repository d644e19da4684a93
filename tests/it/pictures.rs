//! Pictures.
use nalgebra::{Vector2, Vector3};
use toile::chart::*;
use toile::contact::*;

fn grid(
    n: usize,
    size: f64,
    z: impl Fn(f64, f64) -> Vector3<f64>,
) -> (Vec<[u32; 3]>, Vec<Vector2<f64>>, Vec<Vector3<f64>>) {
    let mut m = vec![];
    for i in 0..n {
        for j in 0..n {
            m.push(Vector2::new(
                size * (i as f64 / (n - 1) as f64 - 0.5),
                size * (j as f64 / (n - 1) as f64 - 0.5),
            ));
        }
    }
    let mut f = vec![];
    for i in 0..n - 1 {
        for j in 0..n - 1 {
            let (a, b, c, d) = (
                (i * n + j) as u32,
                ((i + 1) * n + j) as u32,
                ((i + 1) * n + j + 1) as u32,
                (i * n + j + 1) as u32,
            );
            f.push([a, b, c]);
            f.push([a, c, d]);
        }
    }
    let p = m.iter().map(|m| z(m.x, m.y)).collect();
    (f, m, p)
}

#[test]
fn gallery() {
    let drape = |t: f64| {
        move |x: f64, y: f64| {
            // a conical drape with 6 folds over a 100 mm box
            let r = x.hypot(y);
            let a = y.atan2(x);
            let r0 = 0.055;
            if r < r0 {
                return Vector3::new(x, y, 0.0005);
            }
            let s = r - r0;
            let k = t;
            let bend = (s / 0.03).min(1.0) * 1.25 * k;
            let fold = (6.0 * a + 0.5).cos() * 0.35 * k * (s / 0.05).min(1.0);
            let th = bend * (1.0 + fold);
            let rr = r0 + s * th.cos();
            Vector3::new(rr * a.cos(), rr * a.sin(), 0.0005 - s * th.sin())
        }
    };
    let table = |shape: Shape, z: f64| {
        vec![Obstacle {
            name: "table".into(),
            shape,
            pose: Pose::translation(0.0, 0.0, z),
            velocity: Velocity::default(),
            friction: 0.3,
        }]
    };
    let n = 60;
    let (faces, material, positions) = grid(n, 0.2, drape(1.0));
    let subject = Subject {
        title: "drape-table",
        subtitle: "F1 · 6,962 triangles · 3,600 vertices",
        faces: &faces,
        material: &material,
    };
    let m = Moment {
        time: 1.0,
        positions,
        obstacles: table(
            Shape::Cylinder {
                radius: 0.05,
                length: 0.07,
            },
            -0.035,
        ),
    };
    let mut framing = Framing::new(View::default());
    framing.include(&m);
    let t = std::time::Instant::now();
    let p = draw(&subject, &m, &framing, Size::default()).unwrap();
    eprintln!("{:?}", t.elapsed());
    std::fs::write("/tmp/shot1.png", p.png().unwrap()).unwrap();
    let moments: Vec<_> = (0..8)
        .map(|k| Moment {
            time: k as f64 / 7.0,
            positions: grid(n, 0.2, drape(k as f64 / 7.0)).2,
            obstacles: table(
                Shape::Box {
                    size: [0.1, 0.1, 0.02],
                },
                -0.01,
            ),
        })
        .collect();
    let mut framing = Framing::new(View::default());
    moments.iter().for_each(|m| framing.include(m));
    let p = draw_strip(&subject, &moments, &framing, None).unwrap();
    std::fs::write("/tmp/strip1.png", p.png().unwrap()).unwrap();

    let mut obs = vec![];
    for (k, shape) in [
        Shape::Box {
            size: [0.04, 0.06, 0.05],
        },
        Shape::Sphere { radius: 0.03 },
        Shape::Disc { radius: 0.03 },
        Shape::Cylinder {
            radius: 0.02,
            length: 0.05,
        },
        Shape::Capsule {
            radius: 0.015,
            length: 0.03,
        },
    ]
    .into_iter()
    .enumerate()
    {
        obs.push(Obstacle {
            name: format!("o{k}"),
            shape,
            pose: Pose::new(
                Vector3::new(0.08 * k as f64 - 0.16, -0.09, 0.03),
                if k == 4 {
                    Vector3::new(0.0, 0.8, 0.3)
                } else {
                    Vector3::zeros()
                },
            ),
            velocity: Velocity::default(),
            friction: 0.0,
        });
    }
    obs.push(Obstacle {
        name: "ground".into(),
        shape: Shape::Plane,
        pose: Pose::identity(),
        velocity: Velocity::default(),
        friction: 0.0,
    });
    let (faces, material, positions) = grid(12, 0.2, |x, y| {
        Vector3::new(x, 0.06 + 0.02 * (20.0 * x).sin(), 0.1 + y)
    });
    let subject = Subject {
        title: "shapes",
        subtitle: "all six",
        faces: &faces,
        material: &material,
    };
    let m = Moment {
        time: 0.25,
        positions,
        obstacles: obs,
    };
    let mut framing = Framing::new(View::default());
    framing.include(&m);
    let p = draw(&subject, &m, &framing, Size::default()).unwrap();
    std::fs::write("/tmp/shapes.png", p.png().unwrap()).unwrap();
}
