//! Lights seen from surfaces: what methods of direct light get wrong. The sampling of lights by
//! itself is in `light_sampling`.

use std::f64::consts::{PI, TAU};

use glam::Vec3;

use super::stats::{CHI_SQUARE_63, Comparisons, Replicates, cell, chi_square};
use super::trial::{
    FLOOR, RHO, lamps, mean, numbers, one_pixel, picture, quad, replicates, sphere, view,
};
use super::{Bound, Case, Check, Figure, gallery, light_sampling};
use crate::math::Frame;
use crate::sampler::{Dim, Sampler};
use crate::{Method, SamplerKind, Scene};

pub(super) const CASES: &[Case] = &[
    Case {
        id: "L01",
        title: "a light that touches the wall",
        failure: "Sampled by area, the light's nearest points come with densities that vanish like \
                  the distance squared: E[f²] grows like h⁻² towards the edge, and over the wall \
                  the variance is infinite.",
        cure: "Rectangles are sampled by solid angle (Ureña, Fajardo & King 2013), weighted with \
               directions of the BSDF (Veach & Guibas 1995).",
        check: Check::Probe(touching),
        scene: Some("builtin:lab/touching-light.toml"),
        picture: Some(gallery::touching_light),
    },
    Case {
        id: "L02",
        title: "reference points on, in and behind lights",
        failure: "Distance 0, a light seen edge-on, or a number at the end of its range give a \
                  density of 0/0 or ∞.",
        cure: "There is no sample unless its density is positive and finite.",
        check: Check::Probe(light_sampling::edges),
        scene: None,
        picture: None,
    },
    Case {
        id: "L03",
        title: "a lamp seen from the back",
        failure: "If aiming at lights ignores which side shines, or running into them does, the \
                  two disagree, and their weighted sum is wrong by the light of the back.",
        cure: "One rule for both: lamps shine from their front.",
        check: Check::Probe(one_sided),
        scene: None,
        picture: None,
    },
    Case {
        id: "L04",
        title: "solid angle of a distant rectangle",
        failure: "The sum of four angles less 2π cancels in f32: at 3000 edge lengths the solid \
                  angle is wrong by a factor.",
        cure: "Angles as complex numbers in f64, and sampling by area below 0.01 sr.",
        check: Check::Probe(light_sampling::distant),
        scene: None,
        picture: None,
    },
    Case {
        id: "L05",
        title: "just above a rectangle, and in its plane",
        failure: "Close to the light all cosines crowd at 1, in its plane normals of zero vectors \
                  are NaN.",
        cure: "Half the sphere of directions remains, exactly; from the plane there is no sample.",
        check: Check::Probe(light_sampling::grazing),
        scene: None,
        picture: None,
    },
    Case {
        id: "L06",
        title: "a sphere light from afar, close by, and from inside",
        failure: "1 − cos θ cancels to 0 in f32 from 4000 radii on: the density is infinite and \
                  the light goes out.",
        cure: "1 − cos θ as sin² θ/(1 + cos θ), and points by the law of sines expanded.",
        check: Check::Probe(spheres),
        scene: None,
        picture: None,
    },
    Case {
        id: "L07",
        title: "densities of one measure",
        failure: "A density per area weighed against one per solid angle: the two weights of a \
                  direction do not sum to 1.",
        cure: "Every density is per solid angle at the reference point, and what is told when \
               asked is what was used.",
        check: Check::Probe(light_sampling::measures),
        scene: None,
        picture: None,
    },
    Case {
        id: "L08",
        title: "lights of very different power, and a million of them",
        failure: "Powers of 0 divide by 0; a cumulative sum in f32 ends below 1, so that the last \
                  numbers choose a light beyond the end.",
        cure: "f64 sums without lights of no power, an index that cannot pass the end.",
        check: Check::Probe(light_sampling::powers),
        scene: None,
        picture: None,
    },
];

/// Form factor of an element to a rectangle perpendicular to its plane: at distance `c`, from
/// the plane to height `b`, to `a` on one side.
pub(super) fn perpendicular(a: f64, b: f64, c: f64) -> f64 {
    let d = (b * b + c * c).sqrt();
    ((a / c).atan() - c / d * (a / d).atan()) / (2.0 * PI)
}

/// Distances of the wall light.
const DISTANCES: [f64; 5] = [0.1, 0.03, 0.01, 3e-3, 1e-3];

/// The wall light at distance `h` from the origin.
fn wall_light(h: f64) -> String {
    quad(
        "lamp",
        &format!("[{h}, 0, -0.5], [{h}, 0, 0.5], [{h}, 1, 0.5], [{h}, 1, -0.5]"),
    )
}

fn touching() -> Vec<Figure> {
    let mut comparisons = Comparisons::default();
    for h in DISTANCES {
        let scene = one_pixel("[-2, 1, 1]", &(quad("grey", FLOOR) + &wall_light(h)));
        let truth = RHO * 2.0 * perpendicular(0.5, 1.0, h);
        for method in [Method::Nee, Method::Mis] {
            let means = replicates(&scene, |s| {
                (s.method, s.samples, s.depth) = (method, 1024, 2);
            });
            comparisons.mean(&means, truth);
        }
    }
    // And the overhead light, where BSDF sampling has a chance too.
    let lamp = quad(
        "lamp",
        "[-0.5, 1, -0.5], [0.5, 1, -0.5], [0.5, 1, 0.5], [-0.5, 1, 0.5]",
    );
    let scene = one_pixel("[1, 0.7, 3]", &(quad("grey", FLOOR) + &lamp));
    for method in Method::ALL {
        for sampler in SamplerKind::ALL {
            let means = replicates(&scene, |s| {
                (s.method, s.sampler, s.samples, s.depth) = (*method, *sampler, 4096, 2);
            });
            comparisons.mean(&means, RHO / PI * 0.752_274_7);
        }
    }
    let mut figures = comparisons.figures(
        "largest deviation from form factors, critical distances",
        None,
        0.05,
    );
    let growth = |second_moment: fn(f64) -> f64| {
        let at = DISTANCES.map(second_moment);
        at.into_iter().fold(0.0, f64::max) / at[0]
    };
    figures.push(Figure {
        what: "largest E[f²] at distances 10⁻¹ to 10⁻³ over that at 10⁻¹",
        naive: Some(growth(second_moment_by_area)),
        lightbox: growth(second_moment),
        bound: Bound::AtMost(2.0),
    });
    figures
}

/// E[f²] of the irradiance at the origin, estimated as lightbox samples the wall light.
fn second_moment(h: f64) -> f64 {
    let scene = lamps(&wall_light(h));
    let n = 20_000;
    let squares = (0..n).filter_map(|i| {
        let u = numbers(i, Dim::LightPoint(0));
        let sample = scene.lights().sample(Vec3::ZERO, || 0.5, || u)?;
        Some((f64::from(sample.point.p.normalize().y) / f64::from(sample.pdf)).powi(2))
    });
    squares.sum::<f64>() / f64::from(n)
}

/// The same for points uniform over the light, by quadrature: f = cos·cos'/d² has a peak that no
/// reasonable number of samples finds.
fn second_moment_by_area(h: f64) -> f64 {
    // Midpoints in log y and log z, from far below h up to the edges at 1 and ½.
    const STEPS: usize = 400;
    let least = h * 1e-4;
    let midpoints = |end: f64| {
        let step = (end / least).ln() / STEPS as f64;
        (0..STEPS).map(move |i| {
            let x = least * ((i as f64 + 0.5) * step).exp();
            (x, x * step)
        })
    };
    let mut sum = 0.0;
    for (y, dy) in midpoints(1.0) {
        for (z, dz) in midpoints(0.5) {
            let d2 = h * h + y * y + z * z;
            sum += 2.0 * (h * y / (d2 * d2)).powi(2) * dy * dz;
        }
    }
    sum
}

fn one_sided() -> Vec<Figure> {
    let backwards = quad(
        "lamp",
        "[-0.5, 1, -0.5], [-0.5, 1, 0.5], [0.5, 1, 0.5], [0.5, 1, -0.5]",
    );
    let scene = one_pixel("[1, 0.7, 3]", &(quad("grey", FLOOR) + &backwards));
    let back = Method::ALL.iter().map(|method| {
        mean(&picture(&view(&scene, |s| {
            (s.method, s.samples) = (*method, 256)
        })))
    });
    let mut figures = vec![Figure {
        what: "radiance of a floor under the back of a lamp",
        // |cos| in place of cos: the form factor of the front.
        naive: Some(RHO / PI * 0.752_274_7),
        lightbox: back.fold(0.0, f64::max),
        bound: Bound::Exactly(0.0),
    }];
    // Lights of all kinds from the front, beside one that turns its back: the strategies agree.
    let slanted = quad(
        "lamp",
        "[-0.5, 1, -0.5], [0.7, 1.3, -0.5], [1.0, 1.3, 0.5], [-0.2, 1, 0.5]",
    );
    let kite = quad("lamp", "[-1, 1, 0], [0, 1, -0.5], [0.5, 1, 0], [0, 1, 0.9]");
    let horizon = sphere("lamp", [0.9, 0.45, 0.0], 1.0);
    let mut comparisons = Comparisons::default();
    for lamp in [slanted, kite, horizon] {
        let behind = quad(
            "lamp",
            "[-1, 0.5, 1.2], [-1, 2, 1.2], [1, 2, 1.2], [1, 0.5, 1.2]",
        );
        let shapes = quad("grey", FLOOR) + &lamp + &behind;
        let scene = one_pixel("[1, 0.7, 3]", &shapes);
        let means = |method| {
            replicates(&scene, |s| {
                (s.method, s.samples, s.depth) = (method, 4096, 2)
            })
        };
        let naive = means(Method::Naive);
        comparisons.agree(&means(Method::Nee), &naive);
        comparisons.agree(&means(Method::Mis), &naive);
    }
    figures.extend(comparisons.figures(
        "largest disagreement of the methods, critical distances",
        None,
        0.04,
    ));
    figures
}

/// Irradiance from a sphere light of radius 1 at distance `d` above a surface tilted by 60°, or
/// facing it where the sphere would dip below the horizon: π(R/d)² cos θ.
fn spheres() -> Vec<Figure> {
    let lamp = lamps(&sphere("lamp", [0.0, 0.0, 0.0], 1.0));
    let mut comparisons = Comparisons::default();
    let mut worst_naive = 0.0f64;
    for (d, cos) in [
        (1.000_001f32, 1.0f64),
        (1.01, 1.0),
        (3.0, 0.5),
        (400.0, 0.5),
        (1e4, 0.5),
    ] {
        let p = Vec3::new(0.0, d, 0.0);
        let n = Frame::around(-Vec3::Y).world_from_local(Vec3::new(
            (1.0 - cos * cos).sqrt() as f32,
            0.0,
            cos as f32,
        ));
        let estimates = Replicates::of(|seed| {
            let samples = 1024;
            let sum: f64 = (0..samples)
                .filter_map(|i| {
                    let sampler = Sampler::new(SamplerKind::Independent, seed, [i, 9], 0);
                    let u = sampler.get_2d(Dim::LightPoint(0));
                    let sample = lamp.lights().sample(p, || 0.5, || u)?;
                    let cos = (sample.point.p - p).normalize().dot(n);
                    Some(f64::from(cos.max(0.0)) / f64::from(sample.pdf))
                })
                .sum();
            sum / f64::from(samples)
        });
        let truth = PI / f64::from(d).powi(2) * cos;
        comparisons.mean(&estimates, truth);
        // The cone's solid angle with 1 − cos in f32, against its value.
        let cos_max = (1.0 - 1.0 / (d * d)).sqrt();
        let r = 1.0 / f64::from(d);
        let exact = r * r / (1.0 + ((1.0 - r) * (1.0 + r)).sqrt());
        worst_naive = worst_naive.max((f64::from(1.0 - cos_max) / exact - 1.0).abs());
    }
    let exact_angle = |d: f32| {
        let r = 1.0 / f64::from(d);
        2.0 * PI * r * r / (1.0 + ((1.0 - r) * (1.0 + r)).sqrt())
    };
    let angle_error = [1.000_001f32, 1.01, 3.0, 400.0, 1e4, 1e6].map(|d| {
        let p = Vec3::new(0.0, d, 0.0);
        let sample = lamp.lights().sample(p, || 0.5, || [0.5, 0.5]);
        sample.map_or(f64::INFINITY, |s| {
            (1.0 / f64::from(s.pdf) / exact_angle(d) - 1.0).abs()
        })
    });
    let inside = lamp
        .lights()
        .sample(Vec3::new(0.3, 0.0, 0.1), || 0.5, || [0.5; 2]);
    let worst = [1.001f32, 2.0, 50.0].map(|d| cone_chi_square(&lamp, d));
    let mut figures = vec![
        Figure {
            what: "largest relative error of the cone's solid angle",
            naive: Some(worst_naive),
            lightbox: angle_error.into_iter().fold(0.0, f64::max),
            bound: Bound::AtMost(1e-5),
        },
        Figure {
            what: "largest χ² of directions in 64 cells of the cone",
            naive: None,
            lightbox: worst.into_iter().fold(0.0, f64::max),
            bound: Bound::AtMost(CHI_SQUARE_63),
        },
        Figure {
            what: "samples from inside the sphere",
            naive: None,
            lightbox: f64::from(u8::from(inside.is_some())),
            bound: Bound::Exactly(0.0),
        },
    ];
    figures.extend(comparisons.figures(
        "largest deviation from π(R/d)² cos θ, critical distances",
        None,
        0.05,
    ));
    figures
}

/// χ² of directions from distance `d` to the unit sphere: equal counts in equal steps of cos θ
/// and φ.
fn cone_chi_square(lamp: &Scene, d: f32) -> f64 {
    let p = Vec3::new(0.0, 0.0, d);
    let sin2 = 1.0 / f64::from(d).powi(2);
    let one_minus_cos = sin2 / (1.0 + (1.0 - sin2).sqrt());
    let n = 50_000u32;
    let mut observed = [0.0; 64];
    for i in 0..n {
        let u = numbers(i, Dim::LightPoint(2));
        if let Some(sample) = lamp.lights().sample(p, || 0.5, || u) {
            let w = (sample.point.p.as_dvec3() - p.as_dvec3()).normalize();
            let sin2 = w.x * w.x + w.y * w.y;
            let share = sin2 / (1.0 - w.z) / one_minus_cos;
            observed[cell([share, w.y.atan2(w.x) / TAU + 0.5])] += 1.0;
        }
    }
    chi_square(&observed, &[f64::from(n) / 64.0; 64])
}
