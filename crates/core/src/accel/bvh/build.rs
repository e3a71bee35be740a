//! Building the tree from the top: a node's box is divided in two again and again, the largest
//! part first, until there are eight.
//!
//! The tree is a function of the boxes alone: threads share nothing, and each part's order is
//! made by one of them.

use glam::Vec3;

use super::node::{Link, MAX_PRIMITIVES, Node, WIDTH};
use super::split::{Box4, Ref, Split};
use super::{Bvh, MAX_DEPTH, MAX_LEAF};
use crate::math::Aabb;

/// Subtrees of at most so many primitives are built by one thread.
const SERIAL: usize = 4096;

/// From this depth on, parts are halved by number, so that 2²⁸ primitives stay within
/// [`MAX_DEPTH`]: each level then divides by four at least.
const HALVE_FROM: usize = MAX_DEPTH - 14;

/// A tree, and the order in which it wants its primitives.
#[derive(Debug)]
pub struct Built {
    /// The tree.
    pub tree: Bvh,
    /// Ids of the primitives, in the order in which the tree's leaves count them.
    pub order: Vec<u32>,
    /// Number of primitives of each leaf, in the same order; 1 to [`MAX_LEAF`].
    pub runs: Vec<u8>,
}

impl Bvh {
    /// Builds the tree over primitives 0, 1, … with boxes `bounds`; the same tree at any number
    /// of threads. Primitives with an empty box are left out.
    ///
    /// # Panics
    /// With 2²⁸ primitives or more.
    pub fn build(bounds: &[Aabb]) -> Built {
        assert!(
            bounds.len() < MAX_PRIMITIVES,
            "bvh: {} primitives are too many",
            bounds.len()
        );
        let mut refs: Vec<Ref> = (0..)
            .zip(bounds)
            .filter(|(_, b)| !b.is_empty())
            .map(|(id, b)| Ref::new(b, id))
            .collect();
        let whole = Part::new(&mut refs);
        let bounds = whole.bounds.aabb();
        let center = bounds.center();
        let mut subtree = Subtree::default();
        if !whole.refs.is_empty() {
            subtree.nodes.push(Node::EMPTY);
            subtree.nodes[0] = grow(whole, 0, center, &mut subtree);
        }
        subtree.nodes.shrink_to_fit();
        Built {
            tree: Self {
                bounds,
                center,
                nodes: subtree.nodes,
            },
            order: subtree.order,
            runs: subtree.runs,
        }
    }
}

/// Nodes and leaves below some node; their links count from their own start.
#[derive(Default)]
struct Subtree {
    nodes: Vec<Node>,
    order: Vec<u32>,
    runs: Vec<u8>,
}

impl Subtree {
    /// Puts another subtree behind, and gives by how much its links moved.
    fn append(&mut self, other: &Self) -> (u32, u32) {
        let by = (self.nodes.len() as u32, self.order.len() as u32);
        let moved = other.nodes.iter().map(|node| node.moved(by.0, by.1));
        self.nodes.extend(moved);
        self.order.extend_from_slice(&other.order);
        self.runs.extend_from_slice(&other.runs);
        by
    }
}

/// Primitives that go into one child, with the best way to divide them.
struct Part<'a> {
    refs: &'a mut [Ref],
    bounds: Box4,
    split: Option<Split>,
}

impl<'a> Part<'a> {
    fn new(refs: &'a mut [Ref]) -> Self {
        let (bounds, centers) = Ref::bounds(refs);
        Self::with_bounds(refs, bounds, centers)
    }

    fn with_bounds(refs: &'a mut [Ref], bounds: Box4, centers: Box4) -> Self {
        let split = Split::best(refs, &centers);
        Self {
            refs,
            bounds,
            split,
        }
    }

    /// Whether two parts are expected to cost less than one, if the node has room.
    fn gains(&self) -> bool {
        if self.refs.len() > MAX_LEAF {
            return true;
        }
        self.split.as_ref().is_some_and(|split| {
            let leaf = |count: usize| LEAF_COST + TRIANGLE_COST * count as f64;
            let [below, above] = split.counts.map(|n| leaf(n as usize));
            split.areas[0] * below + split.areas[1] * above
                < self.bounds.half_area() * leaf(self.refs.len())
        })
    }

    /// Divides by the best split, or by number where there is none.
    fn divide(self, halve: bool) -> [Self; 2] {
        let Self { refs, split, .. } = self;
        if let Some(split) = split.filter(|_| !halve) {
            let (count, centers) = split.partition(refs);
            let (below, above) = refs.split_at_mut(count);
            let [a, b] = split.bounds;
            return [
                Part::with_bounds(below, a, centers[0]),
                Part::with_bounds(above, b, centers[1]),
            ];
        }
        let (below, above) = refs.split_at_mut(refs.len() / 2);
        [Part::new(below), Part::new(above)]
    }
}

/// Cost of visiting a leaf, and of each primitive in it, in the same unit.
const LEAF_COST: f64 = 1.0;
const TRIANGLE_COST: f64 = 0.3;

/// Makes a node of a part and appends all below it to `out`.
fn grow(part: Part<'_>, depth: usize, center: Vec3, out: &mut Subtree) -> Node {
    let halve = depth >= HALVE_FROM;
    let mut parts = Vec::with_capacity(WIDTH);
    parts.push(part);
    while parts.len() < WIDTH {
        let size = |p: &Part<'_>| {
            if halve {
                p.refs.len() as f64
            } else {
                p.bounds.half_area()
            }
        };
        let mut largest: Option<(f64, usize)> = None;
        for (i, part) in parts.iter().enumerate() {
            if part.refs.len() > 1 && part.gains() && largest.is_none_or(|(s, _)| size(part) > s) {
                largest = Some((size(part), i));
            }
        }
        let Some((_, i)) = largest else {
            break;
        };
        let [below, above] = parts.swap_remove(i).divide(halve);
        parts.extend([below, above]);
    }
    let boxes: [Aabb; WIDTH] = std::array::from_fn(|i| match parts.get(i) {
        Some(part) => part.bounds.aabb(),
        None => Aabb::EMPTY,
    });
    let mut node = Node::new(&boxes[..parts.len()], center);
    // Leaves of a node lie together, and so do its inner children.
    let mut inner = Vec::with_capacity(WIDTH);
    for (i, part) in parts.into_iter().enumerate() {
        if part.refs.len() > MAX_LEAF {
            node.children[i] = Link((out.nodes.len() + inner.len()) as u32);
            inner.push(part);
        } else {
            node.children[i] = Link::to_leaf(out.order.len(), part.refs.len());
            out.order.extend(part.refs.iter().map(Ref::id));
            out.runs.push(part.refs.len() as u8);
        }
    }
    let first = out.nodes.len();
    out.nodes.resize(first + inner.len(), Node::EMPTY);
    let total: usize = inner.iter().map(|p| p.refs.len()).sum();
    if total <= SERIAL {
        for (i, part) in inner.into_iter().enumerate() {
            out.nodes[first + i] = grow(part, depth + 1, center, out);
        }
        return node;
    }
    use rayon::prelude::*;
    let subtrees: Vec<(Node, Subtree)> = inner
        .into_par_iter()
        .map(|part| {
            let mut below = Subtree::default();
            (grow(part, depth + 1, center, &mut below), below)
        })
        .collect();
    for (i, (root, below)) in subtrees.iter().enumerate() {
        let by = out.append(below);
        out.nodes[first + i] = root.moved(by.0, by.1);
    }
    node
}
