//! Walking many rays at once, a step each in turn.
//!
//! What a lone walk waits for is the next node on its way from memory and branches that no one
//! can foresee. Here a few dozen rays have a slot each. Every round takes the nearest box off each
//! slot's stack and sorts the slots into those at a node and those at a leaf, without a branch;
//! by the time the nodes and leaves are looked at they have arrived. A slot whose ray is done
//! takes the next ray.

use super::Bvh;
use super::node::{Link, WIDTH};
use super::walk::{Meet, STACK, Slopes};
use crate::accel::Beam;
use crate::math::Ray;
use crate::simd::Lanes;

/// Rays under way at a time (measured: docs/ray-casting.md).
pub const SLOTS: usize = 16;

/// Below the bottom of a stack lie as many entries that are beyond any distance, so that the top
/// can be looked at in groups.
const BOTTOM: usize = WIDTH;

/// What casts rays and is shown their leaves.
pub(crate) trait Stream {
    /// Puts the next ray into a slot; `None` if there are no more.
    fn start(&mut self, slot: usize) -> Option<Ray>;
    /// Tests primitives `first`, `first` + 1, … of the tree's order, now or by
    /// [`Stream::settle`].
    fn test<L: Lanes>(&mut self, slot: usize, first: u32, count: u32);
    /// Asks for a leaf's memory ahead of its test.
    fn prefetch<L: Lanes>(&self, first: u32, count: u32);
    /// Ends a round of tests.
    fn settle(&mut self);
    /// Boxes beyond this distance need not be visited; −∞ if none need.
    fn t_max(&self, slot: usize) -> f32;
    /// The slot's ray has seen all leaves along it.
    fn finish(&mut self, slot: usize);
}

/// The boxes that a ray has yet to visit: where they begin and what they are.
struct Stack {
    t: [f32; BOTTOM + STACK + WIDTH],
    links: [u32; BOTTOM + STACK + WIDTH],
    /// Number of entries, those below the bottom counted.
    height: usize,
    /// Taken off the top in this round.
    link: Link,
    slopes: Slopes,
}

impl Bvh {
    /// Shows all rays of a stream the leaves along them, as [`Bvh::walk`] does for one.
    #[inline(always)]
    pub(crate) fn walk_many<L: Lanes>(&self, stream: &mut impl Stream) {
        let mut stacks: Box<[Stack; SLOTS]> = Box::new(std::array::from_fn(|_| Stack::default()));
        let mut active = [0u8; SLOTS];
        let mut count = 0;
        for slot in 0..SLOTS {
            active[count] = slot as u8;
            count += usize::from(self.next(&mut stacks[slot], slot, stream));
        }
        while count > 0 {
            let (mut at_nodes, mut at_leaves) = ([0u8; SLOTS], [0u8; SLOTS]);
            let (mut nodes, mut leaves, mut still) = (0, 0, 0);
            for i in 0..count.min(SLOTS) {
                let slot = usize::from(active[i]) % SLOTS;
                let stack = &mut stacks[slot];
                while !stack.pop::<L>(stream.t_max(slot)) {
                    stream.finish(slot);
                    if !self.next(stack, slot, stream) {
                        break;
                    }
                }
                if stack.height == 0 {
                    continue;
                }
                active[still % SLOTS] = slot as u8;
                still += 1;
                let inner = stack.link.inner();
                at_nodes[nodes % SLOTS] = slot as u8;
                at_leaves[leaves % SLOTS] = slot as u8;
                nodes += usize::from(inner.is_some());
                leaves += usize::from(inner.is_none());
                match inner {
                    Some(index) => L::prefetch(self.node(index)),
                    None => {
                        let (first, count) = stack.link.leaf();
                        stream.prefetch::<L>(first, count);
                    }
                }
            }
            count = still;
            for slot in at_nodes[..nodes.min(SLOTS)]
                .iter()
                .map(|&slot| usize::from(slot) % SLOTS)
            {
                let stack = &mut stacks[slot];
                let Some(index) = stack.link.inner() else {
                    continue;
                };
                let t_max = stream.t_max(slot);
                let (enter, exit) = stack.slopes.meet::<L>(self.node(index), t_max);
                stack.push(&self.node(index).children, enter, exit);
            }
            for slot in at_leaves[..leaves.min(SLOTS)]
                .iter()
                .map(|&slot| usize::from(slot) % SLOTS)
            {
                let (first, count) = stacks[slot].link.leaf();
                stream.test::<L>(slot, first, count);
            }
            stream.settle();
        }
    }

    /// Puts the next ray that meets the tree into a slot.
    #[inline(always)]
    fn next(&self, stack: &mut Stack, slot: usize, stream: &mut impl Stream) -> bool {
        while let Some(ray) = stream.start(slot) {
            if let Some(beam) = Beam::new(&ray, &self.bounds)
                && !self.nodes.is_empty()
            {
                stack.slopes = Slopes::new(&beam, self.center);
                (stack.t[BOTTOM], stack.links[BOTTOM]) = (beam.t_enter, Link::ROOT.0);
                stack.height = BOTTOM + 1;
                return true;
            }
            stream.finish(slot);
        }
        stack.height = 0;
        false
    }
}

impl Default for Stack {
    fn default() -> Self {
        Self {
            // No distance is at least NaN.
            t: [f32::NAN; _],
            links: [0; _],
            height: BOTTOM,
            link: Link::ROOT,
            slopes: Slopes::default(),
        }
    }
}

impl Stack {
    /// Takes the nearest box that begins by `t_max` off the top; false if there is none.
    #[inline(always)]
    fn pop<L: Lanes>(&mut self, t_max: f32) -> bool {
        let mut height = self.height;
        loop {
            let Some(top) = self.t[height - WIDTH..].first_chunk() else {
                return false;
            };
            let near = L::load(top).le(L::splat(t_max));
            if near != 0 {
                let above = near.leading_zeros() as usize - (32 - WIDTH);
                self.height = height - above - 1;
                self.link = Link(self.links[self.height]);
                return true;
            }
            if height <= BOTTOM + WIDTH {
                return false;
            }
            height -= WIDTH;
        }
    }

    /// Puts the boxes that are entered before they are left on top, the nearest last.
    #[inline(always)]
    fn push<L: Lanes>(&mut self, links: &[u32; WIDTH], enter: L, exit: L) {
        let height = self.height;
        if let Some(t) = self.t[height..].first_chunk_mut()
            && let Some(sorted) = self.links[height..].first_chunk_mut()
        {
            self.height += L::sort_hits(enter, exit, links, t, sorted);
        }
    }
}
