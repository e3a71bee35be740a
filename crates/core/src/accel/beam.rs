//! A ray as the trees walk it.
//!
//! A walk must not miss what a primitive's own test would accept, and that test rounds. So the
//! ray is walked as a beam: every plane is met not at one distance but over an interval that
//! covers all rounding.

use glam::{Vec3, Vec4};

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

/// A ray in a form that planes are met with, the part of it inside some bounds.
pub(super) struct Beam {
    pub origin: Vec3,
    /// 1/direction, limited so that its product with R is finite: then no plane in reach is met
    /// at NaN, and a ray parallel to a plane meets it either far outside the bounds or, within
    /// the beam's width, everywhere.
    pub inv_dir: Vec3,
    /// Half-width of the beam as a distance along the ray, on each axis.
    pub pad: Vec3,
    pub t_enter: f32,
    pub t_exit: f32,
}

impl Beam {
    /// None if the ray misses the bounds or has no meaning.
    #[inline(always)]
    pub fn new(ray: &Ray, bounds: &Aabb) -> Option<Self> {
        // In registers of four; the last component is 0.
        let [origin, dir, min, max] =
            [ray.origin, ray.dir, bounds.min, bounds.max].map(|v| v.extend(0.0));
        let (to_min, to_max) = (min - origin, max - origin);
        let reach = to_min.abs().max(to_max.abs()).max_element();
        let finite = origin.is_finite() && dir.is_finite() && reach < f32::INFINITY;
        let empty = dir == Vec4::ZERO || ray.t_max.is_nan() || ray.t_max <= 0.0;
        if !finite || empty {
            return None;
        }
        const HUGE: f32 = (1u128 << 124) as f32;
        let inv_limit = Vec4::splat(HUGE / reach.max(1.0));
        let inv_dir = dir.recip().clamp(-inv_limit, inv_limit);
        let pad = inv_dir.abs() * (PAD * reach);
        let (a, b) = (to_min * inv_dir, to_max * inv_dir);
        let (enter, exit) = (a.min(b) - pad, a.max(b) + pad);
        let t_enter = enter.x.max(enter.y).max(enter.z).max(0.0);
        let t_exit = exit.x.min(exit.y).min(exit.z).min(ray.t_max);
        (t_enter <= t_exit).then_some(Self {
            origin: ray.origin,
            inv_dir: inv_dir.truncate(),
            pad: pad.truncate(),
            t_enter,
            t_exit,
        })
    }

    /// 0 if what is below is nearer, 1 if what is above is. A direction of −0 is no exception:
    /// both sides of a plane are then visited or the same one.
    #[inline(always)]
    pub fn near(&self, axis: usize) -> u32 {
        u32::from(self.inv_dir[axis].is_sign_negative())
    }
}
