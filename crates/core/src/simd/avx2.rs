//! Eight lanes as one AVX register.
#![expect(unsafe_code, reason = "vendor intrinsics are unsafe to call")]

use std::arch::x86_64::{
    __m256, __m256i, _CMP_LE_OQ, _CMP_LT_OQ, _MM_HINT_T0, _mm_prefetch, _mm256_add_ps,
    _mm256_andnot_si256, _mm256_blend_epi32, _mm256_castps_si256, _mm256_castsi256_ps,
    _mm256_cmp_ps, _mm256_fmadd_ps, _mm256_loadu_ps, _mm256_loadu_si256, _mm256_max_epi32,
    _mm256_max_ps, _mm256_min_epi32, _mm256_min_ps, _mm256_movemask_ps, _mm256_mul_ps,
    _mm256_or_si256, _mm256_permute2x128_si256, _mm256_permutevar8x32_epi32, _mm256_set1_epi32,
    _mm256_set1_ps, _mm256_setr_epi32, _mm256_shuffle_epi32, _mm256_storeu_ps, _mm256_storeu_si256,
    _mm256_sub_ps, _mm256_xor_si256,
};

use super::Lanes;

/// Eight f32. Made and used only inside functions compiled for AVX2 and FMA, which are entered
/// after the machine was found to have them (see [`super::Kernel`]); that is the reason for each
/// unsafe block below.
#[derive(Clone, Copy)]
pub(crate) struct Avx2(__m256);

impl Lanes for Avx2 {
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
    fn prefetch<T>(what: &T) {
        let start: *const T = what;
        for line in (0..size_of::<T>()).step_by(64) {
            // SAFETY: a hint; reads nothing.
            unsafe { _mm_prefetch::<_MM_HINT_T0>(start.byte_add(line).cast()) };
        }
    }
}

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
