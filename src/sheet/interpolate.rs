//! What is given at the vertices of a mesh, between them: quadratics about the vertices, blended over each face.

use nalgebra::{DMatrix, Matrix3x5, Vector2, Vector3};
use parry3d_f64::math::Vector;
use parry3d_f64::query::PointQueryWithLocation;
use parry3d_f64::shape::TriMesh;

use super::Mesh;

/// Fewest neighbours that a quadratic is fitted to; it has five coefficients beside its value.
const NEIGHBOURS: usize = 9;

/// Values at places of the sheet in material coordinates \[m\], from those at the vertices of a mesh, which it goes through;
/// its error is of third order in the element size. Beyond the mesh it goes on as in the nearest face.
pub fn interpolate(
    mesh: &Mesh,
    values: &[Vector3<f64>],
    places: &[Vector2<f64>],
) -> Vec<Vector3<f64>> {
    let flat = |p: &Vector2<f64>| Vector::new(p.x, p.y, 0.0);
    let surface = TriMesh::new(mesh.material.iter().map(flat).collect(), mesh.faces.clone());
    let surface = surface.expect("a mesh has faces");
    let quadratics = quadratics(mesh, values);
    let value = |p: &Vector2<f64>| {
        let (_, (face, place)) = surface.project_local_point_and_get_location(flat(p), true);
        let weights = place.barycentric_coordinates().unwrap_or([1.0, 0.0, 0.0]);
        let corners = mesh.faces[face as usize].map(|v| v as usize);
        let at = |v: usize| values[v] + quadratics[v] * monomials(&(p - mesh.material[v]));
        (0..3).map(|k| weights[k] * at(corners[k])).sum()
    };
    places.iter().map(value).collect()
}

fn monomials(d: &Vector2<f64>) -> nalgebra::Vector5<f64> {
    nalgebra::Vector5::new(d.x, d.y, d.x * d.x, d.x * d.y, d.y * d.y)
}

/// About each vertex the quadratic through its value that fits its neighbours best, those near most.
fn quadratics(mesh: &Mesh, values: &[Vector3<f64>]) -> Vec<Matrix3x5<f64>> {
    let mut beside = vec![vec![]; values.len()];
    for &[a, b] in &mesh.edges {
        beside[a as usize].push(b as usize);
        beside[b as usize].push(a as usize);
    }
    (0..values.len())
        .map(|v| quadratic(mesh, values, v, &neighbours(&beside, v)))
        .collect()
}

/// Vertices around one, by whole rings, until there are enough or all.
fn neighbours(beside: &[Vec<usize>], vertex: usize) -> Vec<usize> {
    let mut found = vec![vertex];
    let mut ring = 0..1;
    while found.len() <= NEIGHBOURS && !ring.is_empty() {
        for k in ring.clone() {
            let next = beside[found[k]].iter().copied();
            let new: Vec<usize> = next.filter(|n| !found.contains(n)).collect();
            found.extend(new);
        }
        ring = ring.end..found.len();
    }
    found.split_off(1)
}

fn quadratic(
    mesh: &Mesh,
    values: &[Vector3<f64>],
    vertex: usize,
    neighbours: &[usize],
) -> Matrix3x5<f64> {
    let from = |n: usize| mesh.material[n] - mesh.material[vertex];
    let reach = neighbours
        .iter()
        .map(|&n| from(n).norm())
        .fold(0.0, f64::max);
    let mut left = DMatrix::zeros(neighbours.len(), 5);
    let mut right = DMatrix::zeros(neighbours.len(), 3);
    for (row, &n) in neighbours.iter().enumerate() {
        let d = from(n) / reach;
        let weight = d.norm_squared().recip();
        left.set_row(row, &(weight * monomials(&d)).transpose());
        right.set_row(row, &(weight * (values[n] - values[vertex])).transpose());
    }
    let fitted = left.svd(true, true).solve(&right, 1e-9);
    let fitted = fitted.expect("both sides of the decomposition were asked for");
    let scale = [reach, reach, reach * reach, reach * reach, reach * reach];
    Matrix3x5::from_fn(|axis, k| fitted[(k, axis)] / scale[k])
}
