//! Walking many rays together, node by node: each node on the way has the list of all rays that
//! meet its box.
//!
//! What a lone walk waits for is its next node from memory, and branches that no one can foresee.
//! Here a node is fetched once for all its rays, whether a ray meets a box is a bit in a mask, and
//! rays are put into the children's lists by shuffles. Rays of a list go the same way along
//! every axis, so that one order of the children is nearly right for all of them. Once a list is
//! short, its rays go on alone.

use super::Bvh;
use super::node::{Link, WIDTH};
use super::slopes::{Along, Octant, Planes, Slopes};
use super::turns::Turns;
use crate::simd::Lanes;

/// Lists up to so long are taken apart (measured: docs/ray-casting.md).
const SHORT: usize = 2;

/// Where rays start so far apart, in units of the tree, and there are so many nodes for each of
/// them, no list would be long: all go alone from the start.
const SCATTERED: f32 = 0.05;
const MANY_NODES: usize = 64;

/// So many rays that go on alone are walked together.
const ALONE: usize = 128;

/// What is walked: rays by number.
pub(crate) trait Stream {
    /// A ray.
    fn along(&self, item: u16) -> &Along;
    /// Tests primitives `first`, `first` + 1, … of the tree's order for each of some items.
    fn visit<L: Lanes>(&mut self, items: &[u16], first: u32, count: u32);
    /// A bit for each axis along which an item goes down.
    fn octant(&self, item: u16) -> Octant;
    /// Asks for a leaf's memory ahead of its visit.
    fn prefetch<L: Lanes>(&self, first: u32, count: u32);
}

/// Items that have yet to go below a link.
#[derive(Clone, Copy)]
struct List {
    link: Link,
    /// In the arena.
    begin: usize,
    count: usize,
    /// The arena is free from here on when the list's turn comes.
    free: usize,
}

/// Memory of a walk, to be used again.
#[derive(Default)]
pub(crate) struct Lists {
    arena: Vec<u16>,
    pending: Vec<List>,
    /// What goes on alone.
    alone: Vec<(u16, Link)>,
    turns: Turns,
}

impl Bvh {
    /// Shows the leaves along all items of a list, which go the way of an octant. `step` is how
    /// far the start of an item is from that of the one before.
    #[inline(always)]
    pub(crate) fn walk_stream<L: Lanes>(
        &self,
        (octant, step): (Octant, f32),
        items: &[u16],
        lists: &mut Lists,
        stream: &mut impl Stream,
    ) {
        if self.nodes.is_empty() || items.is_empty() {
            return;
        }
        let size = (self.bounds.max - self.bounds.min).max_element();
        if step > SCATTERED * size && self.nodes.len() > MANY_NODES * items.len() {
            lists
                .alone
                .extend(items.iter().map(|&item| (item, Link::ROOT)));
            self.walk_in_turns::<L>(&lists.alone, &mut lists.turns, stream);
            lists.alone.clear();
            return;
        }
        let extent = (self.bounds.max - self.center)
            .abs()
            .max((self.bounds.min - self.center).abs());
        let offset = 2.0 * extent.element_sum();
        let free = items.len().next_multiple_of(WIDTH);
        lists.arena.resize(lists.arena.len().max(free), 0);
        lists.arena[..items.len()].copy_from_slice(items);
        lists.pending.push(List {
            link: Link::ROOT,
            begin: 0,
            count: items.len(),
            free,
        });
        while let Some(list) = lists.pending.pop() {
            let List {
                link,
                begin,
                count,
                free,
            } = list;
            let Some(index) = link.inner() else {
                let (first, n) = link.leaf();
                stream.visit::<L>(&lists.arena[begin..begin + count], first, n);
                continue;
            };
            if count <= SHORT {
                let items = &lists.arena[begin..begin + count];
                lists.alone.extend(items.iter().map(|&item| (item, link)));
                if lists.alone.len() >= ALONE {
                    self.walk_in_turns::<L>(&lists.alone, &mut lists.turns, stream);
                    lists.alone.clear();
                }
                continue;
            }
            let node = self.node(index);
            let stride = count.next_multiple_of(WIDTH);
            let end = free + WIDTH * stride;
            if lists.arena.len() < end {
                lists.arena.resize(2 * end, 0);
            }
            let (below, children) = lists.arena[..end].split_at_mut(free);
            let mut counts = [0usize; WIDTH];
            let (groups, rest) = below[begin..begin + count].as_chunks::<WIDTH>();
            for items in groups {
                let ray = |i: usize| stream.along(items[i]);
                let rays = [
                    ray(0),
                    ray(1),
                    ray(2),
                    ray(3),
                    ray(4),
                    ray(5),
                    ray(6),
                    ray(7),
                ];
                let slopes = Slopes::<L>::eight(rays);
                let items = in_a_row(items);
                for (child, count) in counts.iter_mut().enumerate() {
                    let (enter, exit) =
                        slopes.meet(&Planes::of_child(node, child, octant), slopes.t_max);
                    let mask = enter.le(exit) as usize;
                    if let Some(to) = children[child * stride + *count..].first_chunk_mut() {
                        L::compress(items, mask, to);
                    }
                    *count += mask.count_ones() as usize;
                }
            }
            let planes = Planes::<L>::of_children(node, octant);
            if !rest.is_empty() {
                let mut masks = 0u64;
                for (i, &item) in rest.iter().enumerate() {
                    let slopes = Slopes::one(stream.along(item));
                    let (enter, exit) = slopes.meet(&planes, slopes.t_max);
                    masks |= u64::from(enter.le(exit)) << (8 * i);
                }
                let items = in_a_row(rest);
                for (child, count) in counts.iter_mut().enumerate() {
                    let bits = (masks >> child & BYTES).wrapping_mul(GATHER) >> 56;
                    if let Some(to) = children[child * stride + *count..].first_chunk_mut() {
                        L::compress(items, bits as usize, to);
                    }
                    *count += bits.count_ones() as usize;
                }
            }
            let links: [u32; WIDTH] = std::array::from_fn(|i| i as u32);
            let some = counts.map(|n| if n > 0 { f32::INFINITY } else { -1.0 });
            let (mut t, mut order) = ([0.0; WIDTH], [0; WIDTH]);
            let n = L::sort_hits(
                planes.depth(octant, offset),
                L::load(&some),
                &links,
                &mut t,
                &mut order,
            );
            for &child in &order[..n] {
                let child = child as usize % WIDTH;
                lists.pending.push(List {
                    link: Link(node.children[child]),
                    begin: free + child * stride,
                    count: counts[child],
                    free: end,
                });
            }
        }
        self.walk_in_turns::<L>(&lists.alone, &mut lists.turns, stream);
        lists.alone.clear();
    }
}

/// Up to eight items in a row, the first in the lowest bits. Read one by one: they may have just
/// been written in pieces, which a single read would have to wait for.
#[inline(always)]
pub(crate) fn in_a_row(items: &[u16]) -> u128 {
    let mut row = 0;
    for &item in items {
        row = row >> 16 | u128::from(item) << 112;
    }
    row >> (16 * (WIDTH - items.len()))
}

/// The lowest bit of each byte.
const BYTES: u64 = 0x0101_0101_0101_0101;

/// Multiplied by the lowest bits of bytes, gives them in the highest byte.
const GATHER: u64 = 0x0102_0408_1020_4080;
