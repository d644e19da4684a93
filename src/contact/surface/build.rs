//! From triangles to a surface: what shares what, which way is out, where it stands out.

use std::collections::BTreeMap;
use std::sync::Arc;

use parry3d_f64::partitioning::{Bvh, BvhBuildStrategy};
use xxhash_rust::xxh3::Xxh3;

use super::{Body, FARTHEST, MOST_TRIANGLES, Point, Surface, SurfaceError, Triangles, box_around};

/// Angle between triangles up to which they are one plane \[rad\].
const FLAT: f64 = 1e-4;
/// Angle between triangles up to which they are one smooth part \[rad\].
const SMOOTH: f64 = 0.8;
/// Twice the area over the square of the longest side up to which a triangle has no normal worth the name.
const SLENDER: f64 = 1e-7;

impl TryFrom<Triangles> for Surface {
    type Error = SurfaceError;

    fn try_from(given: Triangles) -> Result<Self, SurfaceError> {
        check(&given)?;
        let vertices: Vec<Point> = given.vertices.iter().map(|p| Point::from(*p)).collect();
        let corners = |t: usize| given.triangles[t].map(|v| vertices[v as usize]);
        let normals = normals(given.triangles.len(), corners)?;
        let leaves: Vec<_> = (0..normals.len())
            .map(|t| box_around(&corners(t), 0.0))
            .collect();
        let tree = Bvh::from_leaves(BvhBuildStrategy::Binned, &leaves);
        let digest = digest(&given);
        let mut body = Body {
            vertices,
            normals,
            edges: vec![],
            sides: vec![],
            edge_normals: vec![],
            vertex_normals: vec![],
            edge_faces: vec![],
            vertex_faces: vec![],
            folds: vec![],
            around_edges: vec![],
            around_vertices: vec![],
            patches: vec![],
            edge_face: vec![],
            vertex_face: vec![],
            closed: false,
            tree,
            digest,
            given,
        };
        let beside = body.join();
        body.closed = body.turn_out(&beside);
        body.fold(&beside);
        body.average(&beside);
        body.spread(&beside);
        Ok(Self(Arc::new(body)))
    }
}

fn check(given: &Triangles) -> Result<(), SurfaceError> {
    match given.triangles.len() {
        0 => return Err(SurfaceError::Empty),
        found if found > MOST_TRIANGLES => return Err(SurfaceError::TooMany { found }),
        _ => {}
    }
    for (vertex, p) in given.vertices.iter().enumerate() {
        if let Some(&value) = p.iter().find(|c| !(-FARTHEST..=FARTHEST).contains(*c)) {
            return Err(SurfaceError::Place { vertex, value });
        }
    }
    for (triangle, corners) in given.triangles.iter().enumerate() {
        let beyond = |v: &&u32| **v as usize >= given.vertices.len();
        if let Some(&index) = corners.iter().find(beyond) {
            let last = given.vertices.len().saturating_sub(1);
            return Err(SurfaceError::Index {
                triangle,
                index,
                last,
            });
        }
    }
    Ok(())
}

fn normals(
    count: usize,
    corners: impl Fn(usize) -> [Point; 3],
) -> Result<Vec<Point>, SurfaceError> {
    let normal = |triangle: usize| {
        let [a, b, c] = corners(triangle);
        let twice_area = (b - a).cross(&(c - a));
        let longest = (b - a).norm().max((c - b).norm()).max((a - c).norm());
        let size = twice_area.norm();
        match size > SLENDER * longest * longest {
            true => Ok(twice_area / size),
            false => Err(SurfaceError::Degenerate { triangle }),
        }
    };
    (0..count).map(normal).collect()
}

fn digest(given: &Triangles) -> u64 {
    let mut digest = Xxh3::new();
    digest.update(&(given.vertices.len() as u64).to_le_bytes());
    let numbers = given.vertices.iter().flatten();
    numbers.for_each(|c| digest.update(&c.to_le_bytes()));
    let corners = given.triangles.iter().flatten();
    corners.for_each(|v| digest.update(&v.to_le_bytes()));
    digest.digest()
}

/// The triangles at each edge, each with its corner opposite to the edge.
type Beside = Vec<Vec<(u32, u8)>>;

impl Body {
    /// Numbers the edges.
    fn join(&mut self) -> Beside {
        let mut known = BTreeMap::new();
        let mut beside: Beside = vec![];
        self.vertex_faces = vec![0; self.vertices.len()];
        self.vertex_face = vec![0; self.vertices.len()];
        for (t, corners) in self.given.triangles.iter().enumerate() {
            let side = |k: usize| {
                let [a, b] = [corners[(k + 1) % 3], corners[(k + 2) % 3]];
                let ends = [a.min(b), a.max(b)];
                let edge = *known.entry(ends).or_insert(self.edges.len() as u32);
                if edge as usize == self.edges.len() {
                    self.edges.push(ends);
                    beside.push(vec![]);
                }
                beside[edge as usize].push((t as u32, k as u8));
                edge
            };
            self.sides.push([0, 1, 2].map(side));
            for &v in corners {
                self.vertex_faces[v as usize] += 1;
                self.vertex_face[v as usize] = t as u32;
            }
        }
        self.edge_faces = beside.iter().map(|list| list.len() as u32).collect();
        self.edge_face = beside
            .iter()
            .map(|list| [list[0].0, list[list.len() - 1].0])
            .collect();
        beside
    }

    /// Whether a triangle runs along an edge from its first end to the second.
    fn runs_along(&self, (t, k): (u32, u8)) -> bool {
        let corners = self.given.triangles[t as usize];
        corners[(usize::from(k) + 1) % 3] < corners[(usize::from(k) + 2) % 3]
    }

    /// Turns the normals so that neighbours agree, out of what they enclose; says whether they enclose something.
    fn turn_out(&mut self, beside: &Beside) -> bool {
        let mut sign = vec![0.0; self.sides.len()];
        let (mut agree, mut turned) = (true, false);
        let mut volume = 0.0;
        for seed in 0..sign.len() {
            if sign[seed] != 0.0 {
                continue;
            }
            sign[seed] = 1.0;
            let mut stack = vec![seed as u32];
            let mut part = vec![];
            while let Some(t) = stack.pop() {
                part.push(t as usize);
                for e in self.sides[t as usize] {
                    let &[one, other] = &beside[e as usize][..] else {
                        continue;
                    };
                    let neighbour = if one.0 == t { other.0 } else { one.0 } as usize;
                    let same = self.runs_along(one) != self.runs_along(other);
                    let wanted = if same {
                        sign[t as usize]
                    } else {
                        -sign[t as usize]
                    };
                    if sign[neighbour] == 0.0 {
                        sign[neighbour] = wanted;
                        turned |= !same;
                        stack.push(neighbour as u32);
                    }
                    agree &= sign[neighbour] == wanted;
                }
            }
            let inside: f64 = part.iter().map(|&t| sign[t] * self.cone(t)).sum();
            if turned && inside < 0.0 {
                part.iter().for_each(|&t| sign[t] = -sign[t]);
            }
            volume += if turned { inside.abs() } else { inside };
        }
        let closed = agree && beside.iter().all(|list| list.len() == 2);
        let all = if closed && volume < 0.0 { -1.0 } else { 1.0 };
        for (normal, sign) in self.normals.iter_mut().zip(sign) {
            *normal *= sign * all;
        }
        closed
    }

    /// Six times the volume between a triangle and the first vertex.
    fn cone(&self, t: usize) -> f64 {
        let origin = self.vertices[0];
        let [a, b, c] = self.given.triangles[t].map(|v| self.vertices[v as usize] - origin);
        a.dot(&b.cross(&c))
    }

    /// How the triangles at each edge are folded, and which make up a smooth part.
    fn fold(&mut self, beside: &Beside) {
        let fold = |(e, list): (usize, &Vec<(u32, u8)>)| {
            let &[one, other] = &list[..] else {
                return f64::NEG_INFINITY;
            };
            let corner = |(t, k): (u32, u8)| {
                self.vertices[self.given.triangles[t as usize][usize::from(k)] as usize]
            };
            let [a, b] = self.edges[e].map(|v| self.vertices[v as usize]);
            let normal = self.normals[one.0 as usize];
            let mut ahead = normal.cross(&(b - a)).normalize();
            if ahead.dot(&(corner(one) - a)) > 0.0 {
                ahead = -ahead;
            }
            let tip = corner(other) - a;
            f64::atan2(tip.dot(&normal), tip.dot(&ahead))
        };
        self.folds = beside.iter().enumerate().map(fold).collect();
        self.patches = vec![u32::MAX; self.sides.len()];
        let mut count = 0;
        for seed in 0..self.sides.len() {
            if self.patches[seed] != u32::MAX {
                continue;
            }
            let mut stack = vec![seed];
            self.patches[seed] = count;
            while let Some(t) = stack.pop() {
                for e in self.sides[t] {
                    let smooth = self.folds[e as usize].abs() < SMOOTH;
                    for &(next, _) in beside[e as usize].iter().filter(|_| smooth) {
                        if self.patches[next as usize] == u32::MAX {
                            self.patches[next as usize] = count;
                            stack.push(next as usize);
                        }
                    }
                }
            }
            count += 1;
        }
    }

    /// Whether something flat can come to rest on an edge.
    pub(super) fn stands_out(&self, edge: u32) -> bool {
        let fold = self.folds[edge as usize];
        fold < -FLAT || (!self.closed && fold > FLAT)
    }

    /// Whether an edge is the bottom of a valley, seen from a point that is above its two triangles or not, as their
    /// normals point.
    pub(super) fn is_valley(&self, edge: u32, above: [bool; 2]) -> bool {
        let fold = self.folds[edge as usize];
        match fold.is_finite() {
            true if fold > FLAT => above == [true; 2],
            true if fold < -FLAT => above == [false; 2] && !self.closed,
            _ => false,
        }
    }

    /// Which ways the surface goes from edges and vertices.
    fn spread(&mut self, beside: &Beside) {
        let at = |v: u32| self.vertices[v as usize];
        let ways = |(e, list): (usize, &Vec<(u32, u8)>)| {
            let [a, b] = self.edges[e].map(at);
            let along = (b - a).normalize();
            let way = |&(t, k): &(u32, u8)| {
                let off = at(self.given.triangles[t as usize][usize::from(k)]) - a;
                (off - along * along.dot(&off)).normalize()
            };
            list.iter().map(way).collect()
        };
        self.around_edges = beside.iter().enumerate().map(ways).collect();
        self.around_vertices = vec![vec![]; self.vertices.len()];
        for &[a, b] in &self.edges {
            let along = (self.vertices[b as usize] - self.vertices[a as usize]).normalize();
            self.around_vertices[a as usize].push(along);
            self.around_vertices[b as usize].push(-along);
        }
    }

    /// Means of the normals around edges and, weighted by angle, vertices.
    fn average(&mut self, beside: &Beside) {
        let mean = |list: &Vec<(u32, u8)>| {
            let sum: Point = list.iter().map(|&(t, _)| self.normals[t as usize]).sum();
            sum.try_normalize(0.0).unwrap_or_else(Point::z)
        };
        self.edge_normals = beside.iter().map(mean).collect();
        let mut sums = vec![Point::zeros(); self.vertices.len()];
        for (t, corners) in self.given.triangles.iter().enumerate() {
            for k in 0..3 {
                let [p, q, r] = [0, 1, 2].map(|j| self.vertices[corners[(k + j) % 3] as usize]);
                sums[corners[k] as usize] += self.normals[t] * (q - p).angle(&(r - p));
            }
        }
        let unit = |sum: &Point| sum.try_normalize(0.0).unwrap_or_else(Point::z);
        self.vertex_normals = sums.iter().map(unit).collect();
    }
}
