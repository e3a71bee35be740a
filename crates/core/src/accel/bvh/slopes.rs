//! Where rays meet the boxes of nodes.

use super::Bvh;
use super::node::Node;
use crate::accel::Beam;
use crate::math::Ray;
use crate::simd::Lanes;

/// A ray in eight numbers, as they are read by the row. Relative to the tree's centre a plane is
/// met at plane · slope + start, widened:
/// - on each axis the slope, 1/direction;
/// - on each axis the start for planes that are nearer;
/// - by what the start for planes that are farther is greater, in units of |slope|;
/// - the distance up to which boxes are met.
#[derive(Clone, Copy, Default)]
#[repr(align(32))]
pub(crate) struct Along([f32; 8]);

/// The way that rays go: a bit is set for each axis along which they go down.
pub(crate) type Octant = usize;

/// Number of octants.
pub(crate) const OCTANTS: usize = 8;

/// For the roundings of starts for farther planes.
const WIDER: f32 = 1.0 + 1.0 / 64.0;

impl Along {
    /// Boxes beyond this distance need not be visited.
    #[inline(always)]
    pub fn t_max(&self) -> f32 {
        self.0[7]
    }

    /// Sets `t_max`; −∞ if no box need be visited.
    #[inline(always)]
    pub fn set_t_max(&mut self, t_max: f32) {
        self.0[7] = t_max;
    }
}

impl Bvh {
    /// What a walk needs of a ray, the octant that the ray goes to, and whether it meets the tree.
    #[inline(always)]
    pub(crate) fn along(&self, ray: &Ray) -> (Along, Octant, bool) {
        let beam = Beam::new(ray, &self.bounds);
        let start = (self.center.extend(0.0) - beam.origin) * beam.inv_dir;
        let first = start - beam.inv_dir.abs() * beam.half_width;
        let ([ix, iy, iz, _], [x, y, z, _]) = (beam.inv_dir.to_array(), first.to_array());
        let width = 2.0 * WIDER * beam.half_width;
        let along = Along([ix, iy, iz, x, y, z, width, ray.t_max]);
        (along, beam.octant() as usize, beam.is_met)
    }
}

/// A ray in every lane, or eight rays of an octant.
pub(super) struct Slopes<L> {
    slope: [L; 3],
    first: [L; 3],
    last: [L; 3],
    pub t_max: L,
}

impl<L: Lanes> Slopes<L> {
    /// The same ray in every lane.
    #[inline(always)]
    pub fn one(ray: &Along) -> Self {
        let [ix, iy, iz, x, y, z, width, t_max] = &ray.0;
        Self::new([
            L::splat(*ix),
            L::splat(*iy),
            L::splat(*iz),
            L::splat(*x),
            L::splat(*y),
            L::splat(*z),
            L::splat(*width),
            L::splat(*t_max),
        ])
    }

    /// Eight rays.
    #[inline(always)]
    pub fn eight([a, b, c, d, e, f, g, h]: [&Along; 8]) -> Self {
        Self::new(L::transpose([
            &a.0, &b.0, &c.0, &d.0, &e.0, &f.0, &g.0, &h.0,
        ]))
    }

    #[inline(always)]
    fn new([ix, iy, iz, x, y, z, width, t_max]: [L; 8]) -> Self {
        Self {
            slope: [ix, iy, iz],
            first: [x, y, z],
            last: [
                abs(ix).mul_add(width, x),
                abs(iy).mul_add(width, y),
                abs(iz).mul_add(width, z),
            ],
            t_max,
        }
    }

    /// Where boxes are entered, but not before the start, and where they are left, but not after
    /// `t_max`; a box is met unless it is entered after it is left.
    #[inline(always)]
    pub fn meet(&self, planes: &Planes<L>, t_max: L) -> (L, L) {
        let (mut enter, mut exit) = (L::splat(0.0), t_max);
        for axis in 0..3 {
            let slope = self.slope[axis];
            enter = enter.max(planes.near[axis].mul_add(slope, self.first[axis]));
            exit = exit.min(planes.far[axis].mul_add(slope, self.last[axis]));
        }
        (enter, exit)
    }
}

#[inline(always)]
fn abs<L: Lanes>(x: L) -> L {
    x.max(L::splat(0.0).sub(x))
}

/// Boxes as rays of an octant meet them, by axis.
pub(super) struct Planes<L> {
    near: [L; 3],
    far: [L; 3],
}

impl<L: Lanes> Planes<L> {
    /// The boxes of a node's children.
    #[inline(always)]
    pub fn of_children(node: &Node, octant: Octant) -> Self {
        let near = [0, 1, 2].map(|axis| octant >> axis & 1);
        let [x, y, z] = &node.planes;
        Self {
            near: [
                L::load(&x[near[0]]),
                L::load(&y[near[1]]),
                L::load(&z[near[2]]),
            ],
            far: [
                L::load(&x[near[0] ^ 1]),
                L::load(&y[near[1] ^ 1]),
                L::load(&z[near[2] ^ 1]),
            ],
        }
    }

    /// The box of a child in every lane.
    #[inline(always)]
    pub fn of_child(node: &Node, child: usize, octant: Octant) -> Self {
        let near = [0, 1, 2].map(|axis| octant >> axis & 1);
        let [x, y, z] = &node.planes;
        Self {
            near: [
                L::splat(x[near[0]][child]),
                L::splat(y[near[1]][child]),
                L::splat(z[near[2]][child]),
            ],
            far: [
                L::splat(x[near[0] ^ 1][child]),
                L::splat(y[near[1] ^ 1][child]),
                L::splat(z[near[2] ^ 1][child]),
            ],
        }
    }

    /// A number for each box that grows along the octant's diagonal, not negative if `offset` is
    /// twice what the boxes reach from the centre, over all axes.
    #[inline(always)]
    pub fn depth(&self, octant: Octant, offset: f32) -> L {
        let mut depth = L::splat(offset);
        for axis in 0..3 {
            let sign = if octant >> axis & 1 == 0 { 1.0 } else { -1.0 };
            depth = self.near[axis]
                .add(self.far[axis])
                .mul_add(L::splat(sign), depth);
        }
        depth.max(L::splat(0.0))
    }
}
