//! Rays by the way they go.

use super::node::WIDTH;
use super::slopes::{OCTANTS, Octant};
use crate::simd::Lanes;

/// Items by octant.
#[derive(Default)]
pub(crate) struct Octants {
    items: [Vec<u16>; OCTANTS],
    counts: [usize; OCTANTS],
}

impl Octants {
    /// Takes all out.
    pub fn clear(&mut self) {
        self.counts = [0; OCTANTS];
    }

    /// The items of an octant.
    #[inline(always)]
    pub fn items(&self, octant: Octant) -> &[u16] {
        &self.items[octant][..self.counts[octant]]
    }

    /// Puts in eight items in a row, from `first` on. Given are the numbers of their
    /// [`Along`](super::Along), each for all; where `is_met` is 0, an item is left out.
    #[inline(always)]
    pub fn list<L: Lanes>(
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
        let row = IN_ORDER + u128::from(first as u16) * EACH;
        for octant in 0..OCTANTS {
            let bit = |axis: usize| (octant as u32 >> axis & 1).wrapping_sub(1);
            let mask = is_met & (x ^ bit(0)) & (y ^ bit(1)) & (z ^ bit(2));
            if mask != 0 {
                let (items, count) = (&mut self.items[octant], &mut self.counts[octant]);
                if items.len() < *count + WIDTH {
                    items.resize(2 * items.len() + WIDTH, 0);
                }
                if let Some(to) = items[*count..].first_chunk_mut() {
                    L::compress(row, mask as usize, to);
                }
                *count += mask.count_ones() as usize;
            }
        }
    }
}

/// 1 in each of eight numbers of 16 bits.
const EACH: u128 = u128::MAX / 0xffff;

/// 0, 1, … 7.
const IN_ORDER: u128 = 0x0007_0006_0005_0004_0003_0002_0001_0000;
