//! Walking rays that run close together as one.

use glam::Vec3;

use super::node::Node;
use super::walk::Meet;
use super::{Bvh, Leaves};
use crate::accel::Beam;
use crate::math::Ray;
use crate::simd::Lanes;

/// How far the directions of a packet may spread along an axis, all of unit length, and how far
/// its origins in units of the bounds (measured: docs/ray-casting.md).
const SPREAD: f32 = 0.06;

/// All the rays of a packet: the part of space that they pass through.
pub(crate) struct Packet {
    /// Least and greatest, relative to the tree's centre.
    origin: [[f32; 2]; 3],
    /// Of one sign on each axis.
    inv_dir: [[f32; 2]; 3],
    pad: [f32; 3],
    t_max: f32,
}

impl Packet {
    /// None unless all rays meet the tree and run close together.
    #[inline(always)]
    pub fn new(tree: &Bvh, rays: &[Ray]) -> Option<Self> {
        let (mut lo, mut hi) = (Vec3::INFINITY, Vec3::NEG_INFINITY);
        let (mut dir_lo, mut dir_hi) = (lo, hi);
        for ray in rays {
            (lo, hi) = (lo.min(ray.origin), hi.max(ray.origin));
            (dir_lo, dir_hi) = (dir_lo.min(ray.dir), dir_hi.max(ray.dir));
        }
        let size = (tree.bounds.max - tree.bounds.min).max_element();
        let together = (dir_hi - dir_lo).max_element() <= SPREAD
            && (hi - lo).max_element() <= SPREAD * size
            && (dir_lo * dir_hi).cmpgt(Vec3::ZERO).all();
        if !together || tree.nodes.is_empty() {
            return None;
        }
        let (mut inv_lo, mut inv_hi) = (Vec3::INFINITY, Vec3::NEG_INFINITY);
        let (mut pad, mut t_max) = (Vec3::ZERO, 0f32);
        for ray in rays {
            let beam = Beam::new(ray, &tree.bounds)?;
            (inv_lo, inv_hi) = (inv_lo.min(beam.inv_dir), inv_hi.max(beam.inv_dir));
            pad = pad.max(beam.pad);
            t_max = t_max.max(ray.t_max);
        }
        let (lo, hi) = (lo - tree.center, hi - tree.center);
        Some(Self {
            origin: [0, 1, 2].map(|i| [lo[i], hi[i]]),
            inv_dir: [0, 1, 2].map(|i| [inv_lo[i], inv_hi[i]]),
            pad: pad.to_array(),
            t_max,
        })
    }
}

impl Meet for Packet {
    /// Bounds on where any of the rays enters and leaves.
    #[inline(always)]
    fn meet<L: Lanes>(&self, node: &Node, t_max: f32) -> (L, L) {
        let (mut enter, mut exit) = (L::splat(0.0), L::splat(t_max));
        for axis in 0..3 {
            let [inv_lo, inv_hi] = self.inv_dir[axis];
            // Lower planes are nearer for rays that go up; the ray that starts highest is first.
            let near = usize::from(inv_lo < 0.0);
            let (near_planes, far_planes) = (
                L::load(&node.planes[axis][near]),
                L::load(&node.planes[axis][near ^ 1]),
            );
            let first = near_planes.sub(L::splat(self.origin[axis][near ^ 1]));
            let last = far_planes.sub(L::splat(self.origin[axis][near]));
            let (lo, hi) = (L::splat(inv_lo), L::splat(inv_hi));
            let pad = L::splat(self.pad[axis]);
            enter = enter.max(first.mul(lo).min(first.mul(hi)).sub(pad));
            exit = exit.min(last.mul(lo).max(last.mul(hi)).add(pad));
        }
        (enter, exit)
    }
}

impl Bvh {
    /// [`Bvh::walk`] for all rays of a packet together: a leaf that any of them may meet is
    /// visited, with the greatest `t_max` of all.
    #[inline(always)]
    pub(crate) fn walk_packet<L: Lanes>(&self, packet: &Packet, leaves: &mut impl Leaves) {
        self.walk_along::<L>(packet, packet.t_max, leaves);
    }
}
