//! The render contract: the picture is a pure function of scene, camera, settings and seed. All
//! comparisons are of bits.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use lightbox_core::color::ToneMap;
use lightbox_core::{AccelKind, Image, RenderSettings, SceneDesc, View, image_io};
use lightbox_tests::{built, built_as, film, on_threads, picture, shipped, view};

const SMALL: fn(&mut RenderSettings) = |s| (s.width, s.height, s.samples) = (50, 37, 8);

fn bits(image: &Image) -> Vec<[u32; 3]> {
    image
        .pixels
        .iter()
        .map(|p| p.to_array().map(f32::to_bits))
        .collect()
}

fn assert_same(a: &Image, b: &Image, what: &str) {
    assert_eq!((a.width, a.height), (b.width, b.height), "{what}");
    let differing = bits(a)
        .iter()
        .zip(bits(b))
        .filter(|(x, y)| **x != *y)
        .count();
    assert_eq!(differing, 0, "{what}: pixels that differ");
}

#[test]
fn any_number_of_threads_gives_the_same_bits() {
    for name in ["teddy-mirror", "glass-sphere"] {
        let scene = built(&shipped(name));
        let one = on_threads(1, || film(&view(&scene, SMALL)));
        for threads in [2, 3, 8] {
            let other = on_threads(threads, || film(&view(&scene, SMALL)));
            let what = format!("{name} on {threads} threads");
            assert_same(&one.develop(), &other.develop(), &what);
            assert_eq!(one.work(), other.work(), "{what}: paths and rays");
        }
    }
}

#[test]
fn pauses_and_batches_change_nothing() {
    for name in ["teddy-diffuse", "glass-sphere"] {
        pauses_and_batches_change_nothing_in(name);
    }
}

/// Where paths have branches of several kinds, whatever paths they advance together with.
#[test]
fn one_sample_at_a_time_changes_nothing() {
    let view = view(&built(&shipped("glass-sphere")), |s| {
        (s.width, s.height, s.samples) = (90, 60, 96);
    });
    let film = view.film();
    for target in 1..=96 {
        view.render(&film, target, &AtomicBool::new(false));
    }
    let whole = lightbox_tests::film(&view);
    assert_same(&whole.develop(), &film.develop(), "one at a time");
    assert_eq!(whole.work(), film.work(), "paths and rays");
}

fn pauses_and_batches_change_nothing_in(name: &str) {
    let scene = built(&shipped(name));
    let view = view(&scene, |s| {
        (s.width, s.height, s.samples) = (64, 48, 24);
        s.filter = "lanczos".parse().expect("a filter");
    });
    let whole = picture(&view);

    // In batches of unequal size.
    let film = view.film();
    for target in [1, 2, 5, 24] {
        view.render(&film, target, &AtomicBool::new(false));
    }
    assert_same(&whole, &film.develop(), "in batches");

    // Interrupted again and again, at moments nobody chose.
    let film = view.film();
    let mut interruptions = 0u32;
    while film.samples() < 24 {
        // A tile is dropped unless it gets done, so the patience grows.
        let patience = Duration::from_millis(2 << interruptions);
        let cancel = AtomicBool::new(false);
        std::thread::scope(|scope| {
            scope.spawn(|| {
                std::thread::sleep(patience);
                cancel.store(true, Ordering::Relaxed);
            });
            view.render(&film, 24, &cancel);
        });
        interruptions += 1;
    }
    assert!(interruptions > 1, "the render was never interrupted");
    assert_same(&whole, &film.develop(), "interrupted");
}

/// Whoever copies a film while it grows, as a checkpoint does, gets samples with their rays.
#[test]
fn a_copy_taken_meanwhile_goes_on_like_the_whole() {
    let view = view(&built(&shipped("glass-sphere")), |s| {
        // More tiles than two threads take one by one.
        (s.width, s.height, s.samples) = (160, 120, 4);
    });
    let whole = film(&view);
    let growing = view.film();
    let never = AtomicBool::new(false);
    let mut copies = Vec::new();
    std::thread::scope(|scope| {
        let render = scope.spawn(|| on_threads(2, || view.render(&growing, 4, &never)));
        while !render.is_finished() {
            copies.push(growing.clone());
            std::thread::sleep(Duration::from_millis(1));
        }
    });
    let is_begun = |copy: &&lightbox_core::Film| copy.most_samples() > 0 && copy.samples() < 4;
    let begun: Vec<_> = copies.iter().filter(is_begun).collect();
    assert!(begun.len() > 1, "copied too late");
    for copy in begun.iter().step_by(begun.len().div_ceil(8)) {
        view.render(copy, 4, &never);
        assert_same(&whole.develop(), &copy.develop(), "a copy");
        assert_eq!(whole.work(), copy.work(), "paths and rays");
    }
}

#[test]
fn a_batch_lands_only_where_it_belongs() {
    let scene = built(&shipped("sphere-mirror"));
    let view = view(&scene, SMALL);
    let film = view.film();
    view.render(&film, 4, &AtomicBool::new(false));
    let before = film.develop();
    let (stale, first) = film.batch(0);
    assert_eq!(first, 4);
    assert!(
        !film.merge(0, &stale, 0, 4),
        "samples that are there already"
    );
    assert!(!film.merge(0, &stale, 8, 12), "samples after a gap");
    assert!(!film.merge(1, &stale, 4, 8), "samples of another tile");
    assert_same(&before, &film.develop(), "after refused batches");
}

#[test]
fn every_accelerator_gives_the_picture_of_brute_force() {
    for name in ["teddy-mirror", "cornell-box", "glass-sphere"] {
        let pictures = [AccelKind::Brute, AccelKind::KdTree, AccelKind::Bvh].map(|accel| {
            let source = shipped(name);
            let mut desc = source.desc.clone();
            desc.render.accel = accel;
            SMALL(&mut desc.render);
            desc.render.samples = 2;
            picture(&View::of(built_as(&source, desc)).unwrap())
        });
        assert_same(&pictures[0], &pictures[1], name);
        assert_same(&pictures[0], &pictures[2], name);
    }
}

fn scaled(desc: &SceneDesc, s: f32) -> SceneDesc {
    let mut desc = desc.clone();
    desc.camera.eye *= s;
    desc.camera.target *= s;
    for sphere in &mut desc.spheres {
        sphere.center *= s;
        sphere.radius *= s;
    }
    for quad in &mut desc.quads {
        quad.corners = quad.corners.map(|c| c * s);
    }
    for mesh in &mut desc.meshes {
        mesh.scale *= s;
        mesh.translate *= s;
    }
    desc
}

/// Scaling by a power of two is exact in floating point, so any difference is an absolute
/// tolerance hidden somewhere.
#[test]
fn a_scaled_scene_gives_the_same_bits() {
    for name in ["teddy-diffuse", "glass-sphere", "cornell-box"] {
        let source = shipped(name);
        let reference = picture(&view(&built(&source), SMALL));
        for k in [-20, -7, 3, 17] {
            let desc = scaled(&source.desc, 2f32.powi(k));
            let scene = built_as(&source, desc);
            assert_same(
                &reference,
                &picture(&view(&scene, SMALL)),
                &format!("{name} times 2^{k}"),
            );
        }
    }
}

/// The lamp of the Cornell box lies in the plane of its ceiling: it must be seen whichever comes
/// first, and nothing else may depend on the order.
#[test]
fn the_order_of_primitives_changes_nothing() {
    let source = shipped("cornell-box");
    let reference = picture(&view(&built(&source), SMALL));
    let mut reversed = source.desc.clone();
    reversed.quads.reverse();
    let scene = built_as(&source, reversed);
    assert_same(&reference, &picture(&view(&scene, SMALL)), "reversed");
}

/// An edit that leaves the shapes alone gives the picture of a fresh build.
#[test]
fn edits_give_the_picture_of_a_fresh_build() {
    let source = shipped("teddy-diffuse");
    let scene = built(&source);
    let mut desc = source.desc.clone();
    let fur = desc.materials.iter_mut().find(|m| m.name == "fur").unwrap();
    (fur.mirror, fur.emission) = (0.4, glam::Vec3::splat(0.3));
    desc.background = glam::Vec3::splat(0.1);
    assert!(!scene.rebuilds_for(&desc));
    let edited = Arc::new(
        scene
            .edit(desc.clone(), &lightbox_core::scene::unwatched)
            .unwrap(),
    );
    let fresh = built_as(&source, desc);
    assert_same(
        &picture(&view(&edited, SMALL)),
        &picture(&view(&fresh, SMALL)),
        "edited",
    );
}

/// EXR is compressed in parallel, and its blocks must not land in the order in which they are done.
#[test]
fn the_same_picture_gives_the_same_file() {
    let view = view(&built(&shipped("sphere-mirror")), |s| {
        (s.width, s.height, s.samples) = (96, 96, 1);
    });
    let image = picture(&view);
    let path = std::env::temp_dir().join(format!("lightbox-{}.exr", std::process::id()));
    let file = || {
        image_io::write(&path, &image, ToneMap::default(), "").unwrap_or_else(|e| panic!("{e}"));
        std::fs::read(&path).expect("it was just written")
    };
    let first = file();
    for _ in 0..50 {
        assert!(file() == first, "the bytes of {}", path.display());
    }
    std::fs::remove_file(&path).expect("it was just written");
}
