//! Maps from the unit square to the shapes that are sampled. Every input is in `[0, 1)`.

use glam::Vec3;

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
pub fn disk(u: [f32; 2]) -> [f32; 2] {
    let (a, b) = (2.0 * u[0] - 1.0, 2.0 * u[1] - 1.0);
    if a == 0.0 && b == 0.0 {
        return [0.0, 0.0];
    }
    let quarter = std::f32::consts::FRAC_PI_4;
    if a.abs() > b.abs() {
        let phi = quarter * (b / a);
        [a * libm::cosf(phi), a * libm::sinf(phi)]
    } else {
        let phi = quarter * (a / b);
        [b * libm::sinf(phi), b * libm::cosf(phi)]
    }
}

/// Direction about +z with density cos θ / π (Malley's method).
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
