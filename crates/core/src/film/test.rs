//! Tests of the film. Its sums are cases of the stability lab.

use super::*;
use crate::filter::Filter;

/// Or a copy could have the samples of some, and the rays of all.
#[test]
fn nobody_copies_a_film_between_batches_that_belong_together() {
    let film = Film::new(2 * TILE, TILE, &FilterSampler::new(Filter::default()));
    let batches = [0, 1].map(|i| film.batch(i).0);
    let batches = batches.iter().enumerate().map(|(i, batch)| (i, batch, 0));
    let alone = batches.inspect(|_| assert!(film.whole.try_write().is_err()));
    assert!(film.merge_all(alone, 1, 7));
    assert_eq!(film.clone().work(), [u64::from(2 * TILE * TILE), 7]);
}

#[test]
fn noise_needs_both_halves() {
    let film = Film::new(1, 1, &FilterSampler::new(Filter::default()));
    for (sample, noise) in [(0, None), (1, Some(0.0))] {
        let (mut batch, _) = film.batch(0);
        batch.add([0, 0], sample, 0, Vec3::ONE);
        assert!(film.merge(0, &batch, sample, sample + 1));
        assert_eq!(film.error().map(|e| e.noise()), noise);
    }
}

/// A film of one tile with two samples per pixel.
fn tile(radiance: impl Fn([u32; 2], u64) -> f32) -> Film {
    let film = Film::new(TILE, TILE, &FilterSampler::new(Filter::default()));
    let (mut batch, _) = film.batch(0);
    for y in 0..TILE {
        for x in 0..TILE {
            for sample in 0..2 {
                batch.add([x, y], sample, 0, Vec3::splat(radiance([x, y], sample)));
            }
        }
    }
    assert!(film.merge(0, &batch, 0, 2));
    film
}

/// What one pixel adds to the relMSE, with half the difference of its halves and the truth.
fn share(half_difference: f64, truth: f64) -> f64 {
    half_difference * half_difference / (truth * truth + 0.01) / 256.0
}

#[test]
fn an_outlier_does_not_hide_itself() {
    // Seen by one half in a flat surrounding: an error of 500, not of half the pixel's value.
    let outlier = tile(|at, sample| match (at, sample) {
        ([7, 9], 0) => 1001.0,
        _ => 1.0,
    });
    let error = outlier.error().unwrap();
    let expected = share(500.0, 1.0);
    assert!((error.rel_mse / expected - 1.0).abs() < 1e-3, "{error:?}");
    // One pixel tells so little that the band is wide.
    assert!(error.high > 5.0 * error.rel_mse && error.low < 0.2 * error.rel_mse);
    // Seen by both halves it is no outlier but a bright pixel.
    let bright = tile(|at, sample| match (at, sample) {
        ([7, 9], 0) => 1001.0,
        ([7, 9], 1) => 999.0,
        _ => 1.0,
    });
    let error = bright.error().unwrap();
    assert!(
        (error.rel_mse / share(1.0, 1000.0) - 1.0).abs() < 0.1,
        "{error:?}"
    );
}

#[test]
fn errors_of_pixels_are_pooled_over_neighbours() {
    let film = tile(|at, sample| match (at, sample) {
        ([7, 9], 0) => 3.0,
        _ => 1.0,
    });
    let (rect, errors) = film.pixel_errors(0).unwrap();
    let at = |x: u32, y: u32| errors[(y * rect.width + x) as usize];
    assert!(at(7, 9) > 0.2 && at(7, 9) == at(8, 10) && at(9, 9) == 0.0);
    assert_eq!(
        film.tile_error(0).unwrap().rel_mse(),
        film.error().unwrap().rel_mse
    );
}

/// Light for other tiles: the mean over all light paths, the same in any order, apart by half;
/// what is no radiance is counted where it came from.
#[test]
fn splats_land_in_any_order() {
    let pixels = f64::from(20 * 3);
    let splat = |pixel, half, radiance| Splat {
        pixel,
        half,
        radiance: Vec3::splat(radiance),
    };
    let merged = |order: [usize; 2]| {
        let film = Film::new(20, 3, &FilterSampler::new(Filter::default())).with_splats();
        for tile in order {
            let (mut batch, _) = film.batch(tile);
            let TileRect { width, height, .. } = batch.rect;
            for (x, y) in (0..height).flat_map(|y| (0..width).map(move |x| (x, y))) {
                for sample in 0..2 {
                    batch.add([x, y], sample, 0, Vec3::ONE);
                }
            }
            batch.add_splat([1, 0], 0, splat([17, 1], 0, 3.0 + tile as f32));
            batch.add_splat([1, 0], 1, splat([17, 1], 1, -0.25));
            batch.add_splat([1, 0], 1, splat([2, 2], 1, f32::NAN));
            assert!(film.merge(tile, &batch, 0, 2));
        }
        film
    };
    let film = merged([0, 1]);
    let image = film.develop();
    assert!(image == merged([1, 0]).develop() && image == film.clone().develop());
    let at = |x: u32, y: u32| image.pixels[(y * 20 + x) as usize].x;
    // Two light paths for each pixel.
    assert_eq!((at(17, 1), at(2, 2)), (1.0 + 6.5 / 2.0, 1.0));
    let (count, kept) = film.invalid();
    assert_eq!(count, 2);
    assert!(kept.iter().all(|i| i.sample == 1 && i.pixel[1] == 0));
    // Halves of 8 and 0.5, among neighbours of 1.
    let error = film.error().unwrap();
    let square = (7.5f64 / 2.0).powi(2) / 1.01;
    assert!(
        (error.rel_mse * pixels / square - 1.0).abs() < 1e-3,
        "{error:?}"
    );
}

#[test]
fn a_pixel_is_what_is_developed_there() {
    let (width, height) = (50, 37);
    let film = Film::new(width, height, &FilterSampler::new(Filter::default()));
    assert_eq!(film.pixel([0, 0]), None);
    for i in 0..film.tiles() {
        let (mut batch, _) = film.batch(i);
        let rect = batch.rect;
        for (x, y) in (0..rect.height).flat_map(|y| (0..rect.width).map(move |x| (x, y))) {
            let radiance = Vec3::new((rect.x + x) as f32, (rect.y + y) as f32, 0.5);
            batch.add([x, y], 0, 0, radiance);
            // As far off in the other half, and once no radiance at all.
            batch.add([x, y], 1, 0, radiance + 4.0);
            let is_odd = (rect.x + x, rect.y + y) == (31, 17);
            batch.add([x, y], 2, 0, if is_odd { Vec3::NAN } else { radiance });
        }
        assert!(film.merge(i, &batch, 0, 3));
        assert_eq!((film.tile_rect(i), film.tile_samples(i)), (rect, 3));
    }
    let image = film.develop();
    for (x, y) in (0..height).flat_map(|y| (0..width).map(move |x| (x, y))) {
        let pixel = film.pixel([x, y]).expect("samples");
        assert_eq!(pixel.mean, image.pixels[(y * width + x) as usize]);
        assert_eq!(pixel.samples, 3);
        assert_eq!(pixel.invalid, u64::from([x, y] == [31, 17]));
        let error = pixel.error.expect("both halves");
        // Of 2 and 1 samples: the difference by the root of 2 over 3.
        let near_odd = x.abs_diff(31) < 2 && y.abs_diff(17) < 2;
        let right = 4.0 * 2f32.sqrt() / 3.0;
        assert!(
            near_odd || (error - right).abs().max_element() < 1e-5,
            "{error}"
        );
    }
    assert_eq!(film.pixel([width, 0]), None);
    assert_eq!(film.pixel([0, height]), None);
    let invalid: u64 = (0..film.tiles()).flat_map(|i| film.tile_invalid(i)).sum();
    assert_eq!(invalid, film.invalid().0);
}
