//! Walking a ray through the tree, the nearest of the boxes it meets first.

use std::mem::MaybeUninit;

use super::node::{Link, Node, WIDTH};
use super::slopes::{Planes, Slopes};
use super::{Bvh, MAX_DEPTH};
use crate::accel::Tree as _;
use crate::math::Ray;
use crate::simd::Lanes;

/// Each node on a path leaves all its children but one on the stack.
pub(super) const STACK: usize = MAX_DEPTH * (WIDTH - 1) + 1;

/// A link and the distance at which its box begins, never negative, so that numbers compare as
/// distances do.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct Entry(u64);

impl Entry {
    #[inline(always)]
    fn new(t: f32, link: Link) -> Self {
        Self(u64::from(t.to_bits()) << 32 | u64::from(link.0))
    }

    #[inline(always)]
    fn t(self) -> f32 {
        f32::from_bits((self.0 >> 32) as u32)
    }

    #[inline(always)]
    fn link(self) -> Link {
        Link(self.0 as u32)
    }
}

/// What a walk shows leaves to.
pub(crate) trait Leaves {
    /// Tests primitives `first`, `first` + 1, … of the tree's order. Returns the new `t_max`: the
    /// same, the distance of a hit that makes what lies beyond it uninteresting, or −∞ to stop at
    /// once. The first is the ray's.
    fn visit<L: Lanes>(&mut self, first: u32, count: u32, t_max: f32) -> f32;
    /// Told of each inner node; only those that count listen.
    #[inline(always)]
    fn node(&mut self) {}
}

/// Reads what was pushed.
#[inline(always)]
fn entry_at(stack: &[MaybeUninit<Entry>; STACK], at: usize) -> Entry {
    #[expect(
        unsafe_code,
        reason = "clearing the stack would cost as much as a short walk"
    )]
    // SAFETY: the walk reads below its height only, where it has written.
    unsafe {
        stack[at].assume_init()
    }
}

impl Bvh {
    /// An inner node by a link.
    #[inline(always)]
    pub(super) fn node(&self, index: u32) -> &Node {
        #[expect(unsafe_code, reason = "the walk is bound by what it executes per node")]
        // SAFETY: the build makes links to nodes that there are, and nothing changes them.
        unsafe {
            self.nodes.get_unchecked(index as usize)
        }
    }

    /// Visits the leaves along `ray`, in the order in which their boxes begin as far as that is
    /// known.
    ///
    /// Visited is every primitive that `ray` meets, to within the rounding errors of an f32 test,
    /// at a distance up to the final `t_max` plus 2⁻²⁰ of itself. A ray with NaN or infinite
    /// origin or direction, no direction, or without `t_max > 0` visits nothing.
    #[inline(always)]
    pub(crate) fn walk<L: Lanes>(&self, ray: &Ray, leaves: &mut impl Leaves) {
        let (along, is_met) = self.along(ray);
        let octant = along.octant();
        if !is_met || self.nodes.is_empty() {
            return;
        }
        let (slopes, mut t_max) = (Slopes::<L>::one(&along), ray.t_max);
        let mut link = Link::ROOT;
        let mut stack = [const { MaybeUninit::<Entry>::uninit() }; STACK];
        let mut height = 0;
        loop {
            if let Some(index) = link.inner() {
                leaves.node();
                let node = self.node(index);
                let planes = Planes::of_children(node, octant);
                let (enter, exit) = slopes.meet(&planes, L::splat(t_max));
                let (mut mask, t) = (enter.le(exit), enter.store());
                if mask != 0 {
                    let nearest = node.take(&mut mask, &t);
                    if mask == 0 {
                        link = nearest.link();
                        continue;
                    }
                    let second = node.take(&mut mask, &t);
                    let (nearest, second) = (nearest.min(second), nearest.max(second));
                    if mask == 0 {
                        stack[height].write(second);
                        height += 1;
                        link = nearest.link();
                        continue;
                    }
                    // Kept in order, the nearest last.
                    let base = height;
                    stack[height].write(second);
                    stack[height + 1].write(nearest);
                    height += 2;
                    while mask != 0 {
                        let entry = node.take(&mut mask, &t);
                        let mut at = height;
                        while at > base && entry_at(&stack, at - 1) < entry {
                            stack[at] = stack[at - 1];
                            at -= 1;
                        }
                        stack[at].write(entry);
                        height += 1;
                    }
                    height -= 1;
                    link = entry_at(&stack, height).link();
                    continue;
                }
            } else {
                let (first, count) = link.leaf();
                t_max = leaves.visit::<L>(first, count, t_max);
            }
            loop {
                if height == 0 {
                    return;
                }
                height -= 1;
                let entry = entry_at(&stack, height);
                if entry.t() <= t_max {
                    link = entry.link();
                    break;
                }
            }
        }
    }
}

impl Node {
    /// Takes the first child out of a mask.
    #[inline(always)]
    fn take(&self, mask: &mut u32, t: &[f32; WIDTH]) -> Entry {
        let i = mask.trailing_zeros() as usize & (WIDTH - 1);
        *mask &= *mask - 1;
        Entry::new(t[i], Link(self.children[i]))
    }
}
