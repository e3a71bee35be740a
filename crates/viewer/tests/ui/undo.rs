//! Undo, redo, and the scene as a file.

use egui::{Key, Modifiers, PointerButton, Vec2};
use lightbox_core::scene;

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
    window.drag(
        PointerButton::Primary,
        window.at(0.5, 0.5),
        Vec2::new(40.0, 10.0),
    );
    window.harness.run_steps(2);
    steps.push(descs(&window));
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
    assert_eq!(*window.status().desc, steps[2]);
    // To read the file again drops the edits, and can be undone too.
    window.key(Modifiers::COMMAND, Key::R);
    window.wait("the file", |w| w.status().opened == 2);
    window.harness.run_steps(3);
    assert_eq!(descs(&window), steps[0]);
    window.key(Modifiers::COMMAND, Key::Z);
    assert_eq!(descs(&window), steps[2]);
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
