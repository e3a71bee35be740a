//! Building the tree from the top: a node's box is divided in two again and again, the largest
//! part first, until there are eight.
//!
//! The tree is a function of the boxes alone: threads share nothing, and each part's order is
//! made by one of them.

use glam::Vec3;
use rayon::prelude::*;

use super::node::{Link, MAX_PRIMITIVES, Node, WIDTH};
use super::split::{Box4, Ref, Split};
use super::{Bvh, MAX_DEPTH, MAX_LEAF};
use crate::accel::progress::{Progress, Task};
use crate::math::Aabb;

/// Subtrees of at most so many primitives are built by one thread.
const SERIAL: usize = 4096;

/// From this depth on, parts are halved by number, so that 2²⁸ primitives stay within
/// [`MAX_DEPTH`]: each level then divides by four at least.
const HALVE_FROM: usize = MAX_DEPTH - 14;

/// Cost of visiting a leaf, and of each primitive in it, in the same unit.
const LEAF_COST: f32 = 1.0;
const PRIMITIVE_COST: f32 = 0.3;

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
    /// Builds the tree over primitives 0 to `count` − 1 with boxes `bounds(id)`; the same tree at
    /// any number of threads. Primitives with an empty box are left out.
    ///
    /// # Panics
    /// With 2²⁸ primitives or more.
    pub fn build(count: usize, bounds: impl Fn(u32) -> Aabb + Sync) -> Built {
        Self::build_watched(count, bounds, &Progress::unwatched())
    }

    /// [`Self::build`] whose progress is watched; if it is ended before time, the tree means nothing.
    pub fn build_watched(
        count: usize,
        bounds: impl Fn(u32) -> Aabb + Sync,
        progress: &Progress<'_>,
    ) -> Built {
        assert!(
            count < MAX_PRIMITIVES,
            "bvh: {count} primitives are too many"
        );
        let mut refs: Vec<Ref> = (0..count as u32)
            .into_par_iter()
            .map(|id| Ref::new(&bounds(id), id))
            .collect();
        refs.retain(|r| !r.is_empty());
        let whole = Part::new(&mut refs);
        let bounds = whole.bounds.aabb();
        let center = bounds.center();
        let mut subtree = Subtree::default();
        if !whole.refs.is_empty() {
            subtree.nodes.push(Node::EMPTY);
            let builder = Builder {
                center,
                progress,
                task: Task::new(whole.refs.len(), SERIAL),
            };
            subtree.nodes[0] = builder.grow(whole, 0, &mut subtree);
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
    fn append(&mut self, other: Self) -> (u32, u32) {
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
    half_area: f32,
    split: Option<Split>,
    /// Whether two parts are expected to cost less than one, if the node has room.
    divides: bool,
}

impl<'a> Part<'a> {
    fn new(refs: &'a mut [Ref]) -> Self {
        let (bounds, centers) = Ref::bounds(refs);
        Self::with_bounds(refs, bounds, centers)
    }

    fn with_bounds(refs: &'a mut [Ref], bounds: Box4, centers: Box4) -> Self {
        let split = Split::best(refs, &centers);
        let half_area = bounds.half_area();
        let leaf = |area: f32, count: usize| area * (LEAF_COST + PRIMITIVE_COST * count as f32);
        let divides = refs.len() > MAX_LEAF
            || split.as_ref().is_some_and(|split| {
                let side = |i: usize| leaf(split.bounds[i].half_area(), split.counts[i] as usize);
                side(0) + side(1) < leaf(half_area, refs.len())
            });
        Self {
            refs,
            bounds,
            half_area,
            split,
            divides,
        }
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

/// What every part of the build needs to know.
struct Builder<'a> {
    center: Vec3,
    progress: &'a Progress<'a>,
    task: Task,
}

impl Builder<'_> {
    /// Makes a node of a part and appends all below it to `out`.
    fn grow(&self, part: Part<'_>, depth: usize, out: &mut Subtree) -> Node {
        let halve = depth >= HALVE_FROM;
        let mut parts = [const { None }; WIDTH];
        parts[0] = Some(part);
        let mut count = 1;
        while count < WIDTH {
            // The largest; of equals the one with the most in it.
            let mut largest: Option<((f32, usize), usize)> = None;
            for (i, part) in parts.iter().flatten().enumerate() {
                let area = if halve { 0.0 } else { part.half_area };
                let size = (area, part.refs.len());
                if part.divides && largest.is_none_or(|(s, _)| size > s) {
                    largest = Some((size, i));
                }
            }
            let Some((i, part)) = largest.and_then(|(_, i)| Some((i, parts[i].take()?))) else {
                break;
            };
            if part.refs.len() > SERIAL && !self.progress.pass(self.task, part.refs.len()) {
                return Node::EMPTY;
            }
            let [below, above] = part.divide(halve);
            (parts[i], parts[count]) = (Some(below), Some(above));
            count += 1;
        }
        let mut boxes = [Aabb::EMPTY; WIDTH];
        for (to, part) in boxes.iter_mut().zip(parts.iter().flatten()) {
            *to = part.bounds.aabb();
        }
        let mut node = Node::new(&boxes[..count], self.center);
        // Leaves of a node lie together, and so do its inner children.
        let first = out.nodes.len();
        let (mut inner, mut below) = (0, 0);
        for (i, slot) in parts.iter_mut().enumerate().take(count) {
            let Some(part) = slot else {
                continue;
            };
            if part.refs.len() > MAX_LEAF {
                node.children[i] = (first + inner) as u32;
                inner += 1;
                below += part.refs.len();
                continue;
            }
            node.children[i] = Link::to_leaf(out.order.len(), part.refs.len()).0;
            out.order.extend(part.refs.iter().map(Ref::id));
            out.runs.push(part.refs.len() as u8);
            *slot = None;
        }
        out.nodes.resize(first + inner, Node::EMPTY);
        let inner = parts.into_iter().flatten();
        if below <= SERIAL {
            for (i, part) in inner.enumerate() {
                out.nodes[first + i] = self.grow(part, depth + 1, out);
            }
            return node;
        }
        let inner: Vec<Part<'_>> = inner.collect();
        let subtrees: Vec<(Node, Subtree)> = inner
            .into_par_iter()
            .map(|part| {
                let mut below = Subtree::default();
                if part.refs.len() <= SERIAL && !self.progress.pass(self.task, part.refs.len()) {
                    return (Node::EMPTY, below);
                }
                (self.grow(part, depth + 1, &mut below), below)
            })
            .collect();
        for (i, (root, below)) in subtrees.into_iter().enumerate() {
            let by = out.append(below);
            out.nodes[first + i] = root.moved(by.0, by.1);
        }
        node
    }
}
