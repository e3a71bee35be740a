//! Eight f32 at a time, and which instructions do it.
//!
//! Kernels are generic over `Lanes` and compiled once for every implementor. All of them round
//! each operation as IEEE 754 asks, so a kernel gives the same bits whichever is chosen; the one
//! exception, `Lanes::mul_add`, is for bounds that allow for either rounding.
//!
//! Sixteen lanes (AVX-512) would be a third implementor with its own node width; there is none
//! because none could be tested.

#[cfg(target_arch = "x86_64")]
mod avx2;
mod portable;

#[cfg(target_arch = "x86_64")]
pub(crate) use avx2::Avx2;
pub(crate) use portable::Portable;

/// Which instructions the ray kernels use.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kernel {
    /// What every machine has.
    Portable,
    /// AVX2 and FMA, and the bit operations that come with them.
    #[cfg(target_arch = "x86_64")]
    Avx2,
}

impl Kernel {
    /// The best kernel of this machine; `LIGHTBOX_KERNEL=portable` in the environment takes the
    /// portable one all the same.
    pub fn detect() -> Self {
        let forced = std::env::var_os("LIGHTBOX_KERNEL").is_some_and(|name| name == "portable");
        #[cfg(target_arch = "x86_64")]
        if !forced && Self::has_avx2() {
            return Self::Avx2;
        }
        let _ = forced;
        Self::Portable
    }

    /// Every kernel that runs on this machine.
    pub fn available() -> Vec<Self> {
        #[cfg(target_arch = "x86_64")]
        if Self::has_avx2() {
            return vec![Self::Portable, Self::Avx2];
        }
        vec![Self::Portable]
    }

    #[cfg(target_arch = "x86_64")]
    fn has_avx2() -> bool {
        is_x86_feature_detected!("avx2")
            && is_x86_feature_detected!("fma")
            && is_x86_feature_detected!("bmi1")
            && is_x86_feature_detected!("bmi2")
            && is_x86_feature_detected!("lzcnt")
            && is_x86_feature_detected!("popcnt")
    }
}

/// Eight f32. Comparisons give a bit for each lane, lane 0 in bit 0.
pub(crate) trait Lanes: Copy {
    /// The same value in every lane.
    fn splat(x: f32) -> Self;
    /// Eight numbers in a row.
    fn load(from: &[f32; 8]) -> Self;
    /// The lanes in a row.
    fn store(self) -> [f32; 8];
    /// a + b
    fn add(self, b: Self) -> Self;
    /// a − b
    fn sub(self, b: Self) -> Self;
    /// a · b
    fn mul(self, b: Self) -> Self;
    /// a · b + c, rounded once or twice.
    fn mul_add(self, b: Self, c: Self) -> Self;
    /// The smaller; no matter which if one is NaN.
    fn min(self, b: Self) -> Self;
    /// The larger; no matter which if one is NaN.
    fn max(self, b: Self) -> Self;
    /// a ≤ b
    fn le(self, b: Self) -> u32;
    /// a < b
    fn lt(self, b: Self) -> u32;
    /// Of the lanes with `enter` ≤ `exit`: writes `enter` (none negative, and possibly a few ulp
    /// less) and what `links` says, by falling `enter`, and gives their number. What follows them
    /// means nothing.
    fn sort_hits(
        enter: Self,
        exit: Self,
        links: &[u32; 8],
        t: &mut [f32; 8],
        sorted: &mut [u32; 8],
    ) -> usize;
    /// Asks for what will soon be read.
    fn prefetch<T>(what: &T);
}

#[cfg(test)]
mod test {
    use super::*;

    fn check<L: Lanes>() {
        let a = [0.0, -0.0, 1.5, -3.25, 1e-42, f32::MAX, f32::INFINITY, 7.0];
        let b = [-0.0, 1.0, 1.5, -4.0, -1e-42, f32::MIN, 1.0, 1.0 / 3.0];
        let (x, y) = (L::load(&a), L::load(&b));
        let bits = |l: L| l.store().map(f32::to_bits);
        let want =
            |f: fn(f32, f32) -> f32| std::array::from_fn::<u32, 8, _>(|i| f(a[i], b[i]).to_bits());
        assert_eq!(bits(x.add(y)), want(|a, b| a + b));
        assert_eq!(bits(x.sub(y)), want(|a, b| a - b));
        assert_eq!(bits(x.mul(y)), want(|a, b| a * b));
        assert_eq!(x.min(y).store(), std::array::from_fn(|i| a[i].min(b[i])));
        assert_eq!(x.max(y).store(), std::array::from_fn(|i| a[i].max(b[i])));
        let mask =
            |f: fn(f32, f32) -> bool| (0..8).fold(0, |m, i| m | u32::from(f(a[i], b[i])) << i);
        assert_eq!(x.le(y), mask(|a, b| a <= b));
        assert_eq!(x.lt(y), mask(|a, b| a < b));
        let nan = L::splat(f32::NAN);
        assert_eq!((nan.le(x), x.lt(nan)), (0, 0));
        let enter = [5.0, 0.0, 7.0, 5.0, 3e-30, 1e30, 2.0, 9.0];
        let exit = [6.0, 0.0, 6.0, 5.0, 4e-30, f32::INFINITY, 1.0, 9.0];
        let links = [10, 11, 12, 13, 14, 15, 16, 17];
        let (enter8, exit8) = (L::load(&enter), L::load(&exit));
        let (mut t, mut sorted) = ([0.0; 8], [0; 8]);
        let count = L::sort_hits(enter8, exit8, &links, &mut t, &mut sorted);
        let links = sorted;
        assert_eq!(count, 6);
        for (t, link) in t.iter().zip(links).take(count) {
            let exact = enter[link as usize - 10];
            assert!(*t <= exact && *t >= exact * (1.0 - 1e-6), "{t} {exact}");
        }
        assert!(t[..count].is_sorted_by(|a, b| a >= b), "{t:?}");
        assert_eq!((links[0], links[1], links[4], links[5]), (15, 17, 14, 11));
        let sum = L::splat(3.0).mul_add(L::splat(5.0), L::splat(-1.0));
        assert_eq!(sum.store(), [14.0; 8]);
    }

    #[test]
    fn lanes_compute_what_scalars_do() {
        check::<Portable>();
        #[cfg(target_arch = "x86_64")]
        if Kernel::available().contains(&Kernel::Avx2) {
            check::<Avx2>();
        }
    }
}
