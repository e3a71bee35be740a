//! The film against exact sums.

use std::sync::LazyLock;

use glam::{DVec3, Vec3};
use lightbox_core::Film;
use lightbox_core::filter::{Filter, FilterKind, FilterSampler};

use super::draw::Draw;

static FILTERS: LazyLock<[FilterSampler; 2]> = LazyLock::new(|| {
    [FilterKind::Box, FilterKind::Lanczos].map(|k| FilterSampler::new(Filter::new(k)))
});

/// Sums of one pixel and stratum, in units of 2⁻⁶⁰.
#[derive(Clone, Copy, Default)]
struct Sum {
    channels: [i128; 3],
    count: u64,
}

/// Batches of samples of any value merged in any order, some refused: every pixel is the mean of
/// what was finite and in range, everything else is counted.
pub fn film(bytes: &[u8]) {
    let mut draw = Draw::new(bytes);
    let filter = &FILTERS[draw.below(2)];
    let [width, height] = [0; 2].map(|_| draw.of(&[1u32, 2, 17, 33]));
    let film = Film::new(width, height, filter);
    let mut sums = vec![[Sum::default(); 2]; (width * height) as usize];
    let mut invalid = 0;
    let mut waiting = Vec::new();
    for _ in 0..12 {
        let tile = draw.byte() as usize % film.tiles();
        if draw.below(8) == 0 && !waiting.is_empty() {
            // Samples that are there already, or not the next ones.
            let (tile, batch, first, end) = waiting.swap_remove(draw.below(waiting.len()));
            assert!(
                !film.merge(tile, &batch, first, end),
                "a stale batch was taken"
            );
            continue;
        }
        let (mut batch, first) = film.batch(tile);
        let end = first + 1 + draw.below(3) as u64;
        let spread = draw.below(2) == 0;
        let (base, rect) = ([0; 3].map(|_| radiance(&mut draw)), batch.rect);
        for y in 0..rect.height {
            for x in 0..rect.width {
                for sample in first..end {
                    let mut value = Vec3::from_array(base);
                    if spread {
                        value.x = radiance(&mut draw);
                    }
                    let stratum = draw.below(filter.strata());
                    batch.add([x, y], sample, stratum, value);
                    if value
                        .to_array()
                        .iter()
                        .all(|v| *v >= 0.0 && *v < 2f32.powi(40))
                    {
                        let index = (rect.y + y) * width + rect.x + x;
                        let sum = &mut sums[index as usize][stratum];
                        sum.count += 1;
                        for (to, v) in sum.channels.iter_mut().zip(value.to_array()) {
                            *to += (f64::from(v) * 2f64.powi(60)) as i128;
                        }
                    } else {
                        invalid += 1;
                    }
                }
            }
        }
        assert!(film.merge(tile, &batch, first, end));
        waiting.push((tile, batch, first, end));
    }
    assert_eq!(film.invalid().0, invalid);
    let [positive, negative] = filter.weights();
    let mean = |s: &Sum| {
        (s.count > 0).then(|| {
            DVec3::from_array(s.channels.map(|c| c as f64 * 2f64.powi(-60))) / s.count as f64
        })
    };
    for (pixel, [p, n]) in film.develop().pixels.iter().zip(&sums) {
        let expected = match (mean(p), mean(n)) {
            (Some(p), Some(n)) => positive * p + negative * n,
            (Some(one), None) | (None, Some(one)) => one,
            (None, None) => DVec3::ZERO,
        };
        assert_eq!(*pixel, expected.as_vec3());
    }
    if let Some(noise) = film.error().map(|e| e.noise()) {
        assert!(noise.is_finite() && noise >= 0.0, "noise {noise}");
    }
}

fn radiance(draw: &mut Draw) -> f32 {
    match draw.below(4) {
        0 => draw.any(),
        1 => draw.of(&[
            2f32.powi(40),
            2f32.powi(40).next_down(),
            -1e-45,
            1e-45,
            2f32.powi(-60),
        ]),
        _ => draw.coordinate(24).abs(),
    }
}
