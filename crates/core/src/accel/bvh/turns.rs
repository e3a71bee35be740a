//! Walking rays on their own, a step each in turn.
//!
//! What a lone walk waits for is the next node on its way from memory and branches that no one
//! can foresee. Here a few rays have a slot each. Every round takes the nearest box off each
//! slot's stack and sorts the slots into those at a node and those at a leaf, without a branch;
//! by the time the nodes and leaves are looked at they have arrived. A slot whose ray is done
//! takes the next.

use super::Bvh;
use super::node::{Link, WIDTH};
use super::slopes::{Planes, Slopes};
use super::stream::Stream;
use super::walk::STACK;
use crate::simd::{Lanes, prefetch};

/// Rays under way at a time (measured: docs/ray-casting.md).
const SLOTS: usize = 16;

/// Below the bottom of a stack lie as many entries that are beyond any distance, so that the top
/// can be looked at in groups.
const BOTTOM: usize = WIDTH;

/// The boxes that an item has yet to visit: where they begin and what they are.
struct Slot {
    t: [f32; BOTTOM + STACK + WIDTH],
    links: [u32; BOTTOM + STACK + WIDTH],
    /// Number of entries, those below the bottom counted.
    height: usize,
    /// Taken off the top in this round.
    link: Link,
    item: u16,
}

/// The slots, to be used again.
pub(super) struct Turns([Slot; SLOTS]);

impl Default for Turns {
    fn default() -> Self {
        Self(std::array::from_fn(|_| Slot {
            // No distance is at least NaN.
            t: [f32::NAN; _],
            links: [0; _],
            height: BOTTOM,
            link: Link::ROOT,
            item: 0,
        }))
    }
}

impl Bvh {
    /// Walks items through what is below their links.
    #[inline(always)]
    pub(super) fn walk_in_turns<L: Lanes>(
        &self,
        tasks: &[(u16, Link)],
        Turns(slots): &mut Turns,
        stream: &mut impl Stream,
    ) {
        let mut tasks = tasks.iter();
        let mut active = [0u8; SLOTS];
        let mut count = 0;
        for (i, slot) in slots.iter_mut().enumerate() {
            active[count % SLOTS] = i as u8;
            count += usize::from(slot.start(tasks.next()));
        }
        while count > 0 {
            let (mut at_nodes, mut at_leaves) = ([0u8; SLOTS], [0u8; SLOTS]);
            let (mut nodes, mut leaves, mut still) = (0, 0, 0);
            for i in 0..count.min(SLOTS) {
                let index = active[i];
                let slot = &mut slots[usize::from(index) % SLOTS];
                while !slot.pop::<L>(stream.along(slot.item).t_max()) && slot.start(tasks.next()) {}
                if slot.height == 0 {
                    continue;
                }
                active[still % SLOTS] = index;
                still += 1;
                let inner = slot.link.inner();
                at_nodes[nodes % SLOTS] = index;
                at_leaves[leaves % SLOTS] = index;
                nodes += usize::from(inner.is_some());
                leaves += usize::from(inner.is_none());
                match inner {
                    Some(index) => prefetch(self.node(index)),
                    None => {
                        let (first, count) = slot.link.leaf();
                        stream.prefetch(first, count);
                    }
                }
            }
            count = still;
            for &index in &at_nodes[..nodes.min(SLOTS)] {
                let slot = &mut slots[usize::from(index) % SLOTS];
                let Some(index) = slot.link.inner() else {
                    continue;
                };
                let node = self.node(index);
                let along = stream.along(slot.item);
                let planes = Planes::<L>::of_children(node, along.octant());
                let slopes = Slopes::one(along);
                let (enter, exit) = slopes.meet(&planes, slopes.t_max);
                slot.push(&node.children, enter, exit);
            }
            for &index in &at_leaves[..leaves.min(SLOTS)] {
                let slot = &slots[usize::from(index) % SLOTS];
                let (first, count) = slot.link.leaf();
                stream.visit::<L>(&[slot.item], first, count);
            }
        }
    }
}

impl Slot {
    /// Takes an item; none leaves the slot without entries.
    #[inline(always)]
    fn start(&mut self, task: Option<&(u16, Link)>) -> bool {
        self.height = 0;
        let Some(&(item, link)) = task else {
            return false;
        };
        self.item = item;
        (self.t[BOTTOM], self.links[BOTTOM]) = (0.0, link.0);
        self.height = BOTTOM + 1;
        true
    }

    /// Takes the nearest box that begins by `t_max` off the top; false if there is none.
    #[inline(always)]
    fn pop<L: Lanes>(&mut self, t_max: f32) -> bool {
        let mut height = self.height;
        loop {
            let Some(top) = height
                .checked_sub(WIDTH)
                .and_then(|at| self.t[at..].first_chunk())
            else {
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
