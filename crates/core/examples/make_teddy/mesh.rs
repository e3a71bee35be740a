//! A closed triangle mesh, with the two edits that improve it: collapsing and flipping an edge.
//!
//! Edits go in passes. A pass looks the neighbourhoods up once, and every edit locks the vertices
//! that it touches until the next pass, so that no edit sees a neighbourhood out of date.

use glam::DVec3;

use super::implicit::Solid;

/// Smallest cosine between a triangle and the solid's normal after an edit: no edit folds the mesh.
const MIN_ALIGNMENT: f64 = 0.3;
/// A flip must make the worse triangle rounder by this factor, so that ties do not flip for ever.
const MIN_FLIP_GAIN: f64 = 1.001;

/// A closed manifold mesh; triangles run counter-clockwise seen from outside.
pub struct Mesh {
    pub positions: Vec<DVec3>,
    pub triangles: Vec<[usize; 3]>,
}

/// The triangles around each vertex.
pub struct Fans(Vec<Vec<usize>>);

impl Fans {
    pub fn of(mesh: &Mesh) -> Self {
        let mut fans = vec![Vec::with_capacity(6); mesh.positions.len()];
        for (id, triangle) in mesh.triangles.iter().enumerate() {
            triangle.iter().for_each(|&v| fans[v].push(id));
        }
        Self(fans)
    }

    /// The triangles around a vertex, in no particular order.
    pub fn around(&self, vertex: usize) -> &[usize] {
        &self.0[vertex]
    }
}

impl Mesh {
    /// The corners of a triangle.
    pub fn corners(&self, [a, b, c]: [usize; 3]) -> [DVec3; 3] {
        [self.positions[a], self.positions[b], self.positions[c]]
    }

    /// Every edge once, its smaller vertex first.
    pub fn edges(&self) -> impl Iterator<Item = [usize; 2]> {
        self.triangles
            .iter()
            .flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]])
            .filter(|[from, to]| from < to)
    }

    /// The vertices that share an edge with `vertex`, each once: around a closed fan every
    /// neighbour comes next after `vertex` in exactly one triangle.
    pub fn neighbors(&self, fans: &Fans, vertex: usize) -> impl Iterator<Item = usize> {
        fans.around(vertex)
            .iter()
            .map(move |&id| rotated(self.triangles[id], vertex)[1])
    }

    /// Collapses up to `budget` edges, first those shortest for the `sizes` wanted at their ends,
    /// each to a point on the surface of `solid` close to its midpoint. Returns how many.
    pub fn collapse(&mut self, solid: &Solid, sizes: &[f64], budget: usize) -> usize {
        let fans = Fans::of(self);
        let length = |[a, b]: [usize; 2]| {
            self.positions[a].distance(self.positions[b]) / (sizes[a] + sizes[b])
        };
        let mut edges: Vec<(f64, [usize; 2])> =
            self.edges().map(|edge| (length(edge), edge)).collect();
        edges.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));

        let mut locked = vec![false; self.positions.len()];
        let mut dropped = vec![false; self.triangles.len()];
        let mut collapsed = 0;
        for (_, [kept, gone]) in edges {
            if collapsed == budget {
                break;
            }
            let around_kept: Vec<usize> = self.neighbors(&fans, kept).collect();
            let around_gone: Vec<usize> = self.neighbors(&fans, gone).collect();
            let ring = around_kept.iter().chain(&around_gone);
            // The ends share two neighbours; through a third the collapse would pinch the surface.
            let shared = around_kept
                .iter()
                .filter(|v| around_gone.contains(v))
                .count();
            if shared != 2 || ring.clone().any(|&v| locked[v]) {
                continue;
            }
            let point = solid.project(self.positions[kept].midpoint(self.positions[gone]));
            let normal = solid.normal(point);
            let (dying, moving): (Vec<usize>, Vec<usize>) = fans
                .around(kept)
                .iter()
                .chain(fans.around(gone))
                .partition(|&&id| {
                    let triangle = self.triangles[id];
                    triangle.contains(&kept) && triangle.contains(&gone)
                });
            let moved = |v: usize| {
                if v == kept || v == gone {
                    point
                } else {
                    self.positions[v]
                }
            };
            if moving
                .iter()
                .any(|&id| alignment(self.triangles[id].map(moved), normal) < MIN_ALIGNMENT)
            {
                continue;
            }
            self.positions[kept] = point;
            moving.iter().for_each(|&id| {
                self.triangles[id] = self.triangles[id].map(|v| if v == gone { kept } else { v });
            });
            dying.iter().for_each(|&id| dropped[id] = true);
            ring.for_each(|&v| locked[v] = true);
            collapsed += 1;
        }
        self.compact(&dropped);
        collapsed
    }

    /// Flips every edge whose two triangles the other diagonal would make rounder.
    pub fn flip(&mut self, solid: &Solid) {
        let fans = Fans::of(self);
        let mut locked = vec![false; self.positions.len()];
        let edges: Vec<[usize; 2]> = self.edges().collect();
        for [a, b] in edges {
            if locked[a] || locked[b] {
                continue;
            }
            // The triangle left of the way from a to b has b next after a, the right one has it last.
            let with_b = |at: usize| {
                let holds_b = |id: &&usize| rotated(self.triangles[**id], a)[at] == b;
                fans.around(a).iter().find(holds_b).copied()
            };
            let (Some(left), Some(right)) = (with_b(1), with_b(2)) else {
                continue;
            };
            let c = rotated(self.triangles[left], a)[2];
            let d = rotated(self.triangles[right], a)[1];
            // No edge may come twice, and no vertex may lose its third triangle.
            let joined = self.neighbors(&fans, c).any(|v| v == d);
            let thin = fans.around(a).len() < 4 || fans.around(b).len() < 4;
            if locked[c] || locked[d] || joined || thin {
                continue;
            }
            let (old, new) = ([[a, b, c], [b, a, d]], [[c, a, d], [d, b, c]]);
            let worst = |pair: [[usize; 3]; 2]| {
                pair.map(|t| roundness(self.corners(t)))
                    .into_iter()
                    .fold(f64::MAX, f64::min)
            };
            if worst(new) <= worst(old) * MIN_FLIP_GAIN {
                continue;
            }
            let normal = solid.normal(self.positions[a].midpoint(self.positions[b]));
            if new
                .iter()
                .any(|&t| alignment(self.corners(t), normal) < MIN_ALIGNMENT)
            {
                continue;
            }
            self.triangles[left] = new[0];
            self.triangles[right] = new[1];
            [a, b, c, d].iter().for_each(|&v| locked[v] = true);
        }
    }

    /// Removes dropped triangles and the vertices that no triangle uses any more.
    fn compact(&mut self, dropped: &[bool]) {
        let mut ids = 0..;
        self.triangles
            .retain(|_| ids.next().is_some_and(|id: usize| !dropped[id]));
        let mut renamed = vec![usize::MAX; self.positions.len()];
        self.triangles
            .iter()
            .flatten()
            .for_each(|&v| renamed[v] = v);
        let mut kept = Vec::with_capacity(self.positions.len());
        for (name, &position) in renamed.iter_mut().zip(&self.positions) {
            if *name != usize::MAX {
                *name = kept.len();
                kept.push(position);
            }
        }
        self.positions = kept;
        self.triangles
            .iter_mut()
            .flatten()
            .for_each(|v| *v = renamed[*v]);
    }
}

/// The same triangle, starting at `first`.
fn rotated([a, b, c]: [usize; 3], first: usize) -> [usize; 3] {
    match first {
        f if f == b => [b, c, a],
        f if f == c => [c, a, b],
        _ => [a, b, c],
    }
}

/// The cosine between a triangle's normal and `normal`.
fn alignment([a, b, c]: [DVec3; 3], normal: DVec3) -> f64 {
    (b - a).cross(c - a).normalize_or_zero().dot(normal)
}

/// The area over the sum of the squared edges: √3/12 for an equilateral triangle, the most, and 0
/// for a degenerate one.
fn roundness([a, b, c]: [DVec3; 3]) -> f64 {
    let squares = (b - a).length_squared() + (c - b).length_squared() + (a - c).length_squared();
    (b - a).cross(c - a).length() / (2.0 * squares)
}
