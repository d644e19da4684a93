//! Parts of the sheet as vertices: what holds it, what hangs on it.

use nalgebra::{Vector2, Vector3};

use crate::physics::support::Support;
use crate::scene::{Region, Scene, SupportKind, SupportSpec};
use crate::sheet::Mesh;

/// What holds the sheet.
pub fn supports(scene: &Scene, mesh: &Mesh) -> Vec<Support> {
    let support = |spec: &SupportSpec| {
        let inside = region(&spec.region, mesh);
        Support::new(
            mesh,
            inside,
            spec.kind == SupportKind::Clamp,
            ["x", "y", "z"].map(|axis| spec.axes.contains(axis)),
            spec.displacement.into(),
        )
    };
    scene.support.values().map(support).collect()
}

/// Test for a region of the sheet, with a margin for rounding.
fn region(region: &Region, mesh: &Mesh) -> impl Fn(&Vector2<f64>) -> bool {
    let points = &mesh.outline;
    let low = points
        .iter()
        .fold(Vector2::repeat(f64::INFINITY), |m, p| m.inf(p));
    let high = points
        .iter()
        .fold(Vector2::repeat(f64::NEG_INFINITY), |m, p| m.sup(p));
    let margin = 1e-9 * (high - low).norm();
    let mut on_boundary: Vec<[u64; 2]> = (0..mesh.edges.len())
        .filter(|&e| mesh.is_boundary(e))
        .flat_map(|e| mesh.edges[e].map(|v| bits(&points[v as usize])))
        .collect();
    on_boundary.sort_unstable();
    let nearest = match region {
        Region::Point { at } => points[nearest_vertex(mesh, at) as usize],
        _ => Vector2::zeros(),
    };
    let region = *region;
    move |p: &Vector2<f64>| match region {
        Region::XMin => p.x <= low.x + margin,
        Region::XMax => p.x >= high.x - margin,
        Region::YMin => p.y <= low.y + margin,
        Region::YMax => p.y >= high.y - margin,
        Region::Boundary => on_boundary.binary_search(&bits(p)).is_ok(),
        Region::Box { min, max } => {
            (0..2).all(|i| p[i] >= min[i] - margin && p[i] <= max[i] + margin)
        }
        Region::Disc { diameter } => p.norm() <= 0.5 * diameter + margin,
        Region::Ring { outer, inner } => {
            (0.5 * inner - margin..=0.5 * outer + margin).contains(&p.norm())
        }
        Region::Point { .. } => *p == nearest,
    }
}

fn bits(p: &Vector2<f64>) -> [u64; 2] {
    [p.x.to_bits(), p.y.to_bits()]
}

/// The vertex nearest to a point of the sheet.
pub fn nearest_vertex(mesh: &Mesh, at: &[f64; 2]) -> u32 {
    let at = Vector2::from(*at);
    let distance = |v: &u32| (mesh.outline[*v as usize] - at).norm_squared();
    (0..mesh.outline.len() as u32)
        .min_by(|a, b| distance(a).total_cmp(&distance(b)))
        .expect("a mesh has vertices")
}

/// Dead loads on the vertices \[N\].
pub fn loads(scene: &Scene, mesh: &Mesh) -> Vec<Vector3<f64>> {
    let mut forces = vec![Vector3::zeros(); mesh.outline.len()];
    for load in scene.load.values() {
        for (force, share) in forces.iter_mut().zip(shares(&load.region, mesh)) {
            *force += Vector3::from(load.force) * share;
        }
    }
    forces
}

/// How what is spread evenly over a region is shared by the vertices: along boundary edges within it, if there are any,
/// else by area. They sum to one, or are all zero where no vertex lies in it.
pub fn shares(inside: &Region, mesh: &Mesh) -> Vec<f64> {
    let within: Vec<bool> = mesh.outline.iter().map(region(inside, mesh)).collect();
    let mut shares = vec![0.0; within.len()];
    for e in (0..mesh.edges.len()).filter(|&e| mesh.is_boundary(e)) {
        let ends = mesh.edges[e].map(|v| v as usize);
        if ends.iter().all(|&v| within[v]) {
            ends.iter().for_each(|&v| shares[v] += mesh.edge_length(e));
        }
    }
    if shares.iter().all(|share| *share == 0.0) {
        let area = |v: usize| if within[v] { mesh.vertex_areas[v] } else { 0.0 };
        shares = (0..within.len()).map(area).collect();
    }
    let all: f64 = shares.iter().sum();
    if all > 0.0 {
        shares.iter_mut().for_each(|share| *share /= all);
    }
    shares
}
