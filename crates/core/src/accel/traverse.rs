//! Walking a ray through the tree.
//!
//! The walk must not miss what a primitive's own test would accept, and that test rounds. So the
//! ray is walked as a beam: every plane is met not at one distance but over an interval that
//! covers all rounding, and in it both sides are visited.

use glam::Vec3;

use super::node::Kind;
use super::{KdTree, MAX_DEPTH};
use crate::math::{Aabb, Ray};

/// Half-width of the beam in units of the largest distance R, along an axis, from the ray's
/// origin to a corner of the tree's bounds: 64 ε with ε = 2⁻²⁴. It is made of
/// - 28 ε for primitives. What a test accepts at distance t lies, in exact arithmetic, so near
///   the point at t on each axis. For triangles after Woop, Benthin & Wald (2013) with the edge
///   functions of a hit taken in f64 it is 16 ε: shearing a vertex, which is at most R away, costs
///   6 ε, and the weighted mean that gives t costs 10 ε. For spheres it is 28 ε.
/// - 4 ε for the walk: (split − origin) · (1/direction), and widening that.
/// - 28 ε for visitors that let a primitive win that is behind another by 2⁻²⁰ of the distance,
///   16 ε of at most √3 R.
const PAD: f32 = 64.0 / (1 << 24) as f32;

/// A ray on one axis.
#[derive(Clone, Copy, Default)]
struct Line {
    origin: f32,
    /// 1/direction, limited so that its product with R is finite: then no plane in reach is met
    /// at NaN, and a ray parallel to a plane meets it either far outside the bounds or, within
    /// the beam's width, everywhere.
    inv_dir: f32,
    /// Half-width of the beam as a distance along the ray.
    pad: f32,
    /// 0 if the child below is nearer, 1 if the one above is. A direction of −0 is no
    /// exception: both children are then visited or the same one.
    near: u32,
}

/// The part of a ray inside the bounds.
struct Beam {
    lines: [Line; 3],
    t_enter: f32,
    t_exit: f32,
}

impl Beam {
    /// None if the ray misses the bounds or has no meaning.
    #[inline]
    fn new(ray: &Ray, bounds: &Aabb) -> Option<Self> {
        let (to_min, to_max) = (bounds.min - ray.origin, bounds.max - ray.origin);
        let reach = to_min.abs().max(to_max.abs()).max_element();
        let finite = ray.origin.is_finite() && ray.dir.is_finite() && reach < f32::INFINITY;
        let empty = ray.dir == Vec3::ZERO || ray.t_max.is_nan() || ray.t_max <= 0.0;
        if !finite || empty {
            return None;
        }
        const HUGE: f32 = (1u128 << 125) as f32;
        let inv_limit = HUGE / reach.max(1.0);
        let mut lines = [Line::default(); 3];
        let (mut t_enter, mut t_exit) = (0f32, ray.t_max);
        for axis in 0..3 {
            let inv_dir = (1.0 / ray.dir[axis]).clamp(-inv_limit, inv_limit);
            let pad = PAD * reach * inv_dir.abs();
            let (a, b) = (to_min[axis] * inv_dir, to_max[axis] * inv_dir);
            t_enter = t_enter.max(a.min(b) - pad);
            t_exit = t_exit.min(a.max(b) + pad);
            lines[axis] = Line {
                origin: ray.origin[axis],
                inv_dir,
                pad,
                near: u32::from(inv_dir.is_sign_negative()),
            };
        }
        (t_enter <= t_exit).then_some(Self {
            lines,
            t_enter,
            t_exit,
        })
    }
}

impl KdTree {
    /// Calls `visit(id, t_max)` for the primitives along `ray`, cells in order, a primitive
    /// possibly more than once. `visit` returns the new `t_max`: the same, the distance of a hit
    /// that makes what lies beyond it uninteresting, or −∞ to stop at once. The first is
    /// `ray.t_max`.
    ///
    /// Visited is every primitive that `ray` meets, to within the rounding errors of an f32 test,
    /// at a distance up to the final `t_max` plus 2⁻²⁰ of itself. A ray with NaN or infinite
    /// origin or direction, no direction, or without `t_max > 0` visits nothing.
    #[inline]
    pub fn walk(&self, ray: &Ray, mut visit: impl FnMut(u32, f32) -> f32) {
        let Some(beam) = Beam::new(ray, &self.bounds) else {
            return;
        };
        let (mut t_enter, mut t_exit) = (beam.t_enter, beam.t_exit);
        let mut t_max = ray.t_max;
        let mut stack = [(0, 0.0, 0.0); MAX_DEPTH];
        let mut height = 0;
        let mut index = 0;
        loop {
            match self.nodes[index as usize].kind() {
                Kind::Inner { axis, split, below } => {
                    let line = &beam.lines[axis];
                    let t = (split - line.origin) * line.inv_dir;
                    let (t_first, t_last) = (t - line.pad, t + line.pad);
                    let (near, far) = (below + line.near, below + (line.near ^ 1));
                    if t_first > t_exit {
                        index = near;
                    } else if t_last < t_enter {
                        index = far;
                    } else {
                        stack[height] = (far, t_first.max(t_enter), t_exit);
                        height += 1;
                        index = near;
                        t_exit = t_exit.min(t_last);
                    }
                    continue;
                }
                Kind::Leaf { word, count: 1 } => t_max = visit(word, t_max),
                Kind::Leaf { word, count } => {
                    for &id in &self.ids[word as usize..][..count as usize] {
                        t_max = visit(id, t_max);
                        if t_max == f32::NEG_INFINITY {
                            return;
                        }
                    }
                }
            }
            // Intervals overlap, so a cell that begins too late may lie above one that does not.
            loop {
                if height == 0 {
                    return;
                }
                height -= 1;
                (index, t_enter, t_exit) = stack[height];
                if t_enter <= t_max {
                    break;
                }
            }
        }
    }
}
