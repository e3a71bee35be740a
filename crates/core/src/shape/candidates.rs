//! Pairs of a ray and a triangle that may be a hit, found eight at a time: a ray and the triangles of a
//! run, or a triangle and eight rays.

use glam::Vec3;

use super::runs::TriangleRuns;
use super::triangle::{Exact, ShearedRay, TriangleHit};
use crate::math::gamma;
use crate::simd::Lanes;

/// Eight rays, side by side.
pub(crate) struct ShearedRays<L> {
    origin: [L; 3],
    shear: [L; 3],
    longest: L,
    t_max: L,
}

impl<L: Lanes> ShearedRays<L> {
    /// With the distances that were set, times a factor.
    #[inline(always)]
    pub fn new(rays: [&ShearedRay; 8], factor: f32) -> Self {
        let [a, b, c, d, e, f, g, h] = rays;
        let rows = [&a.0, &b.0, &c.0, &d.0, &e.0, &f.0, &g.0, &h.0];
        let [ox, oy, oz, sx, sy, sz, longest, t_max] = L::transpose(rows);
        Self {
            origin: [ox, oy, oz],
            shear: [sx, sy, sz],
            longest,
            t_max: t_max.mul(L::splat(factor)),
        }
    }

    /// Sets the distances.
    #[inline(always)]
    pub fn set_t_max(&mut self, t_max: L) {
        self.t_max = t_max;
    }

    /// The rays that might hit a triangle, of those in `all`; none if there is none.
    #[inline(always)]
    pub fn candidates(&self, [a, b, c]: [Vec3; 3], all: u32) -> Option<Candidates<L>> {
        let vertices = [self.shear(a), self.shear(b), self.shear(c)];
        let mask = all & !outside(&vertices);
        if mask == 0 {
            return None;
        }
        Some(Candidates::of(vertices, self.shear[2], self.t_max, mask))
    }

    /// A vertex in each ray's coordinates, as by `ShearedRay::shear` operation by operation but for the
    /// depth, which lacks a factor.
    #[inline(always)]
    fn shear(&self, v: Vec3) -> [L; 3] {
        let [x, y, z] = L::sort_axes(v.to_array(), self.longest);
        let along = z.sub(self.origin[2]);
        [
            x.sub(self.origin[0]).sub(self.shear[0].mul(along)),
            y.sub(self.origin[1]).sub(self.shear[1].mul(along)),
            along,
        ]
    }
}

/// Pairs of a ray and a triangle that may be a hit: a ray and triangles, or a triangle and rays.
pub(crate) struct Candidates<L> {
    /// A bit for each.
    pub mask: u32,
    /// The vertices in the ray's coordinates.
    vertices: [[L; 3]; 3],
}

impl<L: Lanes> Candidates<L> {
    /// Those in a mask that are ahead and not too far. All depths are still to be multiplied by `scale`.
    #[inline(always)]
    fn of([mut a, mut b, mut c]: [[L; 3]; 3], scale: L, t_max: L, mask: u32) -> Self {
        (a[2], b[2], c[2]) = (scale.mul(a[2]), scale.mul(b[2]), scale.mul(c[2]));
        // t is an average of the depths, to within its rounding.
        let (nearest, farthest) = (a[2].min(b[2]).min(c[2]), a[2].max(b[2]).max(c[2]));
        let beyond = t_max.lt(nearest.mul(L::splat(1.0 - gamma(16))));
        let behind = farthest.le(L::splat(0.0));
        Self {
            mask: mask & !(beyond | behind),
            vertices: [a, b, c],
        }
    }

    /// The vertices of those that may be a hit, in front of others.
    #[inline(always)]
    pub(super) fn front(&self) -> [[L; 3]; 3] {
        let mask = self.mask as usize;
        let [a, b, c] = self.vertices;
        [
            [a[0].front(mask), a[1].front(mask), a[2].front(mask)],
            [b[0].front(mask), b[1].front(mask), b[2].front(mask)],
            [c[0].front(mask), c[1].front(mask), c[2].front(mask)],
        ]
    }

    /// The pairs one by one.
    #[inline(always)]
    pub fn apart(&self) -> Apart {
        let [a, b, c] = self.vertices;
        Apart([
            [a[0].store(), a[1].store(), a[2].store()],
            [b[0].store(), b[1].store(), b[2].store()],
            [c[0].store(), c[1].store(), c[2].store()],
        ])
    }
}

/// Triangles in rays' coordinates: by vertex, axis and pair.
#[derive(Clone, Copy, Default)]
pub(crate) struct Apart([[[f32; TriangleRuns::MAX]; 3]; 3]);

impl Apart {
    /// What the sheared vertices of a candidate tell of its hit.
    #[inline(always)]
    pub(super) fn hit(&self, lane: u32, t_max: f32) -> Option<(TriangleHit, bool)> {
        let i = lane as usize % TriangleRuns::MAX;
        let [a, b, c] = &self.0;
        Exact::new(
            [a[0][i], a[1][i], a[2][i]],
            [b[0][i], b[1][i], b[2][i]],
            [c[0][i], c[1][i], c[2][i]],
            t_max,
        )
        .hit()
    }
}

/// Up to eight triangles: by vertex, coordinates.
pub(crate) struct Run<L> {
    pub(super) rows: [[L; 3]; 3],
    /// A bit for each.
    pub(super) all: u32,
}

impl<L: Lanes> Run<L> {
    /// See [`TriangleRuns::candidates`].
    #[inline(always)]
    pub fn candidates(&self, ray: &ShearedRay, t_max: f32) -> Candidates<L> {
        let vertices = [self.shear(0, ray), self.shear(1, ray), self.shear(2, ray)];
        let [_, _, scale] = ray.shears();
        let mask = self.all & !outside(&vertices);
        Candidates::of(vertices, L::splat(scale), L::splat(t_max), mask)
    }

    /// One vertex of all triangles, as by [`ShearedRays::shear`].
    #[inline(always)]
    fn shear(&self, v: usize, ray: &ShearedRay) -> [L; 3] {
        let ([x, y, z], rows) = (ray.axes(), &self.rows[v]);
        let ([ox, oy, oz], [sx, sy, _]) = (ray.origin(), ray.shears());
        let along = rows[z].sub(L::splat(oz));
        [
            rows[x].sub(L::splat(ox)).sub(L::splat(sx).mul(along)),
            rows[y].sub(L::splat(oy)).sub(L::splat(sy).mul(along)),
            along,
        ]
    }
}

/// The pairs whose edge functions have two signs, a bit for each.
#[inline(always)]
fn outside<L: Lanes>([a, b, c]: &[[L; 3]; 3]) -> u32 {
    let (u, v, w) = (edge(*b, *c), edge(*c, *a), edge(*a, *b));
    let zero = L::splat(0.0);
    u.min(v).min(w).lt(zero) & zero.lt(u.max(v).max(w))
}

/// As `edge` in triangle.rs.
#[inline(always)]
fn edge<L: Lanes>(p: [L; 3], q: [L; 3]) -> L {
    q[0].mul(p[1]).sub(q[1].mul(p[0]))
}
