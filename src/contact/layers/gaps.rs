//! Where the flat sheet is not convex: at holes, slits and notches.

use super::tiles::Level;
use crate::sheet::Mesh;

/// Edges of the boundary that have cloth on both sides of their line. Cut by the others alone, a part of the sheet stays
/// convex.
pub(super) fn inward_edges(mesh: &Mesh) -> Vec<bool> {
    let boundary: Vec<usize> = (0..mesh.edges.len())
        .filter(|&e| mesh.is_boundary(e))
        .collect();
    let ends = |e: usize| mesh.edges[e].map(|v| mesh.material[v as usize]);
    // All cloth lies among the corners of its boundary.
    let corners: Vec<_> = boundary.iter().flat_map(|&e| ends(e)).collect();
    let is_inward = |e: usize| {
        let [a, b] = ends(e);
        let along = b - a;
        // Corners of a straight side are off it by rounding.
        let rounding = 1e-9 * along.norm_squared();
        let mut seen = [false; 2];
        for corner in &corners {
            let side = along.perp(&(corner - a));
            seen[0] |= side > rounding;
            seen[1] |= side < -rounding;
            if seen == [true; 2] {
                return true;
            }
        }
        false
    };
    let mut inward = vec![false; mesh.edges.len()];
    for e in boundary {
        inward[e] = is_inward(e);
    }
    inward
}

/// An empty tile beside one that is not convex may be a gap in the sheet.
pub(super) fn leave_out_gaps(grid: Level, covering: &[Vec<u32>], convex: &mut [bool]) {
    let known = convex.to_vec();
    let within = |at: usize, most: usize| at.saturating_sub(1)..(at + 2).min(most);
    for j in 0..grid.rows {
        for i in 0..grid.columns {
            let t = grid.index([i, j]);
            if covering[t].is_empty() {
                let columns = within(i, grid.columns);
                let mut beside =
                    within(j, grid.rows).flat_map(|j| columns.clone().map(move |i| [i, j]));
                convex[t] = beside.all(|other| known[grid.index(other)]);
            }
        }
    }
}

#[cfg(test)]
mod test {
    use nalgebra::{Vector2, Vector3};

    use super::super::test::{THICKNESS, brute, mesh};
    use super::super::{Candidates, Tiles};
    use super::inward_edges;
    use crate::sheet::{MeshOptions, Outline, generate};

    /// Boundary edges, and how many of them lead inward.
    fn count(outline: Outline) -> [usize; 2] {
        let options = MeshOptions {
            edge: 0.01,
            jitter: 0.0,
            seed: 0,
            warp_angle: 0.0,
        };
        let mesh = generate(&outline, &options);
        let inward = inward_edges(&mesh);
        let boundary = (0..mesh.edges.len()).filter(|&e| mesh.is_boundary(e));
        let all = boundary.clone().count();
        [all, boundary.filter(|&e| inward[e]).count()]
    }

    #[test]
    fn only_holes_and_notches_lead_inward() {
        let (length, width) = (0.2, 0.1);
        assert_eq!(count(Outline::Rectangle { length, width })[1], 0);
        assert_eq!(count(Outline::Disc { diameter: 0.2 })[1], 0);
        let (outer, inner) = (0.2, 0.1);
        let [all, inward] = count(Outline::Annulus { outer, inner });
        assert!(
            (0.3..0.36).contains(&(inward as f64 / all as f64)),
            "{inward} of {all}"
        );
        let angle = 300.0;
        let [all, inward] = count(Outline::Sector {
            outer,
            inner,
            angle,
        });
        // The inner arc and both straight sides.
        assert!(
            (0.38..0.45).contains(&(inward as f64 / all as f64)),
            "{inward} of {all}"
        );
    }

    /// A ring with a slit is turned until its ends lie one over the other: they are near, though they were farther apart
    /// than a tile tells in the flat sheet, with no cloth between them.
    #[test]
    fn a_slit_that_closes_is_seen() {
        let slit = Outline::Sector {
            outer: 0.05,
            inner: 0.02,
            angle: 345.0,
        };
        let mesh = mesh(slit, 1.5e-3);
        let tiles = Tiles::new(&mesh, THICKNESS);
        let close = |p: &Vector2<f64>| {
            // The first side is at no angle, or by rounding a little less.
            let angle = (p.y.atan2(p.x) + 0.1).rem_euclid(std::f64::consts::TAU) - 0.1;
            let (sin, cos) = (angle * 365.0 / 345.0).sin_cos();
            Vector3::new(p.norm() * cos, p.norm() * sin, 5e-5 * angle)
        };
        let positions: Vec<_> = mesh.material.iter().map(close).collect();
        let mut candidates = Candidates::default();
        candidates.collect(&tiles, &mesh, &positions, 0.0);
        let wanted = brute(&tiles, &mesh, &positions, THICKNESS);
        assert!(wanted[0].len() > 20, "{}", wanted[0].len());
        assert_eq!(candidates.found(), wanted);
    }
}
