//! Dividing primitives in two: the best of a few planes by the surface-area heuristic (Wald 2007,
//! On fast construction of SAH-based bounding volume hierarchies).

use glam::{Vec3, Vec4, Vec4Swizzles};

use crate::math::Aabb;

/// A box in registers; the last components mean nothing.
#[derive(Clone, Copy, Debug)]
pub(super) struct Box4 {
    lo: Vec4,
    hi: Vec4,
}

impl Box4 {
    const EMPTY: Self = Self {
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

    /// In f64, in which the squares of all f32 have room.
    #[inline(always)]
    pub fn half_area(&self) -> f64 {
        let e = (self.hi - self.lo).xyz().as_dvec3();
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

/// A plane among centres.
#[derive(Clone, Copy, Debug)]
pub(super) struct Split {
    grid: Grid,
    axis: usize,
    /// Bins from this one on are above.
    bin: i32,
    /// Below and above: number of primitives.
    pub counts: [u32; 2],
    /// Their box.
    pub bounds: [Box4; 2],
    /// Its half area.
    pub areas: [f64; 2],
}

/// Bins over the box of the centres.
#[derive(Clone, Copy, Debug)]
struct Grid {
    origin: Vec4,
    bins_per_unit: Vec4,
    bins: usize,
}

impl Grid {
    /// A primitive's bin on each axis, from 0 to below `bins`.
    #[inline(always)]
    fn bins_of(&self, r: &Ref) -> [usize; 3] {
        let at = (r.center() - self.origin) * self.bins_per_unit;
        // Clamped as numbers: what is NaN becomes 0.
        let last = self.bins as i32 - 1;
        [at.x, at.y, at.z].map(|x| (x as i32).clamp(0, last) as usize)
    }
}

#[derive(Clone, Copy)]
struct Bin {
    bounds: Box4,
    count: u32,
}

impl Split {
    /// The split of least cost; none if all centres are in one place.
    pub fn best(refs: &[Ref], centers: &Box4) -> Option<Self> {
        if refs.len() < 2 {
            return None;
        }
        let bins = if refs.len() >= 64 { BINS } else { BINS / 2 };
        let extent = centers.hi - centers.lo;
        let per_unit = |e: f32| {
            if e > 0.0 {
                bins as f32 * 0.9999 / e
            } else {
                0.0
            }
        };
        let grid = Grid {
            origin: centers.lo,
            bins_per_unit: Vec3::new(per_unit(extent.x), per_unit(extent.y), per_unit(extent.z))
                .extend(0.0),
            bins,
        };
        const EMPTY: Bin = Bin {
            bounds: Box4::EMPTY,
            count: 0,
        };
        let mut table = [[EMPTY; BINS]; 3];
        for r in refs {
            let at = grid.bins_of(r);
            for axis in 0..3 {
                let bin = &mut table[axis][at[axis] & (BINS - 1)];
                bin.bounds = bin.bounds.union(&r.0);
                bin.count += 1;
            }
        }
        let mut best: Option<Self> = None;
        let mut least = f64::INFINITY;
        for (axis, row) in table.iter().enumerate() {
            if !(extent[axis] > 0.0) {
                continue;
            }
            // What is above each plane, from the last to the first.
            let mut above = [EMPTY; BINS];
            let mut all = EMPTY;
            for i in (1..bins).rev() {
                all.bounds = all.bounds.union(&row[i].bounds);
                all.count += row[i].count;
                above[i] = all;
            }
            let mut below = EMPTY;
            for i in 1..bins {
                below.bounds = below.bounds.union(&row[i - 1].bounds);
                below.count += row[i - 1].count;
                if below.count == 0 || above[i].count == 0 {
                    continue;
                }
                let sides = [below, above[i]];
                let areas = sides.map(|s| s.bounds.half_area());
                let cost = areas[0] * f64::from(below.count) + areas[1] * f64::from(above[i].count);
                if cost < least {
                    least = cost;
                    best = Some(Self {
                        grid,
                        axis,
                        bin: i as i32,
                        counts: sides.map(|s| s.count),
                        bounds: sides.map(|s| s.bounds),
                        areas,
                    });
                }
            }
        }
        best
    }

    /// Moves what is below to the front, and gives its number and the boxes of both sides'
    /// centres.
    pub fn partition(&self, refs: &mut [Ref]) -> (usize, [Box4; 2]) {
        let mut centers = [Box4::EMPTY; 2];
        let (mut begin, mut end) = (0, refs.len());
        let mut is_below = |r: &Ref| {
            let below = (self.grid.bins_of(r)[self.axis] as i32) < self.bin;
            centers[usize::from(!below)].add_point(r.center());
            below
        };
        loop {
            while begin < end && is_below(&refs[begin]) {
                begin += 1;
            }
            while begin < end && !is_below(&refs[end - 1]) {
                end -= 1;
            }
            // Both stopped: at one that is above, and at one that is below.
            if begin >= end {
                return (begin, centers);
            }
            end -= 1;
            refs.swap(begin, end);
            begin += 1;
        }
    }
}
