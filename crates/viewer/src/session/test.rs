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
        let view = View::of(Arc::new(source.build(&|_| ()).expect("a scene"))).expect("a view");
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
