use nalgebra::{Rotation3, Vector2, Vector3};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;

use super::spread::{Gradient, Spread};

type Point = Vector3<f64>;

fn spread(gradients: &[Gradient]) -> Spread {
    let sum = gradients
        .iter()
        .fold([Point::zeros(); 2], |s, g| [s[0] + g[0], s[1] + g[1]]);
    let mean = sum.map(|s| s / gradients.len() as f64);
    Spread::of(mean, gradients.iter()).expect("the mean has a plane")
}

/// Gradients of cloth that bends about the weft, from one angle to another.
fn bent(from: f64, to: f64) -> Vec<Gradient> {
    let angles = (0..=100).map(|k| from + (to - from) * f64::from(k) / 100.0);
    let gradient = |a: f64| [Point::new(a.cos(), 0.0, a.sin()), Point::y()];
    angles.map(gradient).collect()
}

/// Cloth bent by an angle to either side of a plane keeps its points apart by its cosine; known by its halves, nearly so.
#[test]
fn bending_costs_little() {
    for angle in [0.1, 0.3, 0.6f64] {
        let whole = spread(&bent(-angle, angle));
        let least = Spread::least(&[Some(&whole)]);
        assert!((least - angle.cos()).abs() < 1e-12, "{angle}: {least}");
        let halves = [spread(&bent(-angle, 0.0)), spread(&bent(0.0, angle))];
        let least = Spread::least(&[Some(&halves[0]), Some(&halves[1])]);
        let bounds = 1.0 - 0.8 * angle * angle..=angle.cos();
        assert!(bounds.contains(&least), "{angle}: {least}");
    }
}

/// No straight line through faces of random gradients, in any share, is shorter than is said of them.
#[test]
fn no_line_is_shorter_than_said() {
    let mut random = Pcg64::seed_from_u64(5);
    let mut said = 0;
    for _ in 0..300 {
        let mut draw = |size: f64| size * (random.random::<f64>() - 0.5);
        let mut gradients = |size: f64| -> Vec<Gradient> {
            let turn = Rotation3::new(Point::new(draw(1.0), draw(1.0), draw(1.0)));
            let mut column = |axis| turn * (axis + Point::new(draw(size), draw(size), draw(size)));
            let gradient = |_| [column(Point::x()), column(Point::y())];
            (0..5).map(gradient).collect()
        };
        let groups = [gradients(0.2), gradients(0.5)];
        let spreads = [spread(&groups[0]), spread(&groups[1])];
        let least = Spread::least(&[Some(&spreads[0]), Some(&spreads[1])]);
        said += usize::from(least > 0.2);
        for _ in 0..100 {
            let way = Vector2::new(draw(1.0), draw(1.0));
            let (mut end, mut length) = (Point::zeros(), 0.0);
            for [u, v] in groups.iter().flatten() {
                let share = draw(1.0).max(0.0);
                end += (u * way.x + v * way.y) * share;
                length += way.norm() * share;
            }
            assert!(
                end.norm() >= least * length,
                "{} {length} {least}",
                end.norm()
            );
        }
    }
    assert!(said > 100, "{said}");
}
