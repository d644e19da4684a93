//! The order in which faces are taken, which is that of the sums at the nodes.

use crate::math::sparse::NO_SLOT;
use crate::physics::Potential;
use crate::sim::model::Model;

/// Faces of a strip, about.
const STRIP: usize = 256;

/// Faces with a node that moves, as they are taken: strip after strip across the sheet, and within a strip so that fours
/// are far from each other, since neighbours would have to wait for each other's forces on the nodes that they share.
pub fn order(model: &Model) -> Vec<usize> {
    let (moves, along) = (moving(model), along(model));
    let mut faces: Vec<usize> = (0..model.mesh.faces.len())
        .filter(|&f| {
            let nodes = model.bend.nodes(f);
            nodes.iter().any(|&node| moves[node as usize])
        })
        .collect();
    let middle = |f: &usize| {
        model.mesh.faces[*f]
            .iter()
            .map(|&v| along[v as usize])
            .sum::<f64>()
    };
    faces.sort_by(|a, b| middle(a).total_cmp(&middle(b)));
    let strips = faces.chunks_mut(STRIP).map(|strip| {
        strip.sort();
        let fours = strip.len().div_ceil(4);
        (0..fours).flat_map(move |four| {
            strip
                .iter()
                .copied()
                .skip(four)
                .step_by(fours)
                .collect::<Vec<_>>()
        })
    });
    strips.flatten().collect()
}

/// Where each node is along the longer side of the sheet \[m\]: a vertex, or the middle of an edge.
pub fn along(model: &Model) -> Vec<f64> {
    let mesh = &model.mesh;
    let extent = |axis: usize| {
        let places = mesh.outline.iter().map(|p| p[axis]);
        places.clone().fold(f64::MIN, f64::max) - places.fold(f64::MAX, f64::min)
    };
    let axis = usize::from(extent(1) >= extent(0));
    let vertices = mesh.outline.iter().map(|p| p[axis]);
    let edges = mesh.edges.iter().map(|ends| {
        let [a, b] = ends.map(|v| mesh.outline[v as usize][axis]);
        0.5 * (a + b)
    });
    vertices.chain(edges).collect()
}

/// Nodes that are free, or that a support moves; a face without one never changes, and its forces act on supports that do
/// no work.
fn moving(model: &Model) -> Vec<bool> {
    let free = |index: &[u32; 3]| *index != [NO_SLOT; 3];
    let mut moves: Vec<bool> = model.dofs.index.iter().map(free).collect();
    for (node, _) in model.carried.iter().flat_map(|carried| carried.held()) {
        moves[node] = true;
    }
    moves
}

/// The four and the place in it of each face, given its nodes, in order. No four has two faces with a node in common, and
/// of faces that have one, the later stands in a later four: so forces on a node are summed in the order of its faces,
/// whatever other faces there are.
pub fn pack(faces: impl Iterator<Item = [u32; 6]>) -> Vec<(usize, usize)> {
    // The first four in which a node may be used next.
    let mut free: Vec<usize> = vec![];
    let mut filled: Vec<usize> = vec![];
    let mut full = 0;
    let place = |nodes: [u32; 6]| {
        let nodes = nodes.map(|node| node as usize);
        let last = nodes.iter().fold(0, |last, node| last.max(*node));
        free.resize(free.len().max(last + 1), 0);
        let mut four = nodes.iter().fold(full, |four, node| four.max(free[*node]));
        while filled.get(four) == Some(&4) {
            four += 1;
        }
        if filled.len() <= four {
            filled.resize(four + 1, 0);
        }
        let at = (four, filled[four]);
        filled[four] += 1;
        while filled.get(full) == Some(&4) {
            full += 1;
        }
        for node in nodes {
            free[node] = four + 1;
        }
        at
    };
    faces.map(place).collect()
}

#[cfg(test)]
mod test {
    use super::pack;

    /// A strip of triangles that share corners, with and without every third.
    #[test]
    fn faces_of_a_node_keep_their_order() {
        let nodes = |f: u32| [f, f + 1, f + 2, 1000 + f, 1001 + f, 1002 + f];
        let all: Vec<u32> = (0..10)
            .flat_map(|k| (0..10).map(move |i| k + 10 * i))
            .collect();
        for dropped in [7, 3] {
            let kept: Vec<u32> = all.iter().copied().filter(|f| f % dropped != 1).collect();
            let fours = pack(kept.iter().map(|&f| nodes(f)));
            for (i, a) in kept.iter().enumerate() {
                for (j, b) in kept.iter().enumerate().skip(i + 1) {
                    assert_ne!(fours[i], fours[j]);
                    let share = nodes(*a).iter().any(|node| nodes(*b).contains(node));
                    assert!(!share || fours[i].0 < fours[j].0, "{a} and {b}");
                }
            }
            let count = fours.iter().map(|four| four.0 + 1).max().unwrap();
            assert!(
                count <= kept.len().div_ceil(4) + 3,
                "{count} fours of {}",
                kept.len()
            );
            assert!(fours.iter().all(|four| four.1 < 4));
        }
    }
}
