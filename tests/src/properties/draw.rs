//! Numbers out of bytes.

use glam::Vec3;

/// Values at which arithmetic changes its ways.
const EDGES: [f32; 14] = [
    0.0,
    -0.0,
    1e-45,
    f32::MIN_POSITIVE,
    1e-38,
    1e-19,
    1e19,
    1e38,
    f32::MAX,
    f32::INFINITY,
    f32::NEG_INFINITY,
    f32::NAN,
    1.0,
    -1.0,
];

/// Reads numbers from bytes; zeros once these have run out.
pub struct Draw<'a>(&'a [u8]);

impl<'a> Draw<'a> {
    /// Starts at the first byte.
    pub fn new(bytes: &'a [u8]) -> Self {
        Self(bytes)
    }

    /// Whether bytes are left.
    pub fn has_more(&self) -> bool {
        !self.0.is_empty()
    }

    /// The next byte.
    pub fn byte(&mut self) -> u8 {
        let Some((first, rest)) = self.0.split_first() else {
            return 0;
        };
        self.0 = rest;
        *first
    }

    /// The next four bytes.
    pub fn word(&mut self) -> u32 {
        u32::from_le_bytes([0; 4].map(|_| self.byte()))
    }

    /// A number from 0 to `n − 1`, `n` at most 256.
    pub fn below(&mut self, n: usize) -> usize {
        self.byte() as usize % n
    }

    /// One of some values.
    pub fn of<T: Copy>(&mut self, values: &[T]) -> T {
        values[self.below(values.len())]
    }

    /// Any f32 at all, often a special one.
    pub fn any(&mut self) -> f32 {
        match self.below(4) {
            0 => self.of(&EDGES),
            1 => f32::from_bits(self.word()),
            _ => self.coordinate(20),
        }
    }

    /// A number in [0, 1), often at an end.
    pub fn unit(&mut self) -> f32 {
        match self.below(8) {
            0 => 0.0,
            1 => 1.0 - f32::EPSILON * 0.5,
            2 => f32::EPSILON * 0.5,
            3 => 0.5,
            _ => (self.word() >> 8) as f32 * (1.0 / (1 << 24) as f32),
        }
    }

    /// Zero of either sign, or a number of a size between 2^−`range` and 2^`range`: often a small
    /// whole one, so that points coincide and line up.
    pub fn coordinate(&mut self, range: i32) -> f32 {
        match self.below(4) {
            0 | 1 => f32::from(i16::from(self.byte() as i8) >> 4),
            2 => self.of(&[0.0, -0.0, 0.5, -0.5, 0.25, 1.0 / 3.0]),
            _ => {
                let bits = self.word();
                let mantissa = 1.0 + (bits >> 9) as f32 * (1.0 / (1 << 23) as f32);
                let exponent = i32::from(self.byte()) % (2 * range) - range;
                let sign = if bits & 1 == 0 { 1.0 } else { -1.0 };
                sign * mantissa * 2f32.powi(exponent)
            }
        }
    }

    /// Three coordinates.
    pub fn point(&mut self, range: i32) -> Vec3 {
        Vec3::from_array([0; 3].map(|_| self.coordinate(range)))
    }

    /// Three numbers of any kind.
    pub fn any_point(&mut self) -> Vec3 {
        Vec3::from_array([0; 3].map(|_| self.any()))
    }

    /// A unit vector, often along an axis, with zeros of both signs.
    pub fn direction(&mut self) -> Vec3 {
        let v = match self.below(3) {
            0 => {
                let axis = Vec3::AXES[self.below(3)] * self.of(&[1.0, -1.0]);
                let zero = self.of(&[0.0, -0.0]);
                return axis.map(|x| if x == 0.0 { zero } else { x });
            }
            1 => self.point(20),
            _ => self.point(2),
        };
        unit(v)
    }
}

/// The unit vector along `v`; x for zero.
pub fn unit(v: Vec3) -> Vec3 {
    v.as_dvec3().normalize_or(glam::DVec3::X).as_vec3()
}
