//! Light transport in the shipped scenes. Small scenes with analytic answers are cases of the
//! stability lab.

use std::sync::Arc;

use lightbox_core::lab::stats::{Comparisons, Replicates};
use lightbox_core::settings::UNLIMITED;
use lightbox_core::{Method, RenderSettings, Scene};
use lightbox_tests::{picture, shipped, view};

/// Means of the green channel of pictures with different seeds.
fn replicates(scene: &Arc<Scene>, change: impl Fn(&mut RenderSettings) + Sync) -> Replicates {
    Replicates::of(|seed| {
        let image = picture(&view(scene, |s| {
            change(s);
            s.seed = 1000 + seed;
        }));
        image.pixels.iter().map(|p| f64::from(p.y)).sum::<f64>() / image.pixels.len() as f64
    })
}

/// Asserts that all comparisons hold and could have seen a relative error of `resolution`.
fn assert_holds(comparisons: Comparisons, resolution: f64, what: &str) {
    for figure in comparisons.figures("deviation", None, resolution) {
        assert!(figure.holds(), "{what}: {figure:?}");
    }
}

/// The methods share one expectation (the white furnace has its own test).
#[test]
fn methods_agree() {
    let scenes = [
        ("teddy-diffuse", 0.08),
        ("cornell-box", 0.08),
        ("sphere-mirror", 0.1),
        ("teddy-mirror", 0.1),
        ("glass-sphere", 0.15),
    ];
    for (name, resolution) in scenes {
        let scene = Arc::new(shipped(name).build(&|_| ()).unwrap());
        let means = |method| {
            replicates(&scene, |s| {
                (s.width, s.height, s.samples, s.method) = (20, 20, 96, method);
            })
        };
        let mut comparisons = Comparisons::default();
        let mis = means(Method::Mis);
        comparisons.agree(&means(Method::Naive), &mis);
        // Lights behind mirrors and glass, which nobody can aim at, are counted when run into.
        comparisons.agree(&means(Method::Nee), &mis);
        assert_holds(comparisons, resolution, name);
    }
}

/// Surfaces that reflect everything vanish in uniform light: exactly for a convex body without
/// roulette, in the mean for all of the shipped furnace.
#[test]
fn white_furnace() {
    let source = shipped("white-furnace");
    let scene = Arc::new(source.build(&|_| ()).unwrap());
    let mut comparisons = Comparisons::default();
    for method in Method::ALL {
        let means = replicates(&scene, |s| {
            (s.width, s.height, s.samples) = (24, 24, 16);
            (s.method, s.depth) = (*method, UNLIMITED);
        });
        comparisons.mean(&means, 1.0);
    }
    assert_holds(comparisons, 0.006, "shipped furnace");
    let mut alone = source.desc.clone();
    alone.spheres.truncate(1);
    let scene = Arc::new(source.build_edited(alone, &|_| ()).unwrap());
    let image = picture(&view(&scene, |s| {
        (s.width, s.height, s.samples) = (32, 32, 4)
    }));
    for p in &image.pixels {
        assert!((*p - 1.0).abs().max_element() < 1e-5, "{p}");
    }
}
