//! The Plan window: census, plan, what is lost, where the time goes.

use egui::accesskit::Role;
use egui::{Key, Modifiers, Vec2};
use egui_kittest::kittest::Queryable as _;
use lightbox_core::plan::Part;

use crate::window::{SCENE, Window};

fn open() -> Window {
    let mut window = Window::open(SCENE);
    window.harness.set_size(Vec2::new(1200.0, 1400.0));
    window.harness.run_steps(4);
    window.key(Modifiers::NONE, Key::F5);
    window
}

fn shows(window: &Window, text: &str) -> bool {
    window.harness.query_by_label(text).is_some()
}

#[test]
fn the_plan_says_what_is_left_out_and_escape_closes() {
    let mut window = open();
    for text in [
        "2 quads, 1 sphere",
        "2 diffuse materials",
        "1 rectangle",
        "black: what leaves the scene costs nothing more",
        "not measured yet",
        "shadow rays",
    ] {
        assert!(shows(&window, text), "{text}");
    }
    let expected = [Part::Tree, Part::LightChoice];
    assert_eq!(window.status().left_out, expected);
    assert_eq!(window.harness.query_all_by_label("left out").count(), 2);
    window.key(Modifiers::NONE, Key::Escape);
    assert!(!shows(&window, "not measured yet"));
    window.click("Plan");
    assert!(shows(&window, "not measured yet"));
}

#[test]
fn savings_are_measured_on_demand_and_belong_to_their_view() {
    let mut window = open();
    let samples = window.status().samples;
    window.click("Measure");
    window.wait("the savings", |w| w.status().savings.is_some());
    let status = window.status();
    let savings = status.savings.expect("savings");
    assert_eq!(savings.parts.len(), 2);
    assert!(!status.is_measuring && status.samples == samples);
    assert!(shows(&window, &format!("saves {}", savings.text())));
    // Done: nothing is left to do.
    let number = window.snapshot().number;
    window.harness.run_steps(10);
    assert_eq!(window.snapshot().number, number);

    let before = window.snapshot().rgb();
    window
        .harness
        .get_by_role_and_label(Role::CheckBox, "Full model")
        .click();
    window.done();
    assert!(window.status().savings.is_none());
    assert!(window.status().left_out.is_empty());
    assert!(shows(&window, "saves nothing"));
    assert!(
        window.snapshot().rgb() == before,
        "the full model shows another picture"
    );
}
