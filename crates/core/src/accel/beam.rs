//! A ray as the trees walk it.
//!
//! A walk must not miss what a primitive's own test would accept, and that test rounds. So the
//! ray is walked as a beam: every plane is met not at one distance but over an interval that
//! covers all rounding.

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
#[derive(Clone, Copy)]
pub(crate) struct Beam {
    pub origin: [f32; 3],
    /// 1/direction, limited so that its product with R is finite: then no plane in reach is met
    /// at NaN, and a ray parallel to a plane meets it either far outside the bounds or, within
    /// the beam's width, everywhere.
    pub inv_dir: [f32; 3],
    /// Half-width of the beam; times |`inv_dir`|, as a distance along the ray on each axis.
    pub half_width: f32,
    pub t_enter: f32,
    pub t_exit: f32,
    /// Whether the ray has meaning and meets the bounds.
    pub is_met: bool,
}

impl Beam {
    /// Without a branch, so that a loop over many rays is SIMD code.
    #[inline(always)]
    pub fn new(ray: &Ray, bounds: &Aabb) -> Self {
        const HUGE: f32 = (1u128 << 124) as f32;
        let (origin, dir) = (ray.origin.to_array(), ray.dir.to_array());
        let (min, max) = (bounds.min.to_array(), bounds.max.to_array());
        let (mut reach, mut nothing) = (0.0, 0.0);
        let mut has_direction = false;
        for axis in 0..3 {
            reach = larger(reach, (min[axis] - origin[axis]).abs());
            reach = larger(reach, (max[axis] - origin[axis]).abs());
            // Infinity times zero is NaN.
            nothing += origin[axis] * 0.0 + dir[axis] * 0.0;
            has_direction |= dir[axis] != 0.0;
        }
        let has_meaning =
            (nothing == 0.0) & (reach < f32::INFINITY) & has_direction & (ray.t_max > 0.0);
        let limit = HUGE / larger(reach, 1.0);
        let half_width = PAD * reach;
        let mut inv_dir = [0.0; 3];
        let (mut t_enter, mut t_exit) = (0.0, ray.t_max);
        for axis in 0..3 {
            let inv = smaller(larger(1.0 / dir[axis], -limit), limit);
            let pad = inv.abs() * half_width;
            let (a, b) = (
                (min[axis] - origin[axis]) * inv,
                (max[axis] - origin[axis]) * inv,
            );
            t_enter = larger(t_enter, smaller(a, b) - pad);
            t_exit = smaller(t_exit, larger(a, b) + pad);
            inv_dir[axis] = inv;
        }
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
        let [x, y, z] = self.inv_dir.map(|x| x.to_bits() >> 31);
        x | y << 1 | z << 2
    }
}

/// One instruction, as minima and maxima that care for NaN are not.
#[inline(always)]
fn smaller(a: f32, b: f32) -> f32 {
    if a < b { a } else { b }
}

/// See [`smaller`].
#[inline(always)]
fn larger(a: f32, b: f32) -> f32 {
    if a > b { a } else { b }
}
