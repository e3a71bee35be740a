//! How far the error estimate can be trusted, and what it costs: tables for
//! docs/speed-and-accuracy.md.
//!
//! `cargo run --release -p lightbox-tests --example accuracy [SCENE...]`

use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::time::Instant;

use lightbox_core::compare::compare;
use lightbox_core::{Film, Image, Method, SamplerKind, Scene, View};
use lightbox_tests::{built, film, shipped, shipped_scenes, view};

/// Edge of the pictures, pixels.
const SIZE: u32 = 32;

/// Samples per pixel of the pictures judged.
const SAMPLES: [u64; 3] = [16, 64, 256];

/// Samples per pixel of a reference.
const REFERENCE: u64 = 8192;

/// Fresh seeds of each combination.
const SEEDS: u64 = 24;

fn settings(scene: &Arc<Scene>, method: Method, sampler: SamplerKind, n: u64, seed: u64) -> View {
    view(scene, |s| {
        (s.width, s.height, s.samples) = (SIZE, SIZE, n);
        (s.method, s.sampler, s.seed) = (method, sampler, seed);
    })
}

/// The film of a view whose halves take turns in one stream: its even samples.
fn single_stream(view: &View) -> Film {
    let (film, never) = (view.film(), AtomicBool::new(false));
    for k in 0..view.settings.samples {
        let one = view.film().starting_at(2 * k);
        view.render(&one, 2 * k + 1, &never);
        let image = one.develop();
        for tile in 0..film.tiles() {
            let (mut batch, _) = film.batch(tile);
            let rect = batch.rect;
            for y in 0..rect.height {
                for x in 0..rect.width {
                    let pixel = (rect.y + y) * image.width + rect.x + x;
                    // The box filter of the shipped scenes has one stratum.
                    batch.add([x, y], k, 0, image.pixels[pixel as usize]);
                }
            }
            film.merge(tile, &batch, k, k + 1);
        }
    }
    film
}

/// A picture that counts as right, and its own relMSE.
struct Reference(Image, f64);

/// The true error of a film: what the reference adds to it is taken off in the mean.
fn rel_mse(film: &Film, reference: &Reference) -> f64 {
    let comparison = compare(&film.develop(), &reference.0).expect("one size");
    comparison.rel_mse - reference.1
}

/// Coverage of the band; returns pictures inside, and all.
fn coverage(
    name: &str,
    scene: &Arc<Scene>,
    reference: &Reference,
    method: Method,
) -> [(u64, u64); 3] {
    let mut counts = [(0, 0); 3];
    for sampler in SamplerKind::ALL {
        let mut cells = Vec::new();
        for (k, n) in SAMPLES.into_iter().enumerate() {
            let (mut inside, mut estimates, mut truths) = (0, 0.0, 0.0);
            for seed in 0..SEEDS {
                let film = film(&settings(scene, method, *sampler, n, seed));
                let truth = rel_mse(&film, reference);
                let error = film.error().expect("both halves");
                // Both 0 where light is exact.
                let rounding = 1e-12;
                inside +=
                    u64::from(error.low - rounding <= truth && truth <= error.high + rounding);
                estimates += error.rel_mse;
                truths += truth;
            }
            counts[k].0 += inside;
            counts[k].1 += SEEDS;
            cells.push(format!(
                "{:.0} % ({:.2})",
                100.0 * inside as f64 / SEEDS as f64,
                estimates / truths
            ));
        }
        println!("| {name} | {method} | {sampler} | {} |", cells.join(" | "));
    }
    counts
}

/// Loss of efficiency by two streams instead of one.
fn loss(name: &str, scene: &Arc<Scene>, reference: &Reference, method: Method) {
    let cells = SAMPLES.map(|n| {
        let (mut halves, mut single, mut told) = (0.0, 0.0, 0.0);
        for seed in 0..SEEDS {
            let view = settings(scene, method, SamplerKind::Sobol, n, seed);
            halves += rel_mse(&film(&view), reference);
            let one = single_stream(&view);
            single += rel_mse(&one, reference);
            told += one.error().expect("both halves").rel_mse;
        }
        format!(
            "{:.1} % ({:.1})",
            100.0 * (1.0 - single / halves),
            told / single
        )
    });
    println!("| {name} | {method} | {} |", cells.join(" | "));
}

/// Nanoseconds a pixel of measuring, beside those of a sample.
fn cost(name: &str, scene: &Arc<Scene>) {
    let view = view(scene, |s| (s.width, s.height, s.samples) = (256, 256, 8));
    let start = Instant::now();
    let film = film(&view);
    let sample = start.elapsed().as_secs_f64() / 8.0 / 65536.0 * 1e9;
    let start = Instant::now();
    for _ in 0..10 {
        std::hint::black_box(film.error());
    }
    let measuring = start.elapsed().as_secs_f64() / 10.0 / 65536.0 * 1e9;
    println!(
        "| {name} | {sample:.0} | {measuring:.0} | {:.1} % |",
        100.0 * measuring / sample
    );
}

fn main() {
    let mut names: Vec<String> = std::env::args().skip(1).collect();
    if names.is_empty() {
        let stem =
            |path: &std::path::PathBuf| path.file_stem().map(|s| s.to_string_lossy().into_owned());
        names = shipped_scenes().iter().filter_map(stem).collect();
    }
    let scenes: Vec<Arc<Scene>> = names.iter().map(|name| built(&shipped(name))).collect();
    let references: Vec<Reference> = scenes
        .iter()
        .map(|scene| {
            let view = settings(scene, Method::Mis, SamplerKind::Sobol, REFERENCE, 1 << 40);
            let film = film(&view);
            let error = film.error().expect("both halves").rel_mse;
            Reference(film.develop(), error)
        })
        .collect();
    let all = || names.iter().zip(&scenes).zip(&references);
    let heads = SAMPLES.map(|n| format!("{n} spp")).join(" | ");
    println!("Pictures of {SEEDS} whose true relMSE lies within the band (estimate over truth):");
    println!("| scene | method | sampler | {heads} |\n|---|---|---|---|---|---|");
    let mut total = [(0, 0); 3];
    for ((name, scene), reference) in all() {
        for method in Method::ALL {
            for (sum, (inside, of)) in total
                .iter_mut()
                .zip(coverage(name, scene, reference, *method))
            {
                sum.0 += inside;
                sum.1 += of;
            }
        }
    }
    let shares = total.map(|(inside, of)| format!("{:.1} %", 100.0 * inside as f64 / of as f64));
    println!("| all | | | {} |", shares.join(" | "));
    println!("\nLoss by two Sobol streams instead of one (error told over true with one stream):");
    println!("| scene | method | {heads} |\n|---|---|---|---|---|");
    for ((name, scene), reference) in all() {
        for method in [Method::Mis, Method::Naive] {
            loss(name, scene, reference, method);
        }
    }
    println!(
        "\n| scene | a sample, ns | measuring once, ns a pixel | of one sample per pixel |\n|---|---|---|---|"
    );
    for (name, scene) in names.iter().zip(&scenes) {
        cost(name, scene);
    }
}
