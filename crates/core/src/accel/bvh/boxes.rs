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
        self.with::<L>(&other.0)
    }

    /// A box around this and a primitive.
    #[inline(always)]
    pub fn with<L: Lanes>(&self, r: &Ref) -> Self {
        Self(L::load(&self.0).min(L::load(r)).store())
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

/// A primitive's box as in a [`Box8`], but anywhere in memory, and in the fourth place what [`Ordered`] holds.
pub(super) type Ref = [f32; 8];

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

/// Makes the fourth place of a [`Ref`] a number that arithmetic takes no notice of: denormal ones are slow.
const NORMAL: u32 = 1 << 30;

/// The [`Ref`] of a primitive; none of one whose box holds no point.
pub(super) fn new_ref(bounds: &Aabb, id: u32) -> Option<Ref> {
    let (lo, hi) = (bounds.min, -bounds.max);
    let id = f32::from_bits(id | NORMAL);
    (!bounds.is_empty()).then_some([lo.x, lo.y, lo.z, id, hi.x, hi.y, hi.z, 0.0])
}

#[inline(always)]
pub(super) fn ordered(r: &Ref) -> Ordered {
    Ordered(r[3].to_bits() & !NORMAL)
}

/// Makes a leaf begin with a primitive.
#[inline(always)]
pub(super) fn begin(r: &mut Ref) {
    r[3] = f32::from_bits(r[3].to_bits() | Ordered::BEGINS);
}

/// Twice the centre, as a box.
#[inline(always)]
pub(super) fn center<L: Lanes>(r: &Ref) -> L {
    let corners = L::load(r);
    corners.sub(corners.swap_halves())
}

/// Boxes around primitives and around their centres.
pub(super) fn bounds_of(refs: &[Ref], kernel: Kernel) -> [Box8; 2] {
    if refs.len() < PARALLEL {
        return kernel.run(Bounds(refs));
    }
    let parts: Vec<[Box8; 2]> = refs
        .par_chunks(CHUNK)
        .map(|refs| kernel.run(Bounds(refs)))
        .collect();
    kernel.run(Union(&parts))
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

/// See [`bounds_of`].
struct Bounds<'a>(&'a [Ref]);

impl Task for Bounds<'_> {
    type Output = [Box8; 2];

    #[inline(always)]
    fn run<L: Lanes>(self) -> [Box8; 2] {
        let mut all = [L::splat(f32::INFINITY); 2];
        for r in self.0 {
            all = [all[0].min(L::load(r)), all[1].min(center(r))];
        }
        all.map(|b| Box8(b.store()))
    }
}
