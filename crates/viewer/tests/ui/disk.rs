//! The scene's file: saved with its comments, changed by others, and left with edits.

use std::path::Path;

use egui::{PointerButton, Vec2};
use egui::{ViewportCommand, ViewportEvent, ViewportId};
use egui_kittest::kittest::Queryable as _;
use lightbox_core::scene;

use crate::window::{SCENE, Window};

fn commented() -> String {
    let text = SCENE.replace("[[sphere]]", "# In front of the wall.\n[[sphere]]");
    text.replace("radius = 0.5", "radius = 0.5 # half")
}

fn save_to(window: &mut Window, path: &Path) {
    window.harness.state().save(path.to_owned());
    let name = path
        .file_name()
        .expect("a name")
        .to_string_lossy()
        .into_owned();
    window.wait("word of it", |w| {
        let line = w.harness.query_by_label_contains(&name);
        line.is_some()
    });
}

#[test]
fn a_saved_scene_keeps_the_comments_of_its_file() {
    let mut window = Window::open(&commented());
    window.click_at(window.at(0.5, 0.5));
    window.set("Mirror", 0.75);
    window.click("Duplicate");
    window.done();
    let path = window.file("edited.toml");
    save_to(&mut window, &path);
    let text = std::fs::read_to_string(&path).expect("the file");
    for comment in ["# In front of the wall.", "# half"] {
        assert!(text.contains(comment), "{text}");
    }
    let source = scene::load(&path).expect("a scene");
    assert_eq!(source.desc, window.harness.state().model().desc);
    assert_eq!(source.desc.spheres.len(), 2);
}

#[test]
fn a_file_changed_on_disk_is_read_again_and_the_view_stays() {
    let mut window = Window::open(&commented());
    window.drag(
        PointerButton::Primary,
        window.at(0.5, 0.5),
        Vec2::new(40.0, 0.0),
    );
    window.done();
    let camera = window.status().desc.camera;
    let text = commented().replace("radius = 0.5", "radius = 0.75");
    std::fs::write(window.file("scene.toml"), &text).expect("written");
    window.wait("the file to be read again", |w| w.status().opened == 2);
    window.done();
    let desc = window.status().desc.clone();
    assert_eq!(desc.spheres[0].radius, 0.75);
    assert_eq!(desc.camera, camera, "the camera was moved here");
    // Where nothing was moved, the file's camera counts.
    window.key(egui::Modifiers::NONE, egui::Key::Home);
    window.harness.run_steps(30);
    let text = text.replace("eye = [0, 0, 4]", "eye = [0, 0, 5]");
    std::fs::write(window.file("scene.toml"), text).expect("written");
    window.wait("the file to be read again", |w| w.status().opened == 3);
    window.done();
    assert_eq!(window.eye().z, 5.0);
}

#[test]
fn edits_are_not_lost_to_a_file_changed_on_disk() {
    let mut window = Window::open(&commented());
    window.click_at(window.at(0.5, 0.5));
    window.set("Mirror", 0.75);
    window.done();
    let edited = window.status().desc.clone();
    let write = |window: &Window, radius: &str| {
        let text = commented().replace("radius = 0.5", &format!("radius = {radius}"));
        std::fs::write(window.file("scene.toml"), text).expect("written");
    };
    let asked = |w: &Window| {
        let line = w
            .harness
            .query_by_label_contains("scene.toml was changed on disk");
        line.is_some()
    };
    write(&window, "0.25");
    window.wait("the offer", asked);
    assert_eq!(window.status().opened, 1);
    window.click("Keep edits");
    assert!(!asked(&window));
    assert_eq!(window.status().desc, edited);
    write(&window, "0.125");
    window.wait("the offer", asked);
    window.click("Read again");
    window.wait("the file", |w| w.status().opened == 2);
    window.harness.run_steps(3);
    assert_eq!(window.status().desc.spheres[0].radius, 0.125);
    let lines = window.harness.query_all_by_label_contains("scene.toml");
    let lines: Vec<_> = lines.map(|line| format!("{line:?}")).collect();
    assert!(!asked(&window), "{lines:?}");
    window.key(egui::Modifiers::COMMAND, egui::Key::Z);
    assert_eq!(
        window.harness.state().model().desc.materials,
        edited.materials
    );
}

/// Whether the window asks what becomes of edits before it opens this file.
fn asks(window: &Window, name: &str) -> bool {
    let question = format!("Open {name}?");
    let line = window.harness.query_by_label_contains(&question);
    line.is_some()
}

/// Waits for that question; nothing is opened meanwhile.
fn asked(window: &mut Window, name: &str) {
    window.wait("the question", |w| asks(w, name));
    assert_eq!((window.status().opened, window.status().opening), (1, None));
}

/// A window with an edit, and another file to open.
fn edited_beside_another() -> (Window, std::path::PathBuf) {
    let mut window = Window::open(&commented());
    let other = window.file("other.toml");
    std::fs::write(&other, SCENE).expect("written");
    window.click_at(window.at(0.5, 0.5));
    window.set("Mirror", 0.75);
    window.done();
    (window, other)
}

#[test]
fn edits_are_not_lost_to_another_file() {
    let (mut window, other) = edited_beside_another();
    let edited = window.status().desc.clone();
    window.drop_file(&other);
    asked(&mut window, "other");
    window.click("Stay");
    assert!(!asks(&window, "other"));
    assert_eq!(window.status().desc, edited);

    let list = window
        .harness
        .get_by_role_and_label(egui::accesskit::Role::ComboBox, "Scene");
    list.click();
    window.harness.run_steps(2);
    window.click("white-furnace");
    asked(&mut window, "white-furnace");

    // The newest wish counts.
    window.drop_file(&other);
    asked(&mut window, "other");
    window.click("Open anyway");
    window.wait("the other file", |w| w.status().opened == 2);
    assert!(!asks(&window, "other"));
    let scene = window.status().scene.expect("a scene");
    assert_eq!(scene.path(), other);

    // Without edits there is nothing to ask.
    window.drop_file(&window.file("scene.toml"));
    window.wait("the first file", |w| w.status().opened == 3);
}

/// Whether the window says that opening loses nothing.
fn is_free(window: &Window) -> bool {
    let line = window.harness.query_by_label_contains("No edit is lost");
    line.is_some()
}

#[test]
fn edits_that_are_saved_while_the_question_stands_are_no_longer_at_stake() {
    let (mut window, other) = edited_beside_another();
    window.drop_file(&other);
    asked(&mut window, "other");
    assert!(!is_free(&window));
    // Taken back, nothing is at stake; done again, it is.
    window.key(egui::Modifiers::COMMAND, egui::Key::Z);
    assert!(is_free(&window));
    window.key(egui::Modifiers::COMMAND, egui::Key::Y);
    assert!(!is_free(&window));
    // No new picture, if one was taken back before the other was begun.
    window.wait("the edit", |w| w.is_current(&w.status()));
    // Whoever saves goes on looking at the scene: it is not taken away.
    let path = window.file("saved.toml");
    save_to(&mut window, &path);
    window.wait("the news", is_free);
    asked(&mut window, "other");
    window.set("Mirror", 0.5);
    assert!(!is_free(&window));
    window.done();
    save_to(&mut window, &path);
    window.wait("the news", is_free);
    window
        .harness
        .get_by_role_and_label(egui::accesskit::Role::Button, "Open")
        .click();
    window.wait("the other file", |w| w.status().opened == 2);
    assert!(!asks(&window, "other"));
}

#[test]
fn edits_that_come_while_a_file_is_opened_are_not_lost() {
    let mut window = Window::open(SCENE);
    window.click_at(window.at(0.5, 0.5));
    // In the frame in which it begins to open, nothing is edited yet.
    let slider = window
        .harness
        .get_by_role_and_label(egui::accesskit::Role::Slider, "Mirror");
    slider.set_value_accesskit(0.75);
    window.drop_file(Path::new("builtin:million.toml"));
    asked(&mut window, "million");
    window.click("Stay");
    window.done();
    assert_eq!(window.status().desc.materials[0].mirror, 0.75);
}

#[test]
fn reading_again_can_be_undone() {
    let mut window = Window::open(SCENE);
    window.click_at(window.at(0.5, 0.5));
    window.set("Mirror", 0.75);
    window.done();
    window.key(egui::Modifiers::COMMAND, egui::Key::R);
    window.wait("the file", |w| w.status().opened == 2);
    assert_eq!(window.harness.state().model().desc.materials[0].mirror, 0.0);
    let text = "read again without the edits; Ctrl+Z brings them back";
    assert!(window.harness.query_by_label(text).is_some());
    window.key(egui::Modifiers::COMMAND, egui::Key::Z);
    assert_eq!(
        window.harness.state().model().desc.materials[0].mirror,
        0.75
    );
}

/// Asks the window to close, as its frame's button does; whether it does.
fn closes(window: &mut Window) -> bool {
    let viewport = window.harness.input_mut().viewports.entry(ViewportId::ROOT);
    viewport.or_default().events.push(ViewportEvent::Close);
    window.harness.step();
    !sent(window, &ViewportCommand::CancelClose)
}

fn sent(window: &Window, command: &ViewportCommand) -> bool {
    let outputs = &window.harness.output().viewport_output;
    outputs
        .get(&ViewportId::ROOT)
        .is_some_and(|output| output.commands.contains(command))
}

#[test]
fn quitting_asks_what_becomes_of_edits() {
    let mut window = Window::open(&commented());
    // To look around is no edit.
    window.drag(
        PointerButton::Primary,
        window.at(0.5, 0.5),
        Vec2::new(40.0, 0.0),
    );
    assert!(closes(&mut window));
    window.click_at(window.at(0.5, 0.5));
    window.set("Mirror", 0.75);
    window.done();
    assert!(!closes(&mut window));
    window.harness.run_steps(2);
    window.click("Stay");
    assert!(window.harness.query_by_label("Stay").is_none());

    // Saved, there is nothing to ask.
    let path = window.file("scene.toml");
    save_to(&mut window, &path);
    assert!(closes(&mut window));
    assert_eq!(window.status().opened, 1, "one's own file is no news");

    window.set("Mirror", 0.25);
    assert!(!closes(&mut window));
    window.harness.run_steps(2);
    window
        .harness
        .get_by_role_and_label(egui::accesskit::Role::Button, "Quit without saving")
        .click();
    let mut has_closed = false;
    for _ in 0..4 {
        window.harness.step();
        has_closed |= sent(&window, &ViewportCommand::Close);
    }
    assert!(has_closed);
}
