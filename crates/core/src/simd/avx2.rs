//! Eight lanes as one AVX register.
#![expect(unsafe_code, reason = "vendor intrinsics are unsafe to call")]

use std::arch::x86_64::{
    __m256, _CMP_LE_OQ, _CMP_LT_OQ, _mm256_add_ps, _mm256_cmp_ps, _mm256_fmadd_ps, _mm256_loadu_ps,
    _mm256_max_ps, _mm256_min_ps, _mm256_movemask_ps, _mm256_mul_ps, _mm256_set1_ps,
    _mm256_storeu_ps, _mm256_sub_ps,
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
}
