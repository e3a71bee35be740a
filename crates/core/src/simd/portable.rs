//! Eight lanes as an array, for the compiler to spread over what registers there are.

use super::{Lanes, SET_BITS};

/// Eight f32.
#[derive(Clone, Copy)]
#[repr(align(32))]
pub(crate) struct Portable([f32; 8]);

impl Portable {
    #[inline(always)]
    fn map2(self, b: Self, f: impl Fn(f32, f32) -> f32) -> Self {
        let mut to = [0.0; 8];
        for (to, (a, b)) in to.iter_mut().zip(self.0.iter().zip(&b.0)) {
            *to = f(*a, *b);
        }
        Self(to)
    }

    #[inline(always)]
    fn mask(self, b: Self, f: impl Fn(f32, f32) -> bool) -> u32 {
        let mut mask = 0;
        for (i, (a, b)) in self.0.iter().zip(&b.0).enumerate() {
            mask |= u32::from(f(*a, *b)) << i;
        }
        mask
    }
}

impl Lanes for Portable {
    const MANY: bool = false;

    #[inline(always)]
    fn splat(x: f32) -> Self {
        Self([x; 8])
    }

    #[inline(always)]
    fn load(from: &[f32; 8]) -> Self {
        Self(*from)
    }

    #[inline(always)]
    fn store(self) -> [f32; 8] {
        self.0
    }

    #[inline(always)]
    fn add(self, b: Self) -> Self {
        self.map2(b, |a, b| a + b)
    }

    #[inline(always)]
    fn sub(self, b: Self) -> Self {
        self.map2(b, |a, b| a - b)
    }

    #[inline(always)]
    fn mul(self, b: Self) -> Self {
        self.map2(b, |a, b| a * b)
    }

    #[inline(always)]
    fn div(self, b: Self) -> Self {
        self.map2(b, |a, b| a / b)
    }

    #[inline(always)]
    fn mul_add(self, b: Self, c: Self) -> Self {
        self.mul(b).add(c)
    }

    #[inline(always)]
    fn min(self, b: Self) -> Self {
        self.map2(b, |a, b| if a < b { a } else { b })
    }

    #[inline(always)]
    fn max(self, b: Self) -> Self {
        self.map2(b, |a, b| if a > b { a } else { b })
    }

    #[inline(always)]
    fn le(self, b: Self) -> u32 {
        self.mask(b, |a, b| a <= b)
    }

    #[inline(always)]
    fn lt(self, b: Self) -> u32 {
        self.mask(b, |a, b| a < b)
    }

    #[inline(always)]
    fn sort_hits(
        enter: Self,
        exit: Self,
        links: &[u32; 8],
        t: &mut [f32; 8],
        sorted: &mut [u32; 8],
    ) -> usize {
        let mut count = 0;
        let hits = enter.0.iter().zip(&exit.0).zip(links);
        for ((&enter, _), &link) in hits.filter(|((enter, exit), _)| enter <= exit) {
            let mut at = count;
            while at > 0 && t[at - 1] < enter {
                (t[at], sorted[at]) = (t[at - 1], sorted[at - 1]);
                at -= 1;
            }
            (t[at], sorted[at]) = (enter, link);
            count += 1;
        }
        count
    }

    #[inline(always)]
    fn compress(from: u128, mask: usize, to: &mut [u16; 8]) {
        let mut count = 0;
        for i in 0..8 {
            to[count & 7] = (from >> (16 * i)) as u16;
            count += mask >> i & 1;
        }
    }

    #[inline(always)]
    fn front(self, mask: usize) -> Self {
        Self(SET_BITS[mask & 0xff].map(|i| self.0[usize::from(i)]))
    }

    #[inline(always)]
    fn swap_halves(self) -> Self {
        let [a, b, c, d, e, f, g, h] = self.0;
        Self([e, f, g, h, a, b, c, d])
    }

    #[inline(always)]
    fn transpose(rows: [&[f32; 8]; 8]) -> [Self; 8] {
        let mut columns = [Self([0.0; 8]); 8];
        for (i, row) in rows.iter().enumerate() {
            for (column, &x) in columns.iter_mut().zip(*row) {
                column.0[i] = x;
            }
        }
        columns
    }

    #[inline(always)]
    fn sort_axes(point: [f32; 3], last: Self) -> [Self; 3] {
        let mut sorted = [Self([0.0; 8]); 3];
        for i in 0..8 {
            let z = last.0[i].to_bits() as usize;
            for k in 0..3 {
                sorted[k].0[i] = point[(z + 1 + k) % 3];
            }
        }
        sorted
    }
}
