//! Many streams of random numbers: dimensions, pixels, seeds, indices.

use super::samplers::{PIXEL, sobol};
use super::stats::{CHI_SQUARE_63, chi_square};
use super::{Bound, Figure};
use crate::SamplerKind;
use crate::sampler::{Dim, Sampler, unit_f32};

/// The dimensions of some bounces.
fn dimensions(bounces: u32) -> impl Iterator<Item = Dim> {
    (0..bounces).flat_map(|b| {
        [
            Dim::BsdfDirection(b),
            Dim::Lobe(b),
            Dim::Roulette(b),
            Dim::LightPick(b),
            Dim::LightPoint(b),
        ]
    })
}

/// χ² of all pairs of 64 dimensions. Each pixel gives one sample, so that the points are
/// independent of each other under either sampler.
pub(super) fn many_dimensions() -> Vec<Figure> {
    let n = 16_384u32;
    let expected = [f64::from(n) / 64.0; 64];
    let mut worst = 0.0f64;
    for kind in [SamplerKind::Sobol, SamplerKind::Independent] {
        let columns: Vec<Vec<u8>> = dimensions(13)
            .take(64)
            .map(|dim| {
                let at = |i| Sampler::new(kind, 9, [i, 1], 0).get_2d(dim)[0];
                (0..n).map(|i| (at(i) * 8.0) as u8).collect()
            })
            .collect();
        // Every pair of one sampler is enough of the family's comparisons; the other takes
        // neighbours.
        let reach = if kind == SamplerKind::Sobol { 64 } else { 4 };
        for (i, a) in columns.iter().enumerate() {
            for b in &columns[i.saturating_sub(reach)..i] {
                let mut observed = [0.0; 64];
                for (x, y) in a.iter().zip(b) {
                    observed[usize::from(x * 8 + y)] += 1.0;
                }
                worst = worst.max(chi_square(&observed, &expected));
            }
        }
    }
    // 5000 dimensions of one sample are 5000 pairs of numbers.
    let mut all: Vec<_> = dimensions(1000)
        .map(|dim| sobol(0, 0, dim).map(f32::to_bits))
        .collect();
    all.sort_unstable();
    all.dedup();
    vec![
        Figure {
            what: "largest χ² of pairs of 64 dimensions in 64 cells",
            naive: None,
            lightbox: worst,
            bound: Bound::AtMost(CHI_SQUARE_63),
        },
        Figure {
            what: "pairs of numbers that repeat in a path of 1000 bounces",
            naive: None,
            lightbox: 5000.0 - all.len() as f64,
            bound: Bound::Exactly(0.0),
        },
    ]
}

/// Root mean square and largest |correlation| of any two streams, in units of 1/√N.
fn correlations(streams: &[Vec<f64>]) -> [f64; 2] {
    let n = streams[0].len() as f64;
    let (mut squares, mut pairs, mut largest) = (0.0, 0.0, 0.0f64);
    for (i, a) in streams.iter().enumerate() {
        for b in &streams[..i] {
            let product: f64 = a.iter().zip(b).map(|(a, b)| a * b).sum();
            let correlation = 12.0 / n.sqrt() * product;
            squares += correlation * correlation;
            pairs += 1.0;
            largest = largest.max(correlation.abs());
        }
    }
    [f64::sqrt(squares / pairs), largest]
}

/// Standard deviation of the correlation of two scrambled sequences, in units of 1/√N. It is more
/// than 1 because in each the samples 2j and 2j + 1 lie in different halves: the products of
/// their leading bits are the same, and half as many signs are drawn. Level by level that makes
/// 1 + 9/16 + 9/512 + … = 1.59 for the variance, whatever the scrambling.
const BALANCED: f64 = 1.26;

pub(super) fn correlation() -> Vec<Figure> {
    let n = 4096u32;
    let number = |seed: u64, pixel: [u32; 2], sample: u64, dim: Dim, axis: usize| {
        let sampler = Sampler::new(SamplerKind::Sobol, seed, pixel, sample);
        f64::from(sampler.get_2d(dim)[axis]) - 0.5
    };
    // A column for each dimension and for another half, seed and pixel; down it either the first
    // sample of many pixels, which are independent, or many samples of a pixel.
    let streams = |at: &dyn Fn(u32) -> ([u32; 2], u64)| {
        let column = |seed, half, shift: [u32; 2], dim, axis| -> Vec<f64> {
            let value = |i| {
                let ([x, y], sample) = at(i);
                number(seed, [x + shift[0], y + shift[1]], sample + half, dim, axis)
            };
            (0..n).map(value).collect()
        };
        let mut streams = vec![
            column(0, 1, [0, 0], Dim::Pixel, 0),
            column(1, 0, [0, 0], Dim::Pixel, 0),
            column(0, 0, [1, 0], Dim::Pixel, 0),
            column(0, 0, [0, 1], Dim::Pixel, 0),
        ];
        for dim in dimensions(7).take(32) {
            streams.push(column(0, 0, [0, 0], dim, 0));
            streams.push(column(0, 0, [0, 0], dim, 1));
        }
        streams
    };
    let [_, across] = correlations(&streams(&|i| ([2 * (i % 64), 2 * (i / 64)], 0)));
    let [within, largest] = correlations(&streams(&|i| (PIXEL, 2 * u64::from(i))));
    // Unscrambled: every dimension takes the same points.
    let plain: Vec<f64> = (0..n)
        .map(|i| f64::from(unit_f32(i.reverse_bits())) - 0.5)
        .collect();
    let [_, naive] = correlations(&[plain.clone(), plain]);
    vec![
        Figure {
            what: "largest correlation of 68 streams over pixels, 1/√N",
            naive: Some(naive),
            lightbox: across,
            bound: Bound::AtMost(4.0),
        },
        Figure {
            what: "the same over the samples of a pixel, standard deviations",
            naive: Some(naive / BALANCED),
            lightbox: largest / BALANCED,
            bound: Bound::AtMost(4.0),
        },
        Figure {
            what: "their root mean square, standard deviations",
            naive: Some(naive / BALANCED),
            lightbox: within / BALANCED,
            bound: Bound::Within {
                truth: 1.0,
                tolerance: 0.06,
            },
        },
    ]
}

pub(super) fn large_indices() -> Vec<Figure> {
    let (mut repeats, mut repeats_naive) = (0u32, 0u32);
    for kind in [SamplerKind::Sobol, SamplerKind::Independent] {
        let at = |pixel, sample| Sampler::new(kind, 0, pixel, sample).get_2d(Dim::Pixel);
        for i in 0..1000u64 {
            for far in [1 << 32, 1 << 33, 1 << 34, 1 << 62] {
                repeats += u32::from(at(PIXEL, i) == at(PIXEL, i + far));
                repeats_naive += u32::from(i as u32 == (i + far) as u32);
            }
            let x = i as u32;
            for far in [[x + (1 << 16), 0], [x, 1 << 16], [0, x + (1 << 16)]] {
                repeats += u32::from(at([x, 0], 7) == at(far, 7));
            }
        }
    }
    vec![Figure {
        what: "samples that repeat 2³² later or 65 536 pixels further",
        naive: Some(repeats_naive.into()),
        lightbox: repeats.into(),
        bound: Bound::Exactly(0.0),
    }]
}
