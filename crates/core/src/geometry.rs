//! All primitives of a scene in flat arrays, and what a ray finds there.
//!
//! Primitive ids run over the triangles, then the quads, then the spheres. Among hits at equal
//! distance the lowest id wins, so every accelerator gives the same answer.

use glam::{DVec3, Vec2, Vec3};

use crate::math::{Aabb, Floats, GROUP, Ray, Vectors, offset_origin, round_along};
use crate::shape::{Quad, Sphere, triangle_area, triangle_normal};

pub use crate::accel::TreeStats;
pub use cast::Geometry;
pub use traversal::Traversal;
pub use triangles::Triangles;

mod cast;
mod flights;
mod search;
mod sides;
mod stream;
mod sweep;
mod traversal;
mod triangles;

#[cfg(test)]
pub(crate) mod test;

/// Primitives of a scene; see the module's text for ids.
#[derive(Debug, Default)]
pub struct Primitives {
    /// Triangles, kept once: a frozen scene has them where rays are cast at them.
    pub triangles: Triangles,
    /// Texture coordinates of each triangle's vertices; empty if no mesh has any.
    pub triangle_uvs: Vec<[Vec2; 3]>,
    /// Parallelograms.
    pub quads: Vec<Quad>,
    /// Spheres.
    pub spheres: Vec<Sphere>,
    /// Material slot of each primitive, by id.
    pub slots: Vec<u32>,
}

/// A primitive by kind.
#[derive(Clone, Copy, Debug)]
pub enum Primitive {
    /// Three vertices.
    Triangle([Vec3; 3]),
    /// A parallelogram.
    Quad(Quad),
    /// A sphere.
    Sphere(Sphere),
}

/// Where a ray has hit something.
pub(crate) enum Place {
    /// On a triangle, or one of a quad's, at these second and third barycentric coordinates: many
    /// such points are computed side by side.
    OnTriangle([Vec3; 3], [f32; 2]),
    /// On a sphere, here.
    At(SurfacePoint),
}

/// Nearest hit of a ray.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    /// Distance.
    pub t: f32,
    /// Primitive id.
    pub prim: u32,
    /// Triangle: second barycentric; quad: coordinate along the first edge; sphere: 0.
    pub u: f32,
    /// Triangle: third barycentric; quad: coordinate along the last edge; sphere: 0.
    pub v: f32,
}

/// A point on a surface.
#[derive(Clone, Copy, Debug)]
pub struct SurfacePoint {
    /// Position.
    pub p: Vec3,
    /// Unit geometric normal of the front.
    pub n: Vec3,
    /// Rounding puts `p` off the surface, which is between these two heights over it, along `n`.
    pub surface: [f32; 2],
}

/// Points on surfaces, side by side.
#[derive(Debug)]
pub(crate) struct SurfacePoints {
    pub p: Vectors,
    n: Vectors,
    surface: [Floats; 2],
}

impl Default for SurfacePoints {
    fn default() -> Self {
        Self {
            p: Vectors::default(),
            n: Vectors::default(),
            surface: [[0.0; GROUP]; 2],
        }
    }
}

impl SurfacePoints {
    #[inline(always)]
    pub fn get(&self, lane: usize) -> SurfacePoint {
        SurfacePoint {
            p: self.p.get(lane),
            n: self.n.get(lane),
            surface: [self.surface[0][lane], self.surface[1][lane]],
        }
    }

    #[inline(always)]
    pub fn set(&mut self, lane: usize, point: &SurfacePoint) {
        self.p.set(lane, point.p);
        self.n.set(lane, point.n);
        for (heights, height) in self.surface.iter_mut().zip(point.surface) {
            heights[lane] = height;
        }
    }
}

/// From one point to another. What lies in the same place as the end, such as the ceiling in whose plane a lamp is,
/// does not shade it, as it does not hide a lamp from rays that come upon it.
#[inline(always)]
pub(crate) fn segment(from: Vec3, to: Vec3) -> Ray {
    let way = to - from;
    let distance = way.length();
    Ray {
        origin: from,
        dir: way / distance,
        t_max: distance * (1.0 - search::NUDGE),
    }
}

impl SurfacePoint {
    /// Origin for a ray that leaves in direction `w`.
    #[inline(always)]
    pub fn leave(&self, w: Vec3) -> Vec3 {
        let [low, high] = self.surface;
        let height = if w.dot(self.n) < 0.0 {
            low.min(0.0)
        } else {
            high.max(0.0)
        };
        offset_origin(self.p, height * self.n)
    }

    /// The ray to another point, in unit direction `toward`: [`segment`] between where both ends leave their
    /// surface, so that nothing but what truly stands between can shade.
    #[inline(always)]
    pub(crate) fn ray_to(&self, other: &Self, toward: Vec3) -> Ray {
        segment(self.leave(toward), other.leave(-toward))
    }

    /// The point of a triangle with barycentric coordinates (1−b1−b2, b1, b2).
    #[inline(always)]
    pub fn of_triangle(triangle: [Vec3; 3], b: [f32; 2]) -> Self {
        Self::of_triangle_with(triangle, triangle_normal(triangle), b)
    }

    /// The same, of a triangle whose unit normal `n` is known. In f64, so that only the rounding
    /// of the point is left: between plates two ulp apart there has to be room for the start of
    /// a ray. That rounding is towards the middle of the triangle, so that a point near the edge
    /// does not get onto the neighbour's plane, from where a ray would not see the neighbour.
    #[inline(always)]
    pub(crate) fn of_triangle_with(triangle: [Vec3; 3], n: Vec3, [b1, b2]: [f32; 2]) -> Self {
        let [v0, v1, v2] = triangle.map(|v| v.as_dvec3());
        let (b1, b2) = (f64::from(b1), f64::from(b2));
        let exact = (1.0 - b1 - b2) * v0 + b1 * v1 + b2 * v2;
        let middle = (v0 + v1 + v2) / 3.0;
        Self::rounded(
            exact,
            n,
            middle - exact,
            v0.abs().max(v1.abs()).max(v2.abs()),
        )
    }

    /// The point (u, v) of a quad.
    #[inline(always)]
    pub(crate) fn of_quad(quad: &Quad, u: f32, v: f32) -> Self {
        let (triangle, b) = quad.triangle_at(u, v);
        Self::of_triangle(triangle, b)
    }

    /// The point of a sphere next to `p`, which may have drifted off it.
    pub fn of_sphere(sphere: &Sphere, p: Vec3) -> Self {
        let center = sphere.center.as_dvec3();
        // Any normal will do where rounding has put `p` onto the centre of a minute sphere.
        let n = (p.as_dvec3() - center).normalize_or(DVec3::Z);
        let radius = f64::from(sphere.radius);
        let p = round_along(center + radius * n, DVec3::ZERO);
        // Rounding has moved the point along the surface too. Where the sphere is some steps of
        // f32 large, that turns the normal, and a ray would leave to the wrong side.
        let from_center = p.as_dvec3() - center;
        let n = from_center.normalize_or(n);
        Self::off(p, n.as_vec3(), radius * n - from_center, center.abs())
    }

    /// A point known in f64, computed there from coordinates up to `largest`, rounded along a
    /// direction.
    #[inline(always)]
    fn rounded(exact: DVec3, n: Vec3, along: DVec3, largest: DVec3) -> Self {
        let p = round_along(exact, along);
        Self::off(p, n, exact - p.as_dvec3(), largest)
    }

    /// A point that is `error` off the surface, known in f64 from coordinates up to `largest`.
    #[inline(always)]
    fn off(p: Vec3, n: Vec3, error: DVec3, largest: DVec3) -> Self {
        let normal = n.as_dvec3();
        let height = normal.dot(error);
        // Of the normal in f32, and of f64.
        const F32: f64 = 1.0 / (1u64 << 22) as f64;
        const F64: f64 = 1.0 / (1u64 << 50) as f64;
        let slack = F32 * error.abs().element_sum() + F64 * normal.abs().dot(largest);
        let surface = [(height - slack) as f32, (height + slack) as f32];
        Self { p, n, surface }
    }
}

impl Primitives {
    /// Number of primitives.
    pub fn len(&self) -> usize {
        self.triangles.len() + self.quads.len() + self.spheres.len()
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The primitive of an id.
    #[inline(always)]
    pub fn get(&self, id: u32) -> Primitive {
        let i = id as usize;
        if let Some(triangle) = self.triangles.get(i) {
            return Primitive::Triangle(triangle);
        }
        let i = i - self.triangles.len();
        match self.quads.get(i) {
            Some(quad) => Primitive::Quad(*quad),
            None => Primitive::Sphere(self.spheres[i - self.quads.len()]),
        }
    }

    /// Whether a primitive is a sphere.
    #[inline(always)]
    pub(crate) fn is_sphere(&self, id: u32) -> bool {
        id as usize >= self.triangles.len() + self.quads.len()
    }

    /// Memory, bytes.
    pub fn bytes(&self) -> usize {
        self.triangles.bytes()
            + size_of_val(&*self.triangle_uvs)
            + size_of_val(&*self.quads)
            + size_of_val(&*self.spheres)
            + size_of_val(&*self.slots)
    }

    /// Area of a primitive, square scene units.
    pub fn area(&self, id: u32) -> f32 {
        match self.get(id) {
            Primitive::Triangle(triangle) => triangle_area(triangle),
            Primitive::Quad(quad) => quad.area(),
            Primitive::Sphere(sphere) => sphere.area(),
        }
    }

    /// Box around a primitive.
    pub fn bounds(&self, id: u32) -> Aabb {
        match self.get(id) {
            Primitive::Triangle(triangle) => Aabb::of_points(triangle),
            Primitive::Quad(quad) => Aabb::of_points(quad.corners()),
            Primitive::Sphere(Sphere { center, radius }) => Aabb {
                min: (center - radius).map(f32::next_down),
                max: (center + radius).map(f32::next_up),
            },
        }
    }

    /// Box around the part of a primitive inside `cell`.
    pub(crate) fn clipped_bounds(&self, id: u32, cell: &Aabb) -> Aabb {
        match self.get(id) {
            Primitive::Triangle(triangle) => clip_polygon(&triangle, cell),
            Primitive::Quad(quad) => clip_polygon(&quad.corners(), cell),
            Primitive::Sphere(_) => self.bounds(id).intersection(*cell),
        }
    }

    /// The surface at a hit of `ray`.
    pub fn surface_point(&self, ray: &Ray, hit: &Hit) -> SurfacePoint {
        match self.place(ray, hit) {
            Place::OnTriangle(triangle, b) => SurfacePoint::of_triangle(triangle, b),
            Place::At(point) => point,
        }
    }

    /// Where `ray` has hit something.
    #[inline(always)]
    pub(crate) fn place(&self, ray: &Ray, hit: &Hit) -> Place {
        match self.get(hit.prim) {
            Primitive::Triangle(triangle) => Place::OnTriangle(triangle, [hit.u, hit.v]),
            Primitive::Quad(quad) => {
                let (triangle, b) = quad.triangle_at(hit.u, hit.v);
                Place::OnTriangle(triangle, b)
            }
            Primitive::Sphere(sphere) => Place::At(SurfacePoint::of_sphere(&sphere, ray.at(hit.t))),
        }
    }

    /// Texture coordinates at a hit: the mesh's own, or (u, v) on quads; zero on spheres.
    pub(crate) fn uv(&self, hit: &Hit) -> Vec2 {
        let i = hit.prim as usize;
        if i >= self.triangles.len() {
            return Vec2::new(hit.u, hit.v);
        }
        self.triangle_uvs.get(i).map_or(Vec2::ZERO, |[a, b, c]| {
            (1.0 - hit.u - hit.v) * *a + hit.u * *b + hit.v * *c
        })
    }
}

/// Box around the part of a convex polygon inside a box: clipped plane by plane in f64
/// (Sutherland & Hodgman 1974), rounded outward.
fn clip_polygon<const N: usize>(corners: &[Vec3; N], cell: &Aabb) -> Aabb {
    // Each of six planes adds at most one corner.
    let mut polygon = [DVec3::ZERO; 10];
    let mut count = N;
    for (to, from) in polygon.iter_mut().zip(corners) {
        *to = from.as_dvec3();
    }
    for axis in 0..3 {
        for (bound, sign) in [(cell.min[axis], 1.0), (cell.max[axis], -1.0)] {
            let bound = f64::from(bound);
            let input = polygon;
            let n = std::mem::take(&mut count);
            for i in 0..n {
                let (p, q) = (input[i], input[(i + 1) % n]);
                let (dp, dq) = (sign * (p[axis] - bound), sign * (q[axis] - bound));
                if dp >= 0.0 {
                    polygon[count] = p;
                    count += 1;
                }
                if (dp > 0.0 && dq < 0.0) || (dp < 0.0 && dq > 0.0) {
                    polygon[count] = p + (q - p) * (dp / (dp - dq));
                    polygon[count][axis] = bound;
                    count += 1;
                }
            }
        }
    }
    let (mut min, mut max) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    for p in &polygon[..count] {
        (min, max) = (min.min(*p), max.max(*p));
    }
    let (lo, hi) = (min.as_vec3(), max.as_vec3());
    let outward = |rounded: f32, exact: f64, down: bool| {
        if down && f64::from(rounded) > exact {
            rounded.next_down()
        } else if !down && f64::from(rounded) < exact {
            rounded.next_up()
        } else {
            rounded
        }
    };
    let axis = |i: usize| (outward(lo[i], min[i], true), outward(hi[i], max[i], false));
    let ((x0, x1), (y0, y1), (z0, z1)) = (axis(0), axis(1), axis(2));
    Aabb {
        min: Vec3::new(x0, y0, z0),
        max: Vec3::new(x1, y1, z1),
    }
}
