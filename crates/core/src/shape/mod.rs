//! The primitives and how rays meet them. In: a ray. Out: the least `t` in `(0, t_max]`, closed
//! at edges. f32 throughout, no absolute tolerance: a scene scaled by 2ᵏ is hit at `t` scaled by
//! 2ᵏ, bit for bit.

mod quad;
mod runs;
mod sphere;
mod triangle;

use glam::Vec3;

pub use quad::Quad;
pub use runs::TriangleRuns;
pub(crate) use runs::{Apart, ShearedRays};
pub use sphere::Sphere;
pub(crate) use triangle::edge;
pub use triangle::{ShearedRay, TriangleHit};

/// Unit vector along `e1 × e2`, computed in f64 so that neither tiny nor huge edges lose it.
#[inline(always)]
pub fn unit_normal(e1: Vec3, e2: Vec3) -> Vec3 {
    e1.as_dvec3()
        .cross(e2.as_dvec3())
        .normalize_or_zero()
        .as_vec3()
}

/// Area of a triangle, square scene units.
pub fn triangle_area([a, b, c]: [Vec3; 3]) -> f32 {
    ((b - a).as_dvec3().cross((c - a).as_dvec3()).length() * 0.5) as f32
}
