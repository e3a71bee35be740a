//! The primitives and how rays meet them. In: a ray. Out: the least `t` in `(0, t_max]`, closed
//! at edges. f32 throughout, no absolute tolerance: a scene scaled by 2ᵏ is hit at `t` scaled by
//! 2ᵏ, bit for bit.

mod candidates;
mod pairs;
mod quad;
mod runs;
mod sphere;
mod triangle;

use glam::{DVec3, Vec3};

pub(crate) use candidates::ShearedRays;
pub(crate) use pairs::Pairs;
pub use quad::Quad;
pub(crate) use runs::{Place, RunId, TriangleRuns};
pub use sphere::Sphere;
pub(crate) use triangle::edge;
pub use triangle::{ShearedRay, TriangleHit};

/// Unit vector along `e1 × e2`. In f64, edges too, so that neither tiny nor huge ones lose it, nor
/// those of a triangle so thin that rounding of its edges in f32 would turn it.
#[inline(always)]
pub(crate) fn unit_normal(e1: DVec3, e2: DVec3) -> Vec3 {
    e1.cross(e2).normalize_or_zero().as_vec3()
}

/// Unit normal of the side from which a triangle's vertices run counter-clockwise.
#[inline(always)]
pub fn triangle_normal(triangle: [Vec3; 3]) -> Vec3 {
    let [a, b, c] = triangle.map(|v| v.as_dvec3());
    unit_normal(b - a, c - a)
}

/// Area of a triangle, square scene units.
pub(crate) fn triangle_area(triangle: [Vec3; 3]) -> f32 {
    let [a, b, c] = triangle.map(|v| v.as_dvec3());
    ((b - a).cross(c - a).length() * 0.5) as f32
}
