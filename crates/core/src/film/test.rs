//! Tests of the film.

use super::*;
use crate::filter::{Filter, FilterKind};

fn film(kind: FilterKind) -> (Film, FilterSampler) {
    let filter = FilterSampler::new(Filter::new(kind));
    (Film::new(1, 1, &filter), filter)
}

fn add(film: &Film, first: u64, values: &[Vec3]) {
    let (mut batch, _) = film.batch(0);
    for (i, value) in values.iter().enumerate() {
        batch.add([0, 0], first + i as u64, 0, *value);
    }
    assert!(film.merge(0, &batch, first, first + values.len() as u64));
}

fn pixel(film: &Film) -> Vec3 {
    film.develop().pixels[0]
}

/// In f32 the sum stays at the firefly for ever.
#[test]
fn a_firefly_does_not_freeze_the_pixel() {
    let (film, _) = film(FilterKind::Box);
    let mut values = vec![Vec3::splat(1e6)];
    values.resize(20_001, Vec3::splat(0.03));
    add(&film, 0, &values);
    let truth = (1e6 + 20_000.0 * f64::from(0.03f32)) / 20_001.0;
    assert!((f64::from(pixel(&film).x) / truth - 1.0).abs() < 1e-7);
}

#[test]
fn many_small_samples_keep_their_mean() {
    let (film, _) = film(FilterKind::Box);
    add(&film, 0, &vec![Vec3::splat(0.1); 20_000]);
    assert_eq!(pixel(&film), Vec3::splat(0.1));
}

#[test]
fn any_grouping_gives_the_same_bits() {
    let values: Vec<Vec3> = (0..96u32)
        .map(|i| Vec3::new(1e-6, 0.37, 1e5) * (i.wrapping_mul(2_654_435_761) as f32 * 1e-9))
        .collect();
    let whole = film(FilterKind::Box).0;
    add(&whole, 0, &values);
    let parts = film(FilterKind::Box).0;
    for (i, part) in values.chunks(7).enumerate() {
        add(&parts, 7 * i as u64, part);
    }
    assert_eq!(pixel(&whole), pixel(&parts));
    assert_eq!(whole.noise(), parts.noise());
}

#[test]
fn invalid_samples_are_left_out_counted_and_kept() {
    let (film, _) = film(FilterKind::Box);
    let bad = [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, -1.0, 2e12];
    let mut values = vec![Vec3::splat(2.0); 4];
    values.extend(bad.map(|x| Vec3::new(1.0, x, 1.0)));
    values.extend([Vec3::splat(4.0); 4]);
    add(&film, 0, &values);
    assert_eq!(pixel(&film), Vec3::splat(3.0));
    let (count, kept) = film.invalid();
    assert_eq!(count, bad.len() as u64);
    assert_eq!(
        kept.iter().map(|s| s.sample).collect::<Vec<_>>(),
        [4, 5, 6, 7, 8]
    );
}

/// The half-films' difference estimates the error of the mean: on average over many pixels of
/// independent noise it must come to σ/√n.
#[test]
fn noise_is_the_standard_error() {
    let filter = FilterSampler::new(Filter::default());
    let film = Film::new(64, 64, &filter);
    let samples = 16;
    for tile in 0..film.tiles() {
        let (mut batch, _) = film.batch(tile);
        for y in 0..batch.rect.height {
            for x in 0..batch.rect.width {
                for sample in 0..samples {
                    // Uniform in 0..2: mean 1, variance ⅓.
                    let seed =
                        u64::from(batch.rect.x + x) << 40 | u64::from(batch.rect.y + y) << 20;
                    let pixel = [batch.rect.x + x, batch.rect.y + y];
                    let sampler = crate::sampler::Sampler::new(
                        crate::SamplerKind::Independent,
                        seed,
                        pixel,
                        sample,
                    );
                    let [u, _] = sampler.get_2d(crate::sampler::Dim::Pixel);
                    batch.add([x, y], sample, 0, Vec3::splat(2.0 * u));
                }
            }
        }
        assert!(film.merge(tile, &batch, 0, samples));
    }
    // Relative to value² + 0.01, so a little below σ/√n; and the mean itself is noisy.
    let expected = (1.0 / 3.0 / samples as f64 / 1.01f64).sqrt();
    let noise = film.noise().unwrap();
    assert!(
        (noise / expected - 1.0).abs() < 0.06,
        "{noise} instead of {expected}"
    );
}

#[test]
fn noise_needs_both_halves() {
    let (film, _) = film(FilterKind::Box);
    add(&film, 0, &[Vec3::ONE]);
    assert_eq!(film.noise(), None);
    add(&film, 1, &[Vec3::ONE]);
    assert_eq!(film.noise(), Some(0.0));
}

/// Filters with negative lobes must leave a constant scene constant from the first sample on.
#[test]
fn a_constant_scene_is_constant_under_every_filter() {
    for kind in FilterKind::ALL {
        for samples in [1, 2, 3, 17, 200] {
            let (film, filter) = film(kind);
            let (mut batch, _) = film.batch(0);
            for sample in 0..samples {
                let sampler =
                    crate::sampler::Sampler::new(crate::SamplerKind::Sobol, 3, [0, 0], sample);
                let (_, stratum) = filter.sample(sampler.get_2d(crate::sampler::Dim::Pixel));
                batch.add([0, 0], sample, stratum, Vec3::splat(0.7));
            }
            assert!(film.merge(0, &batch, 0, samples));
            assert!(
                (pixel(&film) - 0.7).abs().max_element() < 1e-6,
                "{kind:?} {samples}"
            );
        }
    }
}
