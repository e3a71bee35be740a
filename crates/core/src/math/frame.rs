//! Orthonormal frame around a direction.

use glam::Vec3;

/// Right-handed orthonormal basis whose third axis is a given unit vector.
#[derive(Clone, Copy, Debug)]
pub struct Frame {
    /// First tangent.
    pub s: Vec3,
    /// Second tangent.
    pub t: Vec3,
    /// The given direction.
    pub n: Vec3,
}

impl Frame {
    /// Basis around the unit vector `n`, without a pole (Duff et al. 2017, Building an
    /// Orthonormal Basis, Revisited).
    #[inline(always)]
    pub fn around(n: Vec3) -> Self {
        let sign = 1f32.copysign(n.z);
        let a = -1.0 / (sign + n.z);
        let b = n.x * n.y * a;
        Self {
            s: Vec3::new(1.0 + sign * n.x * n.x * a, sign * b, -sign * n.x),
            t: Vec3::new(b, sign + n.y * n.y * a, -n.y),
            n,
        }
    }

    /// A vector given in this frame, in world coordinates.
    #[inline(always)]
    pub fn world_from_local(&self, v: Vec3) -> Vec3 {
        v.x * self.s + v.y * self.t + v.z * self.n
    }
}
