//! The error chart: curves, looking back, references.

use egui::accesskit::Role;
use egui::{Key, Modifiers, Pos2};
use egui_kittest::kittest::Queryable as _;
use lightbox_core::color::ToneMap;
use lightbox_core::{Image, image_io};

use crate::window::{SCENE, Window};

fn open_chart(window: &mut Window) {
    window.key(Modifiers::NONE, Key::F3);
    window.harness.run_steps(4);
}

/// A place in the chart, in shares of its width and height.
fn in_chart(window: &Window, x: f32, y: f32) -> Pos2 {
    let rect = window.harness.get_by_label("Error curves").rect();
    rect.min + rect.size() * egui::vec2(x, y)
}

fn has_line(window: &Window, part: &str) -> bool {
    window
        .harness
        .query_all_by_label_contains(part)
        .next()
        .is_some()
}

fn seed(window: &mut Window, seed: f64) {
    window
        .harness
        .get_by_role_and_label(Role::SpinButton, "Seed")
        .set_value_accesskit(seed);
    window.harness.run_steps(2);
}

fn choose_reference(window: &mut Window, entry: &str) {
    window.click("Reference");
    window.click(entry);
    window.harness.run_steps(4);
}

#[test]
fn f3_shows_the_chart_and_it_tells_the_present() {
    let mut window = Window::open(SCENE);
    assert!(window.harness.query_by_label("Error curves").is_none());
    open_chart(&mut window);
    window.harness.get_by_label("Error curves");
    assert!(has_line(&window, "now: 16 spp"));
    let history = window.harness.state().session().history();
    let run = history.present.as_ref().expect("a curve");
    let last = run.points.last().expect("a point");
    let status = window.status();
    assert_eq!(
        (
            last.samples,
            last.rays,
            last.noise.map(|n| n.value),
            last.error
        ),
        (16, status.rays, status.noise, None)
    );
    assert!(run.points.windows(2).all(|w| w[0].samples < w[1].samples
        && w[0].rays < w[1].rays
        && w[0].seconds < w[1].seconds));
    for axis in ["rays", "samples"] {
        window.click(axis);
    }
    window.key(Modifiers::NONE, Key::Escape);
    assert!(window.harness.query_by_label("Error curves").is_none());
}

/// Number of curves of earlier pictures.
fn earlier(window: &Window) -> usize {
    window.harness.state().session().history().earlier.len()
}

#[test]
fn the_chart_shows_the_picture_as_it_was_while_rendering_goes_on() {
    let mut window = Window::open(SCENE);
    window.set("Exposure", 0.5);
    // What the picture is at two samples; then much more of it.
    window.set("Samples", 2.0);
    seed(&mut window, 1.0);
    window.wait("two samples of the new seed", |w| {
        let history = w.harness.state().session().history();
        let is_new = history
            .present
            .as_ref()
            .is_some_and(|run| run.desc.render.seed == 1);
        is_new && w.status().samples == 2
    });
    window.done();
    let at_two = window.snapshot();
    window.set("Samples", 200_000.0);
    open_chart(&mut window);
    // The pictures before this one are near the pointer too.
    window.click("Clear");
    window.wait("no earlier curves", |w| earlier(w) == 0);
    window.wait("a curve", |w| w.status().samples > 64);
    window.harness.hover_at(in_chart(&window, 0.02, 0.05));
    let past = |w: &Window| w.harness.state().session().past();
    window.wait("the picture as it was", |w| past(w).is_some());
    let shown = past(&window).expect("a picture");
    assert_eq!(shown.past.map(|p| p.samples), Some(2));
    assert!(shown.rgb() == at_two.rgb(), "not what it was");
    let samples = window.status().samples;
    window.wait("more samples", |w| w.status().samples > samples);
    assert!(past(&window).is_some());
    // How it is shown may change meanwhile.
    window.key(Modifiers::NONE, Key::E);
    window.wait("a brighter picture", |w| {
        past(w).is_some_and(|p| p.number != shown.number)
    });
    assert!(past(&window).is_some_and(|p| p.rgb() != at_two.rgb()));
    window.harness.hover_at(window.at(0.5, 0.02));
    window.wait("the present", |w| past(w).is_none());
}

#[test]
fn earlier_curves_stay_until_they_are_cleared() {
    let mut window = Window::open(SCENE);
    open_chart(&mut window);
    window.click("Clear");
    window.wait("no earlier curves", |w| earlier(w) == 0);
    for method in ["naive", "nee"] {
        window.click(method);
        window.done();
    }
    assert_eq!(earlier(&window), 2);
    for name in ["reuse", "naive", "1/√N", "noise"] {
        window.harness.get_by_role_and_label(Role::CheckBox, name);
    }
    // More samples are the same curve.
    window.set("Samples", 32.0);
    window.done();
    assert_eq!(earlier(&window), 2);
    window.click("Clear");
    window.wait("no earlier curves", |w| earlier(w) == 0);
    assert!(
        window
            .harness
            .query_by_role_and_label(Role::CheckBox, "reuse")
            .is_none()
    );
}

#[test]
fn a_reference_turns_noise_into_error() {
    let mut window = Window::open(SCENE);
    open_chart(&mut window);
    choose_reference(&mut window, "Keep this picture");
    window.wait("an error", |w| w.status().true_error.is_some());
    // Compared with itself.
    assert_eq!(window.status().true_error, Some(0.0));
    assert!(has_line(&window, "same random numbers"));
    seed(&mut window, 5.0);
    window.wait("another picture", |w| {
        w.status().true_error.is_some_and(|e| e > 0.0)
    });
    window.done();
    assert!(!has_line(&window, "same random numbers"));
    let status = window.status();
    let (noise, error) = (
        status.noise.expect("noise"),
        status.true_error.expect("error"),
    );
    // The reference is as noisy as the picture.
    let ratio = error / (noise * 2f64.sqrt());
    assert!(
        (0.7..1.4).contains(&ratio),
        "{error} for a noise of {noise}"
    );
    let history = window.harness.state().session().history();
    let run = history.present.as_ref().expect("a curve");
    assert!(run.points.iter().all(|p| p.error.is_some()));
    choose_reference(&mut window, "No reference");
    window.wait("no error", |w| w.status().true_error.is_none());
}

#[test]
fn a_reference_must_have_the_picture_s_size() {
    let mut window = Window::open(SCENE);
    open_chart(&mut window);
    let picture = |width: u32, height: u32| Image {
        width,
        height,
        pixels: vec![glam::Vec3::splat(0.25); (width * height) as usize],
    };
    let (other, same) = (window.file("other.exr"), window.file("same.exr"));
    for (path, image) in [(&other, picture(8, 8)), (&same, picture(40, 30))] {
        image_io::write(path, &image, ToneMap::default(), "").expect("a file");
    }
    window.harness.state().session().load_reference(other);
    window.wait("the refusal", |w| {
        has_line(w, "the image is 40x30 but the reference 8x8")
    });
    assert!(window.status().reference.is_none());
    let missing = window.file("none.exr");
    window.harness.state().session().load_reference(missing);
    window.wait("the refusal", |w| has_line(w, "none.exr"));
    window.harness.state().session().load_reference(same);
    window.wait("an error", |w| w.status().true_error.is_some());
    // The curve so far is measured where its pictures are kept.
    let history = window.harness.state().session().history();
    let run = history.present.as_ref().expect("a curve");
    assert!(
        run.points
            .iter()
            .any(|p| p.samples == 4 && p.error.is_some())
    );
    window.click("fit window");
    window.wait("another size", |w| has_line(w, "not compared"));
    window.wait("no error", |w| w.status().true_error.is_none());
}
