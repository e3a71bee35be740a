//! The pixel autopsy: which pixel, what its samples have found, one path step by step.

use egui::accesskit::Role;
use egui::{Event, Key, Modifiers, PointerButton, Pos2, Vec2};
use egui_kittest::kittest::{NodeT as _, Queryable as _};
use lightbox_core::color::luminance;

use crate::window::{SCENE, Window};

/// The scene with as many samples as are traced again at least.
fn scene() -> String {
    SCENE.replace("samples = 16", "samples = 1024")
}

fn ctrl_click(window: &mut Window, pos: Pos2) {
    window.harness.hover_at(pos);
    window.harness.run_steps(1);
    for pressed in [true, false] {
        window.harness.event_modifiers(
            Event::PointerButton {
                pos,
                button: PointerButton::Primary,
                pressed,
                modifiers: Modifiers::COMMAND,
            },
            Modifiers::COMMAND,
        );
    }
    window.harness.run_steps(4);
}

fn has(window: &Window, part: &str) -> bool {
    let mut found = window.harness.query_all_by_label_contains(part);
    found.next().is_some()
}

fn wait_for(window: &mut Window, part: &str) {
    window.wait(part, |w| has(w, part));
}

/// The text of the only label with a part.
#[track_caller]
fn text(window: &Window, part: &str) -> String {
    let node = window.harness.get_by_label_contains(part);
    node.accesskit_node().value().expect("a text")
}

fn number(window: &Window, field: &str) -> f64 {
    let node = window
        .harness
        .get_by_role_and_label(Role::SpinButton, field);
    node.accesskit_node().numeric_value().expect("a number")
}

/// Mean and standard error as the window tells them.
#[track_caller]
fn told(window: &Window) -> [f64; 2] {
    let text = text(window, "as if samples were independent");
    let words: Vec<&str> = text.split_whitespace().collect();
    [words[0], words[2]].map(|word| word.parse().expect("a number"))
}

#[test]
fn ctrl_and_a_click_look_into_the_samples_of_a_pixel() {
    let mut window = Window::open(&scene());
    let on_ball = window.at(0.51, 0.51);
    ctrl_click(&mut window, on_ball);
    assert_eq!(window.harness.state().model().selection, None);
    wait_for(
        &mut window,
        "1\u{a0}024 samples, 1\u{a0}024 of them in the picture",
    );
    assert_eq!(
        [number(&window, "Pixel x"), number(&window, "Pixel y")],
        [20.0, 15.0]
    );
    for chart in ["Histogram of samples", "Convergence of the pixel"] {
        window.harness.get_by_role_and_label(Role::Image, chart);
    }
    // The mean of the samples is what the picture shows there.
    let pixel = window
        .harness
        .state()
        .session()
        .pixel([20, 15])
        .expect("samples");
    let [mean, error] = told(&window);
    let right = f64::from(luminance(pixel.mean));
    assert!((mean / right - 1.0).abs() < 0.005, "{mean} {right}");
    assert!(error > 0.0 && error < mean, "{error}");
    // Two strategies found it, on paths of two segments and more.
    for column in ["light\nmet", "light\naimed at", "variance\naimed at"] {
        window.harness.get_by_label(column);
    }
    assert!(!has(&window, "by mirror") && !has(&window, "Light paths"));
    // A click without Ctrl still selects.
    window.key(Modifiers::NONE, Key::Escape);
    assert!(!has(&window, "Histogram of samples"));
    window.click_at(on_ball);
    assert!(window.harness.state().model().selection.is_some());
}

/// It may have to be scrolled to.
fn click_brightest(window: &mut Window) {
    let button = |w: &Window| {
        w.harness
            .get_by_role_and_label(Role::Button, "Brightest")
            .scroll_to_me()
    };
    button(window);
    window.harness.run_steps(8);
    window.click("Brightest");
}

#[test]
fn a_path_is_followed_step_by_step() {
    let mut window = Window::open(&scene());
    let middle = window.at(0.51, 0.51);
    window.harness.hover_at(middle);
    window.key(Modifiers::NONE, Key::P);
    wait_for(&mut window, "of them in the picture");
    assert_eq!(
        [number(&window, "Pixel x"), number(&window, "Pixel y")],
        [20.0, 15.0]
    );
    assert!(has(&window, "sample 0, RGB"));
    window.set("Step", 1.0);
    assert!(has(&window, "1. ball, clay after 3.5") && !has(&window, "2. "));
    assert!(!has(&window, "It ends here"));
    // Of the first 48 paths and the brightest, the brightest brings most.
    window.set("Path", 5.0);
    assert!(has(&window, "sample 5, RGB"));
    click_brightest(&mut window);
    let brightest = text(&window, ", RGB");
    let light = |text: &str| -> f64 {
        let red = text
            .split("RGB ")
            .nth(1)
            .and_then(|rest| rest.split(' ').next());
        red.and_then(|red| red.parse().ok()).expect("a number")
    };
    for path in [0.0, 9.0, 30.0] {
        window.set("Path", path);
        assert!(light(&text(&window, ", RGB")) <= light(&brightest));
    }
    // What was found on the way adds up to the sample.
    click_brightest(&mut window);
    let parts = window.harness.query_all_by_label_contains("    ");
    let texts = parts.filter_map(|n| n.accesskit_node().value());
    let found = |text: String| -> Option<f64> {
        let is_found = ["    met: ", "    aimed at "]
            .iter()
            .any(|start| text.starts_with(start));
        let numbers = text.split(": ").nth(1).filter(|_| is_found)?;
        numbers.split(' ').next()?.parse().ok()
    };
    let sum: f64 = texts.filter_map(found).sum();
    assert!(
        (sum / light(&brightest) - 1.0).abs() < 0.02,
        "{sum} {brightest}"
    );
}

#[test]
fn paths_stay_when_the_picture_changes_until_asked_again() {
    let mut window = Window::open(&scene());
    let middle = window.at(0.51, 0.51);
    ctrl_click(&mut window, middle);
    wait_for(&mut window, "of them in the picture");
    let before = told(&window);
    let from = window.at(0.95, 0.9);
    window.drag(PointerButton::Primary, from, Vec2::new(-60.0, 0.0));
    window.done();
    wait_for(&mut window, "The picture has changed since");
    assert_eq!(told(&window), before);
    window.click("Again");
    window.wait("the new samples", |w| {
        !has(w, "has changed since") && has(w, "as if samples")
    });
    assert!(told(&window) != before);
    // Another pixel by its number.
    let field = window
        .harness
        .get_by_role_and_label(Role::SpinButton, "Pixel y");
    field.set_value_accesskit(2.0);
    window.harness.run_steps(2);
    window.wait("the other pixel", |w| has(w, "as if samples"));
    assert_eq!(number(&window, "Pixel y"), 2.0);
}
