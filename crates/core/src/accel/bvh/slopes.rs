//! Where rays meet the boxes of nodes.

use super::Bvh;
use super::node::Node;
use crate::accel::{Beam, Tree};
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
pub(crate) struct Along(pub [f32; 8]);

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

    /// Where the ray goes.
    #[inline(always)]
    pub fn octant(&self) -> Octant {
        let [x, y, z] = [0, 1, 2].map(|axis| self.0[axis].to_bits() >> 31);
        (x | y << 1 | z << 2) as Octant
    }
}

impl Tree for Bvh {
    #[inline(always)]
    fn along(&self, ray: &Ray) -> (Along, bool) {
        let beam = Beam::new(ray, &self.bounds);
        let center = self.center.to_array();
        let mut first = [0.0; 3];
        for axis in 0..3 {
            let slope = beam.inv_dir[axis];
            first[axis] =
                (center[axis] - beam.origin[axis]) * slope - slope.abs() * beam.half_width;
        }
        let ([ix, iy, iz], [x, y, z]) = (beam.inv_dir, first);
        let width = 2.0 * WIDER * beam.half_width;
        let along = Along([ix, iy, iz, x, y, z, width, ray.t_max]);
        (along, beam.is_met)
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

    /// From the numbers of [`Along`], of a ray or of eight.
    #[inline(always)]
    pub fn new([ix, iy, iz, x, y, z, width, t_max]: [L; 8]) -> Self {
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

    /// The boxes that are met, a bit for each.
    #[inline(always)]
    pub fn meets(&self, planes: &Planes<L>) -> u32 {
        let (enter, exit) = self.meet(planes, self.t_max);
        enter.le(exit)
    }

    /// In rows.
    #[inline(always)]
    pub fn store(&self) -> [[f32; 8]; 10] {
        let ([sx, sy, sz], [fx, fy, fz], [lx, ly, lz]) = (self.slope, self.first, self.last);
        [
            sx.store(),
            sy.store(),
            sz.store(),
            fx.store(),
            fy.store(),
            fz.store(),
            lx.store(),
            ly.store(),
            lz.store(),
            self.t_max.store(),
        ]
    }

    /// From rows.
    #[inline(always)]
    pub fn load([sx, sy, sz, fx, fy, fz, lx, ly, lz, t_max]: &[[f32; 8]; 10]) -> Self {
        Self {
            slope: [L::load(sx), L::load(sy), L::load(sz)],
            first: [L::load(fx), L::load(fy), L::load(fz)],
            last: [L::load(lx), L::load(ly), L::load(lz)],
            t_max: L::load(t_max),
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
    pub near: [L; 3],
    pub far: [L; 3],
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
