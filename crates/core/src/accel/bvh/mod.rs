//! The wide tree: a bounding volume hierarchy with up to eight children per node and up to eight
//! primitives per leaf, so that the boxes of a node, and the primitives of a leaf, are tested at
//! once.

mod boxes;
mod build;
mod node;
mod part;
mod partition;
mod slopes;
mod sorted;
mod split;
mod stream;
mod turns;
mod walk;

#[cfg(test)]
pub(super) mod test;

use glam::Vec3;

use super::{TreeStats, half_area};
use crate::math::Aabb;
use node::{Link, Node, WIDTH};

pub use boxes::Ordered;
pub use build::Built;

pub(crate) use node::MAX_PRIMITIVES;
pub(crate) use part::in_a_row;
pub(crate) use slopes::{Along, OCTANTS, Octant};
pub(crate) use sorted::Sorted;
pub(crate) use stream::{Lists, Stream};
pub(crate) use walk::Leaves;

/// Greatest number of inner nodes on a path from the root.
const MAX_DEPTH: usize = 32;

/// Most primitives in a leaf.
pub const MAX_LEAF: usize = 8;

/// A bounding volume hierarchy over primitives known by box, built for least expected cost under
/// the surface-area heuristic with binning (Wald 2007).
///
/// A walk shows a visitor every primitive that it could accept, so that what the visitor
/// makes of them is bit for bit what it makes of all primitives, if that does not depend on
/// their order. That holds for coordinates between 2⁻⁶⁰ and 2⁶⁰, beyond which the primitives' own
/// tests leave the range of f32.
#[derive(Debug)]
pub struct Bvh {
    bounds: Aabb,
    /// What nodes' boxes are relative to.
    center: Vec3,
    /// The root first; none if there are no primitives.
    nodes: Vec<Node>,
}

impl Bvh {
    /// Measures the tree, by a walk over all nodes.
    pub fn stats(&self) -> TreeStats {
        let mut stats = TreeStats {
            nodes: self.nodes.len(),
            bytes: self.bytes(),
            ..TreeStats::default()
        };
        let mut cost = 0.0;
        self.for_each(|link, bounds, depth| {
            cost += half_area(bounds);
            if link.inner().is_none() {
                stats.leaves += 1;
                stats.references += link.leaf().1 as usize;
                stats.max_depth = stats.max_depth.max(depth);
            }
        });
        let root = half_area(&self.bounds);
        if root > 0.0 {
            stats.sah_cost = cost / root;
        }
        stats
    }

    /// Memory of the nodes.
    pub fn bytes(&self) -> usize {
        size_of_val(&*self.nodes)
    }

    /// Calls `f(link, box, depth)` for every node and leaf.
    fn for_each(&self, mut f: impl FnMut(Link, &Aabb, usize)) {
        let mut pending = vec![];
        if !self.nodes.is_empty() {
            pending.push((Link::ROOT, self.bounds, 0));
        }
        while let Some((link, bounds, depth)) = pending.pop() {
            f(link, &bounds, depth);
            let Some(index) = link.inner() else {
                continue;
            };
            let node = &self.nodes[index as usize];
            for i in (0..WIDTH).filter(|&i| node.has(i)) {
                let corner =
                    |side: usize| self.center + Vec3::from_array(node.planes.map(|p| p[side][i]));
                let bounds = Aabb {
                    min: corner(0),
                    max: corner(1),
                };
                pending.push((Link(node.children[i]), bounds, depth + 1));
            }
        }
    }
}
