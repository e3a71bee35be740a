//! Sampling against its density: solid angles, χ² from independent numbers, and inputs at the
//! edge.

use std::f64::consts::{PI, TAU};

use glam::Vec3;
use lightbox_core::bsdf::Bsdf;
use lightbox_core::sampler::{Dim, Sampler};
use lightbox_core::{SamplerKind, Scene};
use lightbox_tests::{scene, stats::assert_chi_square};

fn numbers(i: u32, dim: Dim) -> [f32; 2] {
    Sampler::new(SamplerKind::Independent, 77, [i, 3], 0).get_2d(dim)
}

/// A scene with lights of radiance 1 only.
fn lamps(shapes: &str) -> Scene {
    scene(&format!(
        "[[material]]\nname = 'lamp'\nemission = [1, 1, 1]\n{shapes}"
    ))
}

fn quad(corners: &str) -> String {
    format!("[[quad]]\nmaterial = 'lamp'\ncorners = [{corners}]\n")
}

const UNIT_SQUARE: &str = "[-0.5, -0.5, 0], [0.5, -0.5, 0], [0.5, 0.5, 0], [-0.5, 0.5, 0]";

/// 4·atan(ab/(2d√(4d² + a² + b²))) for a = b = 1.
fn solid_angle_of_unit_square(d: f64) -> f64 {
    4.0 * (1.0 / (2.0 * d * (4.0 * d * d + 2.0).sqrt())).atan()
}

#[test]
fn density_of_a_rectangle_is_one_over_its_solid_angle() {
    let scene = lamps(&quad(UNIT_SQUARE));
    for d in [
        0.001, 0.1, 0.5, 1.0, 3.0, 10.0, 100.0, 300.0, 1000.0, 3000.0,
    ] {
        let p = Vec3::new(0.0, 0.0, d as f32);
        let n = 4096;
        let sum: f64 = (0..n)
            .map(|i| {
                scene
                    .lights()
                    .sample(p, || 0.5, || numbers(i, Dim::LightPoint(0)))
            })
            .map(|sample| 1.0 / f64::from(sample.expect("it is in front").pdf))
            .sum();
        let ratio = sum / f64::from(n) / solid_angle_of_unit_square(d);
        assert!((ratio - 1.0).abs() < 1e-4, "distance {d}: {ratio}");
    }
}

#[test]
fn density_of_a_sample_is_what_is_told_when_asked() {
    let scene = lamps(
        &(quad(UNIT_SQUARE)
            + &quad("[3, 0, 0], [3.7, 0.3, 0], [4, 1, 0.2], [3.3, 0.7, 0.2]")
            + "[[sphere]]\nmaterial = 'lamp'\ncenter = [-3, 0, 0]\nradius = 1\n"),
    );
    let lights = scene.lights();
    for i in 0..20_000 {
        let [x, y] = numbers(i, Dim::Pixel);
        let [z, pick] = numbers(i, Dim::LightPick(0));
        let p = Vec3::new(10.0 * x - 5.0, 4.0 * y - 2.0, 0.01 + 3.0 * z);
        let Some(sample) = lights.sample(p, || pick, || numbers(i, Dim::LightPoint(0))) else {
            continue;
        };
        let asked = lights.pdf(p, sample.prim, sample.point.p);
        assert!(
            (asked / sample.pdf - 1.0).abs() < 2e-3,
            "{p}: {asked} and {}",
            sample.pdf
        );
    }
}

/// Where on a rectangle samples fall: the solid angle of each of 8×8 cells, integrated.
#[test]
fn rectangle_samples_are_uniform_in_solid_angle() {
    let scene = lamps(&quad(UNIT_SQUARE));
    for p in [
        Vec3::new(0.1, -0.2, 0.4),
        Vec3::new(-0.49, 0.3, 0.02),
        Vec3::new(1.5, 0.2, 0.3),
    ] {
        let mut expected = [0.0; 64];
        let steps = 800;
        for i in 0..steps * steps {
            let (x, y) = ((i % steps) as f64 + 0.5, (i / steps) as f64 + 0.5);
            let (x, y) = (x / steps as f64, y / steps as f64);
            let q = Vec3::new(x as f32 - 0.5, y as f32 - 0.5, 0.0).as_dvec3();
            let d = p.as_dvec3() - q;
            expected[(y * 8.0) as usize * 8 + (x * 8.0) as usize] += d.z / d.length().powi(3);
        }
        let n = 100_000;
        let mut observed = [0.0; 64];
        for i in 0..n {
            let u = numbers(i, Dim::LightPoint(1));
            let q = scene
                .lights()
                .sample(p, || 0.5, || u)
                .expect("in front")
                .point
                .p
                + 0.5;
            observed[((q.y * 8.0) as usize).min(7) * 8 + ((q.x * 8.0) as usize).min(7)] += 1.0;
        }
        let total: f64 = expected.iter().sum();
        let expected = expected.map(|e| e / total * f64::from(n));
        assert_chi_square(&observed, &expected, &format!("unit square from {p}"));
    }
}

/// Directions to a sphere are uniform over its cone: equal counts in equal steps of cos θ and φ.
#[test]
fn sphere_samples_are_uniform_in_the_cone() {
    let scene = lamps("[[sphere]]\nmaterial = 'lamp'\ncenter = [0, 0, 0]\nradius = 1\n");
    for distance in [1.001f32, 2.0, 50.0] {
        let p = Vec3::new(0.0, 0.0, distance);
        let cos_max = (1.0 - 1.0 / f64::from(distance).powi(2)).sqrt();
        let n = 100_000;
        let mut observed = [0.0; 64];
        for i in 0..n {
            let sample = scene
                .lights()
                .sample(p, || 0.5, || numbers(i, Dim::LightPoint(2)));
            let sample = sample.expect("outside");
            let d = (sample.point.p - p).as_dvec3().normalize();
            let (u, v) = ((1.0 + d.z) / (1.0 - cos_max), d.y.atan2(d.x) / TAU + 0.5);
            observed[((u * 8.0) as usize).min(7) * 8 + ((v * 8.0) as usize).min(7)] += 1.0;
            assert!((f64::from(sample.pdf) * TAU * (1.0 - cos_max) - 1.0).abs() < 1e-3);
        }
        assert_chi_square(
            &observed,
            &[f64::from(n) / 64.0; 64],
            &format!("sphere from {distance}"),
        );
    }
}

#[test]
fn lights_are_chosen_by_power() {
    let bright = "[[material]]\nname = 'bright'\nemission = [5, 5, 5]\n";
    let scene = lamps(
        &(bright.to_owned()
            + &quad(UNIT_SQUARE)
            + &quad("[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]")
            + "[[quad]]\nmaterial = 'bright'\ncorners = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]]\n"),
    );
    let n = 100_000;
    let mut observed = [0.0; 3];
    for i in 0..n {
        let [pick, _] = numbers(i, Dim::LightPick(1));
        let p = Vec3::new(0.0, 0.0, 1.0);
        observed[scene
            .lights()
            .sample(p, || pick, || [0.5; 2])
            .expect("in front")
            .prim as usize] += 1.0;
    }
    assert_chi_square(
        &observed,
        &[0.1, 0.4, 0.5].map(|share| share * f64::from(n)),
        "areas 1, 4, 1 times 1, 1, 5",
    );
}

/// Reference points on, in, behind and beside lights, at all magnitudes, with numbers at the ends
/// of their range: a density is finite and positive or there is no sample.
#[test]
fn light_sampling_survives_any_reference_point() {
    let scene = lamps(
        &(quad(UNIT_SQUARE)
            + &quad("[3, 0, 0], [3.7, 0.3, 0], [4, 1, 0.2], [3.3, 0.7, 0.2]")
            + "[[sphere]]\nmaterial = 'lamp'\ncenter = [-3, 0, 0]\nradius = 1\n"),
    );
    let last = 1.0 - f32::EPSILON / 2.0;
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
    let mut tried = 0;
    for i in 0..50_000u32 {
        let number = |k: u32| {
            let bits = i
                .wrapping_mul(2_654_435_761)
                .wrapping_add(k.wrapping_mul(0x9e37_79b9))
                .rotate_left(k * 7);
            if bits & 1 == 0 {
                special[(bits >> 8) as usize % special.len()]
            } else {
                f32::from_bits(bits)
            }
        };
        let p = Vec3::new(number(1), number(2), number(3));
        if !(p.abs().cmple(Vec3::splat(1e18)).all()) {
            continue;
        }
        for u in [[0.0, 0.0], [0.5, 0.5], [last, last], [0.0, last]] {
            for pick in [0.0, 0.5, last] {
                if let Some(s) = scene.lights().sample(p, || pick, || u) {
                    assert!(
                        s.pdf.is_finite() && s.pdf > 0.0 && s.point.p.is_finite(),
                        "{p} {u:?}: {s:?}"
                    );
                    tried += 1;
                }
            }
        }
    }
    assert!(tried > 10_000, "only {tried} samples were drawn");
}

/// Directions of a diffuse surface follow cos θ/π: equal counts in equal steps of cos² θ and φ;
/// the weight is the reflectance, and the density is what is told when asked.
#[test]
fn diffuse_directions_follow_the_cosine() {
    for n in [
        Vec3::Z,
        -Vec3::Z,
        Vec3::new(0.6, 0.0, -0.8),
        Vec3::new(-0.48, 0.6, 0.64),
    ] {
        let frame = lightbox_core::math::Frame::around(n);
        let count = 100_000;
        let mut observed = [0.0; 64];
        let bsdf = Bsdf::Diffuse(Vec3::splat(0.25));
        for i in 0..count {
            let u = numbers(i, Dim::BsdfDirection(0));
            let s = bsdf.sample(n, n, true, || 0.5, || u).expect("it scatters");
            let (cos, x, y) = (s.wi.dot(n), s.wi.dot(frame.s), s.wi.dot(frame.t));
            assert!(cos > 0.0 && s.weight == Vec3::splat(0.25));
            assert!(
                (s.pdf - bsdf.pdf(cos)).abs() < 1e-5
                    && (f64::from(s.pdf) - f64::from(cos) / PI).abs() < 1e-5
            );
            let (a, b) = (
                1.0 - f64::from(cos * cos),
                f64::from(y).atan2(f64::from(x)) / TAU + 0.5,
            );
            observed[((a * 8.0) as usize).min(7) * 8 + ((b * 8.0) as usize).min(7)] += 1.0;
        }
        assert_chi_square(
            &observed,
            &[f64::from(count) / 64.0; 64],
            &format!("normal {n}"),
        );
    }
}

/// The blend chooses its lobes in proportion and gives back all energy in the mean.
#[test]
fn blend_conserves_energy() {
    let bsdf = Bsdf::Blend {
        diffuse: Vec3::splat(0.3),
        mirror: Vec3::splat(0.6),
    };
    let n = 100_000;
    let wo = Vec3::new(0.6, 0.0, 0.8);
    let (mut specular, mut weight) = (0.0, 0.0);
    for i in 0..n {
        let [lobe, _] = numbers(i, Dim::Lobe(0));
        let s = bsdf
            .sample(
                wo,
                Vec3::Z,
                true,
                || lobe,
                || numbers(i, Dim::BsdfDirection(1)),
            )
            .expect("it scatters");
        specular += f64::from(u8::from(s.specular)) / f64::from(n);
        weight += f64::from(s.weight.x) / f64::from(n);
    }
    assert!((specular - 2.0 / 3.0).abs() < 0.01, "{specular}");
    assert!((weight - 0.9).abs() < 1e-4, "{weight}");
}

#[test]
fn glass_bends_by_snell_and_keeps_unit_length() {
    for ior in [1.0f32, 1.33, 1.5, 2.4] {
        for k in 0..90 {
            let theta = (f64::from(k) * PI / 180.0) as f32;
            let wo = Vec3::new(theta.sin(), 0.0, theta.cos());
            for (front, eta) in [(true, 1.0 / ior), (false, ior)] {
                // The last choice refracts unless all is reflected.
                let s = Bsdf::Glass(ior)
                    .sample(wo, Vec3::Z, front, || 1.0 - 1e-7, || [0.5; 2])
                    .expect("it scatters");
                assert!((s.wi.length() - 1.0).abs() < 4.0 * f32::EPSILON && s.weight == Vec3::ONE);
                if s.wi.z < 0.0 {
                    assert!(
                        (-s.wi.x - eta * wo.x).abs() < 1e-5,
                        "ior {ior}, {k}°: {}",
                        s.wi
                    );
                }
            }
        }
    }
}
