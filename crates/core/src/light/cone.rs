//! Spherical lights, sampled uniformly over the cone that they fill.

use glam::Vec3;

use crate::math::Frame;
use crate::shape::Sphere;

/// The cone that a sphere fills, seen from outside.
pub(super) struct Cone {
    /// Unit vector from the sphere's centre to the apex.
    axis: Vec3,
    sin2_max: f32,
    /// 1 − cos of the half-angle, without cancellation.
    one_minus_cos: f32,
}

impl Cone {
    /// `None` from inside or on the sphere.
    pub fn new(sphere: &Sphere, p: Vec3) -> Option<Self> {
        let to_p = p - sphere.center;
        let distance = to_p.length();
        let ratio = sphere.radius / distance;
        let sin2_max = ratio * ratio;
        if !(sin2_max < 1.0) {
            return None;
        }
        let cos_max = ((1.0 - ratio) * (1.0 + ratio)).sqrt();
        Some(Self {
            axis: to_p / distance,
            sin2_max,
            one_minus_cos: sin2_max / (1.0 + cos_max),
        })
    }

    /// Density per solid angle.
    pub fn pdf(&self) -> f32 {
        1.0 / (std::f32::consts::TAU * self.one_minus_cos)
    }

    /// Maps the unit square to the part of the sphere in sight, uniformly in solid angle: the
    /// unit normal there.
    pub fn sample(&self, u: [f32; 2]) -> Vec3 {
        let one_minus_cos = u[0] * self.one_minus_cos;
        let (cos, sin2) = (1.0 - one_minus_cos, one_minus_cos * (2.0 - one_minus_cos));
        // The point that the direction hits first, by its angle α at the centre from the axis: by
        // the law of sines sin(θ + α) = sin θ/sin θ_max, expanded so that nothing cancels near
        // the sphere.
        let (sin, sin_max) = (sin2.max(0.0).sqrt(), self.sin2_max.sqrt());
        let cos_sum = (1.0 - sin2 / self.sin2_max).max(0.0).sqrt();
        let cos_alpha = sin2 / sin_max + cos * cos_sum;
        let sin_alpha = sin * (cos / sin_max - cos_sum);
        let (sin_phi, cos_phi) = libm::sincosf(std::f32::consts::TAU * u[1]);
        let local = Vec3::new(sin_alpha * cos_phi, sin_alpha * sin_phi, cos_alpha);
        Frame::around(self.axis).world_from_local(local).normalize()
    }
}
