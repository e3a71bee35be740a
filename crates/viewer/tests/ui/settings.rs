//! The settings: what each does to the samples there are.

use std::time::Duration;

use egui::accesskit::Role;
use egui::{Key, Modifiers};
use egui_kittest::kittest::Queryable as _;
use lightbox::session::{Activity, Snapshot};
use lightbox_core::settings::UNLIMITED;
use lightbox_core::{AccelKind, FilterKind, Method, SamplerKind};

use crate::window::{SCENE, Window};

#[test]
fn exposure_and_tone_curve_keep_the_samples() {
    let mut window = Window::open(SCENE);
    let before = (window.snapshot(), window.status());
    window.set("Exposure", 1.0);
    window.wait("a brighter picture", |w| {
        w.snapshot().number > before.0.number
    });
    let sum = |s: &Snapshot| s.rgb().iter().map(|v| u64::from(*v)).sum::<u64>();
    assert!(sum(&window.snapshot()) > sum(&before.0));
    let bright = window.snapshot();
    window.click("filmic");
    window.wait("another curve", |w| w.snapshot().number > bright.number);
    assert!(window.snapshot().rgb() != bright.rgb());
    // Neither the samples nor the time they took are touched.
    let after = window.status();
    assert_eq!(
        (after.samples, after.seconds, after.rays),
        (before.1.samples, before.1.seconds, before.1.rays)
    );
}

#[test]
fn more_samples_go_on_from_those_there_are() {
    let mut window = Window::open(SCENE);
    let before = window.status();
    window.set("Samples", 64.0);
    window.done();
    let after = window.status();
    assert_eq!(after.samples, 64);
    // 48 more samples for each of 40 × 30 pixels, and not 64.
    assert_eq!(after.paths - before.paths, 48 * 1200);
}

#[test]
fn settings_that_change_the_light_start_anew() {
    let mut window = Window::open(SCENE);
    let paths = 16 * 1200;
    assert_eq!(window.status().paths, paths);
    let mut last = window.snapshot();
    let mut expect_new = |window: &mut Window, what: &str| {
        window.done();
        assert_eq!(window.status().paths, paths, "{what}");
        let now = window.snapshot();
        assert!(now.rgb() != last.rgb(), "{what}");
        last = now;
    };
    window.set("Depth", 1.0);
    assert_eq!(window.harness.state().model().desc.render.depth, 1);
    expect_new(&mut window, "depth");
    window
        .harness
        .get_by_role_and_label(Role::CheckBox, "Unlimited depth")
        .click();
    window.harness.run_steps(2);
    assert_eq!(window.status().desc.render.depth, UNLIMITED);
    expect_new(&mut window, "unlimited depth");
    window.set("Radius", 2.0);
    assert_eq!(window.status().desc.render.filter.radius, 2.0);
    expect_new(&mut window, "radius");
    for (name, holds) in [("naive", Method::Naive), ("nee", Method::Nee)] {
        window.click(name);
        assert_eq!(window.status().desc.render.method, holds);
        expect_new(&mut window, name);
    }
    window.click("independent");
    assert_eq!(
        window.status().desc.render.sampler,
        SamplerKind::Independent
    );
    expect_new(&mut window, "sampler");
    window
        .harness
        .get_by_role_and_label(Role::DisclosureTriangle, "Camera")
        .click();
    window.harness.run_steps(2);
    window.set("Field of view", 60.0);
    assert_eq!(window.status().desc.camera.fov, 60.0);
    expect_new(&mut window, "field of view");
}

#[test]
fn filters_are_chosen_from_a_list() {
    let mut window = Window::open(SCENE);
    window
        .harness
        .get_by_role_and_label(Role::ComboBox, "Filter")
        .click();
    window.harness.run_steps(2);
    window.click("mitchell");
    window.done();
    let filter = window.status().desc.render.filter;
    assert_eq!(
        (filter.kind, filter.radius),
        (FilterKind::Mitchell, FilterKind::Mitchell.default_radius())
    );
}

#[test]
fn accelerators_give_the_same_picture() {
    let mut window = Window::open(SCENE);
    let light = |w: &Window| {
        let film = w.harness.state().session().film().expect("a film");
        film.develop().pixels
    };
    let (before, light_before) = (window.snapshot(), light(&window));
    for kind in [AccelKind::Brute, AccelKind::KdTree, AccelKind::Bvh] {
        let name = kind.name();
        window.click(name);
        window.done();
        let scene = window.status().scene.expect("a scene");
        assert_eq!(scene.desc().render.accel, kind);
        assert_eq!(scene.geometry().accel(), kind);
        assert!(light(&window) == light_before, "{name} gives another light");
        assert!(
            window.snapshot().rgb() == before.rgb(),
            "{name} gives another picture"
        );
    }
}

#[test]
fn pause_keeps_the_samples_and_resume_goes_on() {
    let mut window = Window::open(SCENE);
    window.set("Samples", 60_000.0);
    window.wait("rendering", |w| {
        w.status().activity == Activity::Rendering && w.status().samples > 16
    });
    window.key(Modifiers::NONE, Key::Space);
    window.wait("the pause", |w| w.status().activity == Activity::Paused);
    let paused = window.status().samples;
    assert!(paused > 16);
    window.harness.run_steps(8);
    assert_eq!(window.status().samples, paused);
    window.click("Resume");
    window.wait("more samples", |w| w.status().samples > paused);
    window.click("Pause");
    window.wait("the pause", |w| w.status().activity == Activity::Paused);
}

#[test]
fn nothing_is_done_when_the_picture_is_done() {
    let mut window = Window::open(SCENE);
    window.harness.run();
    let (number, delay) = (window.snapshot().number, |w: &Window| {
        let output = &w.harness.output().viewport_output[&egui::ViewportId::ROOT];
        output.repaint_delay
    });
    for _ in 0..10 {
        window.harness.step();
        assert_eq!(
            delay(&window),
            Duration::MAX,
            "{:?}",
            window.harness.ctx.repaint_causes()
        );
    }
    // The engine has had time to wake the window, if it were so inclined.
    std::thread::sleep(Duration::from_millis(300));
    assert!(!window.harness.ctx.has_requested_repaint());
    assert_eq!(window.snapshot().number, number);
}
