//! Files: opening, dropping, saving.

use std::path::Path;

use egui::{Key, Modifiers, PointerButton, Vec2};
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable as _;
use lightbox::app::App;
use lightbox::session::Activity;
use lightbox_core::image_io;

use crate::window::{SCENE, Window};

#[test]
fn opens_a_built_in_scene_without_a_path() {
    let builder = Harness::builder().with_size(Vec2::new(500.0, 300.0));
    let harness =
        builder.build_eframe(|context| App::new(&context.egui_ctx, None).expect("an engine"));
    let mut window = Window {
        harness,
        folder: tempfile::tempdir().expect("a folder"),
        seen: 0,
    };
    window.wait("the scene to open", |w| {
        w.status().opened == 1 && w.harness.state().session().snapshot().is_some()
    });
    let scene = window.status().scene.expect("a scene");
    assert_eq!(scene.path(), Path::new(lightbox_core::scene::BUILTIN[0]));
}

#[test]
fn pictures_are_saved_in_both_formats() {
    let mut window = Window::open(SCENE);
    for name in ["a.png", "a.exr"] {
        let path = window.file(name);
        window.harness.state().save(path.clone());
        window.wait("the file", |w| {
            w.harness.query_by_label_contains(name).is_some()
        });
        let image = image_io::read(&path).expect("a picture");
        assert_eq!((image.width, image.height), (40, 30));
    }
    window.harness.state().save(window.file("a.gif"));
    window.wait("the complaint", |w| {
        w.harness.query_by_label_contains("a.gif").is_some()
    });
}

/// A scene as edited is in no file but the picture: the picture renders again, and opens.
#[test]
fn a_picture_of_an_edited_scene_is_its_scene() {
    let mut window = Window::open(SCENE);
    window.click_at(window.at(0.5, 0.5));
    window.set("Mirror", 0.7);
    window.set("Exposure", 0.7);
    window.drag(
        PointerButton::Primary,
        window.at(0.5, 0.5),
        Vec2::new(30.0, 10.0),
    );
    window.done();
    let (edited, shown) = (window.status().desc.clone(), window.snapshot().rgb());
    for name in ["é.png", "é.exr"] {
        let path = window.file(name);
        window.harness.state().save(path.clone());
        window.wait("the file", |w| {
            w.harness.query_by_label_contains(name).is_some()
        });
        let text = image_io::read_text(&path)
            .expect("readable")
            .expect("a text");
        let words = text
            .lines()
            .next()
            .and_then(|l| l.strip_prefix("lightbox "));
        let again = window.file(&format!("again {name}"));
        let script = format!("\"$0\" {} -o \"$1\"", words.expect("a command"));
        let replay = std::process::Command::new("sh")
            .args(["-c", &script, env!("CARGO_BIN_EXE_lightbox")])
            .arg(&again)
            .output()
            .expect("a shell");
        assert!(replay.status.success(), "{text}\n{replay:?}");
        let bytes = |path: &Path| std::fs::read(path).expect("a picture");
        assert!(bytes(&path) == bytes(&again), "{text}");
    }

    // Opened again, it is as it was left.
    window.set("Mirror", 0.0);
    window.set("Exposure", 0.0);
    window.key(Modifiers::NONE, Key::Home);
    window.click("fit window");
    window.drop_file(&window.file("é.png"));
    window.wait("the picture", |w| w.status().opened == 2);
    window.done();
    assert_eq!(window.status().desc, edited);
    assert!(window.snapshot().rgb() == shown);
    assert!(!window.status().is_edited);
}

#[test]
fn a_bad_file_leaves_the_scene_and_says_why() {
    let mut window = Window::open(SCENE);
    let bad = window.file("bad.toml");
    std::fs::write(&bad, "[camera]\nfov = 400\n").expect("written");
    let before = window.snapshot();
    window.drop_file(&bad);
    window.wait("the complaint", |w| {
        w.harness.query_by_label_contains("fov is 400").is_some()
    });
    assert_eq!(window.status().opened, 1);
    assert_eq!(window.snapshot().number, before.number);
    window.click("Dismiss");
    assert!(window.harness.query_by_label_contains("bad.toml").is_none());
    let image = lightbox_core::Image {
        width: 1,
        height: 1,
        pixels: vec![glam::Vec3::ONE],
    };
    for (name, text, complaint) in [
        ("a.png", "", "without a scene"),
        (
            "b.exr",
            "lightbox render a.toml\n[scene]\n",
            "cannot be read",
        ),
    ] {
        let picture = window.file(name);
        image_io::write(&picture, &image, Default::default(), text).expect("written");
        window.drop_file(&picture);
        window.wait("the complaint", |w| {
            w.harness.query_by_label_contains(complaint).is_some()
        });
    }
    assert_eq!(window.status().opened, 1);
    // What is not opened ends no pause.
    window.set("Samples", 60_000.0);
    window.wait("rendering", |w| w.status().activity == Activity::Rendering);
    window.key(Modifiers::NONE, Key::Space);
    window.wait("the pause", |w| w.status().activity == Activity::Paused);
    window.drop_file(&bad);
    window.wait("the complaint", |w| {
        w.harness.query_by_label_contains("fov is 400").is_some()
    });
    // The engine takes wishes in turn: when it has drawn this one, it knows all before.
    let number = window.snapshot().number;
    window.set("Exposure", 0.5);
    window.wait("another look", |w| w.snapshot().number > number);
    assert_eq!(window.status().activity, Activity::Paused);
    let picture = window.file("a.jpeg");
    window.drop_file(&picture);
    assert!(
        window
            .harness
            .query_by_label_contains("not a scene")
            .is_some()
    );
}

#[test]
fn a_dropped_mesh_opens_in_a_room() {
    let mut window = Window::open(SCENE);
    let mesh = window.file("tent.obj");
    std::fs::write(&mesh, "v -1 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n").expect("written");
    window
        .harness
        .input_mut()
        .hovered_files
        .push(egui::HoveredFile {
            path: Some(mesh.clone()),
            ..Default::default()
        });
    window.harness.run_steps(1);
    window.harness.input_mut().hovered_files.clear();
    window.drop_file(&mesh);
    window.wait("the mesh", |w| w.status().opened == 2);
    assert_eq!(window.harness.state().model().desc.meshes[0].name, "tent");
    window.wait("its census", |w| {
        w.harness
            .query_by_label_contains("1 triangle, 6 quads, 1 light")
            .is_some()
    });
}

#[test]
fn opening_a_large_scene_can_be_called_off() {
    let mut window = Window::open(SCENE);
    let path = window.file("large.toml");
    std::fs::write(&path, "[[mesh]]\nboulder = 500_000\n").expect("written");
    window.drop_file(&path);
    window.wait("word of it", |w| {
        let line = w.harness.query_by_label_contains("Opening large");
        line.is_some()
    });
    // The old scene is there meanwhile.
    window.set("Depth", 3.0);
    window.click("Cancel");
    assert!(
        window
            .harness
            .query_by_label_contains("Opening large")
            .is_none()
    );
    window.done();
    assert_eq!(window.status().opened, 1);
}
