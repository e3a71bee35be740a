//! Building the tree from the top: a node's box is divided in two again and again, the largest
//! part first, until there are eight.
//!
//! The tree is a function of the boxes alone, whichever threads do what.

use std::sync::{Mutex, PoisonError};

use glam::Vec3;
use rayon::prelude::*;

use super::boxes::{Box8, Ordered, Ref, begin, bounds_of, new_ref, ordered};
use super::node::{Link, MAX_PRIMITIVES, Node, WIDTH};
use super::split::{Split, leaf_cost};
use super::{Bvh, MAX_DEPTH, MAX_LEAF};
use crate::accel::progress::{Progress, Task};
use crate::math::Aabb;
use crate::simd::Kernel;

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
    /// The primitives as the tree's leaves count them, 1 to [`MAX_LEAF`] in each.
    pub order: Vec<Ordered>,
}

impl Bvh {
    /// [`Self::build_watched`] for this machine, unwatched, in memory of its own.
    #[cfg(test)]
    pub fn build(count: usize, bounds: impl Fn(u32) -> Aabb + Sync) -> Built {
        let (kernel, progress) = (Kernel::detect(), &Progress::unwatched());
        Self::build_watched(count, bounds, &mut Self::memory(count), kernel, progress)
    }

    /// Memory for [`Self::build_watched`], if there is none that has another use later.
    pub fn memory(count: usize) -> Vec<f32> {
        // One more, so that each can lie in one line of the cache.
        vec![0.0; (count + 1) * size_of::<Ref>() / size_of::<f32>()]
    }

    /// Builds the tree over primitives 0 to `count` − 1 with boxes `bounds(id)`, for a certain
    /// kernel; the same tree at any number of threads. Primitives with an empty box are left out.
    /// If its progress is ended before time, the tree is empty. The boxes are kept in `memory`, at least as much as
    /// [`Self::memory`], of whatever else: to get fresh memory takes a good part of the time of a build.
    ///
    /// # Panics
    /// With 2²⁸ primitives or more, or too little memory.
    pub fn build_watched(
        count: usize,
        bounds: impl Fn(u32) -> Aabb + Sync,
        memory: &mut [f32],
        kernel: Kernel,
        progress: &Progress<'_>,
    ) -> Built {
        assert!(
            count < MAX_PRIMITIVES,
            "bvh: {count} primitives are too many"
        );
        let from = memory.as_ptr().align_offset(size_of::<Ref>());
        let (refs, _) = memory[from..].as_chunks_mut();
        let refs: &mut [Ref] = &mut refs[..count];
        let empty = Mutex::new(vec![]);
        let fill = |(r, id): (&mut Ref, u32)| match new_ref(&bounds(id), id) {
            Some(new) => *r = new,
            None => empty
                .lock()
                .unwrap_or_else(PoisonError::into_inner)
                .push(id),
        };
        refs.par_iter_mut().zip(0..count as u32).for_each(fill);
        let mut empty = empty.into_inner().unwrap_or_else(PoisonError::into_inner);
        empty.sort_unstable();
        // Those at the end take their places.
        for (last, id) in (0..count).rev().zip(empty.iter().rev()) {
            refs[*id as usize] = refs[last];
        }
        let mut refs = &mut refs[..count - empty.len()];
        let task = Task::new(refs.len(), SERIAL);
        let whole = Part::new(refs, 0, kernel);
        let bounds = whole.bounds.aabb();
        let center = bounds.center();
        let builder = Builder {
            center,
            kernel,
            progress,
            task,
        };
        let mut grown = builder.build(whole);
        if progress.is_stopped() {
            (grown, refs) = Default::default();
        }
        let order = refs.par_iter().map(ordered).collect();
        let tree = Self {
            bounds,
            center,
            nodes: grown.join(),
        };
        Built { tree, order }
    }
}

/// Primitives that go into one child.
struct Part<'a> {
    refs: &'a mut [Ref],
    /// Where they begin in the order of all.
    first: usize,
    bounds: Box8,
    centers: Box8,
    half_area: f32,
    /// Whether two parts may be expected to cost less than one, if the node has room.
    may_divide: bool,
}

impl<'a> Part<'a> {
    fn new(refs: &'a mut [Ref], first: usize, kernel: Kernel) -> Self {
        let [bounds, centers] = bounds_of(refs, kernel);
        Self::with_bounds(refs, first, bounds, centers)
    }

    fn with_bounds(refs: &'a mut [Ref], first: usize, bounds: Box8, centers: Box8) -> Self {
        Self {
            half_area: bounds.half_area(),
            may_divide: refs.len() > 1,
            refs,
            first,
            bounds,
            centers,
        }
    }

    fn is_leaf(&self) -> bool {
        self.refs.len() <= MAX_LEAF
    }

    /// Divides by the best split, or by number where there is none; not if a leaf costs less whole.
    fn divide(mut self, halve: bool, kernel: Kernel) -> Result<[Self; 2], Self> {
        let split = Split::best(self.refs, &self.centers, kernel);
        if self.is_leaf() {
            let pays = split.as_ref().is_some_and(|split| {
                let side =
                    |i: usize| leaf_cost(split.bounds[i].half_area(), split.counts[i] as usize);
                side(0) + side(1) < leaf_cost(self.half_area, self.refs.len())
            });
            if !pays {
                self.may_divide = false;
                return Err(self);
            }
        }
        let Self { refs, first, .. } = self;
        if let Some(split) = split.filter(|_| !halve) {
            let (count, centers) = split.by.partition(refs, kernel);
            let (below, above) = refs.split_at_mut(count);
            let [a, b] = split.bounds;
            return Ok([
                Part::with_bounds(below, first, a, centers[0]),
                Part::with_bounds(above, first + count, b, centers[1]),
            ]);
        }
        let half = refs.len() / 2;
        let (below, above) = refs.split_at_mut(half);
        Ok([
            Part::new(below, first, kernel),
            Part::new(above, first + half, kernel),
        ])
    }
}

/// The nodes of a tree before they are put together.
#[derive(Default)]
struct Grown {
    top: Vec<Node>,
    /// Of each where its root comes among these, and what is below it; links in it count from there.
    subtrees: Vec<(usize, Node, Vec<Node>)>,
}

impl Grown {
    /// The subtrees follow each other behind the top.
    fn join(self) -> Vec<Node> {
        let Self { mut top, subtrees } = self;
        let (mut ends, mut count) = (vec![top.len()], top.len());
        for (at, root, below) in &subtrees {
            top[*at] = root.moved(count as u32);
            count += below.len();
            ends.push(count);
        }
        (0..count)
            .into_par_iter()
            .with_min_len(1024)
            .map(|i| match ends.partition_point(|end| *end <= i) {
                0 => top[i],
                k => subtrees[k - 1].2[i - ends[k - 1]].moved(ends[k - 1] as u32),
            })
            .collect()
    }
}

/// What every part of the build needs to know.
struct Builder<'a> {
    center: Vec3,
    kernel: Kernel,
    progress: &'a Progress<'a>,
    task: Task,
}

impl Builder<'_> {
    /// Makes all nodes: first those of parts that many threads divide, one level after the other, then
    /// whole subtrees, side by side.
    fn build(&self, whole: Part<'_>) -> Grown {
        if whole.refs.is_empty() {
            return Grown::default();
        }
        let mut top = vec![Node::EMPTY];
        let (mut level, mut small) = (vec![(0, whole)], Vec::new());
        let mut depth = 0;
        while !level.is_empty() {
            let (large, others): (Vec<_>, Vec<_>) = level
                .into_iter()
                .partition(|(_, part): &(usize, Part<'_>)| part.refs.len() > SERIAL);
            small.extend(others.into_iter().map(|(at, part)| (at, part, depth)));
            let opened: Vec<_> = large
                .into_par_iter()
                .with_max_len(1)
                .map(|(at, part)| (at, self.open(part, depth)))
                .collect();
            level = Vec::new();
            for (at, (node, inner)) in opened {
                top[at] = node;
                for (i, part) in inner.into_iter().enumerate() {
                    if let Some(part) = part {
                        top[at].children[i] = top.len() as u32;
                        level.push((top.len(), part));
                        top.push(Node::EMPTY);
                    }
                }
            }
            depth += 1;
        }
        let subtrees = small
            .into_par_iter()
            .with_max_len(1)
            .map(|(at, part, depth)| {
                // About as many as there will be.
                let mut below = Vec::with_capacity(part.refs.len() / 8);
                if !self.progress.pass(self.task, part.refs.len()) {
                    return (at, Node::EMPTY, below);
                }
                let node = self.grow(part, depth, &mut below);
                below.shrink_to_fit();
                (at, node, below)
            })
            .collect();
        Grown { top, subtrees }
    }

    /// Makes a node of a part, and all below it behind `out`, from whose start links count.
    fn grow(&self, part: Part<'_>, depth: usize, out: &mut Vec<Node>) -> Node {
        let (mut node, inner) = self.open(part, depth);
        // Children of a node lie together.
        let mut at = out.len();
        out.resize(at + inner.iter().flatten().count(), Node::EMPTY);
        for (part, link) in inner.into_iter().zip(&mut node.children) {
            if let Some(part) = part {
                *link = at as u32;
                out[at] = self.grow(part, depth + 1, out);
                at += 1;
            }
        }
        node
    }

    /// Makes a node of a part, with its leaves, and gives the parts of its inner children, each in its
    /// place; they have no link yet. Empty if nobody wants it any more.
    fn open<'a>(&self, part: Part<'a>, depth: usize) -> (Node, [Option<Part<'a>>; WIDTH]) {
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
                if part.may_divide && largest.is_none_or(|(s, _)| size > s) {
                    largest = Some((size, i));
                }
            }
            let Some((i, part)) = largest.and_then(|(_, i)| Some((i, parts[i].take()?))) else {
                break;
            };
            if part.refs.len() > SERIAL && !self.progress.pass(self.task, part.refs.len()) {
                return (Node::EMPTY, [const { None }; WIDTH]);
            }
            match part.divide(halve, self.kernel) {
                Ok([below, above]) => {
                    (parts[i], parts[count]) = (Some(below), Some(above));
                    count += 1;
                }
                Err(whole) => parts[i] = Some(whole),
            }
        }
        let mut boxes = [Aabb::EMPTY; WIDTH];
        for (to, part) in boxes.iter_mut().zip(parts.iter().flatten()) {
            *to = part.bounds.aabb();
        }
        let mut node = Node::new(&boxes[..count], self.center);
        for (slot, link) in parts.iter_mut().zip(&mut node.children) {
            if let Some(part) = slot.take_if(|part| part.is_leaf()) {
                *link = Link::to_leaf(part.first, part.refs.len()).0;
                begin(&mut part.refs[0]);
            }
        }
        (node, parts)
    }
}
