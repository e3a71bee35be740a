//! Mirrors and glass: lobes of one direction.

use glam::Vec3;

use super::stats::Comparisons;
use super::trial::{
    LAST, is_accepted, numbers, one_pixel, path, picture, quad, replicates, scene, view,
};
use super::{Bound, Figure};
use crate::bsdf::{Bsdf, fresnel};
use crate::integrator::power_heuristic;
use crate::math::warp;
use crate::sampler::{Dim, Sampler};
use crate::settings::UNLIMITED;
use crate::{Method, SamplerKind};

pub(super) fn mirrors() -> Vec<Figure> {
    let mirror = "[[material]]\nname = 'mirror'\nmirror = 1\nmirror_color = [0.5, 0.5, 0.5]\n";
    let corridor = quad("mirror", "[-9, 0, 9], [9, 0, 9], [9, 0, -9], [-9, 0, -9]")
        + &quad("mirror", "[-9, 1, 9], [-9, 1, -9], [9, 1, -9], [9, 1, 9]")
        + &quad(
            "lamp",
            "[2.5, 0, 9], [2.5, 1, 9], [2.5, 1, -9], [2.5, 0, -9]",
        );
    // Down at slope 1 to the origin, then up and down until x = 2.5: 3 mirrors, the most that
    // roulette leaves alone.
    let scene = one_pixel("[-0.5, 0.5, 0]", &(corridor + mirror));
    let off = Method::ALL.iter().map(|method| {
        let image = picture(&view(&scene, |s| {
            (s.method, s.samples, s.depth) = (*method, 16, 64);
        }));
        (f64::from(image.pixels[0].y) - 0.125).abs()
    });
    // Weighted against the density with which the lamp could be aimed at from the last mirror.
    let weight = f64::from(power_heuristic(0.0, 1.0));
    vec![Figure {
        what: "error of ρ³L after three mirrors of ½, all methods",
        naive: Some((0.125 * weight - 0.125).abs()),
        lightbox: off.fold(0.0, f64::max),
        bound: Bound::Exactly(0.0),
    }]
}

pub(super) fn fresnel_angles() -> Vec<Figure> {
    let n = 1.5f64;
    let normal = [1.0 / 1.5, 1.5].map(|eta| (f64::from(fresnel(1.0, eta).0) - 0.04).abs());
    // At Brewster's angle the parallel part vanishes: R is half the square of the other.
    let brewster = n.atan();
    let cos_t = brewster.sin();
    let perpendicular = (brewster.cos() / n - cos_t) / (brewster.cos() / n + cos_t);
    let (r, _) = fresnel(brewster.cos() as f32, 1.0 / 1.5);
    let parallel = 2.0 * f64::from(r) - perpendicular * perpendicular;
    let critical = (1.0 / n).asin();
    let reflected = |degrees: f64| fresnel((critical + degrees.to_radians()).cos() as f32, 1.5).0;
    let wrong_side = u8::from(reflected(-1e-3) >= 1.0) + u8::from(reflected(1e-3) != 1.0);
    let (mut invalid, mut invalid_naive, mut worst_snell) = (0u32, 0u32, 0.0f64);
    let mut lossy = 0u32;
    let cosines = [0.0, 1e-7, 0.3, (1.0f32 - 1.0 / 2.25).sqrt(), 1.0];
    for (cos, eta) in cosines
        .iter()
        .flat_map(|c| [0.2f32, 0.66, 1.0, 1.5, 5.0].map(|e| (*c, e)))
    {
        let (r, cos_t) = fresnel(cos, eta);
        invalid += u32::from(!((0.0..=1.0).contains(&r) && cos_t >= 0.0));
        let cos_t = (1.0 - eta * eta * (1.0 - cos * cos)).sqrt();
        invalid_naive += u32::from(!(((cos - eta * cos_t) / (cos + eta * cos_t)).is_finite()));
        for front in [true, false] {
            let wo = Vec3::new((1.0 - cos * cos).sqrt(), 0.0, cos);
            let eta = if front { 1.0 / 1.5 } else { 1.5 };
            // The highest choice refracts unless all is reflected.
            match Bsdf::Glass(1.5).sample(wo, Vec3::Z, front, || LAST, || [0.5; 2]) {
                Some(s) if s.wi.z < 0.0 => {
                    worst_snell = worst_snell.max(f64::from((s.wi.x + eta * wo.x).abs()));
                }
                Some(s) => invalid += u32::from(!s.wi.is_finite()),
                None => invalid += 1,
            }
            // Either lobe is taken with its share and carries all: R + T = 1.
            for choice in [0.0, LAST] {
                let s = Bsdf::Glass(1.5).sample(wo, Vec3::Z, front, || choice, || [0.5; 2]);
                lossy += u32::from(s.is_none_or(|s| s.weight != Vec3::ONE));
            }
        }
    }
    let indices = [0.0, 1e-3, f32::NAN, f32::INFINITY, -1.5];
    let accepted = indices.iter().filter(|n| {
        // TOML spells it nan.
        let n = format!("{n:?}").to_lowercase();
        is_accepted(&format!("[[material]]\nname = 'g'\nglass = {n}\n"))
    });
    let accepted = accepted.count();
    let mut slab = Comparisons::default();
    let face = |corners: &str| quad("glass", corners);
    let shapes = face("[-1, -1, 0.2], [1, -1, 0.2], [1, 1, 0.2], [-1, 1, 0.2]")
        + &face("[1, -1, -0.2], [-1, -1, -0.2], [-1, 1, -0.2], [1, 1, -0.2]")
        + &quad("lamp", "[-3, -3, -2], [3, -3, -2], [3, 3, -2], [-3, 3, -2]")
        + "[[material]]\nname = 'glass'\nglass = 1.5\n";
    let scene = one_pixel("[0, 0, 5]", &shapes);
    let means = replicates(&scene, |s| (s.samples, s.depth) = (4096, UNLIMITED));
    slab.mean(&means, 0.923_076_9);
    let mut figures = vec![
        Figure {
            what: "largest error of R at normal incidence and of its parallel part at Brewster's angle",
            naive: None,
            lightbox: normal[0].max(normal[1]).max(parallel.abs()),
            bound: Bound::AtMost(1e-6),
        },
        Figure {
            what: "sides of the critical angle, 41.8103°, that are wrong at 10⁻³°",
            naive: None,
            lightbox: wrong_side.into(),
            bound: Bound::Exactly(0.0),
        },
        Figure {
            what: "reflectances that are not from 0 to 1",
            naive: Some(invalid_naive.into()),
            lightbox: invalid.into(),
            bound: Bound::Exactly(0.0),
        },
        Figure {
            what: "lobes of glass whose weight is not 1",
            naive: None,
            lightbox: lossy.into(),
            bound: Bound::Exactly(0.0),
        },
        Figure {
            what: "largest reflectance where both indices are the same",
            naive: None,
            lightbox: [1e-7, 1e-3, 0.3, 1.0]
                .map(|cos| f64::from(fresnel(cos, 1.0).0))
                .into_iter()
                .fold(0.0, f64::max),
            bound: Bound::Exactly(0.0),
        },
        Figure {
            what: "largest error of Snell's law, sine",
            naive: None,
            lightbox: worst_snell,
            bound: Bound::AtMost(1e-6),
        },
        Figure {
            what: "impossible indices of refraction accepted",
            naive: None,
            lightbox: accepted as f64,
            bound: Bound::Exactly(0.0),
        },
    ];
    figures.extend(slab.figures(
        "deviation of a slab from (1 − R)/(1 + R), critical distances",
        None,
        0.005,
    ));
    figures
}

pub(super) fn glass_furnace() -> Vec<Figure> {
    let scene = scene(
        "background = [1, 1, 1]
[camera]
eye = [0, 0, 4]
fov = 30
[render]
width = 12
height = 12
samples = 64
depth = 'unlimited'
[[material]]
name = 'glass'
glass = 1.5
[[sphere]]
material = 'glass'
center = [0, 0, 0]
radius = 1
",
    );
    // A path either escapes, with one over its chance to have survived roulette, or was ended
    // by it. Lost light would be a path that ends before roulette begins.
    let view = view(&scene, |_| ());
    let mut wrong = 0u32;
    for (x, y) in (0..12).flat_map(|y| (0..12).map(move |x| (x, y))) {
        for sample in 0..256 {
            let sampler = Sampler::new(SamplerKind::Independent, 4, [x, y], sample);
            let offset = sampler.get_2d(Dim::Pixel).map(|u| u - 0.5);
            let ray = view.camera.ray([x, y], offset);
            let (found, rays) = path(&scene, Method::Mis, ray, sampler);
            let weight = (4..rays).fold(Vec3::ONE, |weight, _| weight / 0.95);
            let ended = rays >= 4 && found == Vec3::ZERO;
            wrong += u32::from(!ended && found != weight);
        }
    }
    let mut comparisons = Comparisons::default();
    comparisons.mean(&replicates(&scene, |_| ()), 1.0);
    let mut figures = vec![Figure {
        what: "paths of 36 864 that bring neither 1 over their survival nor end by roulette",
        naive: None,
        lightbox: wrong.into(),
        bound: Bound::Exactly(0.0),
    }];
    figures.extend(comparisons.figures(
        "deviation of the picture from 1, critical distances",
        None,
        0.005,
    ));
    figures
}

pub(super) fn mirror_chain() -> Vec<Figure> {
    let mirror = Bsdf::Mirror(Vec3::ONE);
    let ulp = |d: Vec3| (d.as_dvec3().length() - 1.0).abs() / f64::from(f32::EPSILON);
    let (mut worst, mut worst_naive) = (0.0f64, 0.0f64);
    for chain in 0..1000 {
        let mut d = warp::uniform_sphere(numbers(chain, Dim::Pixel));
        let mut d_naive = d;
        for bounce in 0..200 {
            let n = warp::uniform_sphere(numbers(chain, Dim::BsdfDirection(bounce)));
            let facing = |d: Vec3| if d.dot(n) < 0.0 { n } else { -n };
            if let Some(s) = mirror.sample(-d, facing(d), true, || 0.0, || [0.0; 2]) {
                d = s.wi;
            }
            let n = facing(d_naive);
            d_naive -= 2.0 * d_naive.dot(n) * n;
            worst = worst.max(ulp(d));
            worst_naive = worst_naive.max(ulp(d_naive));
        }
    }
    // Three orthogonal mirrors send light back where it came from.
    let mut back = 0.0f64;
    for i in 0..1000 {
        let d = warp::uniform_sphere(numbers(i, Dim::LightPoint(9)));
        let mut out = d;
        for axis in [Vec3::X, Vec3::Y, Vec3::Z] {
            let n = if out.dot(axis) < 0.0 { axis } else { -axis };
            if let Some(s) = mirror.sample(-out, n, true, || 0.0, || [0.0; 2]) {
                out = s.wi;
            }
        }
        back = back.max(f64::from((out + d).length()) / f64::from(f32::EPSILON));
    }
    vec![
        Figure {
            what: "largest deviation of |d| from 1 over 200 mirrors, ulp",
            naive: Some(worst_naive),
            lightbox: worst,
            bound: Bound::AtMost(4.0),
        },
        Figure {
            what: "largest deviation of a corner of three mirrors from −d, ulp",
            naive: None,
            lightbox: back,
            bound: Bound::AtMost(8.0),
        },
    ]
}
