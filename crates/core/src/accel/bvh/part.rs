//! Which rays of a list meet each box of a node.

use super::node::{Node, WIDTH};
use super::slopes::{Octant, Planes, Slopes};
use super::stream::Stream;
use crate::simd::Lanes;

/// From so many groups of eight on, children that all of them miss are found first (measured:
/// docs/ray-casting.md).
const BUNDLE: usize = 8;

/// Most groups of a bundle.
const MOST: usize = 16;

/// Eight rays side by side.
#[derive(Clone, Copy, Default)]
#[repr(align(64))]
struct Eight {
    slopes: [[f32; WIDTH]; 10],
    /// Their numbers.
    items: u128,
}

/// Groups that are taken together, to be used again.
#[derive(Default)]
pub(super) struct Bundle([Eight; MOST]);

/// The lists of a node's children: child i's begins at i times the stride.
pub(super) struct Children<'a> {
    pub lists: &'a mut [u16],
    pub stride: usize,
    pub counts: [usize; WIDTH],
}

impl Children<'_> {
    /// Puts those of some items, in a row, whose bit in a mask is set behind a child's list.
    #[inline(always)]
    fn add<L: Lanes>(&mut self, child: usize, items: u128, mask: usize) {
        self.counts[child] += self.put::<L>(child, self.counts[child], items, mask);
    }

    /// The same behind so many of the list; returns how many they are.
    #[inline(always)]
    fn put<L: Lanes>(&mut self, child: usize, count: usize, items: u128, mask: usize) -> usize {
        if let Some(to) = self.lists[child * self.stride + count..].first_chunk_mut() {
            L::compress(items, mask, to);
        }
        mask.count_ones() as usize
    }
}

impl Node {
    /// Lists the items, rays of an octant, that meet the box of each of the first `width` children.
    #[inline(always)]
    pub fn part<L: Lanes>(
        &self,
        width: usize,
        (octant, items): (Octant, &[u16]),
        stream: &impl Stream,
        children: &mut Children<'_>,
        Bundle(bundle): &mut Bundle,
    ) {
        let (groups, rest) = items.as_chunks::<WIDTH>();
        let planes = Planes::<L>::of_children(self, octant);
        if groups.len() >= BUNDLE {
            for groups in groups.chunks(MOST) {
                let mut hull = Hull::new();
                for (to, items) in bundle.iter_mut().zip(groups) {
                    let numbers = side_by_side::<L>(items, stream);
                    hull.add(&numbers);
                    to.slopes = Slopes::new(numbers).store();
                    to.items = in_a_row(items);
                }
                let groups = &bundle[..groups.len().min(MOST)];
                let met = hull.meets(&planes, octant);
                for child in (0..width).filter(|child| met >> child & 1 == 1) {
                    let planes = Planes::<L>::of_child(self, child, octant);
                    // Counted in a register meanwhile.
                    let mut count = children.counts[child];
                    for group in groups {
                        let mask = Slopes::load(&group.slopes).meets(&planes);
                        count += children.put::<L>(child, count, group.items, mask as usize);
                    }
                    children.counts[child] = count;
                }
            }
        } else {
            for items in groups {
                let slopes = Slopes::new(side_by_side::<L>(items, stream));
                let items = in_a_row(items);
                for child in 0..width {
                    let mask = slopes.meets(&Planes::of_child(self, child, octant));
                    children.add::<L>(child, items, mask as usize);
                }
            }
        }
        if rest.is_empty() {
            return;
        }
        let mut masks = 0;
        for (i, &item) in rest.iter().enumerate() {
            let mask = Slopes::one(stream.along(item)).meets(&planes);
            masks |= u64::from(mask) << (8 * i);
        }
        let items = in_a_row(rest);
        for child in 0..width {
            let mask = (masks >> child & BYTES).wrapping_mul(GATHER) >> 56;
            children.add::<L>(child, items, mask as usize);
        }
    }
}

/// Eight rays, each of their numbers for all.
#[inline(always)]
fn side_by_side<L: Lanes>(items: &[u16; WIDTH], stream: &impl Stream) -> [L; 8] {
    let row = |i: usize| &stream.along(items[i]).0;
    L::transpose([
        row(0),
        row(1),
        row(2),
        row(3),
        row(4),
        row(5),
        row(6),
        row(7),
    ])
}

/// Bounds on the numbers of rays of an octant, of the starts in units of the slope: then rays with a
/// common origin are bounded as tightly as their directions are.
struct Hull<L> {
    least: [L; 8],
    most: [L; 8],
}

impl<L: Lanes> Hull<L> {
    /// Of no ray.
    #[inline(always)]
    fn new() -> Self {
        Self {
            least: [L::splat(f32::INFINITY); 8],
            most: [L::splat(f32::NEG_INFINITY); 8],
        }
    }

    #[inline(always)]
    fn add(&mut self, numbers: &[L; 8]) {
        let mut bounded = *numbers;
        for axis in 0..3 {
            bounded[3 + axis] = numbers[3 + axis].div(numbers[axis]);
        }
        let Self { least, most } = self;
        for (i, x) in bounded.iter().enumerate() {
            least[i] = least[i].min(*x);
            most[i] = most[i].max(*x);
        }
    }

    /// A bit for each box of a node; without it, no ray meets that box.
    #[inline(always)]
    fn meets(&self, planes: &Planes<L>, octant: Octant) -> u32 {
        let [a, b, c, d, e, f, g, h] = turned(self.least);
        let least = a.min(b).min(c.min(d)).min(e.min(f).min(g.min(h))).store();
        let [a, b, c, d, e, f, g, h] = turned(self.most);
        let most = a.max(b).max(c.max(d)).max(e.max(f).max(g.max(h))).store();
        let width = most[6];
        // An eighth of the width is 18 ε of the reach, several times what rounds here.
        let pad = width * (1.0 / 8.0);
        let (mut enter, mut exit) = (L::splat(0.0), L::splat(most[7]));
        for axis in 0..3 {
            let (below, above) = (least[3 + axis] - pad, most[3 + axis] + pad);
            let (first, last) = match octant >> axis & 1 {
                0 => (below, above + width),
                _ => (above, below - width),
            };
            let (a, b) = (L::splat(least[axis]), L::splat(most[axis]));
            let near = planes.near[axis].add(L::splat(first));
            let far = planes.far[axis].add(L::splat(last));
            enter = enter.max(near.mul(a).min(near.mul(b)));
            exit = exit.min(far.mul(a).max(far.mul(b)));
        }
        enter.le(exit)
    }
}

/// Lanes as numbers and numbers as lanes.
#[inline(always)]
fn turned<L: Lanes>(numbers: [L; 8]) -> [L; 8] {
    let rows = [
        numbers[0].store(),
        numbers[1].store(),
        numbers[2].store(),
        numbers[3].store(),
        numbers[4].store(),
        numbers[5].store(),
        numbers[6].store(),
        numbers[7].store(),
    ];
    let [a, b, c, d, e, f, g, h] = &rows;
    L::transpose([a, b, c, d, e, f, g, h])
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
