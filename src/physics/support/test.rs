use nalgebra::{Vector2, Vector3};

use super::Support;
use crate::sheet::Mesh;

/// ```text
/// 3 ---- 2        edges by their ends: 01 02 03 12 23
/// |   /  |
/// 0 ---- 1
/// ```
fn square() -> Mesh {
    let points: Vec<Vector2<f64>> = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]]
        .map(Vector2::from)
        .into();
    Mesh::new(points.clone(), points, vec![[0, 1, 2], [0, 2, 3]])
}

fn left(p: &Vector2<f64>) -> bool {
    p.x < 0.5
}

#[test]
fn a_pin_holds_vertices_and_no_slope() {
    let axes = [true, false, true];
    let pin = Support::new(&square(), left, false, axes, Vector3::x());
    assert_eq!(pin.vertices, [0, 3]);
    assert!(pin.edges.is_empty());
    assert_eq!((pin.axes, pin.displacement), (axes, Vector3::x()));
}

#[test]
fn a_clamp_holds_the_slopes_of_edges_with_both_ends_held() {
    let mesh = square();
    let clamp = Support::new(&mesh, left, true, [true; 3], Vector3::zeros());
    assert_eq!(clamp.vertices, [0, 3]);
    let held: Vec<_> = clamp
        .edges
        .iter()
        .map(|&e| mesh.edges[e as usize])
        .collect();
    assert_eq!(held, [[0, 3]]);
    let all = Support::new(&mesh, |_| true, true, [true; 3], Vector3::zeros());
    assert_eq!(all.edges.len(), mesh.edges.len());
}
