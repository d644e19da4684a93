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

fn synthetic() -> Vec<rows::Row> {
    use toile::chart::rows::*;
    use toile::scene::Scheme;
    let mut all = vec![];
    for (scheme, order, c, cost) in [
        (Scheme::BackwardEuler, 1.0, 30.0, 1.0),
        (Scheme::Bdf2, 2.0, 1500.0, 1.05),
        (Scheme::GeneralisedAlpha, 2.0, 400.0, 1.15),
    ] {
        for dt in [1e-2, 5e-3, 2e-3, 1e-3, 5e-4] {
            let dead = scheme == Scheme::GeneralisedAlpha && dt > 4e-3;
            let steps = (0.3f64 / dt) as u64;
            all.push(Row {
                key: Key {
                    scene: "strip-release".into(),
                    fabric: "F1".into(),
                    mesh: "triangles=600".into(),
                    scheme,
                    asked: Asked::Step(dt),
                },
                triangles: 604,
                dt,
                tolerance: 1e-6,
                outcome: if dead {
                    Outcome::Died {
                        time: 0.08,
                        message: "step 8 at 0.08 s did not converge: \"a\", b".into(),
                    }
                } else {
                    Outcome::Done {
                        error: c * dt.powf(order) + 2.3e-3,
                    }
                },
                cpu: cost * 0.3 * (7e-3 / dt).powf(0.8),
                simulated: if dead { 0.08 } else { 0.3 },
                steps,
                substeps: steps,
                rejected: 0,
                iterations: 4 * steps,
                factorisations: 4 * steps,
            });
        }
    }
    for part in [1, 2] {
        let dt = 1.6e-5 / part as f64;
        all.push(Row {
            key: Key {
                scene: "strip-release".into(),
                fabric: "F1".into(),
                mesh: "triangles=600".into(),
                scheme: Scheme::CentralDifference,
                asked: Asked::Limit(part),
            },
            triangles: 604,
            dt,
            tolerance: 1e-6,
            outcome: Outcome::Done { error: 2.25e-3 },
            cpu: 1.3 * part as f64,
            simulated: 0.3,
            steps: 600,
            substeps: 18750 * part as u64,
            rejected: 0,
            iterations: 0,
            factorisations: 0,
        });
    }
    all
}

#[test]
fn charted() {
    let caption = plot::Caption {
        scene: "strip-release".into(),
        title: "strip-release: error against step and CPU time".into(),
        subtitle: "F1, 604 triangles; tip of a 100 mm strip, largest error over 0.3 s".into(),
        error_over: "length (100 mm)".into(),
        uncertainty: 1.3e-4,
        source: "independent chain of 200 links, DOP853".into(),
    };
    let svg = plot::chart(&caption, &synthetic()).unwrap();
    std::fs::write("/tmp/wp.svg", &svg).unwrap();
    std::fs::write("/tmp/wp.png", png_of_svg(&svg, 1.0).unwrap()).unwrap();
}
