//! Eight f32 at a time, and which instructions do it.
//!
//! A `Task` is compiled once for every [`Kernel`]. All of them round each operation as IEEE 754
//! asks, so a kernel gives the same bits whichever is chosen; the one exception,
//! `Lanes::mul_add`, is for bounds that allow for either rounding.

#[cfg(target_arch = "x86_64")]
mod avx2;
mod portable;

#[cfg(target_arch = "x86_64")]
pub(crate) use avx2::Avx2;
pub(crate) use portable::Portable;

/// Which instructions rays are cast and paths are shaded with.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Kernel {
    /// What every machine has.
    Portable,
    /// AVX2 and FMA, and the bit operations that come with them.
    #[cfg(target_arch = "x86_64")]
    Avx2,
    /// AVX-512 as from Ice Lake and Zen 4 on, which run it at full clock. Rays meet eight boxes or
    /// triangles at a time as with AVX2, in more registers; shading is sixteen wide.
    #[cfg(target_arch = "x86_64")]
    Avx512,
}

impl Kernel {
    /// What `LIGHTBOX_KERNEL` in the environment asks for, or else the best kernel of this machine.
    /// So is what it asks for if the machine has no such kernel: whoever can tell a user asks
    /// [`Kernel::wished`] first.
    pub fn detect() -> Self {
        let best = *Self::available().last().unwrap_or(&Self::Portable);
        Self::wished().ok().flatten().unwrap_or(best)
    }

    /// The kernel that `LIGHTBOX_KERNEL` in the environment names, if that says anything. The error
    /// is one line.
    pub fn wished() -> Result<Option<Self>, String> {
        let Some(wish) = std::env::var_os("LIGHTBOX_KERNEL").filter(|wish| !wish.is_empty()) else {
            return Ok(None);
        };
        let available = Self::available();
        let kernel = available.iter().find(|kernel| wish == kernel.name());
        kernel.copied().map(Some).ok_or_else(|| {
            let names: Vec<_> = available.iter().map(|kernel| kernel.name()).collect();
            format!(
                "LIGHTBOX_KERNEL in the environment is \"{}\", and this machine has no such kernel; \
                 use one of: {}",
                wish.to_string_lossy().escape_debug(),
                names.join(", ")
            )
        })
    }

    /// Every kernel that runs on this machine, the best last.
    pub fn available() -> Vec<Self> {
        let mut kernels = vec![Self::Portable];
        #[cfg(target_arch = "x86_64")]
        if has_avx2() {
            kernels.push(Self::Avx2);
            if has_avx512() {
                kernels.push(Self::Avx512);
            }
        }
        kernels
    }

    /// `portable`, `avx2` or `avx512`.
    pub fn name(self) -> &'static str {
        match self {
            Self::Portable => "portable",
            #[cfg(target_arch = "x86_64")]
            Self::Avx2 => "avx2",
            #[cfg(target_arch = "x86_64")]
            Self::Avx512 => "avx512",
        }
    }

    /// Runs a task with these instructions. The machine must have them, as those in
    /// [`Kernel::available`] and [`Kernel::detect`] are.
    #[inline(always)]
    pub(crate) fn run<T: Task>(self, task: T) -> T::Output {
        match self {
            Self::Portable => task.run::<Portable>(),
            #[cfg(target_arch = "x86_64")]
            Self::Avx2 => {
                #[expect(unsafe_code, reason = "enters a SIMD kernel")]
                // SAFETY: the kernel is chosen only on machines that have it.
                unsafe {
                    run_avx2(task)
                }
            }
            #[cfg(target_arch = "x86_64")]
            Self::Avx512 => {
                #[expect(unsafe_code, reason = "enters a SIMD kernel")]
                // SAFETY: the kernel is chosen only on machines that have it.
                unsafe {
                    run_avx512(task)
                }
            }
        }
    }
}

/// Work that is compiled for every kernel. `run`, and what it calls in its loops, must be inlined
/// always: what is not is compiled for any machine.
pub(crate) trait Task {
    /// What it gives.
    type Output;
    /// Does it.
    fn run<L: Lanes>(self) -> Self::Output;
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
fn run_avx2<T: Task>(task: T) -> T::Output {
    task.run::<Avx2>()
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx512f,avx512vl,avx512dq,avx512bw,avx512cd,avx512vbmi")]
#[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
fn run_avx512<T: Task>(task: T) -> T::Output {
    task.run::<Avx2>()
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

#[cfg(target_arch = "x86_64")]
fn has_avx512() -> bool {
    is_x86_feature_detected!("avx512f")
        && is_x86_feature_detected!("avx512vl")
        && is_x86_feature_detected!("avx512dq")
        && is_x86_feature_detected!("avx512bw")
        && is_x86_feature_detected!("avx512cd")
        && is_x86_feature_detected!("avx512vbmi")
}

/// Asks for what will soon be read.
#[inline(always)]
pub(crate) fn prefetch<T>(what: &T) {
    let (size, align) = (size_of::<T>(), align_of::<T>());
    // It may end in one line more.
    let last = (align < 64 && align < size).then_some(size - 1);
    for byte in (0..size).step_by(64).chain(last) {
        prefetch_byte(what, byte);
    }
}

/// Asks for the line of memory in which it begins: enough for what lies in a row, one after the other.
#[inline(always)]
pub(crate) fn prefetch_start<T>(what: &T) {
    prefetch_byte(what, 0);
}

#[inline(always)]
fn prefetch_byte<T>(what: &T, byte: usize) {
    #[cfg(target_arch = "x86_64")]
    {
        use std::arch::x86_64::{_MM_HINT_T0, _mm_prefetch};
        let start: *const T = what;
        #[expect(unsafe_code, reason = "memory is asked for ahead")]
        // SAFETY: a hint; reads nothing.
        unsafe {
            _mm_prefetch::<_MM_HINT_T0>(start.wrapping_byte_add(byte).cast());
        }
    }
    #[cfg(not(target_arch = "x86_64"))]
    let _ = (what, byte);
}

/// Eight f32. Comparisons give a bit for each lane, lane 0 in bit 0.
pub(crate) trait Lanes: Copy {
    /// Whether eight rays against one box are as fast as one ray against eight boxes, so that
    /// casting many rays together pays (measured: docs/ray-casting.md).
    const MANY: bool;
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
    /// a / b
    fn div(self, b: Self) -> Self;
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
    /// Of eight numbers of 16 bits, the first in the lowest bits: moves those whose bit in a mask
    /// is set to the front. What follows them means nothing.
    fn compress(from: u128, mask: usize, to: &mut [u16; 8]);
    /// Moves the lanes whose bit in a mask is set to the front. What follows them means nothing.
    fn front(self, mask: usize) -> Self;
    /// The last four lanes, then the first.
    fn swap_halves(self) -> Self;
    /// Eight rows as eight columns.
    fn transpose(rows: [&[f32; 8]; 8]) -> [Self; 8];
    /// The coordinates of a point, in each lane rotated so that the axis whose number, as an
    /// integer, is in `last` comes last.
    fn sort_axes(point: [f32; 3], last: Self) -> [Self; 3];
}

/// For each mask of eight, the bits that are set, the lowest first.
pub(crate) const SET_BITS: [[u16; 8]; 256] = {
    let mut table = [[0; 8]; 256];
    let mut mask = 0;
    while mask < 256 {
        let (mut bit, mut count) = (0, 0);
        while bit < 8 {
            if mask >> bit & 1 == 1 {
                table[mask][count] = bit;
                count += 1;
            }
            bit += 1;
        }
        mask += 1;
    }
    table
};

#[cfg(test)]
mod test {
    use super::*;

    /// Compares the lanes of a kernel with scalars.
    struct Check;

    impl Task for Check {
        type Output = ();

        fn run<L: Lanes>(self) {
            let a = [0.0, -0.0, 1.5, -3.25, 1e-42, f32::MAX, f32::INFINITY, 7.0];
            let b = [-0.0, 1.0, 1.5, -4.0, -1e-42, f32::MIN, 1.0, 1.0 / 3.0];
            let (x, y) = (L::load(&a), L::load(&b));
            let bits = |l: L| l.store().map(f32::to_bits);
            let want = |f: fn(f32, f32) -> f32| {
                std::array::from_fn::<u32, 8, _>(|i| f(a[i], b[i]).to_bits())
            };
            assert_eq!(bits(x.add(y)), want(|a, b| a + b));
            assert_eq!(bits(x.sub(y)), want(|a, b| a - b));
            assert_eq!(bits(x.mul(y)), want(|a, b| a * b));
            assert_eq!(bits(x.div(L::splat(3.0))), want(|a, _| a / 3.0));
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
            let items = [7, 65535, 3, 0, 9, 8, 4095, 1];
            let row = (0..8)
                .rev()
                .fold(0, |row, i| row << 16 | u128::from(items[i]));
            for mask in 0..256 {
                let mut got = [0; 8];
                L::compress(row, mask, &mut got);
                let want = (0..8).filter(|&i| mask >> i & 1 == 1).map(|i| items[i]);
                assert!(
                    want.eq(got[..mask.count_ones() as usize].iter().copied()),
                    "{mask}"
                );
            }
            for mask in 0..256 {
                let got = x.front(mask).store();
                let want = (0..8).filter(|&i| mask >> i & 1 == 1).map(|i| a[i]);
                assert!(
                    want.eq(got[..mask.count_ones() as usize].iter().copied()),
                    "{mask}"
                );
            }
            let swapped = x.swap_halves().store();
            assert_eq!(swapped, std::array::from_fn(|i| a[(i + 4) % 8]));
            let rows: [[f32; 8]; 8] =
                std::array::from_fn(|i| std::array::from_fn(|j| (8 * i + j) as f32));
            let columns = L::transpose(rows.each_ref());
            for (j, column) in columns.iter().enumerate() {
                assert_eq!(column.store(), std::array::from_fn(|i| rows[i][j]));
            }
            let last: [u32; 8] = [0, 1, 2, 2, 1, 0, 0, 2];
            let sorted = L::sort_axes([10.0, 11.0, 12.0], L::load(&last.map(f32::from_bits)));
            for (k, sorted) in sorted.iter().enumerate() {
                let want = last.map(|z| 10.0 + ((z as usize + 1 + k) % 3) as f32);
                assert_eq!(sorted.store(), want);
            }
            let sum = L::splat(3.0).mul_add(L::splat(5.0), L::splat(-1.0));
            assert_eq!(sum.store(), [14.0; 8]);
        }
    }

    #[test]
    fn lanes_compute_what_scalars_do() {
        for kernel in Kernel::available() {
            kernel.run(Check);
        }
    }
}
