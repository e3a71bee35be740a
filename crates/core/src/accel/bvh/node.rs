//! Tree nodes of 256 bytes: eight children with their boxes.

use glam::Vec3;

use crate::math::Aabb;
use crate::simd::Lanes;

/// Children per node.
pub(super) const WIDTH: usize = 8;

/// An inner node, four cache lines. Boxes are relative to the centre of the tree, rounded
/// outward.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C, align(64))]
pub(super) struct Node {
    /// By axis: the lower planes of all children, the upper planes. A child that there is not
    /// has an empty box.
    pub planes: [[[f32; WIDTH]; 2]; 3],
    /// By child: its [`Link`].
    pub children: [u32; WIDTH],
}

/// What a child is: an inner node, or a leaf.
///
/// In 32 bits: the index of an inner node, or 2³¹ + 8 · first + (count − 1).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Link(pub u32);

/// Exclusive bound on the primitives' number that a link has room for.
pub(crate) const MAX_PRIMITIVES: usize = 1 << 28;

const LEAF: u32 = 1 << 31;

impl Link {
    pub const ROOT: Self = Self(0);

    /// A leaf of 1 to 8 primitives.
    pub fn to_leaf(first: usize, count: usize) -> Self {
        debug_assert!(first < MAX_PRIMITIVES && (1..=8).contains(&count));
        Self(LEAF | (first as u32) << 3 | (count as u32 - 1))
    }

    /// The inner node, unless it is a leaf.
    #[inline(always)]
    pub fn inner(self) -> Option<u32> {
        (self.0 < LEAF).then_some(self.0)
    }

    /// First primitive and number of primitives of a leaf.
    #[inline(always)]
    pub fn leaf(self) -> (u32, u32) {
        ((self.0 & !LEAF) >> 3, (self.0 & 7) + 1)
    }
}

impl Node {
    /// A node without children.
    pub const EMPTY: Self = Self {
        planes: [[[f32::INFINITY; WIDTH], [f32::NEG_INFINITY; WIDTH]]; 3],
        children: [0; WIDTH],
    };

    /// A node with the given children's boxes and no links yet.
    pub fn new(children: &[Aabb], center: Vec3) -> Self {
        let mut node = Self::EMPTY;
        for (i, child) in children.iter().enumerate() {
            for axis in 0..3 {
                let exact = |x: f32| f64::from(x) - f64::from(center[axis]);
                let (min, max) = (exact(child.min[axis]), exact(child.max[axis]));
                let (mut lo, mut hi) = (min as f32, max as f32);
                if f64::from(lo) > min {
                    lo = lo.next_down();
                }
                if f64::from(hi) < max {
                    hi = hi.next_up();
                }
                (node.planes[axis][0][i], node.planes[axis][1][i]) = (lo, hi);
            }
        }
        node
    }

    /// How many children there are: the first ones.
    #[inline(always)]
    pub fn width<L: Lanes>(&self) -> usize {
        let [lower, upper] = &self.planes[0];
        L::load(lower).le(L::load(upper)).count_ones() as usize
    }

    /// Whether there is a child `i`.
    pub fn has(&self, i: usize) -> bool {
        self.planes[0][0][i] <= self.planes[0][1][i]
    }

    /// The same node after its subtree was put behind so many others.
    pub fn moved(mut self, nodes: u32) -> Self {
        for i in 0..WIDTH {
            if !self.has(i) {
                break;
            }
            if Link(self.children[i]).inner().is_some() {
                self.children[i] += nodes;
            }
        }
        self
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lab::random::Rng;

    #[test]
    fn links_hold_as_many_primitives_as_are_allowed() {
        for first in [0, 1, MAX_PRIMITIVES - 8, MAX_PRIMITIVES - 1] {
            for count in 1..=8 {
                let link = Link::to_leaf(first, count);
                assert_eq!(link.inner(), None);
                assert_eq!(link.leaf(), (first as u32, count as u32));
            }
        }
    }

    #[test]
    fn boxes_hold_the_boxes_given() {
        assert_eq!(size_of::<Node>(), 256);
        let mut rng = Rng(1);
        for round in 0..2000 {
            let (at, size) = (
                [0.0, 1e3, -1e6][round % 3],
                [1.0, 1e-4, 0.0, 1e12][round % 4],
            );
            let mut point = || rng.cube() * size + at;
            let center = point();
            let boxes: Vec<Aabb> = (0..1 + round % 8)
                .map(|_| Aabb::of_points([point(), point()]))
                .collect();
            let node = Node::new(&boxes, center);
            for i in 0..WIDTH {
                assert_eq!(node.has(i), i < boxes.len());
            }
            for (i, b) in boxes.iter().enumerate() {
                for axis in 0..3 {
                    let exact = |x: f32| f64::from(x) - f64::from(center[axis]);
                    let [lo, hi] = node.planes[axis].map(|planes| planes[i]);
                    let (min, max) = (exact(b.min[axis]), exact(b.max[axis]));
                    assert!(f64::from(lo) <= min && min < f64::from(lo.next_up()));
                    assert!(f64::from(hi.next_down()) < max && max <= f64::from(hi));
                }
            }
        }
    }
}
