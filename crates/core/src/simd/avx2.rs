//! Eight lanes as one AVX register.
#![expect(unsafe_code, reason = "vendor intrinsics are unsafe to call")]

use std::arch::x86_64::{
    __m256, __m256i, _CMP_LE_OQ, _CMP_LT_OQ, _mm_load_si128, _mm_loadu_si128, _mm_set_epi64x,
    _mm_setr_ps, _mm_shuffle_epi8, _mm_storeu_si128, _mm256_add_ps, _mm256_andnot_si256,
    _mm256_blend_epi32, _mm256_broadcast_ps, _mm256_castps_si256, _mm256_castsi256_ps,
    _mm256_cmp_ps, _mm256_cvtepu16_epi32, _mm256_div_ps, _mm256_fmadd_ps, _mm256_loadu_ps,
    _mm256_loadu_si256, _mm256_max_epi32, _mm256_max_ps, _mm256_min_epi32, _mm256_min_ps,
    _mm256_movemask_ps, _mm256_mul_ps, _mm256_or_si256, _mm256_permute2f128_ps,
    _mm256_permute2x128_si256, _mm256_permutevar8x32_epi32, _mm256_permutevar8x32_ps,
    _mm256_set1_epi32, _mm256_set1_ps, _mm256_setr_epi32, _mm256_shuffle_epi32, _mm256_shuffle_ps,
    _mm256_storeu_ps, _mm256_storeu_si256, _mm256_sub_ps, _mm256_unpackhi_ps, _mm256_unpacklo_ps,
    _mm256_xor_si256,
};

use super::{Lanes, SET_BITS};

/// Eight f32. Made and used only inside functions compiled for AVX2 and FMA, which are entered
/// after the machine was found to have them (see [`super::Kernel`]); that is the reason for each
/// unsafe block below.
#[derive(Clone, Copy)]
pub(crate) struct Avx2(__m256);

impl Lanes for Avx2 {
    const MANY: bool = true;

    #[inline(always)]
    fn splat(x: f32) -> Self {
        // SAFETY: the machine has AVX; see the type.
        Self(unsafe { _mm256_set1_ps(x) })
    }

    #[inline(always)]
    fn load(from: &[f32; 8]) -> Self {
        // SAFETY: the machine has AVX; 32 readable bytes, of any alignment.
        Self(unsafe { _mm256_loadu_ps(from.as_ptr()) })
    }

    #[inline(always)]
    fn store(self) -> [f32; 8] {
        let mut to = [0.0; 8];
        // SAFETY: the machine has AVX; 32 writable bytes, of any alignment.
        unsafe { _mm256_storeu_ps(to.as_mut_ptr(), self.0) };
        to
    }

    #[inline(always)]
    fn add(self, b: Self) -> Self {
        // SAFETY: the machine has AVX; see the type.
        Self(unsafe { _mm256_add_ps(self.0, b.0) })
    }

    #[inline(always)]
    fn sub(self, b: Self) -> Self {
        // SAFETY: the machine has AVX; see the type.
        Self(unsafe { _mm256_sub_ps(self.0, b.0) })
    }

    #[inline(always)]
    fn mul(self, b: Self) -> Self {
        // SAFETY: the machine has AVX; see the type.
        Self(unsafe { _mm256_mul_ps(self.0, b.0) })
    }

    #[inline(always)]
    fn div(self, b: Self) -> Self {
        // SAFETY: the machine has AVX; see the type.
        Self(unsafe { _mm256_div_ps(self.0, b.0) })
    }

    #[inline(always)]
    fn mul_add(self, b: Self, c: Self) -> Self {
        // SAFETY: the machine has FMA; see the type.
        Self(unsafe { _mm256_fmadd_ps(self.0, b.0, c.0) })
    }

    #[inline(always)]
    fn min(self, b: Self) -> Self {
        // SAFETY: the machine has AVX; see the type.
        Self(unsafe { _mm256_min_ps(self.0, b.0) })
    }

    #[inline(always)]
    fn max(self, b: Self) -> Self {
        // SAFETY: the machine has AVX; see the type.
        Self(unsafe { _mm256_max_ps(self.0, b.0) })
    }

    #[inline(always)]
    fn le(self, b: Self) -> u32 {
        // SAFETY: the machine has AVX; see the type.
        unsafe { _mm256_movemask_ps(_mm256_cmp_ps::<_CMP_LE_OQ>(self.0, b.0)) as u32 }
    }

    #[inline(always)]
    fn lt(self, b: Self) -> u32 {
        // SAFETY: the machine has AVX; see the type.
        unsafe { _mm256_movemask_ps(_mm256_cmp_ps::<_CMP_LT_OQ>(self.0, b.0)) as u32 }
    }

    #[inline(always)]
    fn sort_hits(
        enter: Self,
        exit: Self,
        links: &[u32; 8],
        t: &mut [f32; 8],
        sorted: &mut [u32; 8],
    ) -> usize {
        // SAFETY: the machine has AVX2 and popcnt; 32 readable or writable bytes each.
        unsafe {
            let hit = _mm256_castps_si256(_mm256_cmp_ps::<_CMP_LE_OQ>(enter.0, exit.0));
            // Numbers that are not negative are ordered as their bits are. The lane takes the
            // place of the lowest three; what is not hit becomes −1.
            let low = _mm256_set1_epi32(7);
            let lane = _mm256_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7);
            let key = _mm256_or_si256(_mm256_andnot_si256(low, _mm256_castps_si256(enter.0)), lane);
            let key = _mm256_or_si256(key, _mm256_xor_si256(hit, _mm256_set1_epi32(-1)));
            // A bitonic network (Batcher 1968), the largest first.
            let key = exchange::<0x66>(key, _mm256_shuffle_epi32::<0xb1>(key));
            let key = exchange::<0x3c>(key, _mm256_shuffle_epi32::<0x4e>(key));
            let key = exchange::<0x5a>(key, _mm256_shuffle_epi32::<0xb1>(key));
            let key = exchange::<0xf0>(key, _mm256_permute2x128_si256::<1>(key, key));
            let key = exchange::<0xcc>(key, _mm256_shuffle_epi32::<0x4e>(key));
            let key = exchange::<0xaa>(key, _mm256_shuffle_epi32::<0xb1>(key));
            let links = _mm256_loadu_si256(links.as_ptr().cast());
            let links = _mm256_permutevar8x32_epi32(links, key);
            _mm256_storeu_si256(sorted.as_mut_ptr().cast(), links);
            _mm256_storeu_si256(t.as_mut_ptr().cast(), _mm256_andnot_si256(low, key));
            _mm256_movemask_ps(_mm256_castsi256_ps(hit)).count_ones() as usize
        }
    }

    #[inline(always)]
    fn compress(from: u128, mask: usize, to: &mut [u16; 8]) {
        // SAFETY: the machine has SSSE3; 16 readable and 16 writable bytes.
        unsafe {
            let from = _mm_set_epi64x((from >> 64) as i64, from as i64);
            let order = _mm_load_si128(BYTES_OF_SET[mask % 256].0.as_ptr().cast());
            _mm_storeu_si128(to.as_mut_ptr().cast(), _mm_shuffle_epi8(from, order));
        }
    }

    #[inline(always)]
    fn front(self, mask: usize) -> Self {
        // SAFETY: the machine has AVX2; 16 readable bytes.
        unsafe {
            let order = _mm_loadu_si128(SET_BITS[mask & 0xff].as_ptr().cast());
            Self(_mm256_permutevar8x32_ps(
                self.0,
                _mm256_cvtepu16_epi32(order),
            ))
        }
    }

    #[inline(always)]
    fn swap_halves(self) -> Self {
        // SAFETY: the machine has AVX; see the type.
        Self(unsafe { _mm256_permute2f128_ps::<1>(self.0, self.0) })
    }

    #[inline(always)]
    fn transpose(rows: [&[f32; 8]; 8]) -> [Self; 8] {
        let [a, b, c, d, e, f, g, h] = rows;
        let (a, b, c, d) = (
            Self::load(a).0,
            Self::load(b).0,
            Self::load(c).0,
            Self::load(d).0,
        );
        let (e, f, g, h) = (
            Self::load(e).0,
            Self::load(f).0,
            Self::load(g).0,
            Self::load(h).0,
        );
        // SAFETY: the machine has AVX; see the type.
        unsafe {
            // Pairs of rows, then fours, each in both halves; then the halves are brought together.
            let (ab_lo, ab_hi) = (_mm256_unpacklo_ps(a, b), _mm256_unpackhi_ps(a, b));
            let (cd_lo, cd_hi) = (_mm256_unpacklo_ps(c, d), _mm256_unpackhi_ps(c, d));
            let (ef_lo, ef_hi) = (_mm256_unpacklo_ps(e, f), _mm256_unpackhi_ps(e, f));
            let (gh_lo, gh_hi) = (_mm256_unpacklo_ps(g, h), _mm256_unpackhi_ps(g, h));
            let (p0, q0) = (
                _mm256_shuffle_ps::<0x44>(ab_lo, cd_lo),
                _mm256_shuffle_ps::<0x44>(ef_lo, gh_lo),
            );
            let (p1, q1) = (
                _mm256_shuffle_ps::<0xee>(ab_lo, cd_lo),
                _mm256_shuffle_ps::<0xee>(ef_lo, gh_lo),
            );
            let (p2, q2) = (
                _mm256_shuffle_ps::<0x44>(ab_hi, cd_hi),
                _mm256_shuffle_ps::<0x44>(ef_hi, gh_hi),
            );
            let (p3, q3) = (
                _mm256_shuffle_ps::<0xee>(ab_hi, cd_hi),
                _mm256_shuffle_ps::<0xee>(ef_hi, gh_hi),
            );
            [
                Self(_mm256_permute2f128_ps::<0x20>(p0, q0)),
                Self(_mm256_permute2f128_ps::<0x20>(p1, q1)),
                Self(_mm256_permute2f128_ps::<0x20>(p2, q2)),
                Self(_mm256_permute2f128_ps::<0x20>(p3, q3)),
                Self(_mm256_permute2f128_ps::<0x31>(p0, q0)),
                Self(_mm256_permute2f128_ps::<0x31>(p1, q1)),
                Self(_mm256_permute2f128_ps::<0x31>(p2, q2)),
                Self(_mm256_permute2f128_ps::<0x31>(p3, q3)),
            ]
        }
    }

    #[inline(always)]
    fn sort_axes([x, y, z]: [f32; 3], last: Self) -> [Self; 3] {
        // SAFETY: the machine has AVX2; see the type.
        unsafe {
            let point = _mm256_broadcast_ps(&_mm_setr_ps(x, y, z, x));
            let last = _mm256_castps_si256(last.0);
            let (one, two) = (
                _mm256_setr_epi32(1, 2, 0, 1, 1, 2, 0, 1),
                _mm256_setr_epi32(2, 0, 1, 2, 2, 0, 1, 2),
            );
            let first = _mm256_permutevar8x32_epi32(one, last);
            let second = _mm256_permutevar8x32_epi32(two, last);
            [
                Self(_mm256_permutevar8x32_ps(point, first)),
                Self(_mm256_permutevar8x32_ps(point, second)),
                Self(_mm256_permutevar8x32_ps(point, last)),
            ]
        }
    }
}

#[repr(align(16))]
struct Shuffle([u8; 16]);

/// For each mask of eight, the places of the two-byte numbers whose bit is set.
static BYTES_OF_SET: [Shuffle; 256] = {
    let mut table = [const { Shuffle([0; 16]) }; 256];
    let mut mask = 0;
    while mask < 256 {
        let mut i = 0;
        while i < 8 {
            let from = 2 * SET_BITS[mask][i] as u8;
            (table[mask].0[2 * i], table[mask].0[2 * i + 1]) = (from, from + 1);
            i += 1;
        }
        mask += 1;
    }
    table
};

/// One layer of a sorting network: of a lane and its partner, lanes in `MIN` keep the smaller.
#[inline(always)]
fn exchange<const MIN: i32>(key: __m256i, partner: __m256i) -> __m256i {
    // SAFETY: the machine has AVX2; see [`Avx2`].
    unsafe {
        let (smaller, larger) = (
            _mm256_min_epi32(key, partner),
            _mm256_max_epi32(key, partner),
        );
        _mm256_blend_epi32::<MIN>(larger, smaller)
    }
}
