//! Choosing how to divide primitives in two: the best of a few planes by the surface-area heuristic
//! (Wald 2007, On fast construction of SAH-based bounding volume hierarchies).

use glam::Vec4;
use rayon::prelude::*;

use super::boxes::{Box8, Ref};
use super::partition::{By, CHUNK, PARALLEL, TO_WHOLE, bin_at};
use crate::simd::{Kernel, Lanes, Task};

/// What a leaf costs, up to a factor: its visit, and the test of each primitive.
pub(super) fn leaf_cost(half_area: f32, count: usize) -> f32 {
    half_area * (1.0 + 0.3 * count as f32)
}

/// Of up to so many all ways to divide them are tried.
const FEW: usize = 5;

/// A way to divide primitives.
#[derive(Clone, Copy, Debug)]
pub(super) struct Split {
    pub by: By,
    /// Below and above: number of primitives.
    pub counts: [u32; 2],
    /// Their box.
    pub bounds: [Box8; 2],
}

/// Bins over the box of the centres.
#[derive(Clone, Copy, Debug)]
struct Grid {
    origin: Vec4,
    bins_per_unit: Vec4,
}

/// What is in a bin. Its size is a power of two, for its place in a table to be found by a shift.
#[derive(Clone, Copy)]
#[repr(align(64))]
struct Bin {
    bounds: Box8,
    count: u32,
}

impl Bin {
    const EMPTY: Self = Self {
        bounds: Box8::EMPTY,
        count: 0,
    };

    #[inline(always)]
    fn join<L: Lanes>(&mut self, other: &Self) {
        self.bounds = self.bounds.union::<L>(&other.bounds);
        self.count += other.count;
    }
}

/// The bins of all axes.
type Table<const BINS: usize> = [[Bin; BINS]; 3];

impl Grid {
    fn new(centers: &Box8, bins: usize) -> Self {
        // The first and the last are half as wide: walls are met there.
        let per_unit = |e: f32| if e > 0.0 { (bins - 1) as f32 / e } else { 0.0 };
        let [lo, hi] = centers.corners();
        let e = -(lo + hi);
        Self {
            origin: lo,
            bins_per_unit: Vec4::new(per_unit(e.x), per_unit(e.y), per_unit(e.z), 0.0),
        }
    }
}

/// Puts primitives into bins.
struct Fill<'a, const BINS: usize>(&'a Grid, &'a [Ref], &'a mut Table<BINS>);

impl<const BINS: usize> Task for Fill<'_, BINS> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self) {
        let Self(grid, refs, table) = self;
        for r in refs {
            let at = (r.center() - grid.origin) * grid.bins_per_unit + Vec4::splat(TO_WHOLE);
            for (row, at) in table.iter_mut().zip([at.x, at.y, at.z]) {
                let bin = &mut row[bin_at(at, BINS)];
                bin.bounds = bin.bounds.union::<L>(&r.0);
                bin.count += 1;
            }
        }
    }
}

/// See [`Split::best`].
struct Best<'a>(&'a [Ref], &'a Box8, Kernel);

impl Task for Best<'_> {
    type Output = Option<Split>;

    #[inline(always)]
    fn run<L: Lanes>(self) -> Option<Split> {
        let Self(refs, centers, kernel) = self;
        match refs.len() {
            0 | 1 => None,
            2..=FEW => Some(Split::of_few::<L>(refs)),
            n if n < 32 => Split::binned::<L, 8>(refs, centers, kernel),
            _ => Split::binned::<L, 16>(refs, centers, kernel),
        }
    }
}

impl Split {
    /// The split of least cost; none if there is nothing to divide, or the centres of many are in one
    /// place.
    pub fn best(refs: &[Ref], centers: &Box8, kernel: Kernel) -> Option<Self> {
        kernel.run(Best(refs, centers, kernel))
    }

    #[inline(always)]
    fn binned<L: Lanes, const BINS: usize>(
        refs: &[Ref],
        centers: &Box8,
        kernel: Kernel,
    ) -> Option<Self> {
        let grid = Grid::new(centers, BINS);
        let mut table = [[Bin::EMPTY; BINS]; 3];
        if refs.len() < PARALLEL {
            Fill(&grid, refs, &mut table).run::<L>();
        } else {
            let tables = refs.par_chunks(CHUNK).map(|refs| {
                let mut table = [[Bin::EMPTY; BINS]; 3];
                kernel.run(Fill(&grid, refs, &mut table));
                table
            });
            // Unions and sums do not depend on the order.
            for other in &tables.collect::<Vec<Table<BINS>>>() {
                for (row, other) in table.iter_mut().zip(other) {
                    for (to, from) in row.iter_mut().zip(other) {
                        to.join::<L>(from);
                    }
                }
            }
        }
        let mut best: Option<(f32, usize, usize)> = None;
        for (axis, row) in table.iter().enumerate() {
            // What is above each plane, from the last to the first: Σ area · primitives.
            let mut above = [(0.0, 0); BINS];
            let mut all = Bin::EMPTY;
            for i in (1..BINS).rev() {
                all.join::<L>(&row[i]);
                above[i] = (all.bounds.half_area() * all.count as f32, all.count);
            }
            let mut below = Bin::EMPTY;
            for i in 1..BINS {
                below.join::<L>(&row[i - 1]);
                let cost = below.bounds.half_area() * below.count as f32 + above[i].0;
                if below.count > 0 && above[i].1 > 0 && best.is_none_or(|(c, ..)| cost < c) {
                    best = Some((cost, axis, i));
                }
            }
        }
        let (_, axis, bin) = best?;
        let mut sides = [Bin::EMPTY; 2];
        for (i, from) in table[axis].iter().enumerate() {
            sides[usize::from(i >= bin)].join::<L>(from);
        }
        Some(Self {
            by: By::Plane {
                axis,
                origin: grid.origin[axis],
                per_unit: grid.bins_per_unit[axis],
                bins: BINS,
                above: bin,
            },
            counts: sides.map(|side| side.count),
            bounds: sides.map(|side| side.bounds),
        })
    }

    /// The best of all ways to divide a few.
    #[inline(always)]
    fn of_few<L: Lanes>(refs: &[Ref]) -> Self {
        // By set of primitives, a bit for each.
        let mut boxes = [Box8::EMPTY; 1 << FEW];
        let mut areas = [0.0; 1 << FEW];
        let all = (1usize << refs.len()) - 1;
        for set in 1..=all {
            let (first, others) = (set.trailing_zeros() as usize, set & (set - 1));
            boxes[set] = boxes[others].union::<L>(&refs[first].0);
            areas[set] = boxes[set].half_area();
        }
        let cost = |set: usize| leaf_cost(areas[set], set.count_ones() as usize);
        let mut best = (f32::INFINITY, 1);
        // One is on one side.
        for below in (1..all).step_by(2) {
            let cost = cost(below) + cost(all ^ below);
            if cost < best.0 {
                best = (cost, below);
            }
        }
        let sides = [best.1, all ^ best.1];
        Self {
            by: By::Each(best.1 as u32),
            counts: sides.map(usize::count_ones),
            bounds: sides.map(|side| boxes[side]),
        }
    }
}
