//! The seeded disturbance of a flat start.

use nalgebra::Vector2;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;

use crate::physics::support::Support;
use crate::scene::Perturbation;
use crate::sheet::Mesh;

/// Waves that are summed.
const WAVES: usize = 24;

/// A smooth random field on the vertices, scaled to the amplitude \[m\]: plane waves of random direction, phase and length
/// (between a quarter and the whole of the sheet's size). It rises from nothing at the supports.
pub fn perturbation(spec: &Perturbation, mesh: &Mesh, supports: &[Support]) -> Vec<f64> {
    if spec.amplitude == 0.0 {
        return vec![0.0; mesh.outline.len()];
    }
    let waves = waves(spec.seed, mesh);
    let sum = |p: &Vector2<f64>| -> f64 {
        let heights = waves.iter().map(|(k, phase)| (k.dot(p) + phase).cos());
        heights.sum()
    };
    let risen = risen(spec.fade, mesh, supports);
    let raw: Vec<f64> = mesh
        .outline
        .iter()
        .map(sum)
        .zip(risen)
        .map(|(r, f)| r * f)
        .collect();
    let largest = raw.iter().fold(0.0, |m: f64, r| m.max(r.abs()));
    if largest == 0.0 {
        return raw;
    }
    raw.iter().map(|r| r * spec.amplitude / largest).collect()
}

/// Wave vectors \[1/m\] and phases.
fn waves(seed: u64, mesh: &Mesh) -> Vec<(Vector2<f64>, f64)> {
    let mut random = Pcg64::seed_from_u64(seed);
    let size = mesh.outline.iter().map(|p| p.norm()).fold(0.0, f64::max) * 2f64.sqrt();
    (0..WAVES)
        .map(|_| {
            let (turn, phase, length): (f64, f64, f64) =
                (random.random(), random.random(), random.random());
            let (sin, cos) = (std::f64::consts::TAU * turn).sin_cos();
            let number = std::f64::consts::TAU * (1.0 + 3.0 * length) / size;
            let phase = phase * std::f64::consts::TAU;
            (Vector2::new(cos, sin) * number, phase)
        })
        .collect()
}

/// How much of it each vertex has, 0 to 1: it rises smoothly over `fade` from the supports \[m\].
fn risen(fade: f64, mesh: &Mesh, supports: &[Support]) -> Vec<f64> {
    if fade == 0.0 {
        return vec![1.0; mesh.outline.len()];
    }
    let mut held = vec![false; mesh.outline.len()];
    for &v in supports.iter().flat_map(|support| &support.vertices) {
        held[v as usize] = true;
    }
    // Of what is held, only where it ends counts.
    let mut ends = vec![false; mesh.outline.len()];
    for edge in &mesh.edges {
        let [a, b] = edge.map(|v| v as usize);
        ends[a] |= held[a] && !held[b];
        ends[b] |= held[b] && !held[a];
    }
    let ends = mesh.outline.iter().zip(ends).filter(|(_, end)| *end);
    let ends: Vec<Vector2<f64>> = ends.map(|(p, _)| *p).collect();
    let rise = |(p, held): (&Vector2<f64>, bool)| {
        let squares = ends.iter().map(|end| (p - end).norm_squared());
        let near = squares.fold(f64::INFINITY, f64::min).sqrt();
        let part = if held { 0.0 } else { (near / fade).min(1.0) };
        part * part * (3.0 - 2.0 * part)
    };
    mesh.outline.iter().zip(held).map(rise).collect()
}

#[cfg(test)]
mod test {
    use crate::scene::{Override, library, parse};
    use crate::sim::model::Model;

    /// Greatest rise along an edge that ends at the clamp, and of all \[m\].
    fn rises(triangles: &str, fade: &str) -> [f64; 2] {
        let sets = [("sheet.triangles", triangles), ("perturbation.fade", fade)];
        let sets = sets.map(|(key, value)| Override::new(key, value, ""));
        let (scene, _) = parse(library::text("drapemeter").unwrap(), &sets).unwrap();
        let model = Model::new(&scene, scene.fabric.resolve().unwrap());
        let start = model.start();
        let between = model.mesh.edges.iter().map(|edge| {
            let [a, b] = edge.map(|v| start[v as usize].z.abs());
            if a.min(b) == 0.0 { a.max(b) } else { 0.0 }
        });
        let heights = start[..model.masses.len()].iter().map(|p| p.z.abs());
        [between.fold(0.0, f64::max), heights.fold(0.0, f64::max)]
    }

    /// A field that fades out at the clamp rises less from vertex to vertex on a finer mesh; one that does not jumps there.
    #[test]
    fn it_rises_smoothly_from_supports() {
        for (fade, least, most) in [("0.02", 1.6, 5.0), ("0", 0.9, 1.2)] {
            let [coarse, high] = rises("1400", fade);
            let [fine, higher] = rises("5600", fade);
            assert!((high - 1e-3).abs() < 1e-12 && (higher - 1e-3).abs() < 1e-12);
            assert!((least..most).contains(&(coarse / fine)), "{coarse} {fine}");
        }
    }
}
