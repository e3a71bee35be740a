//! The Lab panel: cases, verdicts, pictures, scenes.

use egui::accesskit::Role;
use egui::{Key, Modifiers, Vec2};
use egui_kittest::kittest::Queryable as _;
use lightbox_core::lab::{Case, Check, cases};

use crate::window::{SCENE, Window};

fn open() -> Window {
    let mut window = Window::open(SCENE);
    window.harness.set_size(Vec2::new(1200.0, 1400.0));
    window.harness.run_steps(4);
    window.key(Modifiers::NONE, Key::F2);
    window
}

fn choose(window: &mut Window, case: &Case) {
    let name = format!("{}  {}", case.id, case.title);
    let entry = window.harness.get_by_role_and_label(Role::Button, &name);
    entry.scroll_to_me();
    window.harness.run_steps(4);
    window.click(&name);
}

/// Each is looked at, for a character without a glyph panics here.
#[test]
fn every_case_can_be_looked_at_and_escape_closes() {
    let mut window = open();
    for case in cases() {
        choose(&mut window, case);
        for text in [case.failure, case.cure] {
            assert!(window.harness.query_by_label(text).is_some(), "{text}");
        }
    }
    window.key(Modifiers::NONE, Key::Escape);
    assert!(window.harness.query_by_label("Run all").is_none());
    window.click("Lab");
    assert!(window.harness.query_by_label("Run all").is_some());
}

#[test]
fn a_case_is_measured_beside_the_naive_method() {
    let mut window = open();
    let case = lightbox_core::lab::find("S01").expect("the distant sphere");
    choose(&mut window, case);
    assert!(window.harness.query_by_label("not measured yet").is_some());
    assert!(window.harness.query_by_label(case.failure).is_some());
    window.click("Run");
    window.wait("the verdict", |w| {
        w.harness.query_by_label("holds").is_some()
    });
    let Check::Probe(probe) = case.check else {
        panic!("it has a probe")
    };
    for figure in probe() {
        assert!(window.harness.query_by_label(figure.what).is_some());
    }
}

#[test]
fn a_case_shows_two_pictures_and_opens_as_a_scene() {
    let mut window = open();
    if let Some(drawn) = cases().find(|case| case.picture.is_some()) {
        choose(&mut window, drawn);
        for name in ["naive", "lightbox"] {
            let label = format!("{} {name}", drawn.id);
            window.wait("the picture", |w| {
                let picture = w.harness.query_by_role_and_label(Role::Image, &label);
                picture.is_some()
            });
        }
    }
    if let Some(shown) = cases().find(|case| case.scene.is_some()) {
        choose(&mut window, shown);
        window.click("Open as scene");
        window.wait("the scene", |w| w.status().opened == 2);
        let path = window.status().scene.expect("a scene").path().to_owned();
        assert_eq!(path.to_str(), shown.scene);
    }
}
