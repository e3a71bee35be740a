//! Spherical lights, sampled uniformly over the cone that they fill.

use glam::{DVec3, Vec3};

use crate::math::Frame;
use crate::shape::Sphere;

/// The cone that a sphere fills, seen from outside. In f64: the height of a point over a large
/// sphere is a small difference, and decides what is in sight.
pub(super) struct Cone {
    /// Unit vector from the sphere's centre to the apex.
    axis: Vec3,
    sin_max: f64,
    /// 1 − cos of the half-angle, without cancellation.
    one_minus_cos: f64,
}

impl Cone {
    /// `None` from inside or on the sphere.
    pub fn new(sphere: &Sphere, p: Vec3) -> Option<Self> {
        let to_p = p.as_dvec3() - sphere.center.as_dvec3();
        let distance = to_p.length();
        let sin_max = f64::from(sphere.radius) / distance;
        if !(sin_max < 1.0) {
            return None;
        }
        let cos_max = ((1.0 - sin_max) * (1.0 + sin_max)).sqrt();
        Some(Self {
            axis: (to_p / distance).as_vec3(),
            sin_max,
            one_minus_cos: sin_max * sin_max / (1.0 + cos_max),
        })
    }

    /// Density per solid angle.
    pub fn pdf(&self) -> f32 {
        (1.0 / (std::f64::consts::TAU * self.one_minus_cos)) as f32
    }

    /// Maps the unit square to the part of the sphere in sight, uniformly in solid angle: the
    /// unit normal there.
    pub fn sample(&self, u: [f32; 2]) -> Vec3 {
        let one_minus_cos = f64::from(u[0]) * self.one_minus_cos;
        let (cos, sin2) = (1.0 - one_minus_cos, one_minus_cos * (2.0 - one_minus_cos));
        // The point that the direction hits first, by its angle α at the centre from the axis: by
        // the law of sines sin(θ + α) = sin θ/sin θ_max, expanded so that nothing cancels near
        // the sphere.
        let sin = sin2.sqrt();
        let sin_sum = sin / self.sin_max;
        let cos_sum = ((1.0 - sin_sum) * (1.0 + sin_sum)).max(0.0).sqrt();
        let cos_alpha = sin * sin_sum + cos * cos_sum;
        let sin_alpha = cos * sin_sum - sin * cos_sum;
        let (sin_phi, cos_phi) = libm::sincosf(std::f32::consts::TAU * u[1]);
        let (sin_phi, cos_phi) = (f64::from(sin_phi), f64::from(cos_phi));
        let local = DVec3::new(sin_alpha * cos_phi, sin_alpha * sin_phi, cos_alpha);
        let n = Frame::around(self.axis).world_from_local(local.as_vec3());
        n.normalize()
    }
}
