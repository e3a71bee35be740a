//! Parallelograms: one primitive, tested as the two triangles (a, b, c) and (a, c, d), so that it
//! is as watertight towards its neighbours as a mesh and flat exactly where they say.

use glam::Vec3;

use super::triangle::{ShearedRay, sheared_triangle};
use crate::math::gamma;

/// A parallelogram with corners a, b, c, d; its front is the side from which they run
/// counter-clockwise.
#[derive(Clone, Copy, Debug)]
pub struct Quad {
    corners: [Vec3; 4],
    normal: Vec3,
    area: f32,
}

/// Where a ray meets a quad: `t`, and (u, v) in [0, 1]² along b−a and d−a.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct QuadHit {
    /// Distance.
    pub t: f32,
    /// Coordinate along the first edge, b − a.
    pub u: f32,
    /// Coordinate along the last edge, d − a.
    pub v: f32,
}

impl Quad {
    /// The parallelogram with these corners, in order around the edge.
    pub fn new(corners: [Vec3; 4]) -> Self {
        let [a, b, c, d] = corners;
        let area = (b - a).as_dvec3().cross((d - a).as_dvec3()).length() as f32;
        Self {
            corners,
            normal: super::unit_normal(c - a, d - b),
            area,
        }
    }

    /// Corners in order around the edge.
    pub fn corners(&self) -> [Vec3; 4] {
        self.corners
    }

    /// Whether four corners make a parallelogram: the diagonals' midpoints agree to 10⁻⁵ of the
    /// longer diagonal.
    pub fn is_parallelogram([a, b, c, d]: &[Vec3; 4]) -> bool {
        let (gap, diagonal) = (
            (*a - *b) + (*c - *d),
            (*c - *a).length().max((*d - *b).length()),
        );
        gap.length() <= 1e-5 * diagonal
    }

    /// The hit with `0 < t ≤ t_max`, if any.
    #[inline(always)]
    pub fn intersect(&self, ray: &ShearedRay, t_max: f32) -> Option<QuadHit> {
        let [a, b, c, d] = self.corners;
        // Most quads that are tried lie behind the ray or what it has already hit.
        let (za, zb, zc, zd) = (ray.depth(a), ray.depth(b), ray.depth(c), ray.depth(d));
        let (nearest, farthest) = (za.min(zb).min(zc.min(zd)), za.max(zb).max(zc.max(zd)));
        if farthest <= 0.0 || nearest * (1.0 - gamma(16)) > t_max {
            return None;
        }
        let (a, b, c, d) = (ray.shear(a), ray.shear(b), ray.shear(c), ray.shear(d));
        if let Some(hit) = sheared_triangle(a, b, c, t_max) {
            return Some(QuadHit {
                t: hit.t,
                u: hit.b1 + hit.b2,
                v: hit.b2,
            });
        }
        let hit = sheared_triangle(a, c, d, t_max)?;
        Some(QuadHit {
            t: hit.t,
            u: hit.b1,
            v: hit.b1 + hit.b2,
        })
    }

    /// The triangle of the two in which (u, v) lies, with its second and third barycentric.
    pub fn triangle_at(&self, u: f32, v: f32) -> ([Vec3; 3], [f32; 2]) {
        let [a, b, c, d] = self.corners;
        if u >= v {
            ([a, b, c], [u - v, v])
        } else {
            ([a, c, d], [u, v - u])
        }
    }

    /// Unit normal of the front.
    pub fn normal(&self) -> Vec3 {
        self.normal
    }

    /// Area, square scene units.
    pub fn area(&self) -> f32 {
        self.area
    }
}
