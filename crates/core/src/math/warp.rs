//! Maps from the unit square to the shapes that are sampled. Every input is in `[0, 1)`.

use glam::Vec3;

use super::trig::sin_cos_of_small;

/// Uniform point in a triangle as its second and third barycentric coordinates, without
/// folding the square (Heitz 2019, A Low-Distortion Map Between Triangle and Square).
pub fn triangle(u: [f32; 2]) -> [f32; 2] {
    let [x, y] = u;
    if y > x {
        [x * 0.5, y - x * 0.5]
    } else {
        [x - y * 0.5, y * 0.5]
    }
}

/// Uniform point in the unit disk, area-preserving without folds (Shirley & Chiu 1997).
#[inline(always)]
pub(crate) fn disk(u: [f32; 2]) -> [f32; 2] {
    let (a, b) = (2.0 * u[0] - 1.0, 2.0 * u[1] - 1.0);
    let is_flat = a.abs() > b.abs();
    let (radius, other) = if is_flat { (a, b) } else { (b, a) };
    let phi = std::f32::consts::FRAC_PI_4 * (other / radius);
    let [sin, cos] = sin_cos_of_small(if radius == 0.0 { 0.0 } else { phi });
    let (across, along) = (radius * sin, radius * cos);
    if is_flat {
        [along, across]
    } else {
        [across, along]
    }
}

/// Direction about +z with density cos θ / π (Malley's method).
#[inline(always)]
pub fn cosine_hemisphere(u: [f32; 2]) -> Vec3 {
    let [x, y] = disk(u);
    Vec3::new(x, y, (1.0 - x * x - y * y).max(0.0).sqrt())
}

/// Uniform direction on the unit sphere, density 1/4π.
pub fn uniform_sphere(u: [f32; 2]) -> Vec3 {
    let z = 1.0 - 2.0 * u[0];
    let r = (1.0 - z * z).max(0.0).sqrt();
    let (sin, cos) = libm::sincosf(std::f32::consts::TAU * u[1]);
    Vec3::new(r * cos, r * sin, z)
}
