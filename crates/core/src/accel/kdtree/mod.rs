//! The kd-tree. In: boxes, and a function that clips primitives by id. Out: the ids of the
//! primitives that a ray may hit, nearest cells first. It never sees a shape.

mod build;
mod eight;
mod events;
mod node;
mod traverse;

#[cfg(test)]
pub(super) mod test;

use super::{TreeStats, half_area};
use crate::math::Aabb;
pub(crate) use eight::{Eight, Stack};
use node::{Kind, Node};

/// Greatest depth of a leaf, and so the capacity of the traversal stack.
const MAX_DEPTH: usize = 48;

/// Cost of visiting an inner node, in the unit of [`INTERSECTION_COST`].
const TRAVERSAL_COST: f64 = 1.0;

/// Cost of testing a primitive: what a ray spends on it, measured against an inner node.
const INTERSECTION_COST: f64 = 0.8;

/// A kd-tree over primitives known by id and box, built greedily for least expected cost under
/// the surface-area heuristic (MacDonald & Booth 1990; Wald & Havran 2006).
///
/// [`KdTree::walk`] shows a visitor every primitive that it could accept, so that what the
/// visitor makes of them is bit for bit what it makes of all primitives one after the other.
/// That holds for coordinates between 2⁻⁶⁰ and 2⁶⁰, beyond which the primitives' own tests leave
/// the range of f32.
#[derive(Debug)]
pub struct KdTree {
    bounds: Aabb,
    /// The root first; see [`Node`].
    nodes: Vec<Node>,
    /// Primitives of leaves, by leaf, ascending.
    ids: Vec<u32>,
}

impl KdTree {
    /// Measures the tree, by a walk over all nodes.
    pub fn stats(&self) -> TreeStats {
        let mut stats = TreeStats {
            nodes: self.nodes.len(),
            bytes: self.bytes(),
            ..TreeStats::default()
        };
        let mut cost = 0.0;
        self.for_each_cell(|node, cell, depth| match node.kind() {
            Kind::Inner { .. } => cost += TRAVERSAL_COST * half_area(cell),
            Kind::Leaf { count, .. } => {
                stats.leaves += 1;
                stats.references += count as usize;
                stats.max_depth = stats.max_depth.max(depth);
                cost += INTERSECTION_COST * f64::from(count) * half_area(cell);
            }
        });
        let root = half_area(&self.bounds);
        if root > 0.0 {
            stats.sah_cost = cost / root;
        }
        stats
    }

    /// Memory of nodes and lists.
    pub fn bytes(&self) -> usize {
        size_of_val(&self.nodes[..]) + size_of_val(&self.ids[..])
    }

    /// Calls `f(node, cell, depth)` for every node.
    fn for_each_cell(&self, mut f: impl FnMut(Node, &Aabb, usize)) {
        let mut pending = vec![(0, self.bounds, 0)];
        while let Some((index, cell, depth)) = pending.pop() {
            let node = self.nodes[index as usize];
            f(node, &cell, depth);
            if let Kind::Inner { axis, split, below } = node.kind() {
                let [cell_below, cell_above] = halves(&cell, axis, split);
                pending.push((below + 1, cell_above, depth + 1));
                pending.push((below, cell_below, depth + 1));
            }
        }
    }
}

/// The parts of a cell on either side of a plane.
fn halves(cell: &Aabb, axis: usize, split: f32) -> [Aabb; 2] {
    let (mut below, mut above) = (*cell, *cell);
    below.max[axis] = split;
    above.min[axis] = split;
    [below, above]
}
