//! Dividing primitives in two, by one thread or many.

use rayon::prelude::*;

use super::boxes::{Box8, Ref, Union, center};
use super::split::Grid;
use crate::simd::{Kernel, Lanes, Task};

/// So many primitives are divided by several threads, …
pub(super) const PARALLEL: usize = 1 << 14;

/// … so many by each at a time. What comes of it depends on these, not on the threads.
pub(super) const CHUNK: usize = PARALLEL / 4;

/// What lies below.
#[derive(Clone, Copy, Debug)]
pub(super) enum By {
    /// Bins from a certain one on are above.
    Plane {
        grid: Grid,
        axis: usize,
        bins: usize,
        above: usize,
    },
    /// A bit for each that is below.
    Each(u32),
}

/// Added to a number below 2²³, it leaves the nearest whole number in the lowest bits.
pub(super) const TO_WHOLE: f32 = (1 << 23) as f32;

/// A bin, of whatever is no number one all the same.
#[inline(always)]
pub(super) fn bin_at(sum: f32, bins: usize) -> usize {
    sum.to_bits() as usize & (bins - 1)
}

impl By {
    /// Moves what is below to the front, and gives its number and the boxes of both sides'
    /// centres.
    pub fn partition(&self, refs: &mut [Ref], kernel: Kernel) -> (usize, [Box8; 2]) {
        if refs.len() < PARALLEL {
            return kernel.run(Partition(self, refs));
        }
        let chunks: Vec<(usize, [Box8; 2])> = refs
            .par_chunks_mut(CHUNK)
            .map(|refs| kernel.run(Partition(self, refs)))
            .collect();
        let (counts, centers): (Vec<usize>, Vec<[Box8; 2]>) = chunks.into_iter().unzip();
        (exchange(refs, &counts), kernel.run(Union(&centers)))
    }
}

/// See [`By::partition`].
struct Partition<'a>(&'a By, &'a mut [Ref]);

impl Task for Partition<'_> {
    type Output = (usize, [Box8; 2]);

    #[inline(always)]
    fn run<L: Lanes>(self) -> (usize, [Box8; 2]) {
        let Self(by, refs) = self;
        let (mut count, mut centers) = (0, [Box8::EMPTY; 2]);
        match *by {
            By::Each(below) => {
                for i in 0..refs.len() {
                    if below >> i & 1 == 1 {
                        refs.swap(count, i);
                        count += 1;
                    }
                }
                // Nobody asks so few for their centres.
            }
            By::Plane {
                grid,
                axis,
                bins,
                above,
            } => {
                // Without a branch, which no one could foresee: infinity is no minimum.
                let [mut low, mut high] = centers.map(|b| L::load(&b.0));
                for i in 0..refs.len() {
                    let center = center::<L>(&refs[i]);
                    let is_below = bin_at(grid.place(center)[axis], bins) < above;
                    let [to_low, to_high] =
                        [[f32::INFINITY, 0.0], [0.0, f32::INFINITY]][usize::from(is_below)];
                    low = low.min(center.add(L::splat(to_low)));
                    high = high.min(center.add(L::splat(to_high)));
                    let (this, first) = (L::load(&refs[i]), L::load(&refs[count]));
                    refs[count] = this.store();
                    refs[i] = first.store();
                    count += usize::from(is_below);
                }
                centers = [Box8(low.store()), Box8(high.store())];
            }
        }
        (count, centers)
    }
}

/// Makes one partition of those of all chunks, of each of which so many are below, and gives their
/// number: what is still on the wrong side changes places.
fn exchange(refs: &mut [Ref], chunks: &[usize]) -> usize {
    let count = chunks.iter().sum();
    let (front, back) = refs.split_at_mut(count);
    // What is above in front, chunk by chunk, and what is below behind. One chunk may lie on both
    // sides.
    let in_front = front.chunks_mut(CHUNK).zip(chunks);
    let high = in_front.map(|(refs, &below)| {
        let below = below.min(refs.len());
        &mut refs[below..]
    });
    let (shared, before) = (count / CHUNK, count % CHUNK);
    let (first, others) = back.split_at_mut((CHUNK - before).min(back.len()));
    let left = chunks
        .get(shared)
        .map_or(0, |&below| below.saturating_sub(before));
    let behind = others.chunks_mut(CHUNK).zip(chunks.iter().skip(shared + 1));
    let low = behind.map(|(refs, &below)| &mut refs[..below]);
    let (mut high, mut low) = (high, std::iter::once(&mut first[..left]).chain(low));
    let (mut a, mut b): (&mut [Ref], &mut [Ref]) = (&mut [], &mut []);
    let mut pairs = Vec::new();
    loop {
        let count = a.len().min(b.len());
        let (these, those);
        (these, a) = a.split_at_mut(count);
        (those, b) = b.split_at_mut(count);
        pairs.push((these, those));
        let next = if a.is_empty() {
            (&mut a, high.next())
        } else {
            (&mut b, low.next())
        };
        let (side, Some(more)) = next else { break };
        *side = more;
    }
    pairs
        .into_par_iter()
        .for_each(|(these, those)| these.swap_with_slice(those));
    count
}

#[cfg(test)]
mod tests {
    use super::super::boxes::{bounds_of, new_ref, ordered};
    use super::super::split::Split;
    use super::*;
    use crate::lab::random::Rng;
    use crate::math::Aabb;

    /// Of few, some and very many primitives: each side has what the split foretold, and nothing is
    /// lost, with all kernels alike.
    #[test]
    fn splits_are_as_foretold() {
        let mut rng = Rng(5);
        let mut counts: Vec<usize> = (2..70).collect();
        counts.extend([PARALLEL - 1, PARALLEL, PARALLEL + 1, 5 * CHUNK + 17, 40_000]);
        for n in counts {
            for round in 0..4 {
                let refs: Vec<Ref> = (0..n as u32)
                    .map(|id| {
                        let p = match round {
                            0 => rng.cube(),
                            // Crowded into a corner; in the order of the places; all but one in one place.
                            1 => rng.cube().map(|x| x.powi(9)),
                            2 => rng.cube() * 1e-3 + id as f32,
                            _ => rng.cube() * 1e-3 + if id == 1 { 1.0 } else { 0.0 },
                        };
                        let q = p + 0.01 * rng.cube();
                        new_ref(&Aabb::of_points([p, q]), id).unwrap()
                    })
                    .collect();
                for kernel in Kernel::available() {
                    let [_, centers] = bounds_of(&refs, kernel);
                    let split = Split::best(&refs, &centers, kernel).unwrap();
                    let mut divided = refs.clone();
                    let (count, centers) = split.by.partition(&mut divided, kernel);
                    assert_eq!(count, split.counts[0] as usize, "{n} {kernel:?}");
                    assert_eq!(n - count, split.counts[1] as usize, "{n} {kernel:?}");
                    let (below, above) = divided.split_at(count);
                    for (i, side) in [below, above].into_iter().enumerate() {
                        let [bounds, around] = bounds_of(side, kernel);
                        assert_eq!(bounds.aabb(), split.bounds[i].aabb(), "{n} {kernel:?}");
                        if matches!(split.by, By::Plane { .. }) {
                            assert_eq!(around.aabb(), centers[i].aabb(), "{n} {kernel:?}");
                        }
                    }
                    let mut ids: Vec<u32> = divided.iter().map(|r| ordered(r).id()).collect();
                    ids.sort_unstable();
                    assert!(ids.into_iter().eq(0..n as u32), "{n} {kernel:?}");
                }
            }
        }
    }
}
