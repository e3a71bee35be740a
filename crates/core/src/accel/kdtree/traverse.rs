//! Walking a ray through the tree.
//!
//! The ray is a [`Beam`]: a plane is met over an interval, and in it both sides are visited.

use super::node::Kind;
use super::{KdTree, MAX_DEPTH};
use crate::accel::Beam;
use crate::math::Ray;

/// The beam on one axis.
struct Line {
    origin: f32,
    inv_dir: f32,
    pad: f32,
    near: u32,
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
        self.walk_with(ray, &mut visit, |_| (), |visit, id, t_max| visit(id, t_max));
    }

    /// [`KdTree::walk`] with something that both are shown: `node` at each inner node, and `visit`.
    #[inline(always)]
    pub(crate) fn walk_with<S>(
        &self,
        ray: &Ray,
        state: &mut S,
        node: impl Fn(&mut S),
        visit: impl Fn(&mut S, u32, f32) -> f32,
    ) {
        let Some(beam) = Beam::met(ray, &self.bounds) else {
            return;
        };
        let lines: [Line; 3] = std::array::from_fn(|axis| Line {
            origin: beam.origin[axis],
            inv_dir: beam.inv_dir[axis],
            pad: beam.inv_dir[axis].abs() * beam.half_width,
            near: beam.octant() >> axis & 1,
        });
        let (mut t_enter, mut t_exit) = (beam.t_enter, beam.t_exit);
        let mut t_max = ray.t_max;
        let mut stack = [(0, 0.0, 0.0); MAX_DEPTH];
        let mut height = 0;
        let mut index = 0;
        loop {
            match self.nodes[index as usize].kind() {
                Kind::Inner { axis, split, below } => {
                    node(state);
                    let line = &lines[axis];
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
                Kind::Leaf { word, count: 1 } => t_max = visit(state, word, t_max),
                Kind::Leaf { word, count } => {
                    for &id in &self.ids[word as usize..][..count as usize] {
                        t_max = visit(state, id, t_max);
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
