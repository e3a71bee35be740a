//! Forecasts of the noise on the shipped scenes: do the bands hold what they promise?

use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use lightbox_core::SamplerKind;
use lightbox_core::forecast::{Goal, Mark, forecast};
use lightbox_tests::{shipped, view};

/// Samples at the end of a curve.
const END: u64 = 1024;

/// The noise of a scene's picture while its samples grow.
fn curve(name: &str, sampler: SamplerKind) -> Vec<Mark> {
    let scene = Arc::new(shipped(name).build(&|_| ()).expect("a scene"));
    let view = view(&scene, |s| {
        (s.width, s.height, s.sampler) = (32, 24, sampler);
    });
    let (film, mut marks) = (view.film(), Vec::new());
    let mut samples = 4;
    while samples <= END {
        view.render(&film, samples, &AtomicBool::new(false));
        marks.push(Mark {
            samples,
            // Not what this is about.
            seconds: samples as f64,
            noise: film.noise(),
        });
        samples = (samples + (samples / 6).max(2)).next_multiple_of(2);
    }
    marks
}

/// Bands that should hold nine outcomes of ten hold about as many, near and far ahead, and are
/// not so wide that they would hold anything.
#[test]
fn noise_comes_to_what_was_foretold() {
    let (mut held, mut widths) = (Vec::new(), Vec::new());
    for name in [
        "cornell-box",
        "teddy-diffuse",
        "teddy-mirror",
        "glass-sphere",
        "sphere-mirror",
    ] {
        for sampler in [SamplerKind::Sobol, SamplerKind::Independent] {
            let marks = curve(name, sampler);
            for now in (2..marks.len()).step_by(2) {
                for end in (now + 2..marks.len()).step_by(4) {
                    let (so_far, end) = (&marks[..=now], marks[end]);
                    let goal = Goal::Samples(end.samples);
                    let told = forecast(so_far, goal).and_then(|f| f.noise);
                    let (band, outcome) = (told.expect("a band"), end.noise.expect("a noise"));
                    held.push(band.holds(outcome));
                    widths.push(band.high / band.low);
                    println!(
                        "{name} {sampler} {} to {}: {:.3} times what was told, band {:.2}",
                        marks[now].samples,
                        end.samples,
                        outcome / band.value,
                        band.high / band.low
                    );
                }
            }
        }
    }
    let share = held.iter().filter(|h| **h).count() as f64 / held.len() as f64;
    widths.sort_by(f64::total_cmp);
    let median = widths[widths.len() / 2];
    println!("{share:.3} of {} held, median band {median:.2}", held.len());
    assert!((0.85..0.99).contains(&share), "{share}");
    assert!(median < 1.8, "{median}");
}
