//! How often the lab's statistical tests cry wolf, and how often they see a wolf: the fractions
//! over many runs with fresh seeds, against those stated.
//!
//! `cargo run --release -p lightbox-tests --example alarms`

use std::sync::Arc;

use lightbox_core::agreement::{Agreement, Light};
use lightbox_core::lab::stats::{
    CHI_SQUARE_63, Comparisons, REPLICATES, Replicates, T_31, cell, chi_square,
};
use lightbox_core::lab::trial::{FLOOR, built_in, mean, one_pixel, picture, quad};
use lightbox_core::planted::{Bug, plant};
use lightbox_core::sampler::{Dim, Sampler};
use lightbox_core::settings::UNLIMITED;
use lightbox_core::{Method, RenderSettings, SamplerKind, Scene};
use lightbox_tests::{built, film, shipped, view};
use statrs::distribution::{ChiSquared, ContinuousCDF as _, StudentsT};

/// Runs with fresh seeds in which nothing is wrong.
const TRIALS: u64 = 1000;

/// Runs for each bias and each planted defect.
const BIASED: u64 = 200;

/// Pairs of pictures of each scene and method.
const PAIRS: u64 = 100;

/// Levels at which false alarms are frequent enough to be counted.
const LEVELS: [f64; 3] = [0.05, 0.01, 0.001];

/// What the pixel shows: ½ E/π with E/L = 0.7522747.
const UNDER_A_SQUARE_SHOWS: f64 = 0.5 / std::f64::consts::PI * 0.752_274_7;

/// An experiment: a scene with a known mean.
struct Experiment {
    name: &'static str,
    scene: Arc<Scene>,
    change: fn(&mut RenderSettings),
    truth: f64,
}

impl Experiment {
    /// |t| and the relative error that would be found 9 times of 10, of a run.
    fn run(&self, trial: u64) -> (f64, f64) {
        let means = Replicates::of(|i| {
            let image = picture(&view(&self.scene, |s| {
                (self.change)(s);
                s.seed = 1_000_000 + trial * REPLICATES as u64 + i;
            }));
            mean(&image)
        });
        let mut comparisons = Comparisons::default();
        comparisons.mean(&means, self.truth);
        (comparisons.deviation * T_31, comparisons.blindness)
    }

    /// |t| of all trials.
    fn runs(&self, trials: u64) -> Vec<f64> {
        (0..trials).map(|trial| self.run(trial).0).collect()
    }
}

fn fraction(values: &[f64], limit: f64) -> f64 {
    values.iter().filter(|v| !(**v <= limit)).count() as f64 / values.len() as f64
}

/// χ² of cosine-weighted directions in cells of equal chance.
fn directions(trial: u64, density: f64) -> f64 {
    let n = 20_000u32;
    let mut observed = [0.0; 64];
    let grey = lightbox_core::bsdf::Bsdf::Diffuse(glam::Vec3::ONE);
    for i in 0..n {
        let sampler = Sampler::new(SamplerKind::Independent, 5_000_000 + trial, [i, 0], 0);
        let u = sampler.get_2d(Dim::BsdfDirection(0));
        if let Some(s) = grey.sample(glam::Vec3::Z, glam::Vec3::Z, true, || 0.5, || u) {
            let turn = f64::from(s.wi.y).atan2(f64::from(s.wi.x)) / std::f64::consts::TAU + 0.5;
            let sin2 = (1.0 - f64::from(s.wi.z * s.wi.z)).max(0.0);
            observed[cell([sin2.powf(density), turn])] += 1.0;
        }
    }
    chi_square(&observed, &[f64::from(n) / 64.0; 64])
}

/// 1 − p of pairs of pictures that differ in nothing but noise.
fn disagreements(name: &str, method: Method, samples: u64) -> Vec<f64> {
    let scene = built(&shipped(name));
    let light = |seed| {
        let film = film(&view(&scene, |s| {
            (s.width, s.height, s.samples) = (48, 48, samples);
            (s.method, s.seed) = (method, 7_000_000 + seed);
        }));
        Light::of(&film).expect("both halves")
    };
    let p = |pair| Agreement::between(&light(2 * pair), &light(2 * pair + 1)).p;
    (0..PAIRS).map(|pair| 1.0 - p(pair)).collect()
}

fn main() {
    // A floor of reflectance ½ under a unit square at height 1, by one pixel.
    let lamp = "[-0.5, 1, -0.5], [0.5, 1, -0.5], [0.5, 1, 0.5], [-0.5, 1, 0.5]";
    let under_a_square = one_pixel("[1, 0.7, 3]", &(quad("grey", FLOOR) + &quad("lamp", lamp)));
    let experiments = [
        Experiment {
            name: "square light, nee, Sobol'",
            scene: under_a_square.clone(),
            change: |s| (s.method, s.depth, s.samples) = (Method::Nee, 2, 64),
            truth: UNDER_A_SQUARE_SHOWS,
        },
        Experiment {
            name: "square light, naive, independent",
            scene: under_a_square.clone(),
            change: |s| {
                (s.method, s.depth, s.samples) = (Method::Naive, 2, 256);
                s.sampler = SamplerKind::Independent;
            },
            truth: UNDER_A_SQUARE_SHOWS,
        },
        Experiment {
            name: "closed box, mis, unlimited depth",
            scene: built_in("closed-box"),
            change: |s| {
                (s.width, s.height, s.samples) = (2, 2, 16);
                (s.method, s.depth) = (Method::Mis, UNLIMITED);
            },
            truth: 0.5,
        },
    ];
    let t = StudentsT::new(0.0, 1.0, REPLICATES as f64 - 1.0).expect("31 degrees of freedom");
    let chi = ChiSquared::new(63.0).expect("63 degrees of freedom");

    println!("False alarms of {TRIALS} runs with fresh seeds, at the level stated:");
    println!("| experiment | 5 % | 1 % | 0.1 % | the family's 2.5·10⁻⁷ |");
    println!("|---|---|---|---|---|");
    let row = |name: &str, values: &[f64], limits: [f64; 3], family: f64| {
        let cells = limits.map(|limit| format!("{:.1} %", 100.0 * fraction(values, limit)));
        let alarms = fraction(values, family) * TRIALS as f64;
        println!("| {name} | {} | {alarms} of {TRIALS} |", cells.join(" | "));
    };
    for experiment in &experiments {
        let values = experiment.runs(TRIALS);
        let limits = LEVELS.map(|level| t.inverse_cdf(1.0 - level / 2.0));
        row(experiment.name, &values, limits, T_31);
    }
    let values: Vec<f64> = (0..TRIALS).map(|trial| directions(trial, 1.0)).collect();
    let limits = LEVELS.map(|level| chi.inverse_cdf(1.0 - level));
    row("χ² of cosine directions", &values, limits, CHI_SQUARE_63);

    println!(
        "\nDisagreements of {PAIRS} pairs of pictures of one method with fresh seeds, at the level stated:"
    );
    println!("| scene | method | 5 % | 1 % | 0.1 % |\n|---|---|---|---|---|");
    for name in ["cornell-box", "teddy-diffuse", "sphere-mirror"] {
        for (method, samples) in [(Method::Naive, 64), (Method::Mis, 16), (Method::Reuse, 64)] {
            let values = disagreements(name, method, samples);
            let cells =
                LEVELS.map(|level| format!("{:.0} %", 100.0 * fraction(&values, 1.0 - level)));
            println!("| {name} | {method} | {} |", cells.join(" | "));
        }
    }

    println!("\nDetection at the family's level, {BIASED} runs:");
    println!("| experiment | bias | found | told in advance: found 9 times of 10 |");
    println!("|---|---|---|---|");
    for experiment in &experiments {
        let (_, blindness) = experiment.run(0);
        for share in [0.5, 0.8, 1.0, 1.2, 1.5] {
            let biased = Experiment {
                truth: experiment.truth / (1.0 + share * blindness),
                scene: experiment.scene.clone(),
                ..*experiment
            };
            let values = biased.runs(BIASED);
            println!(
                "| {} | {:.2} % | {:.1} % | {:.2} % |",
                experiment.name,
                100.0 * share * blindness,
                100.0 * fraction(&values, T_31),
                100.0 * blindness
            );
        }
    }
    for density in [1.05, 1.1, 1.2] {
        let values: Vec<f64> = (0..BIASED).map(|i| directions(i, density)).collect();
        println!(
            "| χ², density of sin² θ to the power {density} | | {:.1} % | |",
            100.0 * fraction(&values, CHI_SQUARE_63)
        );
    }

    println!("\nPlanted defects, found of {BIASED} runs at the family's level:");
    println!("| defect | experiment | found |");
    println!("|---|---|---|");
    for (bug, experiment) in [
        (Bug::CosineDropped, &experiments[0]),
        (Bug::PdfTimes1_02, &experiments[0]),
        (Bug::OneSidedFlagFlipped, &experiments[1]),
        (Bug::RouletteWeightOmitted, &experiments[2]),
        (Bug::LastBounceEmissionDoubled, &experiments[1]),
        (Bug::DimensionsShared, &experiments[2]),
    ] {
        plant(Some(bug));
        let values = experiment.runs(BIASED);
        plant(None);
        let found = 100.0 * fraction(&values, T_31);
        println!("| {bug:?} | {} | {found:.1} % |", experiment.name);
    }
}
