//! The race in the window.

use egui::accesskit::Role;
use egui::{Key, Modifiers};
use egui_kittest::kittest::Queryable as _;
use lightbox::session::Activity;

use crate::window::{SCENE, Window};

fn open_race(scene: &str) -> Window {
    let mut window = Window::open(scene);
    window.key(Modifiers::NONE, Key::F4);
    window.harness.run_steps(4);
    number(&mut window, "Seconds each", 0.3);
    number(&mut window, "Seeds", 1.0);
    window
}

fn number(window: &mut Window, name: &str, value: f64) {
    window
        .harness
        .get_by_role_and_label(Role::SpinButton, name)
        .set_value_accesskit(value);
    window.harness.run_steps(2);
}

fn tick(window: &mut Window, name: &str) {
    window
        .harness
        .get_by_role_and_label(Role::CheckBox, name)
        .click();
    window.harness.run_steps(2);
}

fn has(window: &Window, part: &str) -> bool {
    let mut found = window.harness.query_all_by_label_contains(part);
    found.next().is_some()
}

#[test]
fn ways_race_while_the_picture_rests() {
    let mut window = open_race(SCENE);
    // More than is rendered meanwhile.
    window.set("Samples", 1e6);
    window.wait("the render", |w| w.status().activity == Activity::Rendering);
    tick(&mut window, "nee");
    tick(&mut window, "mis");
    tick(&mut window, "caustics");
    tick(&mut window, "independent");
    assert!(has(&window, "4 contestants"));
    window.click("Start");
    window.wait("the picture to rest", |w| {
        w.status().activity == Activity::Paused
    });
    // To rest for a race is no pause: nobody needs to end it, nor can.
    window.harness.get_by_label("RACING");
    assert!(window.harness.query_by_label("Resume").is_none());
    window.key(Modifiers::NONE, Key::Space);
    window.wait("the end of the race", |w| has(w, "naive independent and"));
    window.wait("the picture to go on", |w| {
        w.status().activity == Activity::Rendering
    });
    for label in ["naive sobol", "reuse sobol", "efficiency", "Race curves"] {
        assert!(has(&window, label), "{label}");
    }
    assert!(window.harness.query_by_label("Agreement map").is_none());
    let headline = window
        .harness
        .query_all_by_label_contains("naive sobol and reuse sobol")
        .next();
    headline.expect("a comparison").click();
    window.harness.run_steps(3);
    window.harness.get_by_label("Agreement map");
    window.key(Modifiers::NONE, Key::Escape);
    assert!(!has(&window, "Race curves"));
}

#[test]
fn a_race_that_is_stopped_keeps_what_it_has() {
    let mut window = open_race(SCENE);
    // The reference takes as long as all contestants together.
    number(&mut window, "Seconds each", 3.0);
    tick(&mut window, "naive");
    tick(&mut window, "nee");
    window.click("Start");
    window.wait("the race itself", |w| has(w, "race, "));
    window.click("Stop");
    window.wait("the end", |w| w.harness.query_by_label("Start").is_some());
    // What there is can be saved, and is less than was asked for.
    assert!(has(&window, "Save…"));
    let seconds = |text: &str| text.parse::<f64>().ok().filter(|s| (0.0..3.0).contains(s));
    let labels = window.harness.query_all_by_role(Role::Label);
    let cells = labels.filter_map(|label| seconds(&label.value()?));
    assert!(cells.count() > 0);
}

#[test]
fn nothing_races_in_the_dark() {
    let dark = SCENE.replace("emission = [5, 5, 5]", "emission = [0, 0, 0]");
    let mut window = open_race(&dark);
    window.click("Start");
    assert!(has(&window, "nothing emits light"));
    for method in ["naive", "nee", "mis", "caustics", "reuse"] {
        tick(&mut window, method);
    }
    assert!(has(&window, "0 contestants"));
}
