use std::cell::Cell;

use super::*;
use crate::lab::stats::REPLICATES;
use crate::{Method, Scene, SceneDesc};

fn cornell(method: Method) -> View {
    let scene: Scene = crate::scene::load("builtin:cornell-box.toml".as_ref())
        .and_then(|source| source.build(&crate::scene::unwatched))
        .unwrap();
    let SceneDesc { camera, render, .. } = scene.desc().clone();
    let mut settings = render;
    (settings.width, settings.height, settings.method) = (24, 24, method);
    View::new(scene.into(), &camera, settings).unwrap()
}

/// A clock on which every slice takes one second.
fn clock() -> impl Fn() -> f64 {
    let now = Cell::new(0.0);
    move || {
        now.set(now.get() + 1.0);
        now.get()
    }
}

fn image(view: &View, samples: u64) -> Image {
    let film = view.film();
    view.render(&film, samples, &AtomicBool::new(false));
    film.develop()
}

#[test]
fn everyone_gets_the_same_time_and_seeds_of_its_own() {
    let views = [Method::Mis, Method::Naive].map(cornell);
    let reference = image(&views[0], 256);
    let contestants = views.map(|view| (view, &reference));
    let rules = Rules {
        seconds: 12.0,
        seeds: 2,
    };
    let never = AtomicBool::new(false);
    let mut shares = Vec::new();
    let records = run(&contestants, rules, &clock(), &never, &mut |s, _| {
        shares.push(s)
    })
    .unwrap();
    assert!(
        shares.is_sorted() && shares.last() == Some(&1.0),
        "{shares:?}"
    );
    let mut seeds = Vec::new();
    for record in &records {
        assert_eq!(record.runs.len(), 2);
        for run in &record.runs {
            seeds.push(run.seed);
            let last = run.points.last().unwrap();
            assert_eq!(last.seconds, 12.0, "{run:?}");
            assert!(run.points.is_sorted_by_key(|p| (p.samples, p.rays)));
            assert!(last.rel_mse < run.points[0].rel_mse && last.samples.is_multiple_of(2));
        }
        assert!(record.light.is_some());
    }
    seeds.sort_unstable();
    seeds.dedup();
    assert_eq!(seeds.len(), 4);
    assert!(!seeds.contains(&reference_seed(0)));
    // Aiming at the lamp beats running into it.
    let runs: Vec<&[Run]> = records.iter().map(|r| r.runs.as_slice()).collect();
    let curves = curves(&runs);
    assert!(
        curves[0].efficiency > 10.0 * curves[1].efficiency,
        "{curves:?}"
    );
    assert!(curves[0].front.iter().all(|f| *f) && !curves[1].front.iter().any(|f| *f));
}

#[test]
fn an_interrupted_race_keeps_what_it_has() {
    let view = cornell(Method::Mis);
    let reference = image(&view, 64);
    let cancel = AtomicBool::new(false);
    let rules = Rules {
        seconds: 20.0,
        seeds: 3,
    };
    let records = run(
        &[(view, &reference)],
        rules,
        &clock(),
        &cancel,
        &mut |share, _| {
            cancel.store(share > 0.5, Ordering::Relaxed);
        },
    );
    let record = records.unwrap().remove(0);
    assert_eq!(record.runs.len(), 2);
    assert!(record.runs[1].points.last().unwrap().seconds < 20.0);
    let one = curves(&[&record.runs[..1]]);
    assert!(one[0].slope.is_some() && one[0].efficiency > 0.0);
    let small = image(&cornell(Method::Mis), 1);
    let other = Image {
        width: 1,
        pixels: small.pixels[..24].to_vec(),
        ..small
    };
    let refused = run(
        &[(cornell(Method::Mis), &other)],
        rules,
        &clock(),
        &AtomicBool::new(false),
        &mut |_, _| (),
    );
    assert!(refused.unwrap_err().contains("render both at one size"));
}

/// Runs whose error is `level · samples^power`.
fn synthetic(level: f64, power: f64, seconds_per_sample: f64) -> Vec<Run> {
    let points = (1..=10).map(|k| {
        let samples = 1u64 << k;
        Point {
            seconds: samples as f64 * seconds_per_sample,
            samples,
            rays: samples,
            rel_mse: level * (samples as f64).powf(power),
        }
    });
    vec![Run {
        seed: 0,
        points: points.collect(),
    }]
}

#[test]
fn slopes_and_the_front_are_found() {
    let independent = synthetic(1.0, -1.0, 1.0);
    let sobol = synthetic(4.0, -1.5, 1.0);
    let stuck = synthetic(8.0, -0.3, 1.0);
    let curves = curves(&[&independent, &sobol, &stuck]);
    for (curve, power, trouble) in [
        (&curves[0], -1.0, false),
        (&curves[1], -1.5, false),
        (&curves[2], -0.3, true),
    ] {
        let slope = curve.slope.unwrap();
        assert!((slope.value - power).abs() < 1e-9, "{slope:?}");
        assert_eq!(slope.trouble, trouble);
    }
    assert!((curves[0].efficiency - 1.0).abs() < 1e-9);
    // 1/n and 4/n^1.5 meet at 16.
    for (point, (a, b)) in curves[0]
        .points
        .iter()
        .zip(curves[0].front.iter().zip(&curves[1].front))
    {
        if (point[0] / 16.0).ln().abs() > 0.1 {
            assert_eq!((*a, *b), (point[0] < 16.0, point[0] > 16.0), "{point:?}");
        }
    }
    assert!(!curves[2].front.iter().any(|f| *f));
    assert!(super::curves(&[&[]])[0].points.is_empty());
}

/// Pictures of one method with different seeds hardly ever disagree, one with a tile 3 % brighter
/// is found.
#[test]
fn disagreement_is_found_and_noise_is_not() {
    use crate::agreement::{Agreement, LEVEL};
    let mut lights = Vec::new();
    for method in [Method::Mis, Method::Naive] {
        let mut view = cornell(method);
        for i in 0..REPLICATES as u64 {
            view.settings.seed = 100 * method as u64 + i;
            let film = view.film();
            view.render(&film, 64, &AtomicBool::new(false));
            lights.push(Light::of(&film).unwrap());
        }
    }
    let (mis, naive) = lights.split_at(REPLICATES);
    let mut alarms = 0;
    let mut level = 0;
    let pairs = mis.iter().zip(mis.iter().skip(1).chain(naive));
    for (a, b) in pairs.chain(mis.iter().zip(naive)) {
        let p = Agreement::between(a, b).p;
        alarms += usize::from(p < LEVEL);
        level += usize::from(p < 0.2);
    }
    // 64 pairs or so: at 1 % hardly any, at 20 % about 13.
    assert!(alarms <= 3 && (3..=25).contains(&level), "{alarms} {level}");
    let same = Agreement::between(&mis[0], &mis[0]);
    assert_eq!(same.p, 1.0);
    assert_eq!(same.headline("a", "b"), "a and b agree, p = 1.00");
    let sum = |lights: &[Light]| {
        let mut all = lights[0].clone();
        lights[1..].iter().for_each(|l| all.add(l));
        all
    };
    let found = Agreement::between(&sum(&mis[..16]), &sum(&mis[16..]).brighter(1.03));
    assert!(!found.holds(), "{found:?}");
    assert!(
        found
            .headline("a", "b")
            .starts_with("a and b disagree, p = ")
    );
}

/// With next to no samples, most tiles of `naive` have not met the lamp: that is no disagreement.
#[test]
fn light_that_was_not_met_yet_is_no_disagreement() {
    use crate::agreement::Agreement;
    let light = |method, samples, seed| {
        let View {
            scene,
            mut settings,
            ..
        } = cornell(method);
        (settings.width, settings.height, settings.seed) = (96, 96, seed);
        let camera = scene.desc().camera;
        let view = View::new(scene, &camera, settings).unwrap();
        let film = view.film();
        view.render(&film, samples, &AtomicBool::new(false));
        Light::of(&film).unwrap()
    };
    let mis = light(Method::Mis, 32, 1);
    for (samples, seed) in [(2, 2), (2, 3), (4, 4), (4, 5), (8, 6), (16, 7)] {
        let p = Agreement::between(&light(Method::Naive, samples, seed), &mis).p;
        assert!(p > 1e-3, "{samples} spp: {p}");
    }
}
