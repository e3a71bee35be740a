//! What is remembered, how the window looks, and what it says to somebody new.

use std::collections::HashMap;

use egui::accesskit::Role;
use egui::{Key, Modifiers, PointerButton, Vec2};
use egui_kittest::kittest::Queryable as _;
use lightbox::settings::Settings;

use crate::window::{SCENE, Window};

/// What eframe keeps on disk.
#[derive(Default)]
pub struct Storage(HashMap<String, String>);

impl eframe::Storage for Storage {
    fn get_string(&self, key: &str) -> Option<String> {
        self.0.get(key).cloned()
    }

    fn set_string(&mut self, key: &str, value: String) {
        self.0.insert(key.to_owned(), value);
    }

    fn remove_string(&mut self, key: &str) {
        self.0.remove(key);
    }

    fn flush(&mut self) {}
}

pub fn unfold(window: &mut Window, section: &str) {
    let section = window
        .harness
        .get_by_role_and_label(Role::DisclosureTriangle, section);
    section.click();
    window.harness.run_steps(20);
}

#[test]
fn files_bookmarks_and_panels_are_there_the_next_time() {
    let mut window = Window::open(SCENE);
    window.drag(
        PointerButton::Primary,
        window.at(0.5, 0.5),
        Vec2::new(40.0, 0.0),
    );
    window.key(Modifiers::COMMAND, Key::Num5);
    let place = window.status().desc.camera;
    window.key(Modifiers::NONE, Key::F3);
    window.key(Modifiers::NONE, Key::T);
    let other = window.file("other.toml");
    std::fs::write(&other, SCENE).expect("written");
    window.drop_file(&other);
    window.wait("the other file", |w| w.status().opened == 2);
    window.harness.run_steps(2);
    let mut storage = Storage::default();
    eframe::App::save(window.harness.state_mut(), &mut storage);
    let Window { folder, .. } = window;

    let settings = Settings::load(Some(&storage));
    assert!(settings.is_chart_open && settings.free_orbit && settings.is_acquainted);
    let mut window = Window::remembering(folder, other, settings);
    window.key(Modifiers::NONE, Key::Num5);
    let text = "bookmark 5 is empty";
    assert!(window.harness.query_by_label_contains(text).is_some());
    // The file before is in the list of scenes, and has its bookmark.
    let list = |w: &Window| {
        w.harness
            .get_by_role_and_label(Role::ComboBox, "Scene")
            .rect()
    };
    window.click_at(list(&window).center());
    window.click("scene.toml");
    window.wait("the first file", |w| w.status().opened == 2);
    window.harness.run_steps(3);
    assert_ne!(window.status().desc.camera, place);
    window.key(Modifiers::NONE, Key::Num5);
    window.harness.run_steps(30);
    assert_eq!(window.harness.state().model().desc.camera, place);
}

#[test]
fn settings_that_cannot_be_read_are_none() {
    let mut storage = Storage::default();
    eframe::Storage::set_string(&mut storage, "lightbox", "(files: 3".into());
    assert_eq!(Settings::load(Some(&storage)), Settings::default());
    assert_eq!(Settings::load(None), Settings::default());
}

#[test]
fn theme_and_scale_are_chosen_in_the_panel() {
    let mut window = Window::open(SCENE);
    unfold(&mut window, "Window");
    for (name, theme) in [("light", egui::Theme::Light), ("dark", egui::Theme::Dark)] {
        window.click(name);
        assert_eq!(window.harness.ctx.theme(), theme);
    }
    window.harness.set_size(Vec2::new(1280.0, 1400.0));
    window.harness.run_steps(3);
    let width = |w: &Window| w.harness.get_by_label("Picture").rect().width();
    let before = width(&window);
    unfold(&mut window, "Window");
    unfold(&mut window, "Window");
    assert_eq!(width(&window), before, "no row is too wide");
    for (name, share) in [("125 %", 1.25), ("200 %", 2.0), ("100 %", 1.0)] {
        // What is larger has to be scrolled to.
        let button = window.harness.get_by_role_and_label(Role::Button, name);
        button.scroll_to_me();
        window.harness.run_steps(20);
        window.click(name);
        window.harness.run_steps(3);
        assert_eq!(window.harness.ctx.zoom_factor(), share);
        // The picture is as large as the panel leaves room for, and the panel no wider than it was.
        assert!(width(&window) > 200.0, "{name}: {}", width(&window));
    }
    assert_eq!(width(&window), before);
}

#[test]
fn the_first_move_makes_acquainted() {
    let mut window = Window::open(SCENE);
    let is_known = |w: &Window| w.harness.state().settings().is_acquainted;
    window.set("Depth", 3.0);
    window.harness.hover_at(window.at(0.5, 0.5));
    window.harness.run_steps(5);
    assert!(!is_known(&window), "the picture was not touched");
    window.click_at(window.at(0.5, 0.5));
    assert!(is_known(&window));
}
