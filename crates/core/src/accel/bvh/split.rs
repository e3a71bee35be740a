//! Choosing how to divide primitives in two: the best of a few planes by the surface-area heuristic
//! (Wald 2007, On fast construction of SAH-based bounding volume hierarchies).

use rayon::prelude::*;

use super::boxes::{Box8, Ref, center, half_area};
use super::partition::{By, CHUNK, PARALLEL, TO_WHOLE, bin_at};
use crate::math::Aabb;
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
pub(super) struct Grid {
    origin: [f32; 8],
    bins_per_unit: [f32; 8],
}

/// What is in the bins along an axis.
#[derive(Clone, Copy)]
struct Row<const BINS: usize> {
    bounds: [Box8; BINS],
    counts: [u32; BINS],
}

impl<const BINS: usize> Row<BINS> {
    const EMPTY: Self = Self {
        bounds: [Box8::EMPTY; BINS],
        counts: [0; BINS],
    };
}

/// The bins of all axes.
type Table<const BINS: usize> = [Row<BINS>; 3];

impl Grid {
    fn new(centers: &Box8, bins: usize) -> Self {
        // The first and the last are half as wide: walls are met there.
        let per_unit = |e: f32| if e > 0.0 { (bins - 1) as f32 / e } else { 0.0 };
        let Aabb { min: lo, max } = centers.aabb();
        let e = max - lo;
        Self {
            origin: [lo.x, lo.y, lo.z, 0.0, 0.0, 0.0, 0.0, 0.0],
            bins_per_unit: [
                per_unit(e.x),
                per_unit(e.y),
                per_unit(e.z),
                0.0,
                0.0,
                0.0,
                0.0,
                0.0,
            ],
        }
    }

    /// For each axis, what [`bin_at`] takes, of a centre as [`center`] gives it.
    #[inline(always)]
    pub fn place<L: Lanes>(&self, center: L) -> [f32; 8] {
        let from_origin = center.sub(L::load(&self.origin));
        let bins = from_origin.mul(L::load(&self.bins_per_unit));
        bins.add(L::splat(TO_WHOLE)).store()
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
            let at = grid.place::<L>(center(r));
            for (row, at) in table.iter_mut().zip(at) {
                let bin = bin_at(at, BINS);
                row.bounds[bin] = row.bounds[bin].with::<L>(r);
                row.counts[bin] += 1;
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
        let mut table = [Row::<BINS>::EMPTY; 3];
        if refs.len() < PARALLEL {
            Fill(&grid, refs, &mut table).run::<L>();
        } else {
            let tables = refs.par_chunks(CHUNK).map(|refs| {
                let mut table = [Row::<BINS>::EMPTY; 3];
                kernel.run(Fill(&grid, refs, &mut table));
                table
            });
            // Unions and sums do not depend on the order.
            for other in &tables.collect::<Vec<Table<BINS>>>() {
                for (row, other) in table.iter_mut().zip(other) {
                    for bin in 0..BINS {
                        row.bounds[bin] = row.bounds[bin].union::<L>(&other.bounds[bin]);
                        row.counts[bin] += other.counts[bin];
                    }
                }
            }
        }
        let mut best = (f32::INFINITY, 0, 0);
        for (axis, row) in table.iter().enumerate() {
            // What is above each plane, from the last to the first: Σ area · primitives; no number if
            // there is nothing.
            let mut above = [0.0; BINS];
            let (mut bounds, mut count) = (L::splat(f32::INFINITY), 0);
            for i in (1..BINS).rev() {
                bounds = bounds.min(L::load(&row.bounds[i].0));
                count += row.counts[i];
                above[i] = half_area(bounds) * count as f32;
            }
            (bounds, count) = (L::splat(f32::INFINITY), 0);
            for (i, above) in above.iter().enumerate().skip(1) {
                bounds = bounds.min(L::load(&row.bounds[i - 1].0));
                count += row.counts[i - 1];
                let cost = half_area(bounds) * count as f32 + above;
                if cost < best.0 {
                    best = (cost, axis, i);
                }
            }
        }
        let (cost, axis, bin) = best;
        if cost == f32::INFINITY {
            return None;
        }
        let (below, above) = table[axis].bounds.split_at(bin);
        let around = |bins: &[Box8]| bins.iter().fold(Box8::EMPTY, |a, b| a.union::<L>(b));
        let (count, counts) = (refs.len() as u32, &table[axis].counts[..bin]);
        let count_below: u32 = counts.iter().sum();
        Some(Self {
            by: By::Plane {
                grid,
                axis,
                bins: BINS,
                above: bin,
            },
            counts: [count_below, count - count_below],
            bounds: [around(below), around(above)],
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
            boxes[set] = boxes[others].with::<L>(&refs[first]);
            areas[set] = half_area(L::load(&boxes[set].0));
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
