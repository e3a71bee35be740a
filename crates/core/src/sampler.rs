//! Random numbers as a pure function of (pixel, sample, seed, dimension): nothing is stored, so
//! samples can be taken in any order, on any thread, or again.
//!
//! Sample `i` belongs to half `i & 1`: the two halves use unrelated randomisations and are
//! accumulated apart, so that their difference measures the noise of the picture.

use crate::math::{Floats, GROUP};
use crate::planted::{self, Bug};
use crate::settings::SamplerKind;

/// What a random number, or a pair, is for. Numbered by purpose, not by order of use, so that a
/// branch not taken shifts nothing.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Dim {
    /// Position in the pixel filter.
    Pixel,
    /// Positions of more camera rays there.
    Sights,
    /// Direction of the BSDF at a bounce (the first surface is bounce 0).
    BsdfDirection(u32),
    /// Lobe of the BSDF.
    Lobe(u32),
    /// Russian roulette.
    Roulette(u32),
    /// Which light.
    LightPick(u32),
    /// Point on the light.
    LightPoint(u32),
    /// Which light, and which mirror sphere, for light by way of it.
    ReflectionPick(u32),
    /// Point on that light.
    ReflectionPoint(u32),
    /// Which mark of the guide to caustics.
    GuidePick(u32),
    /// A direction towards it.
    GuideDirection(u32),
}

impl Dim {
    #[inline(always)]
    fn index(self) -> u32 {
        match self {
            Self::Pixel => 0,
            Self::Sights => u32::MAX >> 1,
            Self::BsdfDirection(b) => b.wrapping_mul(5).wrapping_add(1),
            Self::Lobe(b) => b.wrapping_mul(5).wrapping_add(2),
            Self::Roulette(b) => b.wrapping_mul(5).wrapping_add(3),
            Self::LightPick(b) => b.wrapping_mul(5).wrapping_add(4),
            Self::LightPoint(b) => b.wrapping_mul(5).wrapping_add(5),
            // Beyond those of any bounce that comes to pass.
            Self::ReflectionPick(b) => b.wrapping_mul(2).wrapping_add(1 << 31),
            Self::ReflectionPoint(b) => b.wrapping_mul(2).wrapping_add(1 << 31 | 1),
            Self::GuidePick(b) => b.wrapping_mul(2).wrapping_add(3 << 30),
            Self::GuideDirection(b) => b.wrapping_mul(2).wrapping_add(3 << 30 | 1),
        }
    }
}

/// The random numbers of one sample of one pixel.
#[derive(Clone, Copy, Debug)]
pub struct Sampler {
    kind: SamplerKind,
    /// Everything but the index and the dimension, mixed.
    key: u64,
    /// Index within the half, low bits (the high bits are in `key`).
    index: u32,
}

impl Sampler {
    /// The numbers of sample `sample` of pixel (`x`, `y`).
    pub fn new(kind: SamplerKind, seed: u64, [x, y]: [u32; 2], sample: u64) -> Self {
        let (half, index) = (sample & 1, sample >> 1);
        let key = mix(seed ^ 0x6c69_6768_7462_6f78);
        let key = mix(key ^ (u64::from(x) << 32 | u64::from(y)));
        let key = mix(key ^ ((index >> 32) << 1 | half));
        Self {
            kind,
            key,
            index: index as u32,
        }
    }

    /// Of `count` times as many samples, those that stand for this one.
    pub(crate) fn split(self, count: u32) -> impl ExactSizeIterator<Item = Self> {
        (0..count).map(move |i| Self {
            index: self.index.wrapping_mul(count).wrapping_add(i),
            ..self
        })
    }

    #[inline(always)]
    fn key(&self, dim: Dim) -> u64 {
        let dim = if planted::has(Bug::DimensionsShared) {
            Dim::Pixel
        } else {
            dim
        };
        mix(self
            .key
            .wrapping_add(u64::from(dim.index()).wrapping_mul(0x9e37_79b9_7f4a_7c15)))
    }

    /// A number in [0, 1).
    #[inline(always)]
    pub(crate) fn get_1d(&self, dim: Dim) -> f32 {
        let key = self.key(dim);
        match self.kind {
            SamplerKind::Independent => unit_f32((mix(key ^ u64::from(self.index)) >> 32) as u32),
            // Shuffled as in two dimensions, though nothing is paired here: the order of samples
            // must not be that of another dimension.
            SamplerKind::Sobol => {
                let reversed = owen(self.index.reverse_bits(), key as u32);
                let x = owen(reversed.reverse_bits(), (key >> 32) as u32);
                unit_f32(x.reverse_bits())
            }
        }
    }

    /// Two numbers in [0, 1).
    #[inline(always)]
    pub fn get_2d(&self, dim: Dim) -> [f32; 2] {
        let key = self.key(dim);
        match self.kind {
            SamplerKind::Independent => {
                let bits = mix(key ^ u64::from(self.index));
                [unit_f32((bits >> 32) as u32), unit_f32(bits as u32)]
            }
            SamplerKind::Sobol => {
                // Burley 2020, Practical Hash-Based Owen Scrambling: the index is shuffled by a
                // nested uniform permutation, then each coordinate is scrambled the same way.
                // `reversed` is the shuffled index with its bits reversed: the van der Corput
                // point, which is the first Sobol coordinate.
                let reversed = owen(self.index.reverse_bits(), key as u32);
                let x = owen(reversed.reverse_bits(), (key >> 32) as u32);
                let y = owen(
                    sobol_second(reversed).reverse_bits(),
                    (key >> 17) as u32 ^ 0x5bd1_e995,
                );
                [unit_f32(x.reverse_bits()), unit_f32(y.reverse_bits())]
            }
        }
    }
}

/// Samplers side by side, all of one kind.
#[derive(Debug)]
pub(crate) struct Samplers {
    kind: SamplerKind,
    keys: [u64; GROUP],
    indices: [u32; GROUP],
}

impl Default for Samplers {
    fn default() -> Self {
        Self {
            kind: SamplerKind::Sobol,
            keys: [0; GROUP],
            indices: [0; GROUP],
        }
    }
}

impl Samplers {
    #[inline(always)]
    pub fn get(&self, lane: usize) -> Sampler {
        Sampler {
            kind: self.kind,
            key: self.keys[lane],
            index: self.indices[lane],
        }
    }

    #[inline(always)]
    pub fn set(&mut self, lane: usize, sampler: &Sampler) {
        self.kind = sampler.kind;
        (self.keys[lane], self.indices[lane]) = (sampler.key, sampler.index);
    }

    /// [`Sampler::get_1d`] of every lane.
    #[inline(always)]
    pub fn get_1d(&self, dim: Dim) -> Floats {
        let mut u = [0.0; GROUP];
        for (lane, u) in u.iter_mut().enumerate() {
            *u = self.get(lane).get_1d(dim);
        }
        u
    }

    /// [`Sampler::get_2d`] of every lane.
    #[inline(always)]
    pub fn get_2d(&self, dim: Dim) -> [Floats; 2] {
        let [mut x, mut y] = [[0.0; GROUP]; 2];
        for lane in 0..GROUP {
            [x[lane], y[lane]] = self.get(lane).get_2d(dim);
        }
        [x, y]
    }
}

/// The 24 high bits as a number in [0, 1 − 2⁻²⁴]: a plain division by 2³² could round up to 1.
#[inline(always)]
pub(crate) fn unit_f32(bits: u32) -> f32 {
    if planted::has(Bug::UReachesOne) {
        return bits as f32 * (1.0 / (1u64 << 32) as f32);
    }
    // Signed, because only that conversion is an instruction of every machine.
    (bits >> 8) as i32 as f32 * (1.0 / (1 << 24) as f32)
}

/// Permutes all 2⁶⁴ numbers with good avalanche (Stafford's variant 13 of the MurmurHash3 finaliser).
#[inline(always)]
fn mix(mut x: u64) -> u64 {
    x = (x ^ (x >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    x = (x ^ (x >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    x ^ (x >> 31)
}

/// A random permutation in which each bit depends only on the bits below it: on bit-reversed
/// numbers, Owen's nested uniform scrambling (Laine & Karras 2011, constants by Vegdahl 2021).
#[inline(always)]
fn owen(mut x: u32, seed: u32) -> u32 {
    x ^= x.wrapping_mul(0x3d20_adea);
    x = x.wrapping_add(seed);
    x = x.wrapping_mul((seed >> 16) | 1);
    x ^= x.wrapping_mul(0x0552_6c56);
    x ^ x.wrapping_mul(0x53a2_2864)
}

/// The second Sobol coordinate of an index, given the first: multiplication of the bit vector
/// by Pascal's triangle modulo 2, which is a Kronecker power and so takes five steps.
#[inline(always)]
fn sobol_second(van_der_corput: u32) -> u32 {
    let mut x = van_der_corput;
    x ^= (x & 0x5555_5555) << 1;
    x ^= (x & 0x3333_3333) << 2;
    x ^= (x & 0x0f0f_0f0f) << 4;
    x ^= (x & 0x00ff_00ff) << 8;
    x ^ ((x & 0x0000_ffff) << 16)
}
