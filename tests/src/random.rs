//! Independent random numbers from a seed.

use glam::Vec3;

/// Permuted congruential generator (O'Neill 2014), PCG-XSH-RR.
#[derive(Clone, Debug)]
pub struct Pcg(u64);

impl Pcg {
    /// Seeds that follow each other give unrelated numbers.
    pub fn new(seed: u64) -> Self {
        let mut pcg = Self(seed.wrapping_mul(0x9e37_79b9_7f4a_7c15));
        pcg.word();
        pcg
    }

    /// 32 random bits.
    pub fn word(&mut self) -> u32 {
        let old = self.0;
        self.0 = old
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        ((((old >> 18) ^ old) >> 27) as u32).rotate_right((old >> 59) as u32)
    }

    /// A number from 0 to `n − 1`.
    pub fn below(&mut self, n: usize) -> usize {
        self.word() as usize % n
    }

    /// Uniform in [0, 1).
    pub fn unit(&mut self) -> f32 {
        (self.word() >> 8) as f32 * (1.0 / (1 << 24) as f32)
    }

    /// Uniform in [−1, 1)³.
    pub fn cube(&mut self) -> Vec3 {
        Vec3::from_array([0; 3].map(|_| self.unit() * 2.0 - 1.0))
    }

    /// Uniform on the unit sphere.
    pub fn direction(&mut self) -> Vec3 {
        lightbox_core::math::warp::uniform_sphere([self.unit(), self.unit()])
    }

    /// Random bytes.
    pub fn string(&mut self, length: usize) -> Vec<u8> {
        (0..length).map(|_| self.word() as u8).collect()
    }

    /// A string with a few bytes changed, cut off, or replaced by a part of another string.
    pub fn vary(&mut self, seed: &[u8], others: &[Vec<u8>]) -> Vec<u8> {
        let mut bytes = seed.to_vec();
        for _ in 0..=self.below(4) {
            let at = self.below(bytes.len() + 1);
            match self.below(4) {
                0 => bytes.truncate(at),
                1 => {
                    let other = &others[self.below(others.len())];
                    let (from, to) = (self.below(other.len() + 1), self.below(other.len() + 1));
                    let part = &other[from.min(to)..from.max(to)];
                    let end = (at + part.len()).min(bytes.len());
                    bytes.splice(at..end, part.iter().copied());
                }
                _ if at < bytes.len() => bytes[at] = self.word() as u8,
                _ => {}
            }
        }
        bytes
    }
}
