//! Undo, redo, and the scene as a file.

use egui::{Key, Modifiers, PointerButton, Vec2};
use lightbox_core::{SceneDesc, scene};

use crate::window::{SCENE, Window};

const REDO: Modifiers = Modifiers::COMMAND.plus(Modifiers::SHIFT);

#[test]
fn edits_are_taken_back_one_gesture_at_a_time() {
    let mut window = Window::open(SCENE);
    let descs = |window: &Window| window.harness.state().model().desc.clone();
    let mut steps = vec![descs(&window)];
    window.set("Depth", 3.0);
    window.harness.run_steps(2);
    steps.push(descs(&window));
    // To look around is no edit: the camera has a history of its own.
    window.drag(
        PointerButton::Primary,
        window.at(0.5, 0.5),
        Vec2::new(40.0, 10.0),
    );
    window.harness.run_steps(2);
    let camera = descs(&window).camera;
    assert_ne!(camera, steps[0].camera);
    for step in &mut steps {
        step.camera = camera;
    }
    window.click_at(window.at(0.5, 0.5));
    window.set("Mirror", 0.7);
    window.harness.run_steps(2);
    steps.push(descs(&window));
    assert!(steps.windows(2).all(|pair| pair[0] != pair[1]));
    for expected in steps.iter().rev().skip(1) {
        window.key(Modifiers::COMMAND, Key::Z);
        assert_eq!(descs(&window), *expected);
    }
    window.key(Modifiers::COMMAND, Key::Z);
    assert_eq!(descs(&window), steps[0]);
    for expected in &steps[1..] {
        window.key(REDO, Key::Z);
        assert_eq!(descs(&window), *expected);
    }
    // The picture follows.
    window.click("Undo");
    window.done();
    assert_eq!(*window.status().desc, steps[1]);
    // To read the file again drops the edits, and can be undone too.
    window.key(Modifiers::COMMAND, Key::R);
    window.wait("the file", |w| w.status().opened == 2);
    window.harness.run_steps(3);
    let home = descs(&window).camera;
    let from_home = |step: &SceneDesc| SceneDesc {
        camera: home,
        ..step.clone()
    };
    assert_eq!(descs(&window), from_home(&steps[0]));
    assert_ne!(home, camera);
    window.key(Modifiers::COMMAND, Key::Z);
    assert_eq!(descs(&window), from_home(&steps[1]));
    window.key(Modifiers::ALT, Key::ArrowLeft);
    assert_eq!(descs(&window), steps[1]);
}

#[test]
fn a_saved_scene_is_the_scene_as_edited() {
    let mut window = Window::open(SCENE);
    window.click_at(window.at(0.5, 0.5));
    window.set("Mirror", 0.7);
    window.set("Depth", 5.0);
    window.done();
    let path = window.file("edited.toml");
    window.harness.state().save(path.clone());
    window.wait("the file", |w| path.exists() || w.status().opened > 1);
    let source = scene::load(&path).expect("a scene");
    assert_eq!(source.desc, *window.status().desc);
    window
        .harness
        .state()
        .save(window.file("no/such/folder.toml"));
    window.wait("the complaint", |w| {
        use egui_kittest::kittest::Queryable as _;
        let lines = w
            .harness
            .query_by_label_contains("folder.toml: cannot be written");
        lines.is_some()
    });
}
