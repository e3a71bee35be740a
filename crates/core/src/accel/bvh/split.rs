//! Dividing primitives in two: the best of a few planes by the surface-area heuristic (Wald 2007,
//! On fast construction of SAH-based bounding volume hierarchies).

use glam::{Vec4, Vec4Swizzles};
use rayon::prelude::*;

use crate::math::Aabb;

/// A box in registers; the last components mean nothing.
#[derive(Clone, Copy, Debug)]
pub(super) struct Box4 {
    lo: Vec4,
    hi: Vec4,
}

impl Box4 {
    pub const EMPTY: Self = Self {
        lo: Vec4::INFINITY,
        hi: Vec4::NEG_INFINITY,
    };

    #[inline(always)]
    fn union(&self, other: &Self) -> Self {
        Self {
            lo: self.lo.min(other.lo),
            hi: self.hi.max(other.hi),
        }
    }

    #[inline(always)]
    fn add_point(&mut self, p: Vec4) {
        (self.lo, self.hi) = (self.lo.min(p), self.hi.max(p));
    }

    #[inline(always)]
    pub fn half_area(&self) -> f32 {
        let e = self.hi - self.lo;
        e.x * e.y + e.y * e.z + e.z * e.x
    }

    pub fn aabb(&self) -> Aabb {
        Aabb {
            min: self.lo.xyz(),
            max: self.hi.xyz(),
        }
    }
}

/// A primitive's box and, in the last component of `lo`, its id.
#[derive(Clone, Copy, Debug)]
pub(super) struct Ref(Box4);

impl Ref {
    pub fn new(bounds: &Aabb, id: u32) -> Self {
        Self(Box4 {
            lo: bounds.min.extend(f32::from_bits(id)),
            hi: bounds.max.extend(0.0),
        })
    }

    #[inline(always)]
    pub fn id(&self) -> u32 {
        self.0.lo.w.to_bits()
    }

    /// Whether the box holds no point.
    pub fn is_empty(&self) -> bool {
        !(self.0.lo.xyz().cmple(self.0.hi.xyz()).all())
    }

    /// Twice the centre.
    #[inline(always)]
    fn center(&self) -> Vec4 {
        self.0.lo + self.0.hi
    }

    /// Boxes around all of them and around their centres.
    pub fn bounds(refs: &[Self]) -> (Box4, Box4) {
        let mut all = (Box4::EMPTY, Box4::EMPTY);
        for r in refs {
            all.0 = all.0.union(&r.0);
            all.1.add_point(r.center());
        }
        all
    }
}

/// Most bins per axis.
const BINS: usize = 16;

/// So many primitives are put into bins by several threads.
const PARALLEL: usize = 1 << 16;

/// A plane among centres.
#[derive(Clone, Copy, Debug)]
pub(super) struct Split {
    grid: Grid,
    axis: usize,
    /// Bins from this one on are above.
    bin: usize,
    /// Below and above: number of primitives.
    pub counts: [u32; 2],
    /// Their box.
    pub bounds: [Box4; 2],
}

/// Bins over the box of the centres.
#[derive(Clone, Copy, Debug)]
struct Grid {
    origin: Vec4,
    bins_per_unit: Vec4,
}

/// Added to a number below 2²³, it leaves the nearest whole number in the lowest bits.
const TO_WHOLE: f32 = (1 << 23) as f32;

/// A primitive's bin on an axis, of whatever is no number a bin all the same.
#[inline(always)]
fn bin_at(sum: f32) -> usize {
    sum.to_bits() as usize % BINS
}

#[derive(Clone, Copy)]
struct Bin {
    bounds: Box4,
    count: u32,
}

impl Bin {
    const EMPTY: Self = Self {
        bounds: Box4::EMPTY,
        count: 0,
    };

    #[inline(always)]
    fn join(&mut self, other: &Self) {
        self.bounds = self.bounds.union(&other.bounds);
        self.count += other.count;
    }
}

/// The bins of all axes.
type Table = [[Bin; BINS]; 3];

impl Grid {
    fn new(centers: &Box4, bins: usize) -> Self {
        let per_unit = |e: f32| if e > 0.0 { (bins - 1) as f32 / e } else { 0.0 };
        let e = centers.hi - centers.lo;
        Self {
            origin: centers.lo,
            bins_per_unit: Vec4::new(per_unit(e.x), per_unit(e.y), per_unit(e.z), 0.0),
        }
    }

    /// Puts primitives into the bins.
    #[inline(always)]
    fn fill(&self, refs: &[Ref], table: &mut Table) {
        for r in refs {
            let at = (r.center() - self.origin) * self.bins_per_unit + Vec4::splat(TO_WHOLE);
            for (row, at) in table.iter_mut().zip([at.x, at.y, at.z]) {
                let bin = &mut row[bin_at(at)];
                bin.bounds = bin.bounds.union(&r.0);
                bin.count += 1;
            }
        }
    }
}

impl Split {
    /// The split of least cost; none if all centres are in one place.
    pub fn best(refs: &[Ref], centers: &Box4) -> Option<Self> {
        let bins = match refs.len() {
            0 | 1 => return None,
            2..4 => 4,
            4..32 => 8,
            _ => BINS,
        };
        let grid = Grid::new(centers, bins);
        let mut table = [[Bin::EMPTY; BINS]; 3];
        if refs.len() < PARALLEL {
            grid.fill(refs, &mut table);
        } else {
            // Unions and sums do not depend on the order.
            let tables = refs.par_chunks(PARALLEL / 4).map(|refs| {
                let mut table = [[Bin::EMPTY; BINS]; 3];
                grid.fill(refs, &mut table);
                table
            });
            let join = |mut a: Table, b: Table| {
                for (a, b) in a.iter_mut().flatten().zip(b.iter().flatten()) {
                    a.join(b);
                }
                a
            };
            table = tables.reduce(|| [[Bin::EMPTY; BINS]; 3], join);
        }
        let mut best: Option<(f32, usize, usize)> = None;
        for (axis, row) in table.iter().enumerate() {
            // What is above each plane, from the last to the first: Σ area · primitives.
            let mut above = [(0.0, 0); BINS];
            let mut all = Bin::EMPTY;
            for i in (1..bins).rev() {
                all.join(&row[i]);
                above[i] = (all.bounds.half_area() * all.count as f32, all.count);
            }
            let mut below = Bin::EMPTY;
            for i in 1..bins {
                below.join(&row[i - 1]);
                let cost = below.bounds.half_area() * below.count as f32 + above[i].0;
                if below.count > 0 && above[i].1 > 0 && best.is_none_or(|(c, ..)| cost < c) {
                    best = Some((cost, axis, i));
                }
            }
        }
        let (_, axis, bin) = best?;
        let side = |bins: &[Bin]| {
            let mut all = Bin::EMPTY;
            bins.iter().for_each(|bin| all.join(bin));
            all
        };
        let sides = [side(&table[axis][..bin]), side(&table[axis][bin..bins])];
        Some(Self {
            grid,
            axis,
            bin,
            counts: sides.map(|side| side.count),
            bounds: sides.map(|side| side.bounds),
        })
    }

    /// Moves what is below to the front, and gives its number and the boxes of both sides'
    /// centres.
    pub fn partition(&self, refs: &mut [Ref]) -> (usize, [Box4; 2]) {
        let mut centers = [Box4::EMPTY; 2];
        let (origin, per_unit) = (
            self.grid.origin[self.axis],
            self.grid.bins_per_unit[self.axis],
        );
        let is_below = |r: &Ref| {
            let at = (r.center()[self.axis] - origin) * per_unit + TO_WHOLE;
            bin_at(at) < self.bin
        };
        let (mut begin, mut end) = (0, refs.len());
        loop {
            while begin < end && is_below(&refs[begin]) {
                centers[0].add_point(refs[begin].center());
                begin += 1;
            }
            while begin < end && !is_below(&refs[end - 1]) {
                centers[1].add_point(refs[end - 1].center());
                end -= 1;
            }
            // Both stopped: at one that is above, and at one that is below.
            if begin >= end {
                return (begin, centers);
            }
            refs.swap(begin, end - 1);
        }
    }
}
