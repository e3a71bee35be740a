//! Filters. What leaves the film is in `outputs`, what enters it in `sums`.

use glam::Vec3;

use super::trial::{LAST, picture, scene, view};
use super::{Bound, Case, Check, Figure, gallery, outputs, sums};
use crate::film::Film;
use crate::filter::{FilterSampler, sinc};
use crate::sampler::{Dim, Sampler};
use crate::{Filter, FilterKind, SamplerKind};

pub(super) const CASES: &[Case] = &[
    Case {
        id: "F01",
        title: "filters with negative lobes at few samples",
        failure: "Weights of both signs nearly cancel: dividing by their sum gives values of any \
                  size and sign.",
        cure: "Positions are drawn from |f|, the regions of either sign are averaged apart and \
               joined with the exact areas of f: nothing is divided by a sum of weights.",
        check: Check::Probe(negative_lobes),
        scene: None,
        picture: None,
    },
    Case {
        id: "F02",
        title: "narrow filters, borders and a picture of one pixel",
        failure: "A filter narrower than a pixel leaves pixels without a sample: 0/0. At the border \
                  half of the weight is missing.",
        cure: "Radii from half a pixel; every sample belongs to one pixel.",
        check: Check::Probe(coverage),
        scene: None,
        picture: None,
    },
    Case {
        id: "F03",
        title: "sinc at 0 and filters at their radius",
        failure: "sin(0)/0 is NaN, and a value past the radius counts samples of other pixels.",
        cure: "The series near 0; zero beyond the radius.",
        check: Check::Probe(sinc_near_zero),
        scene: None,
        picture: None,
    },
    Case {
        id: "F04",
        title: "one sample that is not a number",
        failure: "A single NaN or infinity in a sum stays for ever: the pixel is dead, with a \
                  splatting filter its neighbours too.",
        cure: "Samples that are no radiance are left out, counted, and remembered by pixel and \
               index.",
        check: Check::Probe(sums::invalid),
        scene: None,
        picture: Some(gallery::nan_injection),
    },
    Case {
        id: "F05",
        title: "colours out of range",
        failure: "A power of a negative number is NaN; conversion to bytes without clamping wraps or \
                  hides it.",
        cure: "A table of steps: NaN and negative give 0, all above white 255.",
        check: Check::Probe(outputs::colors),
        scene: None,
        picture: None,
    },
    Case {
        id: "F06",
        title: "pictures of extreme values in files",
        failure: "Half floats end at 65504, shared exponents wrap, converters panic on NaN.",
        cure: "EXR holds 32-bit floats; PNG what the screen shows.",
        check: Check::Probe(outputs::files),
        scene: None,
        picture: None,
    },
    Case {
        id: "F07",
        title: "pictures without pixels, and too large ones",
        failure: "Width times height overflows, and the allocation is too small or fails.",
        cure: "Sizes are checked in 64 bits before anything is allocated.",
        check: Check::Probe(outputs::sizes),
        scene: None,
        picture: None,
    },
];

/// The Mitchell–Netravali filter of radius 2, up to a factor.
fn mitchell(x: f64) -> f64 {
    FilterKind::Mitchell.eval(x / 2.0)
}

fn negative_lobes() -> Vec<Figure> {
    let numbers = |sample: u64| {
        let sampler = Sampler::new(SamplerKind::Independent, 11, [0, 0], sample);
        (
            sampler.get_2d(Dim::Pixel),
            sampler.get_2d(Dim::LightPick(0))[0],
        )
    };
    // Two samples of radiance 0 or 1 anywhere under the filter, weighted by it.
    let naive = (0..10_000u64).map(|trial| {
        let (mut weights, mut sum) = (0.0, 0.0);
        for sample in 0..2 {
            let (u, light) = numbers(2 * trial + sample);
            let [x, y] = u.map(|u| 4.0 * f64::from(u) - 2.0);
            let weight = mitchell(x) * mitchell(y);
            weights += weight;
            sum += if light < 0.5 { weight } else { 0.0 };
        }
        (sum / weights).abs()
    });
    let naive = naive.fold(0.0, f64::max);
    let (mut largest, mut uneven) = (0.0f64, 0.0f64);
    for kind in FilterKind::ALL {
        let filter = FilterSampler::new(Filter::new(kind));
        let [positive, negative] = filter.weights();
        for samples in [1, 2, 3, 17, 200] {
            for trial in 0..50 {
                let (film, constant) = (Film::new(1, 1, &filter), Film::new(1, 1, &filter));
                let (mut batch, _) = film.batch(0);
                let (mut even, _) = constant.batch(0);
                for sample in 0..samples {
                    let (u, light) = numbers(1000 * trial + sample);
                    let (_, stratum) = filter.sample(u);
                    let light = if light < 0.5 { 1.0 } else { 0.0 };
                    batch.add([0, 0], sample, stratum, Vec3::splat(light));
                    even.add([0, 0], sample, stratum, Vec3::splat(0.7));
                }
                film.merge(0, &batch, 0, samples);
                constant.merge(0, &even, 0, samples);
                // In units of what the areas of f allow.
                let value = f64::from(film.develop().pixels[0].y).abs();
                largest = largest.max(value / (positive - negative));
                let error = f64::from((constant.develop().pixels[0] - 0.7).abs().max_element());
                uneven = if error <= uneven { uneven } else { error };
            }
        }
    }
    vec![
        Figure {
            what: "largest |pixel| over radiances of 0 and 1, in units of ∫|f| (naive: Σwf/Σw)",
            naive: Some(naive),
            lightbox: largest,
            bound: Bound::AtMost(1.000_001),
        },
        Figure {
            what: "largest error of a constant scene, from one sample on",
            naive: None,
            lightbox: uneven,
            bound: Bound::AtMost(1e-6),
        },
    ]
}

fn coverage() -> Vec<Figure> {
    let scene = scene("background = [0.7, 0.7, 0.7]\n");
    let mut worst = 0.0f64;
    for kind in FilterKind::ALL {
        for (width, height) in [(1, 1), (1, 33), (17, 16), (40, 3)] {
            for samples in [1, 2, 7] {
                let image = picture(&view(&scene, |s| {
                    (s.width, s.height, s.samples) = (width, height, samples);
                    s.filter = Filter::new(kind);
                }));
                for p in &image.pixels {
                    let error = f64::from((*p / 0.7 - 1.0).abs().max_element());
                    worst = if error <= worst { worst } else { error };
                }
            }
        }
    }
    // One sample in each pixel, added to the pixels whose centre is within 0.25.
    let uncovered = (0..10_000u64).filter(|i| {
        let sampler = Sampler::new(SamplerKind::Independent, 12, [0, 0], *i);
        let offset = sampler.get_2d(Dim::Pixel).map(|u| (u - 0.5).abs());
        offset[0] > 0.25 || offset[1] > 0.25
    });
    let narrow = [
        "box:0.25",
        "box:0",
        "gaussian:-1",
        "tent:nan",
        "lanczos:inf",
    ];
    let accepted = narrow.iter().filter(|text| text.parse::<Filter>().is_ok());
    vec![
        Figure {
            what: "largest relative error of a constant picture, borders included",
            naive: None,
            lightbox: worst,
            bound: Bound::AtMost(1e-6),
        },
        Figure {
            what: "impossible radii accepted (naive: pixels of 10⁴ left without a sample)",
            naive: Some(uncovered.count() as f64),
            lightbox: accepted.count() as f64,
            bound: Bound::Exactly(0.0),
        },
    ]
}

fn sinc_near_zero() -> Vec<Figure> {
    // Up and down around the change from series to quotient.
    let xs: Vec<f64> = (0..4000).map(|i| f64::from(i) * 2.5e-8).collect();
    let rises = |f: &dyn Fn(f64) -> f64| {
        let values: Vec<f64> = xs.iter().map(|x| f(*x)).collect();
        let falls = |pair: &[f64]| pair[1] <= pair[0] && pair[0] <= 1.0;
        values.windows(2).filter(|pair| !falls(pair)).count() as f64
    };
    let naive = |x: f64| (std::f64::consts::PI * x).sin() / (std::f64::consts::PI * x);
    let mut beyond = 0.0f64;
    for kind in FilterKind::ALL {
        for x in [1.0f64.next_up(), 1.0 + 1e-6, 2.0, f64::INFINITY] {
            beyond = beyond.max(kind.eval(x).abs()).max(kind.eval(-x).abs());
        }
    }
    let outside = FilterKind::ALL.iter().flat_map(|kind| {
        let filter = Filter::new(*kind);
        let sampler = FilterSampler::new(filter);
        [0.0, 0.5, LAST].map(|u| sampler.sample([u, u]).0.map(|x| x.abs() > filter.radius))
    });
    let outside = outside.flatten().filter(|is| *is).count();
    vec![
        Figure {
            what: "steps within 10⁻⁴ of 0 on which sinc does not fall",
            naive: Some(rises(&naive)),
            lightbox: rises(&sinc),
            bound: Bound::Exactly(0.0),
        },
        Figure {
            what: "largest value of a filter past its radius",
            naive: None,
            lightbox: beyond,
            bound: Bound::Exactly(0.0),
        },
        Figure {
            what: "positions drawn outside the radius",
            naive: None,
            lightbox: outside as f64,
            bound: Bound::Exactly(0.0),
        },
    ]
}
