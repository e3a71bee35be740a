//! Rays sorted into lists: by the way they go, or otherwise.

use super::node::WIDTH;
use super::slopes::OCTANTS;
use crate::simd::Lanes;

/// Items in as many lists as there are octants.
#[derive(Default)]
pub(crate) struct Sorted {
    items: [Vec<u16>; OCTANTS],
    counts: [usize; OCTANTS],
}

impl Sorted {
    /// Takes all out.
    pub fn clear(&mut self) {
        self.counts = [0; OCTANTS];
    }

    /// The items of a list.
    #[inline(always)]
    pub fn items(&self, list: usize) -> &[u16] {
        &self.items[list][..self.counts[list]]
    }

    /// Of eight items in a row, from `first` on, puts those into a list that have a bit in a mask.
    #[inline(always)]
    pub fn put<L: Lanes>(&mut self, list: usize, first: usize, mask: u32) {
        if mask == 0 {
            return;
        }
        let (items, count) = (&mut self.items[list], &mut self.counts[list]);
        if items.len() < *count + WIDTH {
            items.resize(2 * items.len() + WIDTH, 0);
        }
        if let Some(to) = items[*count..].first_chunk_mut() {
            let row = IN_ORDER + u128::from(first as u16) * EACH;
            L::compress(row, mask as usize, to);
        }
        *count += mask.count_ones() as usize;
    }

    /// Puts eight items in a row, from `first` on, into the lists of their octants. Given are the
    /// numbers of their [`Along`](super::Along), each for all; where `is_met` is 0, an item is left out.
    #[inline(always)]
    pub fn by_octant<L: Lanes>(
        &mut self,
        first: usize,
        along: &[&[f32; WIDTH]; 8],
        is_met: &[f32; WIDTH],
    ) {
        let zero = L::splat(0.0);
        let is_met = zero.lt(L::load(is_met));
        let (x, y, z) = (
            L::load(along[0]).lt(zero),
            L::load(along[1]).lt(zero),
            L::load(along[2]).lt(zero),
        );
        for octant in 0..OCTANTS {
            let bit = |axis: usize| (octant as u32 >> axis & 1).wrapping_sub(1);
            self.put::<L>(
                octant,
                first,
                is_met & (x ^ bit(0)) & (y ^ bit(1)) & (z ^ bit(2)),
            );
        }
    }
}

/// 1 in each of eight numbers of 16 bits.
const EACH: u128 = u128::MAX / 0xffff;

/// 0, 1, … 7.
const IN_ORDER: u128 = 0x0007_0006_0005_0004_0003_0002_0001_0000;
