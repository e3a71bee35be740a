//! Parallelograms: one primitive, tested as the two triangles (a, b, c) and (a, c, d), so that it
//! is as watertight towards its neighbours as a mesh and flat exactly where they say.

use glam::Vec3;

/// A parallelogram with corners a, b, c, d; its front is the side from which they run
/// counter-clockwise.
#[derive(Clone, Copy, Debug)]
pub struct Quad {
    corners: [Vec3; 4],
    normal: Vec3,
    area: f32,
}

impl Quad {
    /// The parallelogram with these corners, in order around the edge.
    pub fn new(corners: [Vec3; 4]) -> Self {
        let [a, b, c, d] = corners.map(|p| p.as_dvec3());
        let area = (b - a).cross(d - a).length() as f32;
        Self {
            corners,
            normal: super::unit_normal(c - a, d - b),
            area,
        }
    }

    /// Corners in order around the edge.
    #[inline(always)]
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

    /// The two triangles as which it is tested.
    #[inline(always)]
    pub fn triangles(&self) -> [[Vec3; 3]; 2] {
        let [a, b, c, d] = self.corners;
        [[a, b, c], [a, c, d]]
    }

    /// The triangle of the two in which (u, v) lies, with its second and third barycentric.
    #[inline(always)]
    pub(crate) fn triangle_at(&self, u: f32, v: f32) -> ([Vec3; 3], [f32; 2]) {
        let [first, second] = self.triangles();
        if u >= v {
            (first, [u - v, v])
        } else {
            (second, [u, v - u])
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
