//! A ray as the trees walk it.
//!
//! A walk must not miss what a primitive's own test would accept, and that test rounds. So the
//! ray is walked as a beam: every plane is met not at one distance but over an interval that
//! covers all rounding.

use glam::Vec4;

use crate::math::{Aabb, Ray};

/// Half-width of the beam in units of the largest distance R, along an axis, from the ray's
/// origin to a corner of the tree's bounds: 72 ε with ε = 2⁻²⁴. It is made of
/// - 28 ε for primitives. What a test accepts at distance t lies, in exact arithmetic, so near
///   the point at t on each axis. For triangles after Woop, Benthin & Wald (2013) with the edge
///   functions of a hit taken in f64 it is 16 ε: shearing a vertex, which is at most R away, costs
///   6 ε, and the weighted mean that gives t costs 10 ε. For spheres it is 28 ε.
/// - 12 ε for the walk. The kd-tree takes 4 ε for (split − origin) · (1/direction) and widening
///   that; in the wide tree the origin is relative to the centre first, and boxes are met by
///   plane · (1/direction) − start with a rounding for either product and the sums.
/// - 28 ε for visitors that let a primitive win that is behind another by 2⁻²⁰ of the distance,
///   16 ε of at most √3 R.
const PAD: f32 = 72.0 / (1 << 24) as f32;

/// A ray in a form that planes are met with, the part of it inside some bounds. The last
/// components mean nothing.
#[derive(Clone, Copy)]
pub(super) struct Beam {
    pub origin: Vec4,
    /// 1/direction, limited so that its product with R is finite: then no plane in reach is met
    /// at NaN, and a ray parallel to a plane meets it either far outside the bounds or, within
    /// the beam's width, everywhere.
    pub inv_dir: Vec4,
    /// Half-width of the beam; times |`inv_dir`|, as a distance along the ray on each axis.
    pub half_width: f32,
    pub t_enter: f32,
    pub t_exit: f32,
    /// Whether the ray has meaning and meets the bounds.
    pub is_met: bool,
}

impl Beam {
    /// Without a branch: many in a row overlap.
    #[inline(always)]
    pub fn new(ray: &Ray, bounds: &Aabb) -> Self {
        // In registers of four.
        let [origin, dir, min, max] =
            [ray.origin, ray.dir, bounds.min, bounds.max].map(|v| v.extend(0.0));
        let (to_min, to_max) = (min - origin, max - origin);
        let reach = to_min.abs().max(to_max.abs()).max_element();
        // Infinity times zero is NaN.
        let is_finite = (origin * 0.0 + dir * 0.0).cmpeq(Vec4::ZERO).all();
        let has_meaning =
            is_finite & (reach < f32::INFINITY) & dir.cmpne(Vec4::ZERO).any() & (ray.t_max > 0.0);
        const HUGE: f32 = (1u128 << 124) as f32;
        let inv_limit = Vec4::splat(HUGE / if reach > 1.0 { reach } else { 1.0 });
        let inv_dir = dir.recip().clamp(-inv_limit, inv_limit);
        let half_width = PAD * reach;
        let pad = inv_dir.abs() * half_width;
        let (a, b) = (to_min * inv_dir, to_max * inv_dir);
        // The last component lies before what is entered and after what is left.
        let enter = (a.min(b) - pad).max_element();
        let exit = (a.max(b) + pad).min_element();
        let t_enter = if enter > 0.0 { enter } else { 0.0 };
        let t_exit = if exit < ray.t_max { exit } else { ray.t_max };
        Self {
            origin,
            inv_dir,
            half_width,
            t_enter,
            t_exit,
            is_met: has_meaning & (t_enter <= t_exit),
        }
    }

    /// None if the ray misses the bounds or has no meaning.
    #[inline(always)]
    pub fn met(ray: &Ray, bounds: &Aabb) -> Option<Self> {
        let beam = Self::new(ray, bounds);
        beam.is_met.then_some(beam)
    }

    /// A bit for each axis along which what is above is nearer than what is below. A direction of
    /// −0 is no exception: both sides of a plane are then visited or the same one.
    #[inline(always)]
    pub fn octant(&self) -> u32 {
        self.inv_dir.is_negative_bitmask() & 7
    }
}
