//! The error estimate against the truth in shipped scenes: a short version of the example
//! `accuracy`, which has all scenes and gives the figures of docs/speed-and-accuracy.md.

use lightbox_core::compare::compare;
use lightbox_core::film::BAND_FROM;
use lightbox_core::{Method, SamplerKind};
use lightbox_tests::{built, film, shipped, view};

/// Edge of the pictures, pixels.
const SIZE: u32 = 32;

/// Fresh seeds of each scene, method and sampler.
const SEEDS: u64 = 10;

/// The true relMSE lies within the band in nine of ten pictures, give or take what 80 pictures
/// can tell, and the estimate itself is right in the mean.
#[test]
fn the_band_holds_the_true_error() {
    let (mut inside, mut pictures) = (0, 0);
    for name in ["cornell-box", "glass-sphere"] {
        let scene = built(&shipped(name));
        let reference = film(&view(&scene, |s| {
            (s.width, s.height, s.samples, s.seed) = (SIZE, SIZE, 8192, 1 << 40);
        }));
        let (reference, its_own) = (reference.develop(), reference.error().unwrap().rel_mse);
        for method in [Method::Mis, Method::Naive] {
            for sampler in SamplerKind::ALL {
                let (mut estimates, mut truths) = (0.0, 0.0);
                for seed in 0..SEEDS {
                    let film = film(&view(&scene, |s| {
                        (s.width, s.height, s.samples) = (SIZE, SIZE, BAND_FROM);
                        (s.method, s.sampler, s.seed) = (method, *sampler, seed);
                    }));
                    let truth = compare(&film.develop(), &reference).unwrap().rel_mse - its_own;
                    let error = film.error().unwrap();
                    estimates += error.rel_mse;
                    truths += truth;
                    inside += u64::from((error.low..=error.high).contains(&truth));
                    pictures += 1;
                }
                let ratio: f64 = estimates / truths;
                assert!(
                    (0.75..1.3).contains(&ratio),
                    "{name} {method} {sampler}: {ratio}"
                );
            }
        }
    }
    let share = inside as f64 / pictures as f64;
    assert!((0.82..=0.98).contains(&share), "{inside} of {pictures}");
}
