//! Where the sheet is nearest to a surface.
//!
//! What is near a vertex of the sheet are the parts of the surface that nothing beside them is nearer than: one over flat
//! or convex triangles, however they are cut, two in a deep valley. Within an edge of the sheet it is where that passes an
//! edge or vertex that stands out, within a face where such a vertex is. Points of nearly one distance and direction share
//! one contact, by how far they are from the nearest of them, so that no force jumps from one to the next.

use nalgebra::Vector3;

use super::near::STATIONS;
use super::{Candidates, Part, Point, Surface};
use crate::contact::detect::{LEAD, share};
use crate::contact::layers::{crosses, point_to_face, segment_to_segment};
use crate::sheet::Mesh;

/// Beyond the reach, how far distances are told apart \[m\].
pub const CAP: f64 = LEAD;
/// Cosine of the angle up to which two directions are of one contact.
const ONE_WAY: f64 = 0.5;
/// Sine of the angle by which a direction may leave those in which a part is nearest.
const IN_THE_WAY: f64 = 0.5;
/// Difference of distances that are one but for rounding \[m\].
const TIE: f64 = 1e-9;
/// Part of the way to a foot on which nothing may stand.
const NEARLY: f64 = 1.0 - 1e-6;
/// Least weight of a corner inside of a face.
const INSIDE: f64 = 1e-6;

/// A point of the sheet near a part of the surface, in the surface's frame.
#[derive(Clone, Debug)]
pub struct Found {
    /// What of the sheet: 0 a vertex, 1 an edge, 2 a face, and which.
    pub kind: u64,
    pub feature: u32,
    /// Tells those of one feature from each other.
    pub number: u8,
    /// Weights of the vertices of the feature.
    pub weights: [f64; 3],
    pub share: f64,
    pub part: Part,
    pub at: Point,
}

/// A candidate: part, place, weights on the feature of the sheet, value and normal of the distance, and what is left of
/// a whole contact.
#[derive(Clone, Copy, Debug)]
struct Touch {
    part: Part,
    at: Point,
    weights: [f64; 3],
    value: f64,
    normal: Point,
    share: f64,
}

/// Appends every point of the sheet that is nearest to the surface and closer than `reach`, to `found`; `local` are the
/// vertices of the candidates in the surface's frame.
pub fn detect(
    (mesh, surface): (&Mesh, &Surface),
    candidates: &Candidates,
    local: &[Vector3<f64>],
    reach: f64,
    found: &mut Vec<Found>,
) {
    let looker = Looker {
        surface,
        cap: reach + CAP,
        deep: candidates.deep,
    };
    let at = |slot: u32| local[slot as usize];
    let mut of_vertices: Vec<Vec<Touch>> = vec![vec![]; local.len()];
    for row in &candidates.vertices {
        let touches = &mut of_vertices[row.slots[0] as usize];
        looker.at_vertex(&at(row.slots[0]), row.of(&candidates.triangles), touches);
        looker.keep((0, row.feature), reach, touches, found);
    }
    let mut of_edges: Vec<(u32, Vec<Touch>)> = Vec::with_capacity(candidates.edges.len());
    for row in &candidates.edges {
        let rim = row.slots.map(|slot| &of_vertices[slot as usize]);
        let mut touches = vec![];
        looker.at_edge(row.slots.map(at), row.of(&candidates.ridges), &mut touches);
        looker.lead(&mut touches, rim.into_iter().flatten());
        looker.keep((1, row.feature), reach, &touches, found);
        of_edges.push((row.feature, touches));
    }
    for row in &candidates.faces {
        let mut touches = vec![];
        looker.at_face(row.slots.map(at), row.of(&candidates.tips), &mut touches);
        let sides = mesh.face_edges[row.feature as usize].into_iter();
        let of_side = |e: u32| of_edges.binary_search_by_key(&e, |(edge, _)| *edge).ok();
        let sides = sides.filter_map(of_side).flat_map(|i| &of_edges[i].1);
        let corners = row
            .slots
            .into_iter()
            .flat_map(|slot| &of_vertices[slot as usize]);
        looker.lead(&mut touches, corners.chain(sides));
        looker.keep((2, row.feature), reach, &touches, found);
    }
}

struct Looker<'a> {
    surface: &'a Surface,
    /// Distance from which on nothing counts \[m\].
    cap: f64,
    deep: bool,
}

impl Looker<'_> {
    fn touch(&self, part: Part, at: Point, weights: [f64; 3]) -> Touch {
        let distance = self.surface.distance_to(part, &at);
        Touch {
            part,
            at,
            weights,
            value: distance.value,
            normal: distance.normal,
            share: 1.0,
        }
    }

    /// The nearest part of the whole surface, as one that may be deep inside needs it.
    fn deepest(&self, at: Point, weights: [f64; 3]) -> Option<Touch> {
        let part = self.surface.nearest(&at, f64::MAX)?;
        Some(self.touch(part, at, weights)).filter(|touch| touch.value < self.cap)
    }

    fn at_vertex(&self, p: &Point, triangles: &[u32], touches: &mut Vec<Touch>) {
        let weights = [1.0, 0.0, 0.0];
        if self.deep {
            touches.extend(self.deepest(*p, weights));
            return;
        }
        let mut parts: Vec<(Part, f64)> = Vec::with_capacity(triangles.len());
        for &t in triangles {
            let (part, foot) = self.surface.nearest_of(t, p);
            parts.push((part, (p - foot).norm()));
        }
        let Some(nearest) = parts.iter().min_by(|a, b| a.1.total_cmp(&b.1)).copied() else {
            return;
        };
        parts.retain(|(_, distance)| *distance < self.cap);
        parts.sort_by_key(|(part, _)| *part);
        let inside = self.surface.distance_to(nearest.0, p).value < 0.0;
        for group in parts.chunk_by(|a, b| a.0 == b.0) {
            let part = group[0].0;
            let counts = part == nearest.0 || (!inside && self.stands_alone(part, group.len(), p));
            let touch = self.touch(part, *p, weights);
            if counts && (touch.value < 0.0) == inside {
                touches.push(touch);
            }
        }
        if touches.len() > 1 {
            self.see(p, touches);
        }
        divide(touches);
    }

    /// Keeps what can be seen from a point: of thin plates, not the one behind.
    fn see(&self, p: &Point, touches: &mut Vec<Touch>) {
        let faces = touches.iter().filter_map(|touch| match touch.part {
            Part::Face(t) => Some(t),
            _ => None,
        });
        let faces: Vec<u32> = faces.collect();
        touches.retain(|touch| {
            // Not quite there: what it lies in is not in the way.
            let foot = p - touch.normal * (touch.value * NEARLY);
            let in_the_way = |t: &&u32| {
                touch.part != Part::Face(**t) && crosses([p, &foot], self.surface.corners(**t))
            };
            !faces.iter().any(|t| in_the_way(&t))
        });
    }

    /// Whether no triangle at a part is nearer than the part itself, which `count` of them found nearest; or whether it is
    /// the bottom of a valley.
    fn stands_alone(&self, part: Part, count: usize, p: &Point) -> bool {
        let body = &*self.surface.0;
        match part {
            Part::Face(_) => true,
            Part::Edge(e) => {
                let foot = self.surface.0.vertices[body.edges[e as usize][0] as usize];
                let above = |t: u32| body.normals[t as usize].dot(&(p - foot)) > 0.0;
                count == body.edge_faces[e as usize] as usize
                    || body.is_valley(e, body.edge_face[e as usize].map(above))
            }
            Part::Vertex(v) => count == body.vertex_faces[v as usize] as usize,
        }
    }

    /// Whether a part can be nearest: no triangle at it lies in the way; inside, that it is.
    fn may_be(&self, touch: &Touch) -> bool {
        let body = &*self.surface.0;
        let around = match touch.part {
            Part::Face(_) => return true,
            Part::Edge(e) => &body.around_edges[e as usize],
            Part::Vertex(v) => &body.around_vertices[v as usize],
        };
        if around.iter().any(|way| way.dot(&touch.normal) > IN_THE_WAY) {
            return false;
        }
        let off = || touch.value - self.surface.distance(&touch.at).value;
        touch.value >= 0.0 || off().abs() < TIE
    }

    fn at_edge(&self, [a, b]: [Point; 2], ridges: &[u32], touches: &mut Vec<Touch>) {
        if self.deep {
            let stations = STATIONS.iter();
            let all = stations.filter_map(|&t| self.deepest(a + (b - a) * t, [1.0 - t, t, 0.0]));
            touches.extend(all.min_by(|a, b| a.value.total_cmp(&b.value)));
            return;
        }
        let body = &*self.surface.0;
        for &ridge in ridges {
            let ends = body.edges[ridge as usize];
            let [c, d] = ends.map(|v| &body.vertices[v as usize]);
            let [s, t] = segment_to_segment(&a, &b, c, d);
            if s <= 0.0 || s >= 1.0 {
                continue;
            }
            let part = match t {
                0.0 => Part::Vertex(ends[0]),
                1.0 => Part::Vertex(ends[1]),
                _ => Part::Edge(ridge),
            };
            if touches.iter().all(|touch| touch.part != part) {
                let touch = self.touch(part, a + (b - a) * s, [1.0 - s, s, 0.0]);
                if touch.value.abs() < self.cap && self.may_be(&touch) {
                    touches.push(touch);
                }
            }
        }
        divide(touches);
    }

    fn at_face(&self, [a, b, c]: [Point; 3], tips: &[u32], touches: &mut Vec<Touch>) {
        if self.deep {
            touches.extend(self.deepest((a + b + c) / 3.0, [1.0 / 3.0; 3]));
            return;
        }
        for &tip in tips {
            let weights = point_to_face(&self.surface.0.vertices[tip as usize], [&a, &b, &c]);
            if weights.iter().all(|w| *w > INSIDE) {
                let at = a * weights[0] + b * weights[1] + c * weights[2];
                let touch = self.touch(Part::Vertex(tip), at, weights);
                if touch.value.abs() < self.cap && self.may_be(&touch) {
                    touches.push(touch);
                }
            }
        }
        divide(touches);
    }

    /// Takes off the share of what does not lie nearer than the rim of its feature.
    fn lead<'a>(&self, touches: &mut [Touch], rim: impl Iterator<Item = &'a Touch> + Clone) {
        for touch in touches {
            let beside = rim.clone().filter(|other| one_way(touch, other));
            let lowest = beside.map(|other| other.value).fold(self.cap, f64::min);
            touch.share *= share(lowest - touch.value);
        }
    }

    fn keep(
        &self,
        (kind, feature): (u64, u32),
        reach: f64,
        touches: &[Touch],
        found: &mut Vec<Found>,
    ) {
        let mut used: Vec<u8> = vec![];
        let near = |touch: &&Touch| touch.value < reach && touch.share > 0.0;
        for touch in touches.iter().filter(near) {
            let mut number = self.number(kind, touch.part);
            while used.contains(&number) {
                number = number.wrapping_add(1);
            }
            used.push(number);
            found.push(Found {
                kind,
                feature,
                number,
                weights: touch.weights,
                share: touch.share,
                part: touch.part,
                at: touch.at,
            });
        }
    }

    /// A number that a contact keeps while a vertex slides over a smooth part of the surface, or an edge along a ridge.
    fn number(&self, kind: u64, part: Part) -> u8 {
        let body = &*self.surface.0;
        let index = match (kind, part) {
            (0, Part::Face(t)) => body.patches[t as usize],
            (0, Part::Edge(e)) => body.patches[body.edge_face[e as usize][0] as usize],
            (0, Part::Vertex(v)) => body.patches[body.vertex_face[v as usize] as usize],
            (_, Part::Face(i) | Part::Edge(i) | Part::Vertex(i)) => i,
        };
        ((4 * index) % 256) as u8
    }
}

fn one_way(a: &Touch, b: &Touch) -> bool {
    a.normal.dot(&b.normal) > ONE_WAY
}

/// Divides one contact among points in nearly one direction, by how much farther each is than the nearest of them.
fn divide(touches: &mut Vec<Touch>) {
    if touches.len() < 2 {
        return;
    }
    let all = touches.clone();
    let parts: Vec<f64> = all
        .iter()
        .map(|touch| {
            let beside = all.iter().filter(|other| one_way(touch, other));
            let lowest = beside.map(|other| other.value).fold(touch.value, f64::min);
            share(LEAD - (touch.value - lowest))
        })
        .collect();
    for (touch, part) in touches.iter_mut().zip(&parts) {
        let beside = all
            .iter()
            .zip(&parts)
            .filter(|(other, _)| one_way(touch, other));
        let sum: f64 = beside.map(|(_, part)| part).sum();
        touch.share = if *part > 0.0 { part / sum } else { 0.0 };
    }
    touches.retain(|touch| touch.share > 0.0);
}
