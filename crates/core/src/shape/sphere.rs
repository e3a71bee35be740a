//! Ray-sphere intersection without cancellation.
//!
//! The textbook discriminant b² − 4ac subtracts large numbers when the sphere is far away or
//! large. Here it is r² − l² with l the distance of the ray from the centre (Haines, Günther &
//! Akenine-Möller 2019, Precision Improvements for Ray/Sphere Intersection), and the smaller root
//! comes from the larger one. All in f64, in which products of f32 are exact: that settles on
//! which side of the surface a ray starts, even a millimetre above a planet.

use glam::Vec3;

use crate::math::Ray;
use crate::planted::{self, Bug};

/// A sphere; its front is the outside.
#[derive(Clone, Copy, Debug)]
pub struct Sphere {
    /// Centre.
    pub center: Vec3,
    /// Radius, positive.
    pub radius: f32,
}

impl Sphere {
    /// The least distance with `0 < t ≤ t_max`, if any.
    #[inline(always)]
    pub fn intersect(&self, ray: &Ray, t_max: f32) -> Option<f32> {
        let t = self.distance(ray);
        let is_behind = t <= 0.0 && !planted::has(Bug::SeedRootRule);
        (t <= t_max && !is_behind).then_some(t)
    }

    /// The least positive distance; if there is none, negative, 0 or no number. Without a branch, so that a
    /// loop over many rays is SIMD code.
    #[inline(always)]
    pub(crate) fn distance(&self, ray: &Ray) -> f32 {
        let (f, d) = (
            ray.origin.as_dvec3() - self.center.as_dvec3(),
            ray.dir.as_dvec3(),
        );
        let r2 = f64::from(self.radius) * f64::from(self.radius);
        let d2 = d.length_squared(); // 1, but for the rounding of the direction
        // Below 0, where the ray passes by, it has no root.
        let rest = d2 * r2 - f.cross(d).length_squared();
        let b = -f.dot(d);
        // q is d² times the root of larger magnitude; 0 only when the ray starts where it touches.
        let q = b + rest.sqrt().copysign(b);
        let other = if q == 0.0 {
            0.0
        } else {
            (f.length_squared() - r2) / q
        };
        let (q, other) = ((q / d2) as f32, other as f32);
        let (near, far) = if q < other { (q, other) } else { (other, q) };
        if planted::has(Bug::SeedRootRule) {
            return if near * far >= 0.0 { near } else { far };
        }
        if near > 0.0 { near } else { far }
    }

    /// Area, square scene units.
    pub fn area(&self) -> f32 {
        4.0 * std::f32::consts::PI * self.radius * self.radius
    }
}
