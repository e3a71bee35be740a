//! Triangles laid out for SIMD: runs of up to eight that are tested at once.

use glam::Vec3;

use super::candidates::{Apart, Candidates, Run};
use super::triangle::{ShearedRay, TriangleHit};
use crate::simd::{Lanes, prefetch};

/// Words per triangle: nine coordinates and a tag.
const WORDS: usize = 10;

/// Triangles in some order, each with a tag of the caller's. Any run (first, count) of those
/// that it was made of, with count ≤ 8, can be tested.
///
/// A run of n is n·`WORDS` words: nine rows of n for the coordinates (x, y, z of the first
/// vertex, then of the second and third), and a row of tags. Rows are read eight words wide
/// whatever n is, so the last run is followed by padding.
#[derive(Debug, Default)]
pub struct TriangleRuns {
    words: Vec<f32>,
}

/// Which triangles a run is made of, in 32 bits: 8 · first + (count − 1).
#[derive(Clone, Copy, Debug)]
pub(crate) struct RunId(u32);

impl RunId {
    pub fn new(first: usize, count: usize) -> Self {
        Self((first << 3 | (count - 1)) as u32)
    }

    pub fn from_bits(bits: u32) -> Self {
        Self(bits)
    }

    pub fn to_bits(self) -> u32 {
        self.0
    }
}

/// Where a triangle of a run lies: words and the stride between its coordinates.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Place {
    /// Its first coordinate.
    pub at: u32,
    /// Length of the run.
    pub count: u32,
}

impl Place {
    /// The first triangle of a run.
    #[inline(always)]
    pub fn new(first: u32, count: u32) -> Self {
        Self {
            at: first * WORDS as u32,
            count,
        }
    }

    /// The triangle so many places after it in its run.
    #[inline(always)]
    pub fn after(self, lane: u32) -> Self {
        Self {
            at: self.at + lane,
            ..self
        }
    }
}

impl TriangleRuns {
    /// A coordinate of a triangle: x, y, z of the first vertex, of the second, of the third.
    #[inline(always)]
    pub(crate) fn coordinate(&self, place: Place, i: usize) -> f32 {
        let at = place.at as usize + i * place.count as usize;
        debug_assert!(at < self.words.len());
        #[expect(
            unsafe_code,
            reason = "a pair is read in a dozen places, a check for each"
        )]
        // SAFETY: places are made of runs that there are, and nothing changes them.
        unsafe {
            *self.words.get_unchecked(at)
        }
    }

    /// The tag of a triangle.
    #[inline(always)]
    pub(crate) fn tag_at(&self, place: Place) -> u32 {
        self.coordinate(place, 9).to_bits()
    }

    /// The vertices of a triangle.
    #[inline(always)]
    pub(crate) fn triangle_at(&self, place: Place) -> [Vec3; 3] {
        [0, 3, 6].map(|v| Vec3::from_array([0, 1, 2].map(|axis| self.coordinate(place, v + axis))))
    }

    /// The triangle of a run that has a certain tag, which is in it.
    #[inline(always)]
    pub(crate) fn find(&self, run: RunId, tag: u32) -> Place {
        let (first, count) = (run.0 >> 3, (run.0 & 7) + 1);
        let run = Place::new(first, count);
        // Eight words at once, of which those behind the run mean nothing.
        let tags: &[f32] = &self.words[(run.at + 9 * count) as usize..][..Self::MAX];
        let mask = (0..Self::MAX).fold(0, |mask, lane| {
            mask | u32::from(tags[lane].to_bits() == tag) << lane
        });
        run.after(mask.trailing_zeros())
    }

    /// Number of triangles.
    #[inline(always)]
    pub fn count(&self) -> usize {
        self.words.len().saturating_sub(Self::MAX) / WORDS
    }

    /// Most triangles in a run.
    pub const MAX: usize = 8;

    /// Memory for so many triangles.
    pub(crate) fn memory(count: usize) -> Vec<f32> {
        vec![0.0; count * WORDS + Self::MAX]
    }

    /// Lays out a triangle for each item, in runs that begin where `begins` says so;
    /// `triangle(item)` gives it and its tag. No two of a run have the same tag. `ahead` is told of an item
    /// some time before, and `done` into which run it has gone. `words` is [`Self::memory`] for as many or more,
    /// whatever is in it.
    pub(crate) fn new<T: Sync>(
        mut words: Vec<f32>,
        items: &[T],
        begins: impl Fn(&T) -> bool + Sync,
        triangle: impl Fn(&T) -> ([Vec3; 3], u32) + Sync,
        ahead: impl Fn(&T) + Sync,
        done: impl Fn(&T, RunId) + Sync,
    ) -> Self {
        words.truncate(items.len() * WORDS + Self::MAX);
        fill(&mut words, (items, 0), &(begins, triangle, ahead, done));
        Self { words }
    }

    /// Memory, bytes.
    pub fn bytes(&self) -> usize {
        size_of_val(&*self.words)
    }

    /// The triangles of a run that [`ShearedRay::triangle`] might accept, a bit for each: all
    /// that it accepts and few that it does not.
    #[inline(always)]
    pub(crate) fn candidates<L: Lanes>(
        &self,
        ray: &ShearedRay,
        first: u32,
        count: u32,
        t_max: f32,
    ) -> Candidates<L> {
        self.run::<L>(first, count).candidates(ray, t_max)
    }

    /// A run in registers.
    #[inline(always)]
    pub(crate) fn run<L: Lanes>(&self, first: u32, count: u32) -> Run<L> {
        let n = count as usize;
        let words = &self.words[first as usize * WORDS..][..9 * n + Self::MAX];
        Run {
            rows: [
                [row(words, 0), row(words, n), row(words, 2 * n)],
                [row(words, 3 * n), row(words, 4 * n), row(words, 5 * n)],
                [row(words, 6 * n), row(words, 7 * n), row(words, 8 * n)],
            ],
            all: (1 << count) - 1,
        }
    }

    /// The boxes of a run's triangles relative to a centre, rounded outward: by axis the lower planes
    /// of all, the upper planes. A triangle that there is not has an empty box.
    #[inline(always)]
    pub(crate) fn boxes(&self, first: u32, count: u32, center: Vec3) -> [[[f32; 8]; 2]; 3] {
        let n = count as usize;
        let words = &self.words[first as usize * WORDS..][..9 * n + Self::MAX];
        let mut boxes = [[[f32::INFINITY; 8], [f32::NEG_INFINITY; 8]]; 3];
        for axis in 0..3 {
            let row = |v: usize| words[(3 * v + axis) * n..].first_chunk::<8>();
            let (Some(a), Some(b), Some(c)) = (row(0), row(1), row(2)) else {
                continue;
            };
            let center = center[axis];
            let [lower, upper] = &mut boxes[axis];
            for i in 0..8 {
                let (a, b, c) = (a[i], b[i], c[i]);
                let min = if a < b { a } else { b };
                let min = if c < min { c } else { min };
                let max = if a > b { a } else { b };
                let max = if c > max { c } else { max };
                let (min, max) = (min - center, max - center);
                let there = i < n;
                lower[i] = if there {
                    min - min.abs() * f32::EPSILON
                } else {
                    f32::INFINITY
                };
                upper[i] = if there {
                    max + max.abs() * f32::EPSILON
                } else {
                    f32::NEG_INFINITY
                };
            }
        }
        boxes
    }

    /// Asks for a run's memory.
    #[inline(always)]
    pub(crate) fn prefetch(&self, first: u32, count: u32) {
        let (first, count) = (first as usize * WORDS, count as usize * WORDS);
        for line in self.words[first..first + count].chunks(16) {
            prefetch(&line[0]);
        }
        prefetch(&self.words[first + count]);
    }

    /// The hit of a candidate pair of a ray and a triangle of a run with `0 < t ≤ t_max`, if any:
    /// [`ShearedRay::triangle`].
    #[inline(always)]
    pub(crate) fn hit(
        &self,
        (pairs, pair): (&Apart, u32),
        ray: impl FnOnce() -> ShearedRay,
        place: Place,
        t_max: f32,
    ) -> Option<TriangleHit> {
        let (hit, is_clear) = pairs.hit(pair, t_max)?;
        if is_clear {
            return Some(hit);
        }
        ray().meets_plane(self.triangle_at(place)).then_some(hit)
    }
}

/// So many triangles are laid out by one thread.
const SERIAL: usize = 16384;

/// By so many items is `ahead` ahead: memory is far, and some are looked for at a time.
const AHEAD: usize = 24;

/// Lays out triangles from the start of `words`, those of items from the `first` of all on; `how` as in
/// [`TriangleRuns::new`].
fn fill<T: Sync>(
    words: &mut [f32],
    (items, first): (&[T], usize),
    how: &(
        impl Fn(&T) -> bool + Sync,
        impl Fn(&T) -> ([Vec3; 3], u32) + Sync,
        impl Fn(&T) + Sync,
        impl Fn(&T, RunId) + Sync,
    ),
) {
    let (begins, triangle, ahead, done) = how;
    if items.len() > SERIAL {
        let half = items.len() / 2;
        let middle = half
            + items[half..]
                .iter()
                .take_while(|item| !begins(item))
                .count();
        let (before, after) = items.split_at(middle);
        let (words_before, words_after) = words.split_at_mut(middle * WORDS);
        rayon::join(
            || fill(words_before, (before, first), how),
            || fill(words_after, (after, first + middle), how),
        );
        return;
    }
    items.iter().take(AHEAD).for_each(ahead);
    let (mut rest, mut first, mut coming) = (words, first, items.iter().skip(AHEAD));
    for items in items.chunk_by(|_, next| !begins(next)) {
        let n = items.len();
        assert!(n <= TriangleRuns::MAX, "a run of {n} triangles");
        coming.by_ref().take(n).for_each(ahead);
        let id = RunId::new(first, n);
        let (run, after) = std::mem::take(&mut rest).split_at_mut(n * WORDS);
        for (lane, item) in items.iter().enumerate() {
            let (vertices, tag) = triangle(item);
            for (v, vertex) in vertices.iter().enumerate() {
                for axis in 0..3 {
                    run[(3 * v + axis) * n + lane] = vertex[axis];
                }
            }
            run[9 * n + lane] = f32::from_bits(tag);
            done(item, id);
        }
        (rest, first) = (after, first + n);
    }
}

/// Eight words in a row.
#[inline(always)]
fn row<L: Lanes>(words: &[f32], at: usize) -> L {
    match words[at..].first_chunk() {
        Some(row) => L::load(row),
        None => L::splat(0.0),
    }
}

#[cfg(test)]
mod test {
    use super::*;
    use crate::math::Ray;
    use crate::simd::{Kernel, Portable, Task};

    /// Splitmix64 (Steele, Lea & Flood 2014), 24 bits as a number in [−1, 1), coarse so that
    /// edges, vertices and planes are hit exactly.
    fn number(state: &mut u64) -> f32 {
        *state = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let x = (*state ^ (*state >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let x = (x ^ (x >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        let bits = (x ^ (x >> 31)) >> 40;
        if bits.is_multiple_of(3) {
            return (bits % 9) as f32 / 4.0 - 1.0;
        }
        bits as f32 / (1 << 23) as f32 - 1.0
    }

    /// The candidates of a run, for a kernel.
    struct Mask<'a> {
        runs: &'a TriangleRuns,
        ray: &'a ShearedRay,
        first: u32,
        count: u32,
        t_max: f32,
    }

    impl Task for Mask<'_> {
        type Output = u32;

        #[inline(always)]
        fn run<L: Lanes>(self) -> u32 {
            let found = self
                .runs
                .candidates::<L>(self.ray, self.first, self.count, self.t_max);
            found.mask
        }
    }

    #[test]
    fn candidates_hold_every_hit_and_few_more() {
        let mut state = 1;
        let mut point = || Vec3::from_array([0; 3].map(|_| number(&mut state)));
        let triangles: Vec<[Vec3; 3]> = (0..36).map(|_| [point(), point(), point()]).collect();
        // 1, 2, … 8 in a run.
        let items: Vec<usize> = (0..36).collect();
        let begins = |i: &usize| [0, 1, 3, 6, 10, 15, 21, 28].contains(i);
        let triangle = |i: &usize| (triangles[*i], *i as u32 + 7);
        let memory = TriangleRuns::memory(items.len());
        let runs = TriangleRuns::new(memory, &items, begins, triangle, |_| {}, |_, _| {});
        assert_eq!(runs.count(), 36);
        let (mut hits, mut candidates) = (0, 0);
        for _ in 0..20_000 {
            let ray = Ray::new(point() * 2.0, point().normalize_or(Vec3::Z));
            let sheared = ShearedRay::new(&ray);
            let mut first = 0;
            for count in 1..=8 {
                for t_max in [f32::INFINITY, 1.0] {
                    let found = runs.candidates::<Portable>(&sheared, first, count, t_max);
                    let mask = found.mask;
                    for kernel in Kernel::available() {
                        let (runs, ray) = (&runs, &sheared);
                        let other = kernel.run(Mask {
                            runs,
                            ray,
                            first,
                            count,
                            t_max,
                        });
                        assert_eq!(mask, other, "{kernel:?}");
                    }
                    for lane in 0..count {
                        let triangle = triangles[(first + lane) as usize];
                        let (place, tag) = (Place::new(first, count).after(lane), first + lane + 7);
                        assert_eq!(runs.tag_at(place), tag);
                        let run = RunId::new(first as usize, count as usize);
                        assert_eq!(runs.triangle_at(runs.find(run, tag)), triangle);
                        let hit = sheared.triangle(triangle, t_max);
                        let is_candidate = mask >> lane & 1 == 1;
                        assert!(hit.is_none() || is_candidate, "{ray:?} {triangle:?}");
                        if is_candidate {
                            let pair = (&found.apart(), lane);
                            let found = runs.hit(pair, || sheared, place, t_max);
                            assert_eq!(found, hit);
                        }
                        let hit = hit.is_some();
                        hits += u32::from(hit);
                    }
                    assert_eq!(mask >> count, 0);
                    candidates += mask.count_ones();
                }
                first += count;
            }
        }
        assert!(
            hits > 10_000 && candidates < 2 * hits,
            "{hits} {candidates}"
        );
    }
}
