//! Triangle mesh of a flat sheet: vertices, faces, edges, their sizes and neighbours.

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
    /// Whether an edge lies on the boundary.
    pub fn is_boundary(&self, edge: usize) -> bool {
        self.edge_faces[edge][1] == NO_FACE
    }

    /// Total rest area \[m²\].
    pub fn area(&self) -> f64 {
        self.face_areas.iter().sum()
    }
}
