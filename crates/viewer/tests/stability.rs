//! The viewer's cases of the stability lab: what a session survives, and that it leaves no trace.

#[path = "session/property.rs"]
mod property;

use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use glam::Vec3;
use lightbox::session::{Activity, Session};
use lightbox_core::{Image, SceneDesc, View, image_io};

/// How long a test waits for the engine before it gives up.
const PATIENCE: Duration = Duration::from_secs(60);

/// A mirror ball, a glass ball and a lamp over a floor, quick to render.
const SCENE: &str = r#"
[camera]
eye = [0, 0.5, 4]
[render]
width = 48
height = 36
samples = 4
[[material]]
name = "clay"
albedo = [0.5, 0.6, 0.7]
mirror = 0.5
[[material]]
name = "glass"
glass = 1.5
[[material]]
name = "lamp"
emission = [5, 4, 3]
[[sphere]]
material = "clay"
center = [-0.6, 0, 0]
radius = 0.5
[[sphere]]
material = "glass"
center = [0.6, 0, 0]
radius = 0.5
[[quad]]
material = "clay"
corners = [[-3, -0.5, 3], [3, -0.5, 3], [3, -0.5, -3], [-3, -0.5, -3]]
[[quad]]
material = "lamp"
corners = [[-1, 2, -1], [1, 2, -1], [1, 2, 1], [-1, 2, 1]]
"#;

fn wait(what: &str, holds: impl Fn() -> bool) {
    let start = Instant::now();
    while !holds() {
        assert!(start.elapsed() < PATIENCE, "waited in vain for {what}");
        std::thread::sleep(Duration::from_millis(2));
    }
}

/// Opens [`SCENE`] and waits for its picture.
fn open(session: &Session, folder: &Path) -> SceneDesc {
    let path = folder.join("scene.toml");
    std::fs::write(&path, SCENE).expect("a folder to write to");
    session.open(&path);
    wait("the first picture", || is_done(session));
    (*session.status().desc).clone()
}

fn is_done(session: &Session) -> bool {
    let status = session.status();
    status.opened == 1 && status.loading.is_none() && status.activity == Activity::Done
}

/// The picture in the session, as measured.
fn saved(session: &Session, folder: &Path) -> Image {
    let path = folder.join("picture.exr");
    session.take_notices();
    session.save(path.clone());
    let start = Instant::now();
    loop {
        if let Some(notice) = session.take_notices().first() {
            assert!(!notice.is_error, "{}", notice.text);
            return image_io::read(&path).unwrap_or_else(|e| panic!("{e}"));
        }
        assert!(start.elapsed() < PATIENCE, "the picture is not saved");
        std::thread::sleep(Duration::from_millis(2));
    }
}

/// The picture of a description, made from nothing.
fn fresh(desc: &SceneDesc, folder: &Path) -> Image {
    let source = lightbox_core::scene::Source::from_desc(desc.clone(), &folder.join("scene.toml"));
    let scene = source
        .build(&lightbox_core::scene::unwatched)
        .unwrap_or_else(|e| panic!("{e}"));
    let view = View::of(Arc::new(scene)).unwrap_or_else(|e| panic!("{e}"));
    let film = view.film();
    view.render(&film, view.settings.samples, &AtomicBool::new(false));
    film.develop()
}

fn assert_same_bits(a: &Image, b: &Image, what: &str) {
    assert_eq!((a.width, a.height), (b.width, b.height), "{what}");
    let differ = a
        .pixels
        .iter()
        .zip(&b.pixels)
        .filter(|(a, b)| a.to_array().map(f32::to_bits) != b.to_array().map(f32::to_bits));
    assert_eq!(differ.count(), 0, "{what}: pixels that differ");
}

/// Fuzzing does it for longer.
#[test]
fn any_edits_end_in_the_picture_of_a_headless_render() {
    lightbox_tests::properties::check("session", 6, property::session);
}

#[test]
fn moves_leave_nothing_behind() {
    let folder = tempfile::tempdir().unwrap();
    let session = Session::new(3, || ()).unwrap();
    let mut desc = open(&session, folder.path());
    for i in 0..1000 {
        let turn = i as f32 * 0.01;
        desc.camera.eye = Vec3::new(4.0 * turn.sin(), 0.5, 4.0 * turn.cos());
        if i % 100 == 50 {
            // A change of the surfaces among the moves.
            desc.materials[0].mirror = turn.fract();
        }
        session.edit(1, desc.clone());
        if i % 40 == 0 {
            // Long enough, now and then, for tiles of this view to be finished.
            std::thread::sleep(Duration::from_millis(3));
        }
    }
    wait("the last picture", || {
        is_done(&session) && *session.status().desc == desc && session.status().samples == 4
    });
    // `Done` may still be said of the picture before: a picture of the last view has its bits.
    let expected = fresh(&desc, folder.path());
    let start = Instant::now();
    let mut picture = saved(&session, folder.path());
    while picture != expected && start.elapsed() < Duration::from_secs(10) {
        picture = saved(&session, folder.path());
    }
    assert_same_bits(&picture, &expected, "after a thousand moves");
}

#[test]
fn impossible_sizes_are_survived() {
    let folder = tempfile::tempdir().unwrap();
    let session = Session::new(2, || ()).unwrap();
    let good = open(&session, folder.path());
    for (width, height) in [
        (0, 0),
        (0, 36),
        (16_385, 36),
        (65_536, 65_536),
        (u32::MAX, 1),
    ] {
        let mut bad = good.clone();
        (bad.render.width, bad.render.height) = (width, height);
        session.take_notices();
        session.edit(1, bad);
        let start = Instant::now();
        let notice = loop {
            if let Some(notice) = session.take_notices().into_iter().next() {
                break notice;
            }
            assert!(
                start.elapsed() < PATIENCE,
                "{width}x{height} is not refused"
            );
            std::thread::sleep(Duration::from_millis(2));
        };
        assert!(
            notice.is_error && !notice.text.contains('\n'),
            "{}",
            notice.text
        );
        assert!(
            notice.text.contains("width") || notice.text.contains("height"),
            "{}",
            notice.text
        );
    }
    // Narrow and tall is fine, and so is what there was.
    for (width, height) in [(1, 300), (1, 1), (48, 36)] {
        let mut small = good.clone();
        (small.render.width, small.render.height) = (width, height);
        session.edit(1, small.clone());
        let size = [width as usize, height as usize];
        wait("a picture of that size", || {
            let snapshot = session.snapshot();
            is_done(&session) && snapshot.is_some_and(|s| s.size == size && s.preview.is_none())
        });
        let picture = saved(&session, folder.path());
        assert_same_bits(
            &picture,
            &fresh(&small, folder.path()),
            "after refused sizes",
        );
    }
}

#[test]
fn panics_and_closing_do_not_hang() {
    let folder = tempfile::tempdir().unwrap();
    let armed = Arc::new(AtomicBool::new(false));
    let trigger = armed.clone();
    let session = Session::new(2, move || {
        assert!(!trigger.swap(false, Ordering::SeqCst), "planted by a test");
    })
    .unwrap();
    let mut desc = open(&session, folder.path());
    for eye in [3.5, 3.0] {
        armed.store(true, Ordering::SeqCst);
        desc.camera.eye.z = eye;
        session.edit(1, desc.clone());
        wait("the panic", || !armed.load(Ordering::SeqCst));
        // The next wish is served as if nothing had happened.
        desc.camera.eye.z += 0.25;
        session.edit(1, desc.clone());
        let (start, expected) = (Instant::now(), fresh(&desc, folder.path()));
        while !(is_done(&session) && saved(&session, folder.path()) == expected) {
            assert!(start.elapsed() < PATIENCE, "no picture after a panic");
        }
    }
    drop(session);

    // Closed while an accelerator is built: the loader still has its hold on the session's state,
    // so nobody has waited for it.
    let token = Arc::new(());
    let held = token.clone();
    let session = Session::new(2, move || drop(Arc::clone(&held))).unwrap();
    session.open(Path::new("builtin:million.toml"));
    wait("the build", || session.status().loading.is_some());
    drop(session);
    assert!(
        Arc::strong_count(&token) > 1,
        "closing waited for the build"
    );
}
