use std::sync::mpsc::channel;
use std::time::{Duration, Instant};

use lightbox_core::RenderSettings;

use super::*;

const PATIENCE: Duration = Duration::from_secs(60);

fn built(name: &str) -> Loaded {
    let path = format!("builtin:{name}.toml");
    let source = lightbox_core::scene::load(Path::new(&path)).expect("a scene");
    let scene = source.build(&|_| ()).expect("a scene");
    (source, scene, None)
}

/// An edit may want a new accelerator while the user opens a file. The file wins, and an edit that
/// comes later, and drops any rebuild it finds under way, must not take the file for one.
#[test]
fn opening_a_file_supersedes_a_rebuild_and_no_later_edit_abandons_it() {
    let shared = Arc::new(Shared::new(|| ()));
    let (finish_rebuild, until) = channel::<()>();
    *lock(&shared.rebuilding) = Some(Arc::default());
    shared.load("rebuild".into(), false, move |_| {
        until.recv().expect("the test goes on");
        Ok(built("sphere-mirror"))
    });
    let (finish_load, until) = channel::<()>();
    shared.load("file".into(), true, move |_| {
        until.recv().expect("the test goes on");
        Ok(built("glass-sphere"))
    });
    shared.abandon_rebuild();
    assert!(lock(&shared.outbox).status.loading.is_some());
    finish_rebuild.send(()).expect("it waits");
    finish_load.send(()).expect("it waits");

    let inbox = lock(&shared.inbox);
    let (inbox, waited) = shared
        .arrived
        .wait_timeout_while(inbox, PATIENCE, |inbox| inbox.opened.is_none())
        .expect("no panic");
    assert!(!waited.timed_out(), "the file was abandoned");
    let opened = inbox.opened.as_ref().expect("the file");
    assert!(opened.is_new);
    assert_eq!(opened.scene.path(), Path::new("builtin:glass-sphere.toml"));
}

fn wait(what: &str, holds: impl Fn() -> bool) {
    let start = Instant::now();
    while !holds() {
        assert!(start.elapsed() < PATIENCE, "waited in vain for {what}");
        std::thread::sleep(Duration::from_millis(2));
    }
}

/// Saved at any moment, in the midst of a pass too, an edited scene comes back bit for bit.
#[test]
fn a_saved_picture_can_be_made_again() {
    let folder = tempfile::tempdir().expect("a folder");
    let session = Session::new(2, || ()).expect("a session");
    session.open(Path::new("builtin:cornell-box.toml"));
    wait("the scene", || session.status().opened == 1);
    let mut desc = (*session.status().desc).clone();
    desc.render = RenderSettings {
        width: 400,
        height: 300,
        samples: 1 << 20,
        ..desc.render
    };
    desc.materials[0].albedo.x = 0.123_456_79;
    session.edit(1, desc.clone());
    wait("the edit", || session.status().is_edited);
    for i in 0..3 {
        let path = folder.path().join(format!("{i}.exr"));
        session.save(path.clone());
        wait("the file", || {
            let notices = session.take_notices();
            assert!(notices.iter().all(|n| !n.is_error), "{notices:?}");
            !notices.is_empty()
        });
        let saved = image_io::read(&path).expect("a picture");
        let (source, tone) = saved::load(&path).expect("the scene in it");
        assert_eq!(tone, Some(ToneMap::default()));
        assert_eq!(source.desc.materials, desc.materials);
        let view = View::of(Arc::new(source.build(&|_| ()).expect("a scene"))).expect("a view");
        let film = view.film();
        view.render(&film, source.desc.render.samples, &AtomicBool::new(false));
        assert!(film.develop() == saved, "picture {i} comes back otherwise");
    }
}
