//! The ray, and the one place where a ray leaves a surface.

use glam::{DVec3, Vec3};

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
pub(crate) const fn gamma(n: u32) -> f32 {
    let e = n as f32 * (f32::EPSILON * 0.5);
    e / (1.0 - e)
}

/// The point in f32 that is next to `exact`, but on no axis on the far side of it as seen along
/// `along`; where that is 0, the nearest.
#[inline(always)]
pub(crate) fn round_along(exact: DVec3, along: DVec3) -> Vec3 {
    let axis = |exact: f64, along: f64| {
        let nearest = exact as f32;
        let error = f64::from(nearest) - exact;
        if error * along >= 0.0 {
            nearest
        } else if along > 0.0 {
            nearest.next_up()
        } else {
            nearest.next_down()
        }
    };
    Vec3::new(
        axis(exact.x, along.x),
        axis(exact.y, along.y),
        axis(exact.z, along.z),
    )
}

/// Start point for a ray that leaves the surface at `p`: `p` moved by `offset`, to the other side
/// of the rounding error of `p`, and rounded away from `p` (after Pharr, Jakob & Humphreys 2016,
/// §3.9.5). Where nothing has to move, `p` itself. Relative to the coordinates, so a scene scaled
/// by 2ᵏ gives the same point scaled by 2ᵏ.
#[inline(always)]
pub(crate) fn offset_origin(p: Vec3, mut offset: Vec3) -> Vec3 {
    if planted::has(Bug::EpsilonTimes100) {
        offset += 100.0 * f32::EPSILON * p.abs() * offset.signum();
    }
    let offset = offset.as_dvec3();
    round_along(p.as_dvec3() + offset, offset)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rounding_never_goes_against_the_direction() {
        for exact in [1.0 + 1e-9, 1.0 - 1e-9, -1e-60, 1_234.567_89, -0.3, 1.0] {
            for along in [1.0, -1.0] {
                let error = |p: Vec3| f64::from(p.x) - exact;
                let e = error(round_along(DVec3::splat(exact), DVec3::splat(along)));
                let ulp = exact.abs() * f64::from(f32::EPSILON) + f64::from(f32::from_bits(1));
                assert!(e * along >= 0.0 && e.abs() <= ulp, "{exact} {along}: {e}");
                let nearest = error(round_along(DVec3::splat(exact), DVec3::ZERO));
                assert!(nearest.abs() <= e.abs());
            }
        }
    }

    #[test]
    fn an_offset_moves_at_least_as_far_and_scales_bit_for_bit() {
        let p = Vec3::new(1234.5, -0.25, 3e-4);
        assert_eq!(offset_origin(p, Vec3::ZERO), p);
        for n in [Vec3::X, Vec3::Y, -Vec3::Z, Vec3::new(0.6, -0.8, 0.0)] {
            for size in [1e-12, 1e-5] {
                let o = offset_origin(p, size * n);
                let moved = (o.as_dvec3() - p.as_dvec3()).dot(n.as_dvec3());
                assert!(moved >= f64::from(size) * 0.999_999, "{n} {moved}");
                for k in [-40, -3, 1, 17, 40] {
                    let s = 2f32.powi(k);
                    assert_eq!(offset_origin(p * s, size * n * s), o * s);
                }
            }
        }
    }
}
