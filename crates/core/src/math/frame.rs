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
    pub fn world_from_local(&self, v: Vec3) -> Vec3 {
        v.x * self.s + v.y * self.t + v.z * self.n
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frame_is_orthonormal_everywhere_and_at_both_poles() {
        let mut directions = vec![Vec3::Z, -Vec3::Z, Vec3::new(0.0, 0.0, -0.0) - Vec3::Z];
        for i in 0..20_000u32 {
            let u = [(i as f32 + 0.5) / 20_000.0, (i as f32 * 0.618_034).fract()];
            directions.push(super::super::warp::uniform_sphere(u));
        }
        for n in directions {
            let f = Frame::around(n);
            for (a, b, expected) in [
                (f.s, f.s, 1.0),
                (f.t, f.t, 1.0),
                (f.s, f.t, 0.0),
                (f.s, n, 0.0),
                (f.t, n, 0.0),
            ] {
                assert!(
                    (a.dot(b) - expected).abs() <= 4.0 * f32::EPSILON,
                    "{n}: {f:?}"
                );
            }
            assert!(f.s.cross(f.t).dot(n) > 0.999);
        }
    }
}
