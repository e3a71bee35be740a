//! Accumulation: sums of many samples, and what must not enter them.

use glam::Vec3;

use super::trial::{one_pixel, quad, view};
use super::{Bound, Case, Check, Figure, gallery};
use crate::film::Film;
use crate::filter::FilterSampler;
use crate::render::autopsy::Tally;
use crate::sampler::{Dim, Sampler};
use crate::{Filter, Method, SamplerKind};

pub(super) const CASES: &[Case] = &[
    Case {
        id: "A01",
        title: "20 000 samples of 0.1",
        failure: "The f32 sum drifts: its mean is 2·10⁻⁴ too low.",
        cure: "Sums of 128-bit integers in units of 2⁻⁶⁰, exact.",
        check: Check::Probe(small_samples),
        scene: None,
        picture: None,
    },
    Case {
        id: "A02",
        title: "a firefly, then ordinary samples",
        failure: "After 10⁶ an f32 sum does not take in 0.03: the pixel freezes.",
        cure: "Sums that hold 67 bits above and 60 below the point.",
        check: Check::Probe(firefly),
        scene: None,
        picture: Some(gallery::frozen_firefly),
    },
    Case {
        id: "A03",
        title: "twenty million samples",
        failure: "The f32 sum of uniform numbers ends 10⁻⁴ off, and a count in f32 stops at 2²⁴.",
        cure: "Integers for both.",
        check: Check::Probe(many_samples),
        scene: None,
        picture: None,
    },
    Case {
        id: "A04",
        title: "small noise on a large mean",
        failure: "E[x²] − E[x]² cancels in f32: the variance of 100 ± 0.005 comes out negative.",
        cure: "The difference of two half-films of exact sums; in the autopsy, squares about the mean \
               (Welford 1962).",
        check: Check::Probe(small_noise),
        scene: None,
        picture: None,
    },
    Case {
        id: "A05",
        title: "parts put together in any grouping",
        failure: "f32 sums of parts differ from the sum of the whole.",
        cure: "Integer sums are associative.",
        check: Check::Probe(grouping),
        scene: None,
        picture: None,
    },
    Case {
        id: "A06",
        title: "noise where no sample has seen the light",
        failure: "An estimate from samples cannot tell darkness from bad luck: a lamp that no path \
                  has met yet counts as no noise at all.",
        cure: "Lamps are aimed at, so that every sample sees them.",
        check: Check::Probe(unseen_light),
        scene: Some("builtin:lab/unseen-light.toml"),
        picture: Some(gallery::unseen_light),
    },
];

fn film() -> Film {
    Film::new(1, 1, &FilterSampler::new(Filter::default()))
}

/// Adds samples of one pixel, from index `first` on.
fn add(film: &Film, first: u64, values: impl Iterator<Item = f32>) {
    let (mut batch, _) = film.batch(0);
    let mut end = first;
    for value in values {
        batch.add([0, 0], end, 0, Vec3::splat(value));
        end += 1;
    }
    film.merge(0, &batch, first, end);
}

fn pixel(film: &Film) -> f64 {
    f64::from(film.develop().pixels[0].y)
}

/// Uniform numbers by sample.
fn uniform(sample: u64) -> f32 {
    Sampler::new(SamplerKind::Independent, 21, [0, 0], sample).get_2d(Dim::Pixel)[0]
}

fn small_samples() -> Vec<Figure> {
    let film = film();
    add(&film, 0, std::iter::repeat_n(0.1, 20_000));
    let naive = (0..20_000).fold(0.0f32, |sum, _| sum + 0.1) / 20_000.0;
    let truth = f64::from(0.1f32);
    vec![Figure {
        what: "relative error of the mean",
        naive: Some((f64::from(naive) / truth - 1.0).abs()),
        lightbox: (pixel(&film) / truth - 1.0).abs(),
        bound: Bound::AtMost(1e-7),
    }]
}

fn firefly() -> Vec<Figure> {
    let values = || std::iter::once(1e6).chain(std::iter::repeat_n(0.03f32, 20_000));
    let film = film();
    add(&film, 0, values());
    // What the ordinary samples have added.
    let added = pixel(&film) * 20_001.0 - 1e6;
    let naive = values().fold(0.0f32, |sum, x| sum + x);
    let truth = 20_000.0 * f64::from(0.03f32);
    vec![Figure {
        what: "what 20 000 samples of 0.03 add to a firefly of 10⁶",
        naive: Some(f64::from(naive) - 1e6),
        lightbox: added,
        bound: Bound::Within {
            truth,
            // The pixel is read as f32, of which half an ulp counts 20 001 times.
            tolerance: 20_001.0 * f64::from(50f32.next_up() - 50.0) / 2.0,
        },
    }]
}

fn many_samples() -> Vec<Figure> {
    let n = 20_000_000u64;
    // A generator that costs little; f64 holds the sum to 10⁻¹³.
    let values = || {
        let mut state = 1u32;
        (0..n).map(move |_| {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (state >> 8) as f32 / (1 << 24) as f32
        })
    };
    let film = film();
    add(&film, 0, values());
    let truth = values().map(f64::from).sum::<f64>() / n as f64;
    let naive = values().fold(0.0f32, |sum, x| sum + x);
    let count = (0..n).fold(0.0f32, |count, _| count + 1.0);
    vec![
        Figure {
            what: "relative error of the mean of 2·10⁷ uniform numbers",
            naive: Some((f64::from(naive) / n as f64 / truth - 1.0).abs()),
            lightbox: (pixel(&film) / truth - 1.0).abs(),
            bound: Bound::AtMost(1e-7),
        },
        Figure {
            what: "samples counted",
            naive: Some(f64::from(count)),
            lightbox: film.samples() as f64,
            bound: Bound::Exactly(n as f64),
        },
    ]
}

/// A sample of 100 ± 0.005.
fn noisy(pixel: [u32; 2], sample: u64) -> f32 {
    let sampler = Sampler::new(SamplerKind::Independent, 22, pixel, sample);
    100.0 + 0.01 * (sampler.get_2d(Dim::Pixel)[0] - 0.5)
}

/// The error that two half-films of a square picture of such samples tell.
fn noise_of(size: u32, samples: u64) -> f64 {
    let film = Film::new(size, size, &FilterSampler::new(Filter::default()));
    for tile in 0..film.tiles() {
        let (mut batch, _) = film.batch(tile);
        let rect = batch.rect;
        for (x, y) in (0..rect.height).flat_map(|y| (0..rect.width).map(move |x| (x, y))) {
            for sample in 0..samples {
                let light = noisy([rect.x + x, rect.y + y], sample);
                batch.add([x, y], sample, 0, Vec3::splat(light));
            }
        }
        film.merge(tile, &batch, 0, samples);
    }
    film.error().map_or(f64::NAN, |error| error.noise())
}

fn small_noise() -> Vec<Figure> {
    const SAMPLES: u64 = 20_000;
    let n = SAMPLES as f64;
    // Between 64 and 128 the numbers of f32 are 2⁻¹⁷ apart: integers hold all sums exactly.
    let unit = 2f64.powi(-17);
    let steps = |pixel, sample| (f64::from(noisy(pixel, sample)) - 100.0) / unit;
    let steps = |pixel, sample| steps(pixel, sample) as i64;
    let (mut sum, mut squares, mut tally) = (0, 0, Tally::default());
    let mut naive = [0.0f32; 2];
    for sample in 0..SAMPLES {
        let (step, x) = (steps([0, 0], sample), noisy([0, 0], sample));
        sum += step;
        squares += step * step;
        tally.add(f64::from(x));
        naive = [naive[0] + x, naive[1] + x * x];
    }
    let variance = (squares * SAMPLES as i64 - sum * sum) as f64 * (unit / n).powi(2);
    let [mean, mean_square] = naive.map(|sum| sum / SAMPLES as f32);
    // The halves are the samples of even and of odd numbers.
    let pixels: Vec<[u32; 2]> = (0..16).map(|i| [i % 4, i / 4]).collect();
    let squares = pixels.iter().map(|pixel| {
        let difference: i64 = (0..SAMPLES)
            .map(|sample| steps(*pixel, sample) * if sample % 2 == 0 { 1 } else { -1 })
            .sum();
        let sum: i64 = (0..SAMPLES).map(|sample| steps(*pixel, sample)).sum();
        let mean = 100.0 + sum as f64 * unit / n;
        (difference as f64 * unit / n).powi(2) / (mean * mean + 0.01)
    });
    let exact = (squares.sum::<f64>() / pixels.len() as f64).sqrt();
    // Uniform within 0.01: σ = 0.01/√12.
    let truth = 0.01 / 12f64.sqrt() / 1000f64.sqrt() / 1e4f64.sqrt();
    vec![
        Figure {
            what: "variance of 20 000 samples of 100 ± 0.005, in the autopsy, over that of exact sums",
            naive: Some(f64::from(mean_square - mean * mean) / variance),
            lightbox: tally.variance(SAMPLES as usize) / variance,
            bound: Bound::Within {
                truth: 1.0,
                tolerance: 1e-12,
            },
        },
        Figure {
            what: "noise told by two half-films of 16 pixels of them, over that of exact sums",
            naive: None,
            lightbox: noise_of(4, SAMPLES) / exact,
            bound: Bound::Within {
                truth: 1.0,
                // Squares and means of pixels are added up in f32.
                tolerance: 4.0 * f64::from(f32::EPSILON),
            },
        },
        Figure {
            what: "noise told by 1024 pixels of 1000 of them, over the true one",
            naive: None,
            lightbox: noise_of(32, 1000) / truth,
            bound: Bound::Within {
                truth: 1.0,
                // 1024 estimates of one degree of freedom: √(2/1024)/2 each, four of them.
                tolerance: 0.09,
            },
        },
    ]
}

fn grouping() -> Vec<Figure> {
    let values: Vec<f32> = (0..20_000)
        .map(|i| uniform(i) * [1e-6, 0.37, 1e5][i as usize % 3])
        .collect();
    let picture = |parts: usize| {
        let film = film();
        for (i, part) in values.chunks(parts).enumerate() {
            add(&film, (i * parts) as u64, part.iter().copied());
        }
        (pixel(&film), film.error().map(|e| e.noise()))
    };
    let whole = picture(values.len());
    let differ = [1, 7, 1250, 5000]
        .iter()
        .filter(|parts| picture(**parts) != whole);
    let sum = |part: &[f32]| part.iter().fold(0.0f32, |sum, x| sum + x);
    let naive = [7, 1250, 5000].iter().filter(|parts| {
        let parts: Vec<f32> = values.chunks(**parts).map(sum).collect();
        sum(&parts) != sum(&values)
    });
    vec![Figure {
        what: "groupings that give other bits",
        naive: Some(naive.count() as f64),
        lightbox: differ.count() as f64,
        bound: Bound::Exactly(0.0),
    }]
}

pub(super) fn invalid() -> Vec<Figure> {
    let bad = [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, -1.0, 2e12];
    let film = film();
    let values = [2.0, 2.0, 2.0, 2.0].into_iter().chain(bad).chain([4.0; 4]);
    add(&film, 0, values.clone());
    let (count, kept) = film.invalid();
    let remembered = kept.iter().filter(|s| (4..9).contains(&s.sample)).count();
    vec![
        Figure {
            what: "mean of the eight samples that are a radiance",
            naive: Some(values.map(f64::from).sum::<f64>() / 13.0),
            lightbox: pixel(&film),
            bound: Bound::Exactly(3.0),
        },
        Figure {
            what: "samples counted as invalid, of 5",
            naive: None,
            lightbox: count as f64,
            bound: Bound::Exactly(5.0),
        },
        Figure {
            what: "of which place and index are kept",
            naive: None,
            lightbox: remembered as f64,
            bound: Bound::Exactly(5.0),
        },
    ]
}

/// A small lamp over a floor, which paths that scatter at random do not meet.
fn unseen_light() -> Vec<Figure> {
    let lamp = "[-0.005, 1, -0.005], [0.005, 1, -0.005], [0.005, 1, 0.005], [-0.005, 1, 0.005]";
    let shapes = quad("grey", super::trial::FLOOR) + &quad("lamp", lamp);
    let scene = one_pixel("[1, 0.7, 3]", &shapes);
    let blind = |method| {
        let films = (0..256).map(|seed| {
            let view = view(&scene, |s| {
                (s.method, s.depth, s.samples, s.seed) = (method, 2, 4, seed);
            });
            let film = view.film();
            view.render(&film, 4, &std::sync::atomic::AtomicBool::new(false));
            film.error().map(|e| e.noise())
        });
        films
            .filter(|noise| !noise.is_some_and(|n| n > 0.0))
            .count() as f64
    };
    vec![Figure {
        what: "pictures of 256 that tell no noise at 4 samples, though there is",
        naive: Some(blind(Method::Naive)),
        lightbox: blind(Method::Mis),
        bound: Bound::Exactly(0.0),
    }]
}
