//! Files of triangles: STL and OBJ, told apart by what is in them.

use std::collections::BTreeMap;
use std::io::Cursor;

use super::{MOST_TRIANGLES, Surface, SurfaceError, Triangles};

impl Surface {
    /// Reads the bytes of an STL (binary or text) or OBJ file, whose lengths are multiplied by `scale`. Vertices in one
    /// place become one; polygons are cut into triangles.
    ///
    /// # Errors
    /// The bytes are neither, or the triangles are no surface.
    pub fn read(bytes: &[u8], scale: f64) -> Result<Self, SurfaceError> {
        let corners = match is_obj(bytes) {
            true => obj(bytes)?,
            false => stl(bytes)?,
        };
        Surface::try_from(merged(&corners, scale)?)
    }
}

/// OBJ has no signature, but its lines begin with words of its own, comments aside; an STL begins with `solid` or has
/// zeros among its first bytes.
fn is_obj(bytes: &[u8]) -> bool {
    let words = [
        "v", "vn", "vt", "vp", "f", "o", "g", "s", "l", "usemtl", "mtllib",
    ];
    let lines = bytes
        .split(|byte| *byte == b'\n')
        .map(|line| line.trim_ascii());
    let mut lines = lines.filter(|line| !line.is_empty() && line[0] != b'#');
    lines.next().is_some_and(|line| {
        let word = line.split(u8::is_ascii_whitespace).next().unwrap_or(line);
        words.iter().any(|known| known.as_bytes() == word)
    })
}

fn stl(bytes: &[u8]) -> Result<Vec<[[f64; 3]; 3]>, SurfaceError> {
    let failed = |error: std::io::Error| SurfaceError::Format {
        format: "STL",
        reason: error.to_string(),
    };
    let mut cursor = Cursor::new(bytes);
    let reader = stl_io::create_stl_reader(&mut cursor).map_err(failed)?;
    let mut corners = vec![];
    for triangle in reader {
        if corners.len() > MOST_TRIANGLES {
            return Err(SurfaceError::TooMany {
                found: corners.len(),
            });
        }
        let triangle = triangle.map_err(failed)?;
        corners.push(triangle.vertices.map(|v| v.0.map(f64::from)));
    }
    Ok(corners)
}

fn obj(bytes: &[u8]) -> Result<Vec<[[f64; 3]; 3]>, SurfaceError> {
    let failed = |error: tobj::LoadError| SurfaceError::Format {
        format: "OBJ",
        reason: error.to_string(),
    };
    let options = tobj::LoadOptions {
        triangulate: true,
        ignore_points: true,
        ignore_lines: true,
        ..tobj::LoadOptions::default()
    };
    let no_materials = |_: &std::path::Path| Err(tobj::LoadError::OpenFileFailed);
    let (models, _) =
        tobj::load_obj_buf(&mut Cursor::new(bytes), &options, no_materials).map_err(failed)?;
    let corner = |mesh: &tobj::Mesh, index: u32| {
        let at = 3 * index as usize;
        [0, 1, 2].map(|k| mesh.positions[at + k])
    };
    let mut corners = vec![];
    for mesh in models.iter().map(|model| &model.mesh) {
        let (triangles, _) = mesh.indices.as_chunks::<3>();
        corners.extend(triangles.iter().map(|t| t.map(|index| corner(mesh, index))));
    }
    Ok(corners)
}

/// Triangles whose corners in one place are one vertex.
fn merged(corners: &[[[f64; 3]; 3]], scale: f64) -> Result<Triangles, SurfaceError> {
    let mut known = BTreeMap::new();
    let mut given = Triangles {
        vertices: vec![],
        triangles: vec![],
    };
    for corners in corners {
        let vertex = |p: &[f64; 3]| {
            // Both zeros are one place.
            let p = p.map(|c| c * scale + 0.0);
            let next = given.vertices.len() as u32;
            let vertex = *known.entry(p.map(f64::to_bits)).or_insert(next);
            if vertex == next {
                given.vertices.push(p);
            }
            vertex
        };
        given.triangles.push(corners.each_ref().map(vertex));
    }
    match given.triangles.len() {
        0 => Err(SurfaceError::Empty),
        _ => Ok(given),
    }
}
