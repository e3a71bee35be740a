//! Random numbers for tests and probes; pictures have [`crate::sampler`].

use glam::{DVec3, Vec3};

/// Permuted congruential generator (O'Neill 2014), PCG-XSH-RR.
#[derive(Clone, Debug)]
pub struct Rng(pub u64);

impl Rng {
    /// Seeds that follow each other give unrelated numbers; as states of `Rng` they would not at
    /// first.
    pub fn new(seed: u64) -> Self {
        let mut rng = Self(seed.wrapping_mul(0x9e37_79b9_7f4a_7c15));
        rng.bits();
        rng
    }

    /// 32 random bits.
    pub fn bits(&mut self) -> u32 {
        let old = self.0;
        self.0 = old
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        ((((old >> 18) ^ old) >> 27) as u32).rotate_right((old >> 59) as u32)
    }

    /// A number from 0 to `n − 1`.
    pub fn below(&mut self, n: usize) -> usize {
        self.bits() as usize % n
    }

    /// Uniform in [0, 1).
    pub fn unit(&mut self) -> f32 {
        (self.bits() >> 8) as f32 / (1 << 24) as f32
    }

    /// Uniform in [−1, 1)³.
    pub fn cube(&mut self) -> Vec3 {
        Vec3::from_array([0; 3].map(|_| self.unit() * 2.0 - 1.0))
    }

    /// Uniform on the unit sphere, of unit length to an ulp.
    pub fn direction(&mut self) -> Vec3 {
        let (z, phi) = (
            1.0 - 2.0 * f64::from(self.unit()),
            std::f64::consts::TAU * f64::from(self.unit()),
        );
        let r = (1.0 - z * z).max(0.0).sqrt();
        DVec3::new(r * libm::cos(phi), r * libm::sin(phi), z).as_vec3()
    }

    /// As [`Rng::direction`], on the side of `n`.
    pub fn direction_about(&mut self, n: Vec3) -> Vec3 {
        let d = self.direction();
        if d.dot(n) < 0.0 { -d } else { d }
    }

    /// 10 to a power within ±`decades`.
    pub fn magnitude(&mut self, decades: f64) -> f32 {
        libm::pow(10.0, decades * (2.0 * f64::from(self.unit()) - 1.0)) as f32
    }

    /// Uniform on a triangle.
    pub fn point_of(&mut self, [a, b, c]: [Vec3; 3]) -> Vec3 {
        let (mut u, mut v) = (self.unit(), self.unit());
        if u + v > 1.0 {
            (u, v) = (1.0 - u, 1.0 - v);
        }
        a + (b - a) * u + (c - a) * v
    }

    /// Triangles anywhere in [−1, 1)³, their corners within `size` of their centres.
    pub fn soup(&mut self, n: usize, size: f32) -> Vec<[Vec3; 3]> {
        let mut triangle = || {
            let center = self.cube();
            [0; 3].map(|_| center + size * self.cube())
        };
        (0..n).map(|_| triangle()).collect()
    }

    /// Puts items into any order.
    pub fn shuffle<T>(&mut self, items: &mut [T]) {
        for i in (1..items.len()).rev() {
            items.swap(i, self.below(i + 1));
        }
    }
}
