//! Triangle mesh of a flat sheet: vertices, faces, edges, their sizes and neighbours.

use std::collections::BTreeMap;

use nalgebra::Vector2;

/// Marks the missing second face of a boundary edge.
pub const NO_FACE: u32 = u32::MAX;

/// A flat triangle mesh. Two charts of the same points: `outline` is the sheet's own x, y, in which scenes
/// name places; `material` has a1 along the warp and a2 along the weft, in which the fabric law is written.
#[derive(Clone, Debug)]
pub struct Mesh {
    /// Sheet coordinates \[m\], shape \[vertices\].
    pub outline: Vec<Vector2<f64>>,
    /// Warp and weft coordinates \[m\], shape \[vertices\].
    pub material: Vec<Vector2<f64>>,
    /// Vertices of each face, counter-clockwise, shape \[faces\].
    pub faces: Vec<[u32; 3]>,
    /// Edges of each face; edge k is opposite to vertex k, shape \[faces\].
    pub face_edges: Vec<[u32; 3]>,
    /// Vertices of each edge, smaller index first, shape \[edges\].
    pub edges: Vec<[u32; 2]>,
    /// The two faces of each edge (a hinge), the second `u32::MAX` on the boundary, shape \[edges\].
    pub edge_faces: Vec<[u32; 2]>,
    /// Rest area of each face \[m²\], shape \[faces\].
    pub face_areas: Vec<f64>,
    /// A third of the area of the faces around each vertex \[m²\], shape \[vertices\].
    pub vertex_areas: Vec<f64>,
}

impl Mesh {
    /// Completes a mesh from its points in both charts and its counter-clockwise faces.
    pub fn new(
        outline: Vec<Vector2<f64>>,
        material: Vec<Vector2<f64>>,
        faces: Vec<[u32; 3]>,
    ) -> Self {
        let mut by_ends: BTreeMap<[u32; 2], [u32; 2]> = BTreeMap::new();
        for (f, face) in faces.iter().enumerate() {
            for k in 0..3 {
                by_ends
                    .entry(ends(face, k))
                    .and_modify(|pair| pair[1] = f as u32)
                    .or_insert([f as u32, NO_FACE]);
            }
        }
        let edges: Vec<[u32; 2]> = by_ends.keys().copied().collect();
        let edge_faces = by_ends.values().copied().collect();
        let index = |e: [u32; 2]| edges.binary_search(&e).expect("every edge was listed") as u32;
        let face_edges = faces
            .iter()
            .map(|face| [0, 1, 2].map(|k| index(ends(face, k))))
            .collect();
        let face_areas: Vec<f64> = faces.iter().map(|f| area(&material, f)).collect();
        let mut vertex_areas = vec![0.0; material.len()];
        for (face, area) in faces.iter().zip(&face_areas) {
            for &v in face {
                vertex_areas[v as usize] += area / 3.0;
            }
        }
        Self {
            outline,
            material,
            faces,
            face_edges,
            edges,
            edge_faces,
            face_areas,
            vertex_areas,
        }
    }

    /// Whether an edge lies on the boundary.
    pub fn is_boundary(&self, edge: usize) -> bool {
        self.edge_faces[edge][1] == NO_FACE
    }

    /// Total rest area \[m²\].
    pub fn area(&self) -> f64 {
        self.face_areas.iter().sum()
    }

    /// Rest length of an edge \[m\].
    pub fn edge_length(&self, edge: usize) -> f64 {
        self.edge_vector(edge).norm()
    }

    /// Unit normal of an edge in the sheet's plane (material coordinates): its direction from the smaller to
    /// the larger vertex index, turned clockwise. The slope of an edge is the derivative along it.
    pub fn edge_normal(&self, edge: usize) -> Vector2<f64> {
        let along = self.edge_vector(edge).normalize();
        Vector2::new(along.y, -along.x)
    }

    fn edge_vector(&self, edge: usize) -> Vector2<f64> {
        let [a, b] = self.edges[edge];
        self.material[b as usize] - self.material[a as usize]
    }

    /// Vertices, then edges, of a face: the nodes of its bending stencil. Edge nodes count from the vertices.
    pub fn face_nodes(&self, face: usize) -> [u32; 6] {
        let [a, b, c] = self.faces[face];
        let [d, e, f] = self.face_edges[face].map(|e| e + self.material.len() as u32);
        [a, b, c, d, e, f]
    }

    /// Gradients of the three linear shape functions of a face in material coordinates \[1/m\].
    pub fn shape_gradients(&self, face: usize) -> [Vector2<f64>; 3] {
        let p = self.faces[face].map(|v| self.material[v as usize]);
        [0, 1, 2].map(|k| {
            let opposite = p[(k + 2) % 3] - p[(k + 1) % 3];
            Vector2::new(-opposite.y, opposite.x) / (2.0 * self.face_areas[face])
        })
    }
}

/// Ends of the edge opposite to corner `k`, smaller first.
fn ends(face: &[u32; 3], k: usize) -> [u32; 2] {
    let (a, b) = (face[(k + 1) % 3], face[(k + 2) % 3]);
    [a.min(b), a.max(b)]
}

fn area(points: &[Vector2<f64>], face: &[u32; 3]) -> f64 {
    let [a, b, c] = face.map(|v| points[v as usize]);
    0.5 * (b - a).perp(&(c - a))
}
