//! Watertight ray-triangle intersection (Woop, Benthin & Wald 2013).
//!
//! The ray is sheared onto an axis once; a triangle is then hit if the three edge functions of
//! its projected vertices have no two signs. An edge shared by two triangles gives the same
//! products in both, and edges count as inside, so nothing slips between. (Rust never contracts
//! a·b−c·d into a fused operation by itself, which would break that.) Edge functions of 0 are decided, and
//! those of hits refined, in f64, where the products are exact.

use glam::{DVec3, Vec3};

use crate::math::Ray;
use crate::planted::{self, Bug};

/// A ray in the form the triangle test wants: computed once per ray.
///
/// Eight numbers, as they are read by the row: the origin and the shear in the order of the axes,
/// the longest axis of the direction as an integer, and a place for the distance up to which a
/// hit counts.
#[derive(Clone, Copy, Debug, Default)]
#[repr(align(32))]
pub struct ShearedRay(pub(crate) [f32; 8]);

/// The axes in the order x', y', z', with z' a certain one.
pub(super) const AXES: [[usize; 3]; 4] = [[1, 2, 0], [2, 0, 1], [0, 1, 2], [0, 1, 2]];

/// Where a ray meets a triangle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TriangleHit {
    /// Distance.
    pub t: f32,
    /// Barycentric coordinates of the second and third vertex, ≥ 0, with a sum ≤ 1 (to rounding).
    pub b1: f32,
    /// See `b1`.
    pub b2: f32,
}

/// A vertex relative to the ray: x', y' in the sheared plane, z' along the ray.
pub(crate) type Sheared = [f32; 3];

impl ShearedRay {
    /// Prepares a ray; its `t_max` is not used.
    #[inline(always)]
    pub fn new(ray: &Ray) -> Self {
        let a = ray.dir.abs();
        // Chosen without a branch, which no one could foresee.
        let is_z = a.z > if a.y > a.x { a.y } else { a.x };
        let is_y = (a.y > a.x) & !is_z;
        let longest = if is_z { 2 } else { u32::from(is_y) };
        let sorted = |v: Vec3| {
            let either = |z: f32, y: f32, x: f32| {
                if is_z {
                    z
                } else if is_y {
                    y
                } else {
                    x
                }
            };
            [
                either(v.x, v.z, v.y),
                either(v.y, v.x, v.z),
                either(v.z, v.y, v.x),
            ]
        };
        let ([ox, oy, oz], [x, y, z]) = (sorted(ray.origin), sorted(ray.dir));
        let (sx, sy, sz) = (x / z, y / z, 1.0 / z);
        Self([ox, oy, oz, sx, sy, sz, f32::from_bits(longest), ray.t_max])
    }

    /// In the order of the axes.
    #[inline(always)]
    pub(super) fn origin(&self) -> [f32; 3] {
        [self.0[0], self.0[1], self.0[2]]
    }

    /// In the order of the axes.
    #[inline(always)]
    pub(super) fn shears(&self) -> [f32; 3] {
        [self.0[3], self.0[4], self.0[5]]
    }

    /// Sets the distance up to which a hit counts in groups of rays.
    #[inline(always)]
    pub(crate) fn set_t_max(&mut self, t_max: f32) {
        self.0[7] = t_max;
    }

    /// The axes in the order x', y', z', with z' the longest of the direction.
    #[inline(always)]
    pub(super) fn axes(&self) -> [usize; 3] {
        AXES[self.0[6].to_bits() as usize & 3]
    }

    /// A vertex in the ray's coordinates.
    #[inline(always)]
    fn shear(&self, v: Vec3) -> Sheared {
        let (v, o, shear) = (v.to_array(), self.origin(), self.shears());
        let [x, y, z] = self.axes();
        let along = v[z] - o[2];
        [
            (v[x] - o[0]) - shear[0] * along,
            (v[y] - o[1]) - shear[1] * along,
            shear[2] * along,
        ]
    }

    /// The hit with `0 < t ≤ t_max`, if any.
    #[inline(always)]
    pub fn triangle(&self, [a, b, c]: [Vec3; 3], t_max: f32) -> Option<TriangleHit> {
        let (hit, is_clear) = sheared_triangle(self.shear(a), self.shear(b), self.shear(c), t_max)?;
        (is_clear || self.meets_plane([a, b, c])).then_some(hit)
    }

    /// Whether the plane of a triangle lies ahead of the ray. In f64 from the vertices themselves:
    /// rounding of the shear can make a triangle of a line, and put the origin of a ray that has
    /// just left the triangle on its other side. Seen from the vertex next to the origin: from the
    /// far end of a long triangle even f64 might not tell the sides apart, nor with a normal that
    /// has lost digits because its edges are long and all but parallel.
    #[inline(always)]
    pub(crate) fn meets_plane(&self, [a, b, c]: [Vec3; 3]) -> bool {
        let [x, y, z] = self.axes();
        let sorted = |v: Vec3| DVec3::new(v[x].into(), v[y].into(), v[z].into());
        let (a, b, c) = (sorted(a), sorted(b), sorted(c));
        let o = DVec3::from_array(self.origin().map(f64::from));
        if is_surely_ahead([a, b, c].map(|v| v.to_array()), o.to_array(), self.shears()) {
            return true;
        }
        let away = |v: DVec3| (v - o).length_squared();
        let (a, b, c) = match (away(a), away(b), away(c)) {
            (x, y, z) if y < x && y <= z => (b, c, a),
            (x, _, z) if z < x => (c, a, b),
            _ => (a, b, c),
        };
        let n = exact_cross(b - a, c - a);
        // The direction, but for its length.
        let [sx, sy, sz] = self.shears();
        let d = DVec3::new(sx.into(), sy.into(), 1.0);
        n.dot(a - o) * n.dot(d) * f64::from(sz) > 0.0
    }
}

/// Whether the plane of a triangle lies ahead of a ray, if that is plain in f64 without any care; all in
/// the order of the ray's axes. Ten bits more than rounding takes are asked for, so that
/// [`ShearedRay::meets_plane`] would say the same with any vertex.
#[inline(always)]
fn is_surely_ahead([a, b, c]: [[f64; 3]; 3], o: [f64; 3], shear: [f32; 3]) -> bool {
    let [sx, sy, sz] = shear.map(f64::from);
    let (p, q) = (
        [b[0] - a[0], b[1] - a[1], b[2] - a[2]],
        [c[0] - a[0], c[1] - a[1], c[2] - a[2]],
    );
    let r = [a[0] - o[0], a[1] - o[1], a[2] - o[2]];
    let n = [
        p[1] * q[2] - p[2] * q[1],
        p[2] * q[0] - p[0] * q[2],
        p[0] * q[1] - p[1] * q[0],
    ];
    let height = n[0] * r[0] + n[1] * r[1] + n[2] * r[2];
    let slope = n[0] * sx + n[1] * sy + n[2];
    let size = |v: [f64; 3]| v[0].abs() + v[1].abs() + v[2].abs();
    let error = size(p) * size(q) * (1.0 / (1u64 << 43) as f64);
    (height.abs() > error * size(r))
        & (slope.abs() > error * (sx.abs() + sy.abs() + 1.0))
        & (height * slope * sz > 0.0)
}

/// a × b, each component to its last digits however alike its products are (Kahan's difference of
/// products: Jeannerod, Louvet & Muller 2013).
#[inline(always)]
fn exact_cross(a: DVec3, b: DVec3) -> DVec3 {
    let difference = |a: f64, b: f64, c: f64, d: f64| {
        let cd = c * d;
        a.mul_add(b, -cd) + (-c).mul_add(d, cd)
    };
    DVec3::new(
        difference(a.y, b.z, a.z, b.y),
        difference(a.z, b.x, a.x, b.z),
        difference(a.x, b.y, a.y, b.x),
    )
}

/// Twice the signed area that the projected edge spans with the ray; negated when the ends are
/// swapped, exactly.
#[inline(always)]
pub(crate) fn edge(p: Sheared, q: Sheared) -> f32 {
    q[0] * p[1] - q[1] * p[0]
}

/// The same in f64, in which the products of two f32 are exact.
#[inline(always)]
fn edge_f64(p: Sheared, q: Sheared) -> f64 {
    f64::from(q[0]) * f64::from(p[1]) - f64::from(q[1]) * f64::from(p[0])
}

/// Whether some weight is below zero and some above.
#[inline(always)]
fn disagree<T: PartialOrd + Default>(u: T, v: T, w: T) -> bool {
    let zero = T::default();
    ((u < zero) | (v < zero) | (w < zero)) & ((u > zero) | (v > zero) | (w > zero))
}

/// The test in the ray's coordinates.
#[inline(always)]
fn sheared_triangle(a: Sheared, b: Sheared, c: Sheared, t_max: f32) -> Option<(TriangleHit, bool)> {
    // Rounding can make an edge function 0 but never turn its sign, so most misses end here.
    if disagree(edge(b, c), edge(c, a), edge(a, b)) {
        return None;
    }
    Exact::new(a, b, c, t_max).hit()
}

/// The test of what the rounded edge functions did not rule out.
#[derive(Clone, Copy)]
pub(super) struct Exact {
    /// The hit, if it is one: else its `t` is 0.
    pub hit: TriangleHit,
    /// Whether it is so clear that [`ShearedRay::meets_plane`] need not be asked.
    pub is_clear: bool,
}

impl Exact {
    /// Without a branch, for many at once.
    #[inline(always)]
    pub fn new(a: Sheared, b: Sheared, c: Sheared, t_max: f32) -> Self {
        // What may be a hit is computed in f64: exact products decide the zeros, t stays within a few
        // ulp however thin the triangle, and products of minute lengths do not underflow.
        let (u, v, w) = (edge_f64(b, c), edge_f64(c, a), edge_f64(a, b));
        let is_open = planted::has(Bug::StrictEdges) && u * v * w == 0.0;
        // The weights have one sign, so t is an average of the three depths: it cannot leave their
        // range, however thin the triangle. It is NaN, and no hit, where all of them are 0.
        let det = u + v + w;
        let [za, zb, zc] = [a[2], b[2], c[2]].map(f64::from);
        let t = ((u * za + v * zb + w * zc) / det) as f32;
        let is_hit = !disagree(u, v, w) & !is_open & (t > 0.0) & (t <= t_max) & (det != 0.0);
        Self {
            hit: TriangleHit {
                t: if is_hit { t } else { 0.0 },
                b1: (v / det) as f32,
                b2: (w / det) as f32,
            },
            is_clear: is_clear([a, b, c], det as f32, t),
        }
    }

    /// What it found.
    #[inline(always)]
    pub fn hit(self) -> Option<(TriangleHit, bool)> {
        (self.hit.t > 0.0).then_some((self.hit, self.is_clear))
    }
}

/// Whether a triangle with some `det` is met ahead of the ray whatever rounding has done to its
/// vertices. Depths have but their own rounding, a few 2⁻²⁴ of them; the other coordinates that of
/// what was subtracted, as much of the depth and themselves. So much at each vertex, and a factor of
/// 2⁸ more, leaves the sign of `det`, and puts the hit off by no more than a part in 2⁸ of the
/// way from one vertex to another, which stays ahead if all depths are alike to within that, or if the
/// hit is farther than a part in 2⁴ of the farthest vertex is in either direction.
#[inline(always)]
fn is_clear([a, b, c]: [Sheared; 3], det: f32, t: f32) -> bool {
    let largest = |axis: usize| a[axis].abs().max(b[axis].abs()).max(c[axis].abs());
    let (extent, far) = (largest(0).max(largest(1)), largest(2));
    let near = a[2].min(b[2]).min(c[2]);
    ((near > far * (1.0 / 256.0)) | (t > far * (1.0 / 16.0)))
        & (det.abs() > (far + extent) * extent * (1.0 / 4096.0))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sampler::{Dim, Sampler};
    use crate::settings::SamplerKind;

    fn number(i: u32, dimension: u32) -> f32 {
        let sampler = Sampler::new(SamplerKind::Independent, 11, [i, dimension], 0);
        2.0 * sampler.get_1d(Dim::Lobe(0)) - 1.0
    }

    fn vector(i: u32, dimension: u32) -> Vec3 {
        Vec3::from_array([0, 1, 2].map(|k| number(i, dimension + k)))
    }

    /// Whatever the triangle and the ray, thin, far out, grazing or just leaving, a hit that is
    /// called clear is ahead; and ordinary hits are called so.
    #[test]
    fn clear_hits_are_ahead() {
        let (mut clear, mut hits, mut ordinary, mut ordinary_hits) = (0, 0, 0, 0);
        for i in 0..400_000 {
            let power = |dimension: u32, most: f32| 2f32.powf(most * number(i, dimension));
            let is_ordinary = i % 4 == 0;
            let offset = match is_ordinary {
                true => Vec3::ZERO,
                false => vector(i, 0) * power(3, 20.0),
            };
            let thin = if is_ordinary {
                1.0
            } else {
                power(4, 20.0).min(1.0)
            };
            let a = offset + vector(i, 10);
            let b = a + vector(i, 13);
            let c = a + (b - a) * number(i, 16) + thin * vector(i, 17);
            // Towards a point of it, from a distance, or from all but in its plane.
            let (u, v) = (number(i, 20).abs(), number(i, 21).abs());
            let p = a + (b - a) * (u * (1.0 - v)) + (c - a) * v;
            let far = if is_ordinary { 3.0 } else { power(22, 12.0) };
            let along = (b - a) * number(i, 23) + (c - a) * number(i, 24);
            let away = match i % 3 {
                0 => vector(i, 25),
                1 => along + vector(i, 25) * power(28, 20.0).min(1.0),
                _ => along,
            };
            let origin = p + away * far;
            let ray = Ray::new(origin, (p - origin).normalize_or(Vec3::X));
            let sheared = ShearedRay::new(&ray);
            let vertices = [a, b, c].map(|v| sheared.shear(v));
            let found = sheared_triangle(vertices[0], vertices[1], vertices[2], f32::INFINITY);
            let Some((_, is_clear)) = found else { continue };
            hits += 1;
            clear += u32::from(is_clear);
            if is_ordinary && i % 3 == 0 {
                ordinary_hits += 1;
                ordinary += u32::from(is_clear);
            }
            assert!(
                !is_clear || sheared.meets_plane([a, b, c]),
                "{ray:?} {a} {b} {c}"
            );
        }
        assert!(hits > 50_000 && clear > 20_000, "{clear} of {hits}");
        assert!(
            ordinary * 10 > ordinary_hits * 9,
            "{ordinary} of {ordinary_hits}"
        );
    }
}
