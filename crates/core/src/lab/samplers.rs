//! Random numbers: their range and their balance. What they must not repeat is in `streams`.

use glam::Vec3;

use super::stats::{Comparisons, Replicates};
use super::trial::numbers;
use super::{Bound, Case, Check, Figure, streams};
use crate::sampler::{Dim, Sampler, unit_f32};
use crate::scene::CameraDesc;
use crate::settings::MAX_SIZE;
use crate::{Camera, Filter, FilterKind, SamplerKind};

pub(super) const CASES: &[Case] = &[
    Case {
        id: "Y01",
        title: "random numbers that reach 1",
        failure: "32 random bits over 2³² round up to 1.0 once in 3·10⁷ draws: an index beyond the \
                  end, a logarithm of 0.",
        cure: "The 24 high bits over 2²⁴: at most 1 − 2⁻²⁴.",
        check: Check::Probe(range),
        scene: None,
        picture: None,
    },
    Case {
        id: "Y02",
        title: "the last position within a pixel",
        failure: "Pixel 1023 plus 0.99999994 is 1024: the sample lands in the next pixel, or beyond \
                  the picture.",
        cure: "Pixel and offset stay apart; the pixel of a sample never follows from a position.",
        check: Check::Probe(pixel_edge),
        scene: None,
        picture: None,
    },
    Case {
        id: "Y03",
        title: "elementary intervals",
        failure: "Wrong direction numbers, or a hash that is no nested scrambling, leave intervals \
                  empty and fill others twice.",
        cure: "Sobol' points with hash-based Owen scrambling (Burley 2020; Laine & Karras 2011).",
        check: Check::Probe(intervals),
        scene: None,
        picture: None,
    },
    Case {
        id: "Y04",
        title: "samples taken backwards, or between those of other pixels",
        failure: "A generator with a state gives other numbers in another order.",
        cure: "Numbers are a function of pixel, sample, seed and dimension.",
        check: Check::Probe(order),
        scene: None,
        picture: None,
    },
    Case {
        id: "Y05",
        title: "sample counts that are no power of two",
        failure: "Of 20 000 points the last 3616 are unbalanced, and the error is larger than that \
                  of 16 384.",
        cure: "The mean stays unbiased (Owen 1998), and the error far below that of independent \
               numbers; the viewer doubles its batches.",
        check: Check::Probe(any_count),
        scene: None,
        picture: None,
    },
    Case {
        id: "Y06",
        title: "paths with more dimensions than a table has",
        failure: "Beyond 1024 dimensions tables of direction numbers end, and pairs of high \
                  dimensions are visibly correlated.",
        cure: "Each pair of dimensions is a two-dimensional set of its own.",
        check: Check::Probe(streams::many_dimensions),
        scene: None,
        picture: None,
    },
    Case {
        id: "Y07",
        title: "dimensions, pixels, halves and seeds that follow each other",
        failure: "One seed for all gives noise with a structure, and means that look biased.",
        cure: "All of them are mixed into the key of the scrambling. Within a pixel correlations are \
               told in standard deviations: those of stratified numbers are 1.26/√N, not 1/√N.",
        check: Check::Probe(streams::correlation),
        scene: None,
        picture: None,
    },
    Case {
        id: "Y08",
        title: "sample 2³² and pixel 65 536",
        failure: "Indices wrap, and the same samples come again.",
        cure: "64-bit sample indices; the bits above 32 choose another scrambling.",
        check: Check::Probe(streams::large_indices),
        scene: None,
        picture: None,
    },
];

pub(super) const PIXEL: [u32; 2] = [17, 4711];

pub(super) fn sobol(seed: u64, sample: u64, dim: Dim) -> [f32; 2] {
    Sampler::new(SamplerKind::Sobol, seed, PIXEL, sample).get_2d(dim)
}

fn range() -> Vec<Figure> {
    let bits = [0, 0x7fff_ffff].into_iter().chain(0xffff_0000..=u32::MAX);
    let (mut outside, mut outside_naive) = (0u32, 0u32);
    for bits in bits {
        outside += u32::from(!(0.0..1.0).contains(&unit_f32(bits)));
        outside_naive += u32::from(bits as f32 / 4_294_967_296.0 >= 1.0);
    }
    vec![Figure {
        what: "numbers outside [0, 1) from the highest 2¹⁶ bit patterns",
        naive: Some(outside_naive.into()),
        lightbox: outside.into(),
        bound: Bound::Exactly(0.0),
    }]
}

/// Where rays cross the picture's plane, from their directions, in the widest picture.
fn pixel_edge() -> Vec<Figure> {
    let desc = CameraDesc {
        eye: Vec3::ZERO,
        target: -Vec3::Z,
        ..CameraDesc::default()
    };
    let filter = crate::filter::FilterSampler::new(Filter::default());
    let unit = crate::filter::FilterSampler::new(Filter::new(FilterKind::Box));
    let (mut missed, mut missed_naive) = (0u32, 0u32);
    let mut outside = 0.0f64;
    for width in [2, 1024, MAX_SIZE] {
        let Ok(camera) = Camera::new(&desc, width, 4) else {
            return Vec::new();
        };
        // One unit ahead, a pixel is this wide.
        let pixel = 2.0 * (f64::from(desc.fov).to_radians() * 0.5).tan() / 4.0;
        for x in [0, width / 2 - 1, width - 1] {
            for u in [0.0, 0.25, super::trial::LAST] {
                let (offset, _) = filter.sample([u, 0.5]);
                let d = camera.ray([x, 1], offset).dir.as_dvec3();
                let position = -d.x / d.z / pixel + f64::from(width) / 2.0;
                let beyond = (f64::from(x) - position).max(position - f64::from(x + 1));
                // f32 tells directions apart to about an ulp of their slope.
                let ulp = f64::from(width).max(1.0) * f64::from(f32::EPSILON);
                outside = outside.max(beyond / ulp);
                // Pixel and offset of a filter of one pixel, added where nothing is rounded.
                let (offset, _) = unit.sample([u, 0.5]);
                let position = f64::from(x) + 0.5 + f64::from(offset[0]);
                missed += u32::from(position.floor() != f64::from(x));
                missed_naive += u32::from((x as f32 + u) as u32 != x);
            }
        }
    }
    vec![
        Figure {
            what: "samples of 27 that are not in their pixel",
            naive: Some(missed_naive.into()),
            lightbox: missed.into(),
            bound: Bound::Exactly(0.0),
        },
        Figure {
            what: "how far their rays miss it in f32, ulp of the position",
            naive: None,
            lightbox: outside,
            bound: Bound::AtMost(4.0),
        },
    ]
}

/// Intervals of area 2⁻ᵏ without exactly one of 2ᵏ points.
fn unbalanced(points: &[[f32; 2]]) -> u32 {
    let k = points.len().ilog2();
    let mut wrong = 0;
    for columns in 0..=k {
        let (nx, ny) = (1usize << columns, 1usize << (k - columns));
        let mut counts = vec![0u32; 1 << k];
        for [x, y] in points {
            counts[(x * nx as f32) as usize * ny + (y * ny as f32) as usize] += 1;
        }
        wrong += counts.iter().filter(|n| **n != 1).count() as u32;
    }
    wrong
}

fn intervals() -> Vec<Figure> {
    let (mut wrong, mut wrong_naive) = (0, 0);
    for dim in [
        Dim::Pixel,
        Dim::BsdfDirection(0),
        Dim::LightPoint(3),
        Dim::Lobe(1000),
    ] {
        for half in [0, 1] {
            for k in 0..=12 {
                let points: Vec<_> = (0..1 << k).map(|i| sobol(5, 2 * i + half, dim)).collect();
                wrong += unbalanced(&points);
            }
        }
    }
    let points: Vec<_> = (0..1 << 10).map(|i| numbers(i, Dim::Pixel)).collect();
    wrong_naive += unbalanced(&points);
    vec![Figure {
        what: "elementary intervals without exactly one point (naive: independent numbers)",
        naive: Some(wrong_naive.into()),
        lightbox: wrong.into(),
        bound: Bound::Exactly(0.0),
    }]
}

fn order() -> Vec<Figure> {
    let n = 256;
    let dims = [Dim::Pixel, Dim::LightPoint(2)];
    let mut differ = 0u32;
    for kind in [SamplerKind::Sobol, SamplerKind::Independent] {
        let at = |x: u32, i: u64, dim| Sampler::new(kind, 5, [x, 0], i).get_2d(dim);
        let forward: Vec<_> = (0..n).flat_map(|i| dims.map(|d| at(1, i, d))).collect();
        let mut backward: Vec<_> = (0..n)
            .rev()
            .flat_map(|i| {
                // Other pixels between, and the dimensions the other way round.
                let _ = at(2, i, Dim::Pixel);
                let second = at(1, i, dims[1]);
                [second, at(1, i, dims[0])]
            })
            .collect();
        backward.reverse();
        differ += forward
            .iter()
            .zip(&backward)
            .filter(|(a, b)| a != b)
            .count() as u32;
    }
    // A linear congruential generator that goes on where it is.
    let generate = |count: usize| {
        let mut state = 1u32;
        let mut next = move || {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            state
        };
        (0..count).map(|_| next()).collect::<Vec<_>>()
    };
    let forward = generate(n as usize);
    let mut backward = generate(n as usize);
    backward.reverse();
    let differ_naive = forward
        .iter()
        .zip(&backward)
        .filter(|(a, b)| a != b)
        .count();
    vec![Figure {
        what: "numbers that differ when samples are taken backwards",
        naive: Some(differ_naive as f64),
        lightbox: differ.into(),
        bound: Bound::Exactly(0.0),
    }]
}

fn any_count() -> Vec<Figure> {
    // ∫∫ e^{x+y}·[x + y < 1] = 1: a smooth part and an edge, as a pixel has.
    let estimates = |kind: SamplerKind, n: u64| {
        Replicates::of(move |seed| {
            let sum: f64 = (0..n)
                .map(|i| {
                    let s = Sampler::new(kind, seed, PIXEL, i);
                    let [x, y] = s.get_2d(Dim::Pixel).map(f64::from);
                    if x + y < 1.0 { (x + y).exp() } else { 0.0 }
                })
                .sum();
            sum / n as f64
        })
    };
    let [even, odd] = [1 << 14, 20_000].map(|n| estimates(SamplerKind::Sobol, n));
    let mut comparisons = Comparisons::default();
    comparisons.mean(&even, 1.0);
    comparisons.mean(&odd, 1.0);
    let independent = estimates(SamplerKind::Independent, 20_000);
    let mut figures = comparisons.figures(
        "largest deviation of the mean, critical distances",
        None,
        2e-3,
    );
    figures.push(Figure {
        what: "RMSE of 20 000 points over that of 16 384",
        naive: None,
        lightbox: odd.rmse(1.0) / even.rmse(1.0),
        bound: Bound::AtMost(2.0),
    });
    figures.push(Figure {
        what: "RMSE of 20 000 points over that of independent numbers",
        naive: Some(1.0),
        lightbox: odd.rmse(1.0) / independent.rmse(1.0),
        bound: Bound::AtMost(0.25),
    });
    figures
}
