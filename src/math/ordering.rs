//! Nested dissection of a planar mesh by coordinate bisection of its elements (George 1973).

/// Elements below which a part is not cut further.
const LEAF_ELEMENTS: usize = 4;

/// Elimination order of `node_count` nodes: parts first, the separators between them last.
///
/// `elements` lists the nodes of each element, `centres` their centres. Cutting elements, not nodes, makes a
/// separator a path of the mesh: 1 vertex and 1 edge per edge length, which a vertex cut would double.
/// Nodes in no element come last.
pub fn nested_dissection<const N: usize>(
    elements: &[[u32; N]],
    centres: &[[f64; 2]],
    node_count: usize,
) -> Vec<u32> {
    let mut dissection = Dissection {
        elements,
        centres,
        side: vec![Side::Free; node_count],
        order: Vec::with_capacity(node_count),
    };
    let mut all: Vec<u32> = (0..elements.len() as u32).collect();
    dissection.cut(&mut all);
    let Dissection {
        side, mut order, ..
    } = dissection;
    order.extend((0..node_count as u32).filter(|&n| side[n as usize] != Side::Done));
    order
}

#[derive(Clone, Copy, PartialEq, Eq)]
enum Side {
    Free,
    Left,
    Separator,
    Done,
}

struct Dissection<'a, const N: usize> {
    elements: &'a [[u32; N]],
    centres: &'a [[f64; 2]],
    side: Vec<Side>,
    order: Vec<u32>,
}

impl<const N: usize> Dissection<'_, N> {
    fn cut(&mut self, part: &mut [u32]) {
        if part.len() <= LEAF_ELEMENTS {
            self.finish(part);
            return;
        }
        let axis = self.longest_axis(part);
        let middle = part.len() / 2;
        let key = |e: &u32| self.centres[*e as usize][axis];
        part.select_nth_unstable_by(middle, |a, b| key(a).total_cmp(&key(b)).then(a.cmp(b)));
        let (left, right) = part.split_at_mut(middle);
        let separator = self.mark_separator(left, right);
        self.cut(left);
        self.cut(right);
        for node in separator {
            self.side[node as usize] = Side::Done;
            self.order.push(node);
        }
    }

    /// Marks the free nodes that both sides share and returns them in order of first meeting.
    fn mark_separator(&mut self, left: &[u32], right: &[u32]) -> Vec<u32> {
        for node in nodes_of(self.elements, left) {
            if self.side[node] == Side::Free {
                self.side[node] = Side::Left;
            }
        }
        let mut separator = vec![];
        for node in nodes_of(self.elements, right) {
            if self.side[node] == Side::Left {
                self.side[node] = Side::Separator;
                separator.push(node as u32);
            }
        }
        for node in nodes_of(self.elements, left) {
            if self.side[node] == Side::Left {
                self.side[node] = Side::Free;
            }
        }
        separator
    }

    fn finish(&mut self, part: &[u32]) {
        for node in nodes_of(self.elements, part) {
            if self.side[node] == Side::Free {
                self.side[node] = Side::Done;
                self.order.push(node as u32);
            }
        }
    }

    fn longest_axis(&self, part: &[u32]) -> usize {
        let extent = |axis: usize| {
            let values = part.iter().map(|&e| self.centres[e as usize][axis]);
            let (low, high) = values.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| {
                (l.min(v), h.max(v))
            });
            high - low
        };
        usize::from(extent(1) > extent(0))
    }
}

fn nodes_of<'a, const N: usize>(
    elements: &'a [[u32; N]],
    part: &'a [u32],
) -> impl Iterator<Item = usize> + 'a {
    part.iter()
        .flat_map(move |&e| elements[e as usize].iter().map(|&n| n as usize))
}
