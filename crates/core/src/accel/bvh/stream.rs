//! Walking many rays together, node by node: each node on the way has the list of all rays that
//! meet its box.
//!
//! What a lone walk waits for is its next node from memory, and branches that no one can foresee.
//! Here a node is fetched once for all its rays, whether a ray meets a box is a bit in a mask, and
//! rays are put into the children's lists by shuffles. Rays of a list go the same way along
//! every axis, so that one order of the children is nearly right for all of them. Once a list is
//! short, its rays go on alone.

use glam::Vec3;

use super::Bvh;
use super::node::{Link, Node, WIDTH};
use super::part::{Bundle, Children};
use super::slopes::{Along, Octant, Planes};
use super::turns::Turns;
use crate::simd::Lanes;

/// Lists up to so long are taken apart (measured: docs/ray-casting.md).
const SHORT: usize = 2;

/// For lists from so long on, leaves are nodes whose children are single primitives (measured: likewise).
const LONG: usize = 16;

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
    /// The boxes of primitives `first`, `first` + 1, … of the tree's order, as a node has them.
    fn boxes(&self, first: u32, count: u32, center: Vec3) -> [[[f32; WIDTH]; 2]; 3];
    /// As [`Stream::visit`], but tests only the primitive that is so many places behind the first.
    fn visit_one<L: Lanes>(&mut self, items: &[u16], first: u32, count: u32, place: u32);
    /// Asks for a leaf's memory ahead of its visit.
    fn prefetch(&self, first: u32, count: u32);
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
    bundle: Bundle,
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
            let leaf: Node;
            let (node, width) = match link.inner() {
                Some(index) if count > SHORT => {
                    let node = self.node(index);
                    (node, node.width::<L>())
                }
                Some(_) => {
                    let items = &lists.arena[begin..begin + count];
                    lists.alone.extend(items.iter().map(|&item| (item, link)));
                    if lists.alone.len() >= ALONE {
                        self.walk_in_turns::<L>(&lists.alone, &mut lists.turns, stream);
                        lists.alone.clear();
                    }
                    continue;
                }
                None => {
                    let (first, n) = link.leaf();
                    let items = &lists.arena[begin..begin + count];
                    if count < LONG {
                        stream.visit::<L>(items, first, n);
                        continue;
                    }
                    if n == 1 {
                        stream.visit_one::<L>(items, first, n, 0);
                        continue;
                    }
                    leaf = Node {
                        planes: stream.boxes(first, n, self.center),
                        ..Node::EMPTY
                    };
                    (&leaf, n as usize)
                }
            };
            let stride = count.next_multiple_of(WIDTH);
            let end = free + WIDTH * stride;
            if lists.arena.len() < end {
                lists.arena.resize(2 * end, 0);
            }
            let (above, arena) = lists.arena[..end].split_at_mut(free);
            let mut below = Children {
                lists: arena,
                stride,
                counts: [0; WIDTH],
            };
            let items = (octant, &above[begin..begin + count]);
            node.part::<L>(width, items, stream, &mut below, &mut lists.bundle);
            if link.inner().is_none() {
                let (first, n) = link.leaf();
                for (i, &count) in below.counts[..width].iter().enumerate() {
                    let items = &below.lists[i * stride..][..count];
                    stream.visit_one::<L>(items, first, n, i as u32);
                }
                continue;
            }
            let links: [u32; WIDTH] = std::array::from_fn(|i| i as u32);
            let some = below
                .counts
                .map(|n| if n > 0 { f32::INFINITY } else { -1.0 });
            let (mut t, mut order) = ([0.0; WIDTH], [0; WIDTH]);
            let n = L::sort_hits(
                Planes::<L>::of_children(node, octant).depth(octant, offset),
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
                    count: below.counts[child],
                    free: end,
                });
            }
        }
        self.walk_in_turns::<L>(&lists.alone, &mut lists.turns, stream);
        lists.alone.clear();
    }
}
