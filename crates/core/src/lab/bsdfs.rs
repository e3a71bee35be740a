//! Scattering at surfaces. Mirrors and glass are in `specular`.

use std::f64::consts::{PI, TAU};

use glam::Vec3;

use super::stats::{CHI_SQUARE_63, Comparisons, Replicates, cell, chi_square};
use super::trial::{LAST, closed_box, is_accepted, numbers, path, replicates, view};
use super::{Bound, Case, Check, Figure, gallery, specular};
use crate::bsdf::Bsdf;
use crate::math::{Frame, warp};
use crate::sampler::{Dim, Sampler};
use crate::settings::UNLIMITED;
use crate::{Method, SamplerKind};

pub(super) const CASES: &[Case] = &[
    Case {
        id: "B01",
        title: "cosine sampling at the ends of the range",
        failure: "The concentric map divides 0 by 0 in the middle of the disk, and a direction in \
                  the surface has weight 0/0.",
        cure: "The middle is a case of its own, and a direction with cos θ = 0 is none.",
        check: Check::Probe(cosine_sampling),
        scene: None,
        picture: None,
    },
    Case {
        id: "B02",
        title: "frames around directions near −z",
        failure: "The short formula 1/(1 + n_z) divides by 0 at −z and loses all digits near it \
                  (Frisvad 2012).",
        cure: "The sign of n_z chooses the pole (Duff et al. 2017).",
        check: Check::Probe(frames),
        scene: None,
        picture: None,
    },
    Case {
        id: "B03",
        title: "a light seen only in mirrors",
        failure: "Light sampling cannot aim through a mirror, and a weight for light run into \
                  takes away the only way there is: the mirror is dark.",
        cure: "After a delta lobe light run into counts fully.",
        check: Check::Probe(specular::mirrors),
        scene: Some("builtin:lab/mirror-only.toml"),
        picture: Some(gallery::mirror_only),
    },
    Case {
        id: "B04",
        title: "Fresnel at the critical angle, at grazing, without boundary",
        failure: "The root of a negative number beyond the critical angle; 0/0 at grazing.",
        cure: "Total reflection is a branch of its own; indices below 0.2 are refused.",
        check: Check::Probe(specular::fresnel_angles),
        scene: None,
        picture: None,
    },
    Case {
        id: "B05",
        title: "a lossless glass sphere in uniform light",
        failure: "A factor η² too many, or paths lost in total reflection, show as a rim.",
        cure: "Paths carry radiance over n² (Veach 1997), and unlimited depth.",
        check: Check::Probe(specular::glass_furnace),
        scene: Some("builtin:white-furnace.toml"),
        picture: None,
    },
    Case {
        id: "B06",
        title: "a closed box of albedo 1",
        failure: "A path that survives with probability 1 never ends.",
        cure: "Roulette takes at least one path in twenty at each bounce, at any throughput; \
               reflectances above 1 are refused.",
        check: Check::Probe(albedo_one),
        scene: Some("builtin:lab/albedo-one.toml"),
        picture: Some(gallery::albedo_one),
    },
    Case {
        id: "B07",
        title: "two hundred mirrors in a row",
        failure: "Each reflection in f32 changes the length of the direction a little; t is then no \
                  distance, and at last NaN.",
        cure: "Directions are normalised at each bounce.",
        check: Check::Probe(specular::mirror_chain),
        scene: Some("builtin:lab/mirror-box.toml"),
        picture: Some(gallery::mirror_box),
    },
    Case {
        id: "B08",
        title: "interpolated normals",
        failure: "A shading normal that disagrees with the surface leaks light or leaves seams.",
        cure: "There are none.",
        check: Check::Absent(
            "surfaces are shaded by their geometric normals; normals in files are not used",
        ),
        scene: None,
        picture: None,
    },
];

fn cosine_sampling() -> Vec<Figure> {
    let grey = Bsdf::Diffuse(Vec3::splat(0.25));
    let (mut invalid, mut invalid_naive) = (0u32, 0u32);
    for u in [0.0, 0.5, LAST]
        .into_iter()
        .flat_map(|x| [[x, 0.0], [x, 0.5], [x, LAST]])
    {
        // The disk by the ratio of the two offsets, the weight by division.
        let [a, b] = u.map(|u| 2.0 * u - 1.0);
        let (r, phi) = if a.abs() > b.abs() {
            (a, b / a * std::f32::consts::FRAC_PI_4)
        } else {
            (b, (2.0 - a / b) * std::f32::consts::FRAC_PI_4)
        };
        let cos = (1.0 - (r * phi.cos()).powi(2) - (r * phi.sin()).powi(2)).sqrt();
        invalid_naive += u32::from(!(0.25 * cos / cos).is_finite());
        if let Some(s) = grey.sample(Vec3::Z, Vec3::Z, true, || 0.5, || u) {
            let fine = s.wi.is_finite() && s.wi.z > 0.0 && s.pdf > 0.0 && s.pdf.is_finite();
            invalid += u32::from(!fine || s.weight != Vec3::splat(0.25));
        }
    }
    let n_samples = 100_000;
    let (mut worst, mut worst_pdf) = (0.0f64, 0.0f64);
    for n in [
        Vec3::Z,
        -Vec3::Z,
        Vec3::new(0.6, 0.0, -0.8),
        Vec3::new(-0.48, 0.6, 0.64),
    ] {
        let frame = Frame::around(n);
        let mut observed = [0.0; 64];
        for i in 0..n_samples {
            let u = numbers(i, Dim::BsdfDirection(0));
            let Some(s) = grey.sample(n, n, true, || 0.5, || u) else {
                continue;
            };
            let (cos, x, y) = (s.wi.dot(n), s.wi.dot(frame.s), s.wi.dot(frame.t));
            invalid += u32::from(!(cos > 0.0));
            worst_pdf = worst_pdf
                .max((f64::from(s.pdf) - f64::from(cos) / PI).abs())
                .max(f64::from((s.pdf - grey.pdf(cos)).abs()));
            // Equal counts in equal steps of cos² θ and φ.
            let turn = f64::from(y).atan2(f64::from(x)) / TAU + 0.5;
            observed[cell([1.0 - f64::from(cos * cos), turn])] += 1.0;
        }
        worst = worst.max(chi_square(&observed, &[f64::from(n_samples) / 64.0; 64]));
    }
    // A blend keeps its energy in the mean, whichever lobe is drawn.
    let blend = Bsdf::Blend {
        diffuse: Vec3::splat(0.3),
        mirror: Vec3::splat(0.6),
    };
    let energy = Replicates::of(|seed| {
        let sum: f64 = (0..1000u32)
            .filter_map(|i| {
                let sampler = Sampler::new(SamplerKind::Independent, seed, [i, 5], 0);
                let [choice, _] = sampler.get_2d(Dim::Lobe(0));
                let u = sampler.get_2d(Dim::BsdfDirection(0));
                blend.sample(Vec3::Z, Vec3::Z, true, || choice, || u)
            })
            .map(|s| f64::from(s.weight.x))
            .sum();
        sum / 1000.0
    });
    vec![
        Figure {
            what: "directions below the surface or not finite",
            naive: Some(invalid_naive.into()),
            lightbox: invalid.into(),
            bound: Bound::Exactly(0.0),
        },
        Figure {
            what: "largest χ² of directions in 64 cells",
            naive: None,
            lightbox: worst,
            bound: Bound::AtMost(CHI_SQUARE_63),
        },
        Figure {
            what: "largest difference of densities, 1/sr",
            naive: None,
            lightbox: worst_pdf,
            bound: Bound::AtMost(1e-6),
        },
        Figure {
            what: "energy given back by a blend of 0.3 and 0.6",
            naive: None,
            lightbox: energy.mean(),
            bound: Bound::Within {
                truth: 0.9,
                tolerance: 1e-4,
            },
        },
    ]
}

fn frames() -> Vec<Figure> {
    // Deviation of the frame from an orthonormal one, ulp of 1.
    let deviation = |s: Vec3, t: Vec3, n: Vec3| {
        [s.dot(s) - 1.0, t.dot(t) - 1.0, s.dot(t), s.dot(n), t.dot(n)]
            .map(|x| f64::from(x.abs() / f32::EPSILON))
            .into_iter()
            .fold(0.0, |worst, x| if x <= worst { worst } else { x })
    };
    let worse = |worst: f64, x: f64| if x <= worst { worst } else { x };
    let (mut worst, mut worst_naive, mut left_handed) = (0.0, 0.0, 0u32);
    let mut try_direction = |n: Vec3| {
        let frame = Frame::around(n);
        worst = worse(worst, deviation(frame.s, frame.t, n));
        left_handed += u32::from(!(frame.s.cross(frame.t).dot(n) > 0.999));
        let a = 1.0 / (1.0 + n.z);
        let b = -n.x * n.y * a;
        let s = Vec3::new(1.0 - n.x * n.x * a, b, -n.x);
        let t = Vec3::new(b, 1.0 - n.y * n.y * a, -n.y);
        worst_naive = worse(worst_naive, deviation(s, t, n));
    };
    for n in [
        Vec3::Z,
        -Vec3::Z,
        Vec3::new(-0.0, -0.0, -1.0),
        Vec3::X,
        -Vec3::Y,
    ] {
        try_direction(n);
    }
    for i in 0..500_000 {
        let u = numbers(i, Dim::Pixel);
        try_direction(warp::uniform_sphere(u));
        // And close to the pole of the short formula.
        try_direction(Vec3::new(u[0] * 1e-3, u[1] * 1e-3, -1.0).normalize());
    }
    vec![
        Figure {
            what: "largest deviation from orthonormal over 10⁶ directions, ulp",
            naive: Some(worst_naive),
            lightbox: worst,
            bound: Bound::AtMost(4.0),
        },
        Figure {
            what: "left-handed frames",
            naive: None,
            lightbox: left_handed.into(),
            bound: Bound::Exactly(0.0),
        },
    ]
}

fn albedo_one() -> Vec<Figure> {
    let scene = closed_box(1.0);
    let view = view(&scene, |s| s.depth = UNLIMITED);
    let longest = (0..20_000u32).map(|i| {
        let sampler = Sampler::new(SamplerKind::Independent, 3, [i, 0], 0);
        let ray = view.camera.ray([i % 8, i / 8 % 8], [0.0; 2]);
        path(&scene, Method::Naive, ray, sampler).1
    });
    let longest = longest.max().unwrap_or(u64::MAX);
    let mut comparisons = Comparisons::default();
    for method in Method::ALL {
        let means = replicates(&scene, |s| {
            (s.method, s.samples, s.depth) = (*method, 16, 12)
        });
        comparisons.mean(&means, 12.0);
    }
    let mut figures = vec![Figure {
        what: "segments of the longest of 20 000 paths without limit",
        naive: Some(f64::INFINITY),
        lightbox: longest as f64,
        // The chance that one of them is longer is 2·10⁴·0.95⁵⁰⁰ = 10⁻⁷.
        bound: Bound::AtMost(503.0),
    }];
    let above = [1.0f32.next_up(), 2.0, f32::INFINITY];
    let accepted = above.iter().filter(|x| {
        let text = format!("[[material]]\nname = 'a'\nalbedo = [0.5, {x:?}, 0.5]\n");
        is_accepted(&text)
    });
    figures.push(Figure {
        what: "reflectances above 1 accepted",
        naive: None,
        lightbox: accepted.count() as f64,
        bound: Bound::Exactly(0.0),
    });
    figures.extend(comparisons.figures(
        "largest deviation of the sum cut at 12 segments, critical distances",
        None,
        0.03,
    ));
    figures
}
