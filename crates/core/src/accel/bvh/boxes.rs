//! Primitives as the builder of the tree moves them about: boxes with ids.

use glam::Vec3;
use rayon::prelude::*;

use super::partition::{CHUNK, PARALLEL};
use crate::math::Aabb;
use crate::simd::{Kernel, Lanes, Portable, Task};

/// A box as its lower corner and its upper one negated, so that a union is one minimum. What is in
/// the fourth and the last place means nothing.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(32))]
pub(super) struct Box8(pub [f32; 8]);

impl Box8 {
    pub const EMPTY: Self = Self([f32::INFINITY; 8]);

    #[inline(always)]
    pub fn union<L: Lanes>(&self, other: &Self) -> Self {
        Self(L::load(&self.0).min(L::load(&other.0)).store())
    }

    pub fn half_area(&self) -> f32 {
        half_area(Portable::load(&self.0))
    }

    pub fn aabb(&self) -> Aabb {
        let [x, y, z, _, a, b, c, _] = self.0;
        Aabb {
            min: Vec3::new(x, y, z),
            max: -Vec3::new(a, b, c),
        }
    }
}

/// Half the area of a [`Box8`].
#[inline(always)]
pub(super) fn half_area<L: Lanes>(bounds: L) -> f32 {
    // The extents negated.
    let [x, y, z, ..] = bounds.add(bounds.swap_halves()).store();
    x * y + y * z + z * x
}

/// A primitive's box and, in the fourth place, what [`Ordered`] holds.
#[derive(Clone, Copy, Debug)]
pub(super) struct Ref(pub Box8);

/// A primitive in the order of a tree's leaves: its id, and 2³¹ more where a leaf begins.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Ordered(u32);

impl Ordered {
    const BEGINS: u32 = 1 << 31;

    /// A primitive, and whether a leaf begins with it.
    pub fn new(id: u32, begins: bool) -> Self {
        Self(id | u32::from(begins) << 31)
    }

    /// The primitive's id.
    #[inline(always)]
    pub fn id(self) -> u32 {
        self.0 & !Self::BEGINS
    }

    /// Whether a leaf begins with it.
    #[inline(always)]
    pub fn begins(self) -> bool {
        self.0 & Self::BEGINS != 0
    }
}

impl Ref {
    /// Makes the fourth place a number that arithmetic takes no notice of: denormal ones are slow.
    const NORMAL: u32 = 1 << 30;

    pub fn new(bounds: &Aabb, id: u32) -> Self {
        let (lo, hi) = (bounds.min, -bounds.max);
        let id = f32::from_bits(id | Self::NORMAL);
        Self(Box8([lo.x, lo.y, lo.z, id, hi.x, hi.y, hi.z, 0.0]))
    }

    #[inline(always)]
    pub fn ordered(&self) -> Ordered {
        Ordered(self.0.0[3].to_bits() & !Self::NORMAL)
    }

    /// Makes a leaf begin with it.
    #[inline(always)]
    pub fn begin(&mut self) {
        self.0.0[3] = f32::from_bits(self.0.0[3].to_bits() | Ordered::BEGINS);
    }

    /// Whether the box holds no point.
    pub fn is_empty(&self) -> bool {
        let Aabb { min, max } = self.0.aabb();
        !min.cmple(max).all()
    }

    /// Twice the centre, as a box.
    #[inline(always)]
    pub fn center<L: Lanes>(&self) -> L {
        let corners = L::load(&self.0.0);
        corners.sub(corners.swap_halves())
    }

    /// Boxes around all of them and around their centres.
    pub fn bounds(refs: &[Self], kernel: Kernel) -> [Box8; 2] {
        if refs.len() < PARALLEL {
            return kernel.run(Bounds(refs));
        }
        let parts: Vec<[Box8; 2]> = refs
            .par_chunks(CHUNK)
            .map(|refs| kernel.run(Bounds(refs)))
            .collect();
        kernel.run(Union(&parts))
    }
}

/// Unions of boxes by place.
pub(super) struct Union<'a>(pub &'a [[Box8; 2]]);

impl Task for Union<'_> {
    type Output = [Box8; 2];

    #[inline(always)]
    fn run<L: Lanes>(self) -> [Box8; 2] {
        let mut all = [Box8::EMPTY; 2];
        for [a, b] in self.0 {
            all = [all[0].union::<L>(a), all[1].union::<L>(b)];
        }
        all
    }
}

/// See [`Ref::bounds`].
struct Bounds<'a>(&'a [Ref]);

impl Task for Bounds<'_> {
    type Output = [Box8; 2];

    #[inline(always)]
    fn run<L: Lanes>(self) -> [Box8; 2] {
        let mut all = [L::splat(f32::INFINITY); 2];
        for r in self.0 {
            all = [all[0].min(L::load(&r.0.0)), all[1].min(r.center())];
        }
        all.map(|b| Box8(b.store()))
    }
}
