//! The sampling of lights by itself: densities, solid angles, probabilities, inputs at the edge.

use std::sync::Arc;

use glam::Vec3;

use super::stats::{CHI_SQUARE_63, cell, chi_square};
use super::trial::{LAST, lamps, numbers, quad, sphere};
use super::{Bound, Figure};
use crate::Scene;
use crate::geometry::Primitives;
use crate::integrator::power_heuristic;
use crate::light::Lights;
use crate::math::Ray;
use crate::sampler::Dim;

/// A square light of edge 1 around the origin that shines towards +z.
const SQUARE: &str = "[-0.5, -0.5, 0], [0.5, -0.5, 0], [0.5, 0.5, 0], [-0.5, 0.5, 0]";

/// A rectangle, a slanted parallelogram, a kite of two triangles and a sphere.
fn all_kinds() -> Arc<Scene> {
    lamps(
        &(quad("lamp", SQUARE)
            + &quad(
                "lamp",
                "[3, 0, 0], [3.7, 0.3, 0], [4, 1, 0.2], [3.3, 0.7, 0.2]",
            )
            + &quad("lamp", "[0, 3, 0], [1, 3.5, 0], [0, 5, 0], [-1, 3.5, 0]")
            + &sphere("lamp", [-3.0, 0.0, 0.0], 1.0)),
    )
}

/// 4·atan(ab/(2d√(4d² + a² + b²))) for a = b = 1.
fn solid_angle_of_square(d: f64) -> f64 {
    4.0 * (1.0 / (2.0 * d * (4.0 * d * d + 2.0).sqrt())).atan()
}

/// Solid angle of the square from a point above it: of its four parts with a corner under `p`.
fn solid_angle_above(p: Vec3) -> f64 {
    let [x, y, z] = p.to_array().map(f64::from);
    let part = |a: f64, b: f64| (a * b / (z * (a * a + b * b + z * z).sqrt())).atan();
    part(0.5 - x, 0.5 - y)
        + part(0.5 + x, 0.5 - y)
        + part(0.5 + x, 0.5 + y)
        + part(0.5 - x, 0.5 + y)
}

/// The solid angle in front of `p` as lightbox samples it: the mean of 1/density.
fn sampled_angle(scene: &Scene, p: Vec3) -> f64 {
    let n = 1024;
    let inverse = (0..n).map(|i| {
        let u = numbers(i, Dim::LightPoint(0));
        let sample = scene.lights().sample(p, || 0.5, || u);
        sample.map_or(f64::NAN, |s| 1.0 / f64::from(s.pdf))
    });
    inverse.sum::<f64>() / f64::from(n)
}

/// The sum of the inner angles less 2π, in f32, by normals of the sides.
fn naive_angle(p: Vec3) -> f32 {
    let corners = [[-0.5, -0.5], [0.5, -0.5], [0.5, 0.5], [-0.5, 0.5]]
        .map(|[x, y]: [f32; 2]| Vec3::new(x, y, 0.0) - p);
    let normal = |i: usize| corners[i].cross(corners[(i + 1) % 4]).normalize();
    let n = [normal(0), normal(1), normal(2), normal(3)];
    let angles: f32 = (0..4).map(|i| (-n[i].dot(n[(i + 1) % 4])).acos()).sum();
    angles - std::f32::consts::TAU
}

pub(super) fn distant() -> Vec<Figure> {
    let scene = lamps(&quad("lamp", SQUARE));
    let (mut worst, mut worst_naive) = (0.0f64, 0.0f64);
    for d in [0.001, 0.1, 1.0, 10.0, 100.0, 300.0, 1000.0, 3000.0] {
        let p = Vec3::new(0.0, 0.0, d as f32);
        let truth = solid_angle_of_square(d);
        let error = (sampled_angle(&scene, p) / truth - 1.0).abs();
        worst = if error <= worst { worst } else { error };
        worst_naive = worst_naive.max((f64::from(naive_angle(p)) / truth - 1.0).abs());
    }
    let mut figures = vec![Figure {
        what: "largest relative error of the solid angle",
        naive: Some(worst_naive),
        lightbox: worst,
        bound: Bound::AtMost(1e-4),
    }];
    let shares = [
        Vec3::new(0.1, -0.2, 0.4),
        Vec3::new(-0.49, 0.3, 0.02),
        Vec3::new(1.5, 0.2, 0.3),
    ]
    .map(|p| samples_by_solid_angle(&scene, p));
    figures.push(Figure {
        what: "largest χ² of samples in 64 cells by solid angle",
        naive: Some(
            shares
                .iter()
                .map(|[_, by_area]| *by_area)
                .fold(0.0, f64::max),
        ),
        lightbox: shares
            .iter()
            .map(|[sampled, _]| *sampled)
            .fold(0.0, f64::max),
        bound: Bound::AtMost(CHI_SQUARE_63),
    });
    figures
}

/// χ² against the solid angle of each of 8×8 cells, integrated: of lightbox's samples, and of
/// samples uniform over the area.
fn samples_by_solid_angle(scene: &Scene, p: Vec3) -> [f64; 2] {
    let mut expected = [0.0; 64];
    let steps = 400;
    for i in 0..steps * steps {
        let at = [i % steps, i / steps].map(|k| (f64::from(k) + 0.5) / f64::from(steps));
        let d = p.as_dvec3() - glam::DVec3::new(at[0] - 0.5, at[1] - 0.5, 0.0);
        expected[cell(at)] += d.z / d.length().powi(3);
    }
    let n = 100_000;
    let total: f64 = expected.iter().sum();
    let expected = expected.map(|e| e / total * f64::from(n));
    let (mut observed, mut by_area) = ([0.0; 64], [0.0; 64]);
    for i in 0..n {
        let u = numbers(i, Dim::LightPoint(1));
        by_area[cell(u.map(f64::from))] += 1.0;
        if let Some(sample) = scene.lights().sample(p, || 0.5, || u) {
            let q = sample.point.p.as_dvec3() + 0.5;
            observed[cell([q.x, q.y])] += 1.0;
        }
    }
    [observed, by_area].map(|counts| chi_square(&counts, &expected))
}

pub(super) fn grazing() -> Vec<Figure> {
    let scene = lamps(&quad("lamp", SQUARE));
    // The foot lies within the square, so that about half of all directions meet it.
    let (mut worst, mut worst_naive) = (0.0f64, 0.0f64);
    for [x, y] in [[0.0, 0.0], [0.4, -0.3], [0.499, 0.499]] {
        for height in [1e-2, 1e-4, 1e-6] {
            let p = Vec3::new(x, y, height);
            let truth = solid_angle_above(p);
            worst = worst.max((sampled_angle(&scene, p) / truth - 1.0).abs());
            let error = (f64::from(naive_angle(p)) / truth - 1.0).abs();
            worst_naive = if error <= worst_naive {
                worst_naive
            } else {
                error
            };
        }
    }
    // In the plane: beside the square, on its edge, on a corner, within it.
    let in_plane = [[2.0, 0.0], [0.5, 0.1], [0.5, 0.5], [0.2, 0.1], [0.0, 0.0]];
    let (mut samples, mut invalid_naive) = (0u32, 0u32);
    for [x, y] in in_plane {
        let p = Vec3::new(x, y, 0.0);
        invalid_naive += u32::from(!naive_angle(p).is_finite() || naive_angle(p) > 0.0);
        for u in [[0.0, 0.0], [0.5, 0.5], [LAST, LAST]] {
            samples += u32::from(scene.lights().sample(p, || 0.5, || u).is_some());
        }
    }
    vec![
        Figure {
            what: "largest relative error of nearly 2π sr, down to 10⁻⁶ above the light",
            naive: Some(worst_naive),
            lightbox: worst,
            bound: Bound::AtMost(1e-4),
        },
        Figure {
            what: "samples from points in the light's plane",
            naive: Some(invalid_naive.into()),
            lightbox: samples.into(),
            bound: Bound::Exactly(0.0),
        },
    ]
}

/// Numbers at the edges of what floats are, and random bits.
fn odd_number(i: u32, k: u32) -> f32 {
    let special = [
        0.0,
        -0.0,
        0.5,
        -0.5,
        1e-6,
        1e-38,
        -2.0,
        -3.0,
        1e10,
        1e18,
        f32::MIN_POSITIVE,
    ];
    let bits = i
        .wrapping_mul(2_654_435_761)
        .wrapping_add(k.wrapping_mul(0x9e37_79b9))
        .rotate_left(k * 7);
    if bits & 1 == 0 {
        special[(bits >> 8) as usize % special.len()]
    } else {
        f32::from_bits(bits)
    }
}

pub(super) fn edges() -> Vec<Figure> {
    let scene = all_kinds();
    let (mut drawn, mut invalid, mut invalid_naive) = (0u32, 0u32, 0u32);
    for i in 0..20_000 {
        let p = Vec3::new(odd_number(i, 1), odd_number(i, 2), odd_number(i, 3));
        if !p.abs().cmple(Vec3::splat(1e18)).all() {
            continue;
        }
        for u in [[0.0, 0.0], [0.5, 0.5], [LAST, LAST], [0.0, LAST]] {
            // Uniform over the square, density d²/|cos| without a second look.
            let q = Vec3::new(u[0] - 0.5, u[1] - 0.5, 0.0);
            let d = p - q;
            let pdf = d.length_squared() / (d.z.abs() / d.length());
            invalid_naive += u32::from(!(pdf.is_finite() && pdf > 0.0));
            for pick in [0.0, 0.5, LAST] {
                if let Some(s) = scene.lights().sample(p, || pick, || u) {
                    drawn += 1;
                    let fine = s.pdf.is_finite() && s.pdf > 0.0 && s.point.p.is_finite();
                    invalid += u32::from(!fine);
                }
            }
        }
    }
    vec![
        Figure {
            what: "densities that are 0, infinite or NaN",
            naive: Some(invalid_naive.into()),
            lightbox: invalid.into(),
            bound: Bound::Exactly(0.0),
        },
        Figure {
            what: "samples drawn",
            naive: None,
            lightbox: drawn.into(),
            bound: Bound::AtLeast(10_000.0),
        },
    ]
}

pub(super) fn measures() -> Vec<Figure> {
    let scene = all_kinds();
    let (lights, primitives) = (scene.lights(), scene.primitives());
    let (mut differ, mut worst_hit) = (0u32, 0.0f64);
    let (mut worst_sum, mut worst_naive) = (0.0f64, 0.0f64);
    for i in 0..20_000 {
        let [x, y] = numbers(i, Dim::Pixel);
        let [z, pick] = numbers(i, Dim::LightPick(0));
        let p = Vec3::new(10.0 * x - 5.0, 8.0 * y - 3.0, 0.01 + 3.0 * z);
        let u = numbers(i, Dim::LightPoint(0));
        let Some(sample) = lights.sample(p, || pick, || u) else {
            continue;
        };
        let asked = lights.pdf(p, sample.prim, sample.point.p);
        differ += u32::from(asked != sample.pdf);
        // What a path along the same direction asks when it runs into the light.
        let toward = sample.point.p - p;
        let ray = Ray::new(p, toward.normalize());
        if let Some(hit) = scene.intersect(&ray).filter(|hit| hit.prim == sample.prim) {
            let q = primitives.surface_point(&ray, &hit).p;
            let found = lights.pdf(p, hit.prim, q);
            // Seen edge-on, the density of a direction changes faster than f32 can tell.
            let cos = sample.point.n.dot(-ray.dir);
            let error = f64::from((found / sample.pdf - 1.0).abs() * cos);
            worst_hit = worst_hit.max(error);
        }
        // The weights of the two strategies that could have taken this direction.
        let bsdf = std::f32::consts::FRAC_1_PI * ray.dir.z.abs();
        let sum = |told: f32, asked: f32| {
            f64::from(power_heuristic(told, bsdf) + power_heuristic(bsdf, asked))
        };
        worst_sum = worst_sum.max((sum(sample.pdf, asked) - 1.0).abs());
        // A fifth of the lights each, near enough.
        let per_area = 0.2 / primitives.area(sample.prim);
        worst_naive = worst_naive.max((sum(sample.pdf, per_area) - 1.0).abs());
    }
    vec![
        Figure {
            what: "largest deviation from 1 of the sum of two weights",
            naive: Some(worst_naive),
            lightbox: worst_sum,
            bound: Bound::AtMost(2e-7),
        },
        Figure {
            what: "samples of which another density is told than was used",
            naive: None,
            lightbox: differ.into(),
            bound: Bound::Exactly(0.0),
        },
        Figure {
            what: "largest relative difference where a ray runs into the light, times cos",
            naive: None,
            lightbox: worst_hit,
            bound: Bound::AtMost(1e-4),
        },
    ]
}

/// Choices, of those at the ends of the range, of a lamp that has no area in f32, alone or beside
/// one that has.
fn without_area() -> usize {
    let minute = quad(
        "lamp",
        "[0, 0, 0], [1e-25, 0, 0], [1e-25, 1e-25, 0], [0, 1e-25, 0]",
    );
    let beside = "[1, 0, 0], [2, 0, 0], [2, 1, 0], [1, 1, 0]";
    let chosen = |shapes: String| {
        let scene = lamps(&shapes);
        let sample = |u| {
            scene
                .lights()
                .sample(Vec3::new(0.1, 0.2, 1.0), || u, || [u; 2])
        };
        let drawn = [0.0, 0.5, LAST].into_iter().filter_map(sample);
        drawn.filter(|sample| sample.prim == 0).count()
    };
    chosen(minute.clone()) + chosen(minute + &quad("lamp", beside))
}

pub(super) fn powers() -> Vec<Figure> {
    // Triangles side by side, all the same but for their power.
    let n = 1_000_000u32;
    let triangle = |i: u32| {
        let corner = |x: u32, y: f32| Vec3::new((i + x) as f32, y, 0.0);
        [corner(0, 0.0), corner(1, 0.0), corner(1, 1.0)]
    };
    let primitives = Primitives {
        triangles: Vec::from_iter((0..n).map(triangle)).into(),
        ..Primitives::default()
    };
    let lights = |powers: &[f64]| {
        let emitters = powers.iter().enumerate();
        Lights::new(&primitives, emitters.map(|(i, power)| (i as u32, *power)))
    };

    // 0 by 0, extremes, and no light at all.
    let nothing = [lights(&[0.0, 0.0, f64::NAN]), lights(&[])];
    let extreme = lights(&[1e30, 1e-30, 0.0]);
    let numbers_at_the_ends = [0.0, 0.5, LAST];
    let wrong = numbers_at_the_ends.iter().filter(|u| {
        nothing.iter().any(|lights| lights.pick(|| **u).is_some())
            || extreme.pick(|| **u).is_none_or(|(_, p)| !(p > 0.0))
    });
    let wrong = wrong.count() + without_area();

    let power = |i: usize| 0.1 + (i % 7) as f64;
    let powers: Vec<f64> = (0..n as usize).map(power).collect();
    let many = lights(&powers);
    let sum: f64 = (0..many.len())
        .map(|i| f64::from(many.probability(i)))
        .sum();
    // A cumulative sum in f32 of shares of a sum in f32.
    let total = powers.iter().fold(0.0f32, |sum, p| sum + *p as f32);
    let last = powers.iter().fold(0.0f32, |sum, p| sum + *p as f32 / total);
    let mut differ = 0u32;
    for i in 0..10_000 {
        let [pick, x] = numbers(i, Dim::LightPick(3));
        let p = Vec3::new(x * n as f32, 0.5, 1.0);
        let u = numbers(i, Dim::LightPoint(3));
        if let Some(sample) = many.sample(p, || pick, || u) {
            let asked = many.pdf(p, sample.prim, sample.point.p);
            differ += u32::from(asked != sample.pdf);
        }
    }

    let few = lights(&powers[..64]);
    let total: f64 = powers[..64].iter().sum();
    let samples = 100_000;
    let expected = std::array::from_fn(|i| power(i) / total * f64::from(samples));
    let mut observed = [0.0; 64];
    for i in 0..samples {
        let [u, _] = numbers(i, Dim::LightPick(4));
        if let Some((chosen, _)) = few.pick(|| u) {
            observed[chosen] += 1.0;
        }
    }
    vec![
        Figure {
            what: "sum of a million probabilities",
            naive: Some(last.into()),
            lightbox: sum,
            bound: Bound::Within {
                truth: 1.0,
                tolerance: 1e-6,
            },
        },
        Figure {
            what: "choices without a light, or of one without power or area",
            naive: None,
            lightbox: wrong as f64,
            bound: Bound::Exactly(0.0),
        },
        Figure {
            what: "samples of a million lights of which another density is told",
            naive: None,
            lightbox: differ.into(),
            bound: Bound::Exactly(0.0),
        },
        Figure {
            what: "χ² of 64 lights chosen by power",
            naive: None,
            lightbox: chi_square(&observed, &expected),
            bound: Bound::AtMost(CHI_SQUARE_63),
        },
    ]
}
