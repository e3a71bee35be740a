use std::sync::atomic::AtomicBool;
use std::time::{Duration, Instant};

use glam::Vec3;
use lightbox_core::scene::MeshDesc;
use lightbox_core::{RenderSettings, View, image_io};

use super::*;

const PATIENCE: Duration = Duration::from_secs(60);

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
        let view =
            View::of(Arc::new(source.build(&scene::unwatched).expect("a scene"))).expect("a view");
        let film = view.film();
        view.render(&film, source.desc.render.samples, &AtomicBool::new(false));
        assert!(film.develop() == saved, "picture {i} comes back otherwise");
    }
}

/// A session in which the furnace's ball has just been edited and asks for a new accelerator.
fn edited_furnace() -> (Session, SceneDesc) {
    let session = Session::new(2, || ()).expect("a session");
    session.open(Path::new("builtin:white-furnace.toml"));
    wait("the scene", || session.status().opened == 1);
    let mut desc = (*session.status().desc).clone();
    desc.spheres[0].radius *= 0.5;
    (session, desc)
}

/// A scene that takes long enough to open for an edit to come in between.
fn slow_scene(folder: &Path) -> PathBuf {
    let path = folder.join("slow.toml");
    let text = "[camera]\neye = [0, 0, 3]\ntarget = [0, 0, 0]\n[[mesh]]\nboulder = 200_000\n";
    std::fs::write(&path, text).expect("a file");
    path
}

#[test]
fn an_edit_of_shapes_does_not_drop_a_file_that_is_being_opened() {
    let folder = tempfile::tempdir().expect("a folder");
    let (session, desc) = edited_furnace();
    let path = slow_scene(folder.path());
    session.open(&path);
    session.edit(1, desc);
    wait("the file", || session.status().opened == 2);
    let status = session.status();
    assert_eq!(status.scene.expect("a scene").path(), path);
    assert!(
        status.desc.spheres.is_empty(),
        "the edit was for the scene before"
    );
}

/// A rock of so many triangles that building its accelerator takes a while.
fn rock() -> MeshDesc {
    MeshDesc {
        name: "rock".into(),
        material: None,
        file: None,
        boulder: Some(100_000),
        scale: 0.1,
        rotate: Vec3::ZERO,
        translate: Vec3::ZERO,
    }
}

#[test]
fn an_edit_is_not_lost_when_the_one_before_is_refused_in_the_background() {
    let (session, mut desc) = edited_furnace();
    desc.meshes.push(rock());
    let mut bad = desc.clone();
    // Found out only when the accelerator is there.
    bad.materials[0].texture = Some("missing.png".into());
    session.edit(1, bad);
    wait("the build", || session.status().loading.is_some());
    session.edit(1, desc.clone());
    wait("the edit", || {
        let scene = session.status().scene;
        scene.is_some_and(|scene| scene.desc().same_shapes(&desc))
    });
}

/// A drag asks for new shapes with each frame: they are built one after another, not side by side.
#[test]
fn a_drag_of_a_shape_builds_one_accelerator_at_a_time() {
    let (session, mut desc) = edited_furnace();
    // That takes longer than several edits do.
    desc.meshes.push(MeshDesc {
        boulder: Some(300_000),
        ..rock()
    });
    session.edit(1, desc.clone());
    wait("the build", || session.status().loading.is_some());
    for step in 1..=30 {
        desc.spheres[0].center.x = step as f32 * 1e-3;
        session.edit(1, desc.clone());
        // Edits that come faster than the engine takes them are one.
        wait("the engine", || lock(&session.shared.inbox).edit.is_none());
    }
    wait("the edit", || {
        let scene = session.status().scene;
        scene.is_some_and(|scene| scene.desc().same_shapes(&desc))
    });
    let works = lock(&session.shared.outbox).works;
    assert!(works < 15, "{works} works for 31 edits");
}

#[test]
fn a_file_that_cannot_be_opened_does_not_drop_an_edit_of_shapes() {
    let (session, mut desc) = edited_furnace();
    desc.meshes.push(rock());
    session.edit(1, desc.clone());
    wait("the build", || session.status().loading.is_some());
    session.open(Path::new("missing.toml"));
    wait("the refusal", || !session.take_notices().is_empty());
    wait("the edit", || {
        let scene = session.status().scene;
        scene.is_some_and(|scene| scene.desc().same_shapes(&desc))
    });
}

/// What a session keeps in a file is taken up by the next one, which ends with the picture of one
/// render; a picture that is no longer the same leaves the file as it was.
#[test]
fn kept_samples_are_taken_up() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("kept.part");
    let notices = |session: &Session| {
        let notices = session.take_notices();
        assert!(notices.iter().all(|n| !n.is_error), "{notices:?}");
        notices
    };
    let samples_in = |path: &Path| part::read_head(path).map(|h| h.samples_per_pixel());
    let first = Session::new(2, || ()).expect("a session");
    first.open(Path::new("builtin:glass-sphere.toml"));
    wait("the scene", || first.status().opened == 1);
    let mut desc = (*first.status().desc).clone();
    (desc.render.width, desc.render.height) = (90, 60);
    desc.render.samples = 1 << 40;
    first.edit(1, desc.clone());
    wait("samples", || first.status().samples > 3);
    first.save(path.clone());
    wait("the file", || !notices(&first).is_empty());
    let saved = samples_in(&path).expect("a part");
    assert!(saved > 3);
    // Ends with what there is by then.
    wait("more samples", || first.status().samples > saved + 10);
    drop(first);
    let kept = samples_in(&path).expect("a part");
    assert!(kept > saved + 10, "{kept} after {saved}");

    let second = Session::new(2, || ()).expect("a session");
    second.open(&path);
    wait("the picture", || second.status().samples > 0);
    assert!(second.status().samples >= kept);
    let mut desc = (*second.status().desc).clone();
    desc.render.samples = kept + 7;
    second.edit(1, desc.clone());
    wait("the end", || {
        let status = second.status();
        status.activity == Activity::Done && status.samples >= kept + 7
    });
    let status = second.status();
    let scene = status.scene.clone().expect("a scene");
    let view = View::new(scene, &desc.camera, desc.render).expect("a view");
    let film = view.film();
    view.render(&film, status.samples, &AtomicBool::new(false));
    assert_eq!([status.paths, status.rays], film.work());
    let exr = folder.path().join("end.exr");
    second.save(exr.clone());
    wait("the picture's file", || {
        exr.exists() && !notices(&second).is_empty()
    });
    assert!(image_io::read(&exr).expect("a picture") == film.develop());

    // Another camera is another picture.
    wait("the last samples in the file", || {
        samples_in(&path) == Ok(status.samples)
    });
    desc.camera.eye.x += 0.01;
    second.edit(1, desc);
    wait("word of it", || {
        notices(&second)
            .iter()
            .any(|n| n.text.contains("keeps the picture as it was"))
    });
    drop(second);
    assert_eq!(samples_in(&path), Ok(status.samples));
}
