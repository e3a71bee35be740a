//! Whole paths: what an integrator loses, counts twice, or weighs wrongly.

use super::stats::Comparisons;
use super::trial::{closed_box, picture, replicates, scene, view};
use super::{Bound, Case, Check, Figure, convergence, gallery};
use crate::Method;
use crate::integrator::power_heuristic;
use crate::settings::UNLIMITED;

pub(super) const CASES: &[Case] = &[
    Case {
        id: "G01",
        title: "a closed Lambertian box",
        failure: "Any energy lost or made at a bounce adds up over the series.",
        cure: "Weights exact at each bounce: the box shows 1/(1 − ρ).",
        check: Check::Probe(furnace),
        scene: Some("builtin:lab/closed-box.toml"),
        picture: Some(gallery::closed_box),
    },
    Case {
        id: "G02",
        title: "depth that cuts the series",
        failure: "A path one segment too long or too short is hidden by a tolerance of a percent.",
        cure: "Depth counts segments: the sum has exactly that many terms.",
        check: Check::Probe(truncation),
        scene: Some("builtin:lab/depth.toml"),
        picture: Some(gallery::depth),
    },
    Case {
        id: "G03",
        title: "Russian roulette",
        failure: "Survivors that are not weighted up darken the picture, a probability near 0 \
                  blows them up, one above 1 brightens.",
        cure: "Survival with three times the throughput, from 0.05 to 0.95, after three bounces.",
        check: Check::Probe(roulette),
        scene: None,
        picture: None,
    },
    Case {
        id: "G04",
        title: "the power heuristic at any magnitude",
        failure: "a²/(a² + b²) overflows from 2·10¹⁹ on and is 0/0 below 10⁻²³.",
        cure: "1/(1 + (b/a)²) with the larger density below the line.",
        check: Check::Probe(heuristic),
        scene: None,
        picture: None,
    },
    Case {
        id: "G05",
        title: "methods against each other",
        failure: "A bias in one strategy shows only where another is right.",
        cure: "naive, nee and mis are one loop with different weights.",
        check: Check::Probe(convergence::methods),
        scene: None,
        picture: None,
    },
    Case {
        id: "G06",
        title: "a light seen directly, in a mirror, at the last bounce",
        failure: "Emission counted twice, or not at all, where strategies take over from each \
                  other.",
        cure: "Weight 1 from the camera and after mirrors, at any depth.",
        check: Check::Probe(seen_light),
        scene: None,
        picture: None,
    },
    Case {
        id: "G07",
        title: "the slope of the error",
        failure: "Correlated samples or infinite variance show as a slope flatter than −½ on a \
                  log-log chart of error against samples.",
        cure: "Independent numbers fall as N^−½, scrambled nets faster.",
        check: Check::Probe(convergence::slope),
        scene: None,
        picture: None,
    },
    Case {
        id: "G08",
        title: "tests of heavy tails",
        failure: "Where one sample carries the sum, a t-test accepts the wrong and rejects the \
                  right.",
        cure: "The estimator is bounded: no sample carries more than a hundredth.",
        check: Check::Probe(convergence::tails),
        scene: None,
        picture: None,
    },
];

fn furnace() -> Vec<Figure> {
    let mut comparisons = Comparisons::default();
    for rho in [0.5, 0.8] {
        let scene = closed_box(rho);
        for method in Method::ALL {
            // 32·64·50 = 10⁵ paths.
            let means = replicates(&scene, |s| {
                (s.method, s.samples, s.depth) = (*method, 50, UNLIMITED);
            });
            comparisons.mean(&means, 1.0 / (1.0 - rho));
        }
    }
    comparisons.figures(
        "largest deviation from 1/(1 − ρ), critical distances",
        None,
        0.02,
    )
}

fn truncation() -> Vec<Figure> {
    let rho: f64 = 0.5;
    let scene = closed_box(rho);
    let (mut comparisons, mut endless) = (Comparisons::default(), Comparisons::default());
    for depth in 1..=8 {
        for method in Method::ALL {
            let means = replicates(&scene, |s| {
                (s.method, s.samples, s.depth) = (*method, 16, depth);
            });
            comparisons.mean(&means, (1.0 - rho.powi(depth as i32)) / (1.0 - rho));
            if depth == 8 {
                endless.mean(&means, 1.0 / (1.0 - rho));
            }
        }
    }
    let mut figures = comparisons.figures(
        "largest deviation from the sum of D terms, critical distances",
        None,
        0.02,
    );
    // 8 terms are 0.4 % short of the whole series: a test must be able to tell.
    let means = replicates(&scene, |s| {
        (s.method, s.samples, s.depth) = (Method::Naive, 256, 8);
    });
    let mut sharp = Comparisons::default();
    sharp.mean(&means, 2.0 - 0.5f64.powi(7));
    let mut whole = Comparisons::default();
    whole.mean(&means, 2.0);
    figures.extend(sharp.figures(
        "deviation at 8 terms with 5·10⁵ paths (naive: from the endless sum)",
        Some(whole),
        0.003,
    ));
    figures
}

fn roulette() -> Vec<Figure> {
    // Depth 4 never meets roulette, depth 40 nearly always.
    let mut comparisons = Comparisons::default();
    let box_half = closed_box(0.5);
    for (depth, truth) in [(4, 1.875), (40, 2.0 - 0.5f64.powi(39))] {
        let means = replicates(&box_half, |s| {
            (s.method, s.samples, s.depth) = (Method::Naive, 256, depth);
        });
        comparisons.mean(&means, truth);
    }
    // A throughput that tends to 0 and one that stays 1.
    for rho in [0.02, 1.0] {
        let scene = closed_box(rho);
        let depth = 10;
        let truth: f64 = (0..depth).map(|k| rho.powi(k)).sum();
        let means = replicates(&scene, |s| {
            (s.method, s.samples, s.depth) = (Method::Naive, 256, depth as u32);
        });
        comparisons.mean(&means, truth);
    }
    // Without the weight each of the 4th and later terms comes with 0.95 or less of its energy.
    let unweighted: f64 = (0..40)
        .map(|k| 0.5f64.powi(k) * 0.5f64.powi((k - 3).max(0)))
        .sum();
    let mut figures = comparisons.figures(
        "largest deviation with roulette, critical distances",
        None,
        0.01,
    );
    let means = replicates(&box_half, |s| {
        (s.method, s.samples, s.depth) = (Method::Naive, 256, UNLIMITED);
    });
    figures.push(Figure {
        what: "radiance of a box of albedo ½ (naive: survivors unweighted)",
        naive: Some(unweighted),
        lightbox: means.mean(),
        bound: Bound::Within {
            truth: 2.0,
            tolerance: 0.01,
        },
    });
    figures
}

fn heuristic() -> Vec<Figure> {
    let densities = [0.0, 1e-38, 1e-23, 1e-3, 1.0, 7.0, 1e20, 3e38, f32::INFINITY];
    let (mut worst, mut invalid, mut invalid_naive) = (0.0f64, 0u32, 0u32);
    for (a, b) in densities.iter().flat_map(|a| densities.map(|b| (*a, b))) {
        // Two strategies that both cannot take a direction, or both take nothing else, do not
        // meet.
        if a == b && (a == 0.0 || a == f32::INFINITY) {
            continue;
        }
        let (wa, wb) = (power_heuristic(a, b), power_heuristic(b, a));
        worst = worst.max(f64::from((wa + wb - 1.0).abs()));
        invalid += u32::from(!((0.0..=1.0).contains(&wa) && wa.is_finite()));
        let naive = a * a / (a * a + b * b);
        invalid_naive += u32::from(!(0.0..=1.0).contains(&naive));
    }
    vec![
        Figure {
            what: "weights that are not from 0 to 1",
            naive: Some(invalid_naive.into()),
            lightbox: invalid.into(),
            bound: Bound::Exactly(0.0),
        },
        Figure {
            what: "largest deviation from 1 of the sum of both",
            naive: None,
            lightbox: worst,
            bound: Bound::AtMost(2e-7),
        },
    ]
}

fn seen_light() -> Vec<Figure> {
    // A camera before a wall of mirror above a lamp below; the mirror shows another lamp, behind.
    let text = "
[camera]
eye = [0, 0, 0]
target = [0, 0, -1]
fov = 90
[render]
width = 4
height = 4
samples = 4
[[material]]
name = 'mirror'
mirror = 1
mirror_color = [0.5, 0.5, 0.5]
[[material]]
name = 'lamp'
albedo = [0.5, 0.5, 0.5]
emission = [18.387, 13.9873, 6.75357]
[[quad]]
material = 'mirror'
corners = [[-9, 0, -1], [9, 0, -1], [9, 9, -1], [-9, 9, -1]]
[[quad]]
material = 'lamp'
corners = [[-9, -9, -1], [9, -9, -1], [9, 0, -1], [-9, 0, -1]]
[[quad]]
material = 'lamp'
corners = [[9, -40, 1], [-9, -40, 1], [-9, 40, 1], [9, 40, 1]]
";
    let scene = scene(text);
    let light = glam::Vec3::new(18.387, 13.9873, 6.75357);
    let mut wrong = 0;
    for method in Method::ALL {
        // Cut where the lamp is the last segment: at 1 for the lower half, at 2 for the mirror.
        for depth in [1, 2] {
            let image = picture(&view(&scene, |s| (s.method, s.depth) = (*method, depth)));
            for (i, p) in image.pixels.iter().enumerate() {
                let (is_mirror, sees) = (i < 8, depth == 2);
                let expected = match (is_mirror, sees) {
                    (true, false) => glam::Vec3::ZERO,
                    (true, true) => 0.5 * light,
                    // One more segment adds what the other lamp sends here.
                    (false, true) => continue,
                    (false, false) => light,
                };
                // A mean of equal numbers may be off by its last bit.
                let off = (*p - expected).abs().cmpgt(f32::EPSILON * expected);
                wrong += u32::from(off.any());
            }
        }
    }
    vec![Figure {
        what: "pixels that do not show L or ρL to the last bit, all methods, depths 1 and 2",
        naive: None,
        lightbox: wrong.into(),
        bound: Bound::Exactly(0.0),
    }]
}
