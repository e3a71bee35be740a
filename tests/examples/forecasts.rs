//! How often a forecast of the noise holds: a table for docs/speed-and-accuracy.md.
//!
//! `cargo run --release -p lightbox-tests --example forecasts [SCENE...]`

use std::collections::BTreeMap;
use std::sync::atomic::AtomicBool;

use lightbox_core::forecast::{Goal, Mark, Span, forecast};
use lightbox_core::{Method, SamplerKind, View};
use lightbox_tests::{built, shipped, shipped_scenes, view};

/// Edge of the pictures, pixels.
const SIZE: u32 = 40;

/// Fresh seeds of each combination.
const SEEDS: u64 = 4;

/// Samples per pixel from which is foretold, and how many times more are there at the end.
const FROM: [u64; 4] = [9, 18, 40, 114];
const AHEAD: [u64; 3] = [2, 4, 16];

/// A curve measured as the viewer measures it.
fn curve(view: &View) -> Vec<Mark> {
    let (film, never) = (view.film(), AtomicBool::new(false));
    let (mut marks, mut samples) = (Vec::new(), 2);
    while samples <= view.settings.samples {
        view.render(&film, samples, &never);
        marks.push(Mark {
            samples,
            seconds: samples as f64,
            noise: film.error().as_ref().map(Span::noise_of),
        });
        samples += samples.div_ceil(if samples < 16 { 2 } else { 8 });
    }
    marks
}

/// How a forecast came out.
#[derive(Default)]
struct Score {
    held: u64,
    of: u64,
    /// Half the width of the bands, relative.
    widths: Vec<f64>,
}

fn main() {
    let mut names: Vec<String> = std::env::args().skip(1).collect();
    if names.is_empty() {
        let all = shipped_scenes();
        let stems = all.iter().filter_map(|path| path.file_stem());
        names = stems.map(|s| s.to_string_lossy().into_owned()).collect();
    }
    let mut scores: BTreeMap<(u64, u64), Score> = BTreeMap::new();
    for name in &names {
        let scene = built(&shipped(name));
        for method in [Method::Naive, Method::Mis] {
            for sampler in SamplerKind::ALL {
                for seed in 0..SEEDS {
                    let view = view(&scene, |s| {
                        (s.width, s.height) = (SIZE, SIZE);
                        s.samples = FROM[FROM.len() - 2] * AHEAD[AHEAD.len() - 1];
                        (s.method, s.sampler, s.seed) = (method, *sampler, seed + 1000);
                    });
                    judge(&curve(&view), &mut scores);
                }
            }
        }
    }
    println!("Forecasts of the noise whose band held (half of the band, median):");
    println!("| from | 2 times | 4 times | 16 times as many samples |\n|---|---|---|---|");
    for from in FROM {
        let cells = AHEAD.map(|ahead| match scores.get_mut(&(from, ahead)) {
            Some(score) => {
                score.widths.sort_by(f64::total_cmp);
                let share = 100.0 * score.held as f64 / score.of as f64;
                let width = 100.0 * score.widths[score.widths.len() / 2];
                format!("{share:.0} % of {} (± {width:.0} %)", score.of)
            }
            None => "–".to_owned(),
        });
        println!("| {from} | {} |", cells.join(" | "));
    }
}

fn judge(marks: &[Mark], scores: &mut BTreeMap<(u64, u64), Score>) {
    for from in FROM {
        let known = marks.partition_point(|mark| mark.samples <= from);
        for ahead in AHEAD {
            let at = marks.partition_point(|mark| mark.samples < from * ahead);
            let Some(end) = marks.get(at) else { continue };
            let foretold = forecast(&marks[..known], Goal::Samples(end.samples));
            // A picture without noise has none to foretell.
            let (Some(noise), Some(outcome)) = (foretold.and_then(|f| f.noise), end.noise) else {
                continue;
            };
            let score = scores.entry((from, ahead)).or_default();
            score.of += 1;
            score.held += u64::from(noise.holds(outcome.value));
            score.widths.push((noise.high / noise.low).sqrt() - 1.0);
        }
    }
}
