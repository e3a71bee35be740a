//! Estimators against each other and against the number of samples.

use std::f64::consts::{PI, TAU};
use std::sync::Arc;

use super::stats::{Comparisons, Replicates};
use super::trial::{
    FLOOR, RHO, lamps, mean, numbers, one_pixel, picture, quad, replicates, sphere, view,
};
use super::{Bound, Figure};
use crate::sampler::Dim;
use crate::settings::UNLIMITED;
use crate::{Method, SamplerKind, Scene};

/// Twelve small scenes, each a pixel: a lamp of each kind, several, hidden, near, blended
/// surfaces, more bounces.
fn pixels() -> Vec<(Arc<Scene>, u32)> {
    let over = quad(
        "lamp",
        "[-0.5, 1, -0.5], [0.5, 1, -0.5], [0.5, 1, 0.5], [-0.5, 1, 0.5]",
    );
    let wall = quad(
        "lamp",
        "[0.3, 0, 0], [0.3, 0, 0.5], [0.3, 1, 0.5], [0.3, 1, 0]",
    );
    let slanted = quad(
        "lamp",
        "[-0.5, 1, -0.5], [0.7, 1.3, -0.5], [1.0, 1.3, 0.5], [-0.2, 1, 0.5]",
    );
    let kite = quad("lamp", "[-1, 1, 0], [0, 1, -0.5], [0.5, 1, 0], [0, 1, 0.9]");
    let ball = sphere("lamp", [0.5, 0.8, -0.2], 0.4);
    let horizon = sphere("lamp", [0.9, 0.45, 0.0], 1.0);
    let blocker = quad(
        "grey",
        "[-0.1, 0.5, -2], [0.8, 0.5, -2], [0.8, 0.5, 2], [-0.1, 0.5, 2]",
    );
    let back = quad("grey", "[-2, 0, -1], [2, 0, -1], [2, 2, -1], [-2, 2, -1]");
    let blend = "[[material]]\nname = 'blend'\nalbedo = [0.8, 0.8, 0.8]\nmirror = 0.5\n";
    let floor = quad("grey", FLOOR);
    let eye = "[1, 0.7, 3]";
    let grey = |shapes: &str| one_pixel(eye, &(floor.clone() + shapes));
    let sky = |shapes: &str| {
        one_pixel(
            eye,
            &format!("background = [0.2, 0.2, 0.2]\n{floor}{shapes}"),
        )
    };
    vec![
        (grey(&over), 2),
        (grey(&wall), 2),
        (grey(&slanted), 2),
        (grey(&kite), 2),
        (grey(&ball), 2),
        (grey(&horizon), 2),
        (grey(&(over.clone() + &ball)), 2),
        (grey(&(over.clone() + &blocker)), 2),
        (grey(&(over.clone() + &back)), 5),
        (sky(&kite), 3),
        (one_pixel(eye, &(quad("blend", FLOOR) + &over + blend)), 2),
        (grey(&(slanted + &back + &wall)), UNLIMITED),
    ]
}

pub(super) fn methods() -> Vec<Figure> {
    let mut comparisons = Comparisons::default();
    for (scene, depth) in pixels() {
        for sampler in SamplerKind::ALL {
            let means = |method| {
                replicates(&scene, |s| {
                    // The noisiest needs most.
                    let samples = if method == Method::Naive { 6144 } else { 2048 };
                    (s.method, s.sampler, s.samples, s.depth) = (method, *sampler, samples, depth);
                })
            };
            let mis = means(Method::Mis);
            comparisons.agree(&means(Method::Naive), &mis);
            comparisons.agree(&means(Method::Nee), &mis);
        }
    }
    comparisons.figures(
        "largest disagreement in 12 scenes, critical distances",
        None,
        0.14,
    )
}

/// Slope of log RMSE against log N by least squares.
fn log_slope(points: &[(f64, f64)]) -> f64 {
    let n = points.len() as f64;
    let (mx, my) = points.iter().fold((0.0, 0.0), |(a, b), (x, y)| {
        (a + x.ln() / n, b + y.ln() / n)
    });
    let (num, den) = points.iter().fold((0.0, 0.0), |(num, den), (x, y)| {
        let (dx, dy) = (x.ln() - mx, y.ln() - my);
        (num + dx * dy, den + dx * dx)
    });
    num / den
}

pub(super) fn slope() -> Vec<Figure> {
    let lamp = quad(
        "lamp",
        "[-0.5, 1, -0.5], [0.5, 1, -0.5], [0.5, 1, 0.5], [-0.5, 1, 0.5]",
    );
    let scene = one_pixel("[1, 0.7, 3]", &(quad("grey", FLOOR) + &lamp));
    let truth = RHO / PI * 0.752_274_7;
    let slope = |sampler, shared| {
        let points: Vec<(f64, f64)> = (4u64..=14)
            .map(|k| {
                let n = 1u64 << k;
                // Two sets of seeds, so that each RMSE is known to 9 %.
                let square: f64 = (0..2)
                    .map(|set| {
                        let means = Replicates::of(|i| {
                            let seed = 10_000 * k + 100 * set + i;
                            if shared {
                                // A sampler that comes round after 16 samples.
                                return repeating(&scene, seed);
                            }
                            mean(&picture(&view(&scene, |s| {
                                (s.method, s.sampler, s.seed) = (Method::Naive, sampler, seed);
                                (s.samples, s.depth) = (n, 2);
                            })))
                        });
                        means.rmse(truth).powi(2)
                    })
                    .sum();
                (n as f64, (square / 2.0).sqrt())
            })
            .collect();
        log_slope(&points)
    };
    vec![
        Figure {
            what: "slope, independent numbers (naive: the same 16 samples again and again)",
            naive: Some(slope(SamplerKind::Independent, true)),
            lightbox: slope(SamplerKind::Independent, false),
            bound: Bound::Within {
                truth: -0.5,
                tolerance: 0.05,
            },
        },
        Figure {
            what: "slope, scrambled Sobol' points",
            naive: None,
            lightbox: slope(SamplerKind::Sobol, false),
            bound: Bound::AtMost(-0.5),
        },
    ]
}

/// The mean of 16 samples, which no further repetition changes.
fn repeating(scene: &Arc<Scene>, seed: u64) -> f64 {
    mean(&picture(&view(scene, |s| {
        (s.method, s.sampler, s.seed) = (Method::Naive, SamplerKind::Independent, seed);
        (s.samples, s.depth) = (16, 2);
    })))
}

/// The share of the largest sample in the irradiance from a light 10⁻³ away.
pub(super) fn tails() -> Vec<Figure> {
    let h = 1e-3f32;
    let lamp = format!("[{h}, 0, -0.5], [{h}, 0, 0.5], [{h}, 1, 0.5], [{h}, 1, -0.5]");
    let lamp = lamps(&quad("lamp", &lamp));
    let n = 100_000u32;
    let (mut values, mut values_naive) = (Vec::new(), Vec::new());
    for i in 0..n {
        let u = numbers(i, Dim::LightPoint(0));
        let sample = lamp.lights().sample(glam::Vec3::ZERO, || 0.5, || u);
        values.push(sample.map_or(0.0, |s| {
            f64::from(s.point.p.normalize().y) / f64::from(s.pdf)
        }));
        let [y, z] = [f64::from(u[0]), f64::from(u[1]) - 0.5];
        let h = f64::from(h);
        let d2 = h * h + y * y + z * z;
        values_naive.push(h * y / (d2 * d2));
    }
    let share =
        |values: &[f64]| values.iter().copied().fold(0.0, f64::max) / values.iter().sum::<f64>();
    let median_of_means = |values: &[f64]| {
        let group = |values: &[f64]| values.iter().sum::<f64>() / values.len() as f64;
        let mut means: Vec<f64> = values.chunks(1000).map(group).collect();
        means.sort_by(f64::total_cmp);
        means[means.len() / 2]
    };
    // Irradiance over radiance: π times the form factor of both halves.
    let truth = TAU * super::lights::perpendicular(0.5, 1.0, f64::from(h));
    vec![
        Figure {
            what: "share of the largest of 10⁵ samples in their sum",
            naive: Some(share(&values_naive)),
            lightbox: share(&values),
            bound: Bound::AtMost(0.01),
        },
        Figure {
            what: "median of 100 means over the irradiance",
            naive: Some(median_of_means(&values_naive) / truth),
            lightbox: median_of_means(&values) / truth,
            bound: Bound::Within {
                truth: 1.0,
                tolerance: 0.005,
            },
        },
    ]
}
