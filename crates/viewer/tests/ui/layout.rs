//! What moves in the window, and what must not.

use std::collections::BTreeSet;

use egui::accesskit::Role;
use egui::{Key, Modifiers, Vec2};
use egui_kittest::kittest::{By, NodeT as _, Queryable as _};

use crate::window::{SCENE, Window};

#[test]
fn f1_lists_the_keys() {
    let mut window = Window::open(SCENE);
    assert!(window.harness.query_by_label("orbit").is_none());
    window.key(Modifiers::NONE, Key::F1);
    assert!(window.harness.query_by_label("orbit").is_some());
    window.key(Modifiers::NONE, Key::Escape);
    assert!(window.harness.query_by_label("orbit").is_none());
}

/// Name and vertical middle of what has the keyboard.
fn focused(window: &Window) -> Option<(String, f32)> {
    let by = By::new().predicate(|node| node.is_focused());
    let node = window.harness.query_all(by).next()?;
    let name = node.accesskit_node().label().unwrap_or_default();
    Some((name, node.rect().center().y))
}

#[test]
fn the_keyboard_reaches_nothing_that_is_out_of_sight() {
    let mut window = Window::open(SCENE);
    let height = 300.0;
    window.harness.set_size(Vec2::new(700.0, height));
    window.harness.run_steps(4);
    let mut names = BTreeSet::new();
    for _ in 0..90 {
        window.harness.key_press(Key::Tab);
        // It glides into sight.
        window.harness.run_steps(15);
        if let Some((name, y)) = focused(&window) {
            assert!((0.0..height).contains(&y), "{name} at {y}");
            names.insert(name);
        }
    }
    for name in ["Scene", "Depth", "Exposure", "Add lamp", "Window", "Keys"] {
        assert!(names.contains(name), "{name} is not reached: {names:?}");
    }
}

#[test]
fn the_panel_does_not_push_the_picture() {
    let mut window = Window::open(SCENE);
    window.click("fit window");
    // As high as the panel before an object is selected, and less than after.
    let camera = window
        .harness
        .get_by_role_and_label(Role::DisclosureTriangle, "Camera");
    let height = camera.rect().bottom() + 60.0;
    window.harness.set_size(Vec2::new(620.0, height));
    window.harness.run_steps(20);
    let width = |w: &Window| w.harness.state().model().desc.render.width;
    let before = width(&window);
    assert!(before > 100);
    window.click_at(window.at(0.5, 0.5));
    assert!(window.harness.state().model().selection.is_some());
    for section in ["Camera", "Objects (3)"] {
        window
            .harness
            .get_by_role_and_label(Role::DisclosureTriangle, section)
            .click();
        window.harness.run_steps(20);
        assert_eq!(width(&window), before, "{section}");
    }
}

#[test]
fn the_picture_follows_the_window_when_it_rests() {
    let mut window = Window::open(SCENE);
    window.click("fit window");
    window.wait("the window's size", |w| w.snapshot().size[0] > 100);
    let size = |w: &Window| [w.status().desc.render.width, w.status().desc.render.height];
    let before = size(&window);
    // In frames of 1/30 s, the size is still for less than it takes.
    let mut frames = 0;
    window.harness.set_size(Vec2::new(630.0, 1400.0));
    while size(&window) == before {
        window.harness.step();
        frames += 1;
        assert!(frames < 100);
    }
    assert_eq!(size(&window), [before[0] + 10, before[1]]);
    assert!(frames > 5, "taken over at once");
}
