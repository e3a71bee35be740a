//! Ray-sphere intersection without cancellation.
//!
//! The textbook discriminant b² − 4ac subtracts large numbers when the sphere is far away or
//! large. Here it is (r − |l|)(r + |l|) with l the vector from the centre to the ray at closest
//! approach (Haines, Günther & Akenine-Möller 2019, Precision Improvements for Ray/Sphere
//! Intersection), and the smaller root comes from the larger one by c/q with
//! c = (|f| − r)(|f| + r).

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
        let f = ray.origin - self.center;
        let b = -f.dot(ray.dir);
        let l = (f + b * ray.dir).length();
        if l > self.radius {
            return None;
        }
        let half_chord = ((self.radius - l) * (self.radius + l)).sqrt();
        let distance = f.length();
        let c = (distance - self.radius) * (distance + self.radius);
        // q is the root of larger magnitude; 0 only when the ray starts where it touches.
        let q = b + half_chord.copysign(b);
        let other = if half_chord < 0.5 * b.abs() {
            b - half_chord.copysign(b) // Nothing cancels, and c is the less accurate.
        } else if q == 0.0 {
            0.0
        } else {
            c / q
        };
        let (near, far) = if q < other { (q, other) } else { (other, q) };
        if planted::has(Bug::SeedRootRule) {
            return Some(if near * far >= 0.0 { near } else { far });
        }
        let t = if near > 0.0 { near } else { far };
        (t > 0.0 && t <= t_max).then_some(t)
    }

    /// The point of the surface nearest to `p`, for hit points that have drifted off it.
    pub fn project(&self, p: Vec3) -> Vec3 {
        let r = p - self.center;
        self.center + r * (self.radius / r.length())
    }

    /// Area, square scene units.
    pub fn area(&self) -> f32 {
        4.0 * std::f32::consts::PI * self.radius * self.radius
    }
}
