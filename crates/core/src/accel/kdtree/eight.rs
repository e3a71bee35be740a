//! Walking eight rays through the tree together: each has an interval of its own, which is empty where
//! the others go without it, and all else is as for one ray (`traverse.rs`). A node is fetched once, and
//! no branch hangs on a single ray.

use super::node::Kind;
use super::{KdTree, MAX_DEPTH};
use crate::accel::bvh::{Along, Octant};
use crate::accel::{Beam, Tree};
use crate::math::Ray;
use crate::simd::Lanes;

/// Eight rays on their way.
pub(crate) trait Eight<L: Lanes> {
    /// Tests a primitive for the rays whose bits are set.
    fn visit(&mut self, id: u32, rays: u32);
    /// How far each goes yet, when a leaf is left: as `visit` of [`KdTree::walk`] returns it.
    fn t_max(&mut self) -> L;
}

/// Where eight rays have yet to go: a node, and where each enters its cell and leaves it. Used again from
/// walk to walk, as clearing it takes as long as some steps.
pub(crate) struct Stack<L>([(u32, L, L); MAX_DEPTH]);

impl<L: Lanes> Stack<L> {
    #[inline(always)]
    pub fn new() -> Self {
        Self([(0, L::splat(0.0), L::splat(0.0)); MAX_DEPTH])
    }
}

/// 1/direction, the origin, the half-width of the beam, and how far it goes.
impl Tree for KdTree {
    #[inline(always)]
    fn along(&self, ray: &Ray) -> (Along, bool) {
        let Beam {
            origin: [ox, oy, oz],
            inv_dir: [ix, iy, iz],
            half_width,
            is_met,
            ..
        } = Beam::new(ray, &self.bounds);
        let along = Along([ix, iy, iz, ox, oy, oz, half_width, ray.t_max]);
        (along, is_met)
    }
}

impl KdTree {
    /// Visits the primitives along eight rays of one octant, given as columns of [`Tree::along`].
    #[inline(always)]
    pub(crate) fn walk_eight<L: Lanes>(
        &self,
        [ix, iy, iz, ox, oy, oz, half_width, t_max]: [L; 8],
        octant: Octant,
        Stack(stack): &mut Stack<L>,
        rays: &mut impl Eight<L>,
    ) {
        let zero = L::splat(0.0);
        let (inv_dir, origin) = ([ix, iy, iz], [ox, oy, oz]);
        let mut pad = [zero; 3];
        let (mut enter, mut exit) = (zero, t_max);
        for axis in 0..3 {
            pad[axis] = inv_dir[axis].max(zero.sub(inv_dir[axis])).mul(half_width);
            let (min, max) = (self.bounds.min[axis], self.bounds.max[axis]);
            let a = L::splat(min).sub(origin[axis]).mul(inv_dir[axis]);
            let b = L::splat(max).sub(origin[axis]).mul(inv_dir[axis]);
            enter = enter.max(a.min(b).sub(pad[axis]));
            exit = exit.min(a.max(b).add(pad[axis]));
        }
        let mut height = 0;
        let mut index = 0;
        loop {
            match self.nodes[index as usize].kind() {
                Kind::Inner { axis, split, below } => {
                    let t = L::splat(split).sub(origin[axis]).mul(inv_dir[axis]);
                    let (first, last) = (t.sub(pad[axis]), t.add(pad[axis]));
                    let side = (octant >> axis & 1) as u32;
                    let (near, far) = (below + side, below + (side ^ 1));
                    let (near_exit, far_enter) = (exit.min(last), enter.max(first));
                    if enter.le(near_exit) == 0 {
                        (index, enter) = (far, far_enter);
                        continue;
                    }
                    if far_enter.le(exit) != 0 {
                        stack[height] = (far, far_enter, exit);
                        height += 1;
                    }
                    (index, exit) = (near, near_exit);
                    continue;
                }
                Kind::Leaf { count: 0, .. } => {}
                Kind::Leaf { word, count } => {
                    let all = enter.le(exit);
                    match count {
                        1 => rays.visit(word, all),
                        _ => {
                            let ids = &self.ids[word as usize..][..count as usize];
                            for &id in ids {
                                rays.visit(id, all);
                            }
                        }
                    }
                }
            }
            let t_max = rays.t_max();
            loop {
                if height == 0 {
                    return;
                }
                height -= 1;
                (index, enter, exit) = stack[height];
                exit = exit.min(t_max);
                if enter.le(exit) != 0 {
                    break;
                }
            }
        }
    }
}
