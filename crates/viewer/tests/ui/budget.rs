//! The budget: samples, seconds or error.

use egui::accesskit::Role;
use egui_kittest::kittest::Queryable as _;
use lightbox::session::{Activity, Budget};

use crate::window::{SCENE, Window};

fn choose(window: &mut Window, name: &str) {
    window
        .harness
        .get_by_role_and_label(Role::RadioButton, name)
        .click();
    window.harness.run_steps(2);
}

fn budget(window: &Window) -> Budget {
    window.harness.state().model().budget
}

fn wait_until_done(window: &mut Window) {
    window.wait("the engine to know", |w| w.status().budget == budget(w));
    window.wait("the end", |w| w.status().activity == Activity::Done);
}

fn lines(window: &Window, part: &str) -> usize {
    window.harness.query_all_by_label_contains(part).count()
}

#[test]
fn seconds_end_the_picture() {
    let mut window = Window::open(SCENE);
    choose(&mut window, "Seconds");
    assert!(matches!(budget(&window), Budget::Seconds(_)));
    let before = window.status();
    window.set("Seconds", 0.5);
    wait_until_done(&mut window);
    let after = window.status();
    // Samples are kept, and go on until the time is up.
    assert!(after.samples > before.samples);
    assert!(after.seconds > 0.45, "{}", after.seconds);
    assert_eq!(after.paths, after.samples * 1200);
    // Back to samples: done where it is, or as foretold.
    choose(&mut window, "Samples");
    assert_eq!(budget(&window), Budget::Samples);
    let wanted = window.harness.state().model().desc.render.samples;
    assert!(wanted.abs_diff(after.samples) <= 1 + after.samples / 10);
}

#[test]
fn error_ends_the_picture() {
    let mut window = Window::open(SCENE);
    choose(&mut window, "Error");
    let noise = window.status().noise.expect("a noise");
    // A quarter of the noise takes about sixteen times the samples.
    window.set("Error", noise * 25.0);
    wait_until_done(&mut window);
    let status = window.status();
    assert!(status.noise.expect("a noise") <= noise * 0.25);
    assert!((64..2048).contains(&status.samples), "{}", status.samples);
    // More is asked for: it goes on from there.
    window.set("Error", noise * 15.0);
    wait_until_done(&mut window);
    assert!(window.status().samples > status.samples);
}

#[test]
fn forecasts_are_made_and_scored() {
    let mut window = Window::open(SCENE);
    window.set("Samples", 100_000.0);
    window.wait("a forecast", |w| {
        let forecast = w.status().forecast;
        forecast.is_some_and(|f| f.samples.value == 100_000.0 && f.noise.is_some())
    });
    let status = window.status();
    let forecast = status.forecast.expect("a forecast");
    assert!(forecast.seconds.value > status.seconds);
    assert!(
        forecast
            .noise
            .is_some_and(|n| n.value < status.noise.expect("a noise"))
    );
    assert_eq!(lines(&window, " s ± "), 1);
    assert_eq!(lines(&window, " % ± "), 1);
    assert_eq!(lines(&window, "said"), 0);
    let promise = status.promise.expect("a promise");
    window.wait("another forecast", |w| {
        w.status().forecast != Some(forecast)
    });
    assert_eq!(window.status().promise, Some(promise));

    window.set("Samples", 512.0);
    // By now there may be more than that: the picture starts anew.
    window.click("independent");
    window.done();
    assert_eq!((lines(&window, "took"), lines(&window, "got")), (1, 1));
    assert_eq!(lines(&window, "said"), 2);
    // What is set anew is promised anew.
    window.set("Samples", 1024.0);
    window.done();
    let last = window.status().promise.expect("a promise");
    assert_eq!(last.samples.value, 1024.0);
}
