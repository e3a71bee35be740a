//! What the depth leaves out, against the truth.

use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use super::*;
use crate::lab::trial::{closed_box, mean, picture, view};
use crate::plan::test::shipped;
use crate::settings::UNLIMITED;
use crate::{Method, Scene, View};

/// A view of some tiles, deep enough sampled for each to have been followed once.
fn followed(scene: &Arc<Scene>, method: Method, depth: u32) -> View {
    view(scene, |s| {
        (s.width, s.height, s.samples) = (64, 32, interval(depth));
        (s.method, s.depth) = (method, depth);
    })
}

/// Where a picture's light comes from, and its mean radiance.
fn light(view: &View) -> (Light, f64) {
    let film = view.film();
    view.render(&film, view.settings.samples, &AtomicBool::new(false));
    (film.light(), film.error().expect("two samples").mean)
}

/// In a closed box of reflectance ρ that glows everywhere, paths of k segments bring ρ^(k−1), and
/// those of more than d the share ρ^d of all.
#[test]
fn a_glowing_box_loses_a_power_of_its_reflectance() {
    for (rho, depth, method) in [
        (0.9, 16, Method::Mis),
        (0.9, 16, Method::Naive),
        (0.9, 16, Method::Nee),
        (0.75, 8, Method::Mis),
        (0.5, 4, Method::Mis),
    ] {
        let (light, mean) = light(&followed(&closed_box(rho), method, depth));
        let lost = light.lost(mean).expect("tiles were followed");
        let expected = rho.powi(depth as i32);
        assert_eq!(lost.paths, 64 * 32);
        let off = (lost.share - expected).abs();
        assert!(
            off < 4.0 * lost.error && lost.error < 0.1 * expected,
            "{method}, depth {depth}: {lost:?} instead of {expected}"
        );
        // The same of every lesser depth.
        for depth in 1..=depth {
            let (known, expected) = (light.beyond(depth, mean), rho.powi(depth as i32));
            let off = known.map(|known| (known / expected - 1.0).abs());
            assert!(
                off < Some(0.3),
                "beyond {depth}: {known:?} instead of {expected}"
            );
        }
        // ρ^d < 1/5 from d = ln 5 / ln(1/ρ) on.
        let least = (5f64.ln() / -rho.ln()).ceil() as u32;
        let found = light.least_depth(0.2, mean).expect("a depth");
        assert!(found.abs_diff(least) <= 1, "{found} instead of {least}");
    }
}

/// In a scene like others, against a picture without a limit.
#[test]
fn what_a_low_depth_loses_is_what_a_long_render_finds() {
    let scene = shipped("cornell-box");
    let (found, radiance) = light(&followed(&scene, Method::Mis, 3));
    let lost = found.lost(radiance).expect("tiles");
    let mean_at = |depth| {
        mean(&picture(&view(&scene, |s| {
            (s.width, s.height, s.samples, s.depth) = (64, 32, 400, depth);
        })))
    };
    // The green channel, like all of them, to within what the colour of the walls changes.
    let expected = 1.0 - mean_at(3) / mean_at(UNLIMITED);
    assert!(expected > 0.05, "{expected}");
    let off = (lost.share / expected - 1.0).abs();
    assert!(off < 0.15, "{lost:?} instead of {expected}");
}

/// A few tiles that see no lamp must not make believe that all light is lost.
#[test]
fn light_that_no_followed_path_met_counts_all_the_same() {
    let scene = shipped("cornell-box");
    let (found, radiance) = light(&view(&scene, |s| {
        (s.width, s.height, s.samples, s.depth) = (512, 512, 16, 1);
    }));
    let lost = found.lost(radiance).expect("tiles");
    assert!(lost.paths < 512 * 512 / 16, "{lost:?}");
    let all = mean(&picture(&view(&scene, |s| {
        (s.width, s.height, s.samples, s.depth) = (64, 64, 256, UNLIMITED);
    })));
    let seen = mean(&picture(&view(&scene, |s| {
        (s.width, s.height, s.samples, s.depth) = (64, 64, 256, 1);
    })));
    let off = (lost.share - (1.0 - seen / all)).abs();
    assert!(
        0.0 < lost.error && off < 4.0 * lost.error && off < 0.2,
        "{lost:?} instead of 1 - {seen} / {all}"
    );
}

#[test]
fn nothing_is_lost_without_a_limit() {
    let view = followed(&shipped("cornell-box"), Method::Mis, UNLIMITED);
    let (light, mean) = light(&view);
    let lost = light.lost(mean).expect("tiles were followed");
    assert_eq!((lost.share, lost.error), (0.0, 0.0));
    let beyond = |depth| light.beyond(depth, mean);
    assert!(beyond(2) > beyond(4) && beyond(4) > Some(0.0));
    assert_eq!(light.least_depth(1.0, mean), Some(1));
}

/// One path in so many, of every tile alike.
#[test]
fn samples_to_follow_are_spread_evenly() {
    for (depth, expected) in [
        (1, 2048),
        (2, 1024),
        (3, 1024),
        (16, 128),
        (100, 64),
        (UNLIMITED, 64),
    ] {
        assert_eq!(interval(depth), expected, "{depth}");
        let mut by_sample = vec![0; expected as usize];
        for tile in 0..1024 {
            let rect = TileRect {
                x: TILE * (tile % 32),
                y: TILE * (tile / 32),
                width: TILE,
                height: TILE,
            };
            let samples = (0..expected).filter(|s| is_followed(&rect, *s, depth));
            let samples: Vec<u64> = samples.collect();
            assert_eq!(samples.len(), 1);
            by_sample[samples[0] as usize] += 1;
        }
        let fair = (1024 / expected).max(1);
        assert!(by_sample.iter().all(|n| *n <= 3 * fair), "{by_sample:?}");
    }
}

/// Whatever the batches, what is found is the same to the bit, and survives a file.
#[test]
fn batches_and_files_keep_it() {
    let scene = closed_box(0.9);
    let view = view(&scene, |s| {
        (s.width, s.height, s.samples, s.depth) = (40, 20, 130, 16);
    });
    let never = AtomicBool::new(false);
    let [whole, steps] = [130, 7].map(|step| {
        let film = view.film();
        for end in (0..130).step_by(step).skip(1).chain([130]) {
            view.render(&film, end, &never);
        }
        film
    });
    assert!(whole.light().lost(1.0).is_some());
    for i in 0..whole.tiles() {
        let survey = whole.tile(i).survey.clone();
        assert!(survey.paths > 0 && survey.by_length.len() > 20);
        assert_eq!(steps.tile(i).survey, survey);
        let mut bytes = Vec::new();
        whole.pack_tile(i, &mut bytes);
        let mut tile = whole.empty_tile(i);
        assert_eq!(tile.add_packed(&bytes), Some(130));
        assert_eq!(tile.survey, survey);
        tile.add_packed(&bytes).expect("a second time");
        assert_eq!(tile.survey.paths, 2 * survey.paths);
    }
}

/// Following a path changes neither what it brings within the depth nor the rays counted for it.
#[test]
fn paths_that_are_followed_bring_the_same() {
    use crate::integrator::{Transport, Wave};
    use crate::sampler::Sampler;
    use crate::work::Stopwatch;
    for name in [
        "cornell-box",
        "glass-sphere",
        "teddy-mirror",
        "white-furnace",
    ] {
        let scene = shipped(name);
        let view = followed(&scene, Method::Mis, 3);
        let trace = |method, followed: Option<&mut Followed>, depth| {
            let (mut wave, mut rays) = (Wave::default(), 0);
            // Enough for some of them to have light by a probe.
            for i in 0..64 * 32 {
                let pixel = [i % 64, i / 64];
                let sampler = Sampler::new(view.settings.sampler, 1, pixel, 0);
                wave.push(view.camera.ray(pixel, [0.0; 2]), sampler);
            }
            let mut transport = Transport {
                scene: &scene,
                plan: view.plan(),
                method,
                depth,
                camera: &view.camera,
                margin: 0.5,
                guide: None,
            };
            if transport.traces_light() {
                transport.guide = scene.guide(&transport);
            }
            let (never, mut watch) = (AtomicBool::new(false), Stopwatch::start());
            let found = wave.trace(&transport, &never, &mut rays, &mut watch, followed);
            (found.expect("not cancelled").to_vec(), rays)
        };
        for depth in [1, 2, 3, 5] {
            let caustics = trace(Method::Caustics, Some(&mut Followed::default()), depth);
            let unfollowed = trace(Method::Caustics, None, depth);
            assert!(caustics == unfollowed, "{name}, {depth}");
            let mut found = Followed::default();
            let (radiance, rays) = trace(Method::Mis, Some(&mut found), depth);
            assert_eq!(
                (radiance.clone(), rays),
                trace(Method::Mis, None, depth),
                "{name}, {depth}"
            );
            // All there is, within and beyond, is what paths without a limit bring; but light by way
            // of a mirror sphere is aimed at within the limit and run into beyond, which is the
            // same in the mean only.
            let sum = |radiance: &[glam::Vec3]| -> f64 {
                radiance.iter().map(|r| f64::from(r.element_sum())).sum()
            };
            let (unlimited, _) = trace(Method::Mis, None, UNLIMITED);
            let all: f64 = found.by_length.iter().sum();
            assert!(
                (all / sum(&unlimited) - 1.0).abs() < 1e-6 || !scene.mirror_spheres().is_empty(),
                "{name}, {depth}"
            );
            let within = all - found.beyond;
            assert!(
                (within - sum(&radiance)).abs() < 1e-6 * all,
                "{name}, {depth}"
            );
        }
    }
}
