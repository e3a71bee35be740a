//! The ray, and the one place where a ray leaves a surface.

use glam::Vec3;

use crate::planted::{self, Bug};

/// A half-line with an end: the points `origin + t·dir` for `0 < t ≤ t_max`.
#[derive(Clone, Copy, Debug)]
pub struct Ray {
    /// Start, scene units.
    pub origin: Vec3,
    /// Direction of unit length (to within a few ulp), so that `t` is a distance.
    pub dir: Vec3,
    /// Largest distance that counts as a hit; may be infinite.
    pub t_max: f32,
}

impl Ray {
    /// A ray without end; `dir` must have unit length.
    pub fn new(origin: Vec3, dir: Vec3) -> Self {
        Self {
            origin,
            dir,
            t_max: f32::INFINITY,
        }
    }

    /// The point at distance `t`.
    pub fn at(&self, t: f32) -> Vec3 {
        self.origin + t * self.dir
    }
}

/// Bound γₙ = nε/(1−nε) on the relative error of `n` f32 operations in a row, with ε = 2⁻²⁴
/// (Higham 2002, Accuracy and Stability of Numerical Algorithms).
pub const fn gamma(n: u32) -> f32 {
    let e = n as f32 * (f32::EPSILON * 0.5);
    e / (1.0 - e)
}

/// Start point for a ray that leaves the surface at `p` in direction `w`: `p` moved along the
/// normal `n` out of the box of half-size `p_err` in which the true hit point lies, to the side
/// of `w`, and rounded away from `p` (Pharr, Jakob & Humphreys 2016, §3.9.5). Relative to the
/// coordinates, so a scene scaled by 2ᵏ gives the same point scaled by 2ᵏ.
pub fn offset_origin(p: Vec3, p_err: Vec3, n: Vec3, w: Vec3) -> Vec3 {
    let mut distance = n.abs().dot(p_err);
    if planted::has(Bug::EpsilonTimes100) {
        distance *= 100.0;
    }
    let offset = if w.dot(n) < 0.0 { -distance } else { distance } * n;
    let moved = p + offset;
    // One or two ulp further; a coordinate that the normal does not touch stays.
    let away = offset.cmpne(Vec3::ZERO);
    let ulp = moved.abs() * f32::EPSILON;
    moved + Vec3::select(away, ulp * offset.signum(), Vec3::ZERO)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn offset_leaves_the_error_box_on_the_side_of_the_direction() {
        let p = Vec3::new(1234.5, -0.25, 3e-4);
        let p_err = gamma(7) * p.abs();
        for n in [Vec3::X, Vec3::Y, -Vec3::Z, Vec3::new(0.6, -0.8, 0.0)] {
            for w in [n, -n] {
                let o = offset_origin(p, p_err, n, w);
                assert!((o - p).dot(w) >= n.abs().dot(p_err) * 0.999, "{n} {w}");
            }
        }
    }

    #[test]
    fn offset_scales_with_the_scene_bit_for_bit() {
        let p = Vec3::new(0.3, -7.25, 11.0);
        let n = Vec3::new(0.48, 0.6, -0.64);
        for k in [-40, -3, 1, 17, 40] {
            let s = 2f32.powi(k);
            let scaled = offset_origin(p * s, gamma(7) * p.abs() * s, n, n);
            assert_eq!(scaled, offset_origin(p, gamma(7) * p.abs(), n, n) * s);
        }
    }
}
