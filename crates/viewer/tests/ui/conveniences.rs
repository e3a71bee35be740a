//! Small things that save a detour: the picture in the clipboard, a slider brought back, the first
//! invalid sample, one pass, fewer threads, text that stays readable.

use egui::accesskit::Role;
use egui::{Event, Key, Modifiers, OutputCommand, PointerButton, Pos2};
use egui_kittest::kittest::{NodeT as _, Queryable as _};
use glam::Vec3;
use lightbox::aov::Aov;
use lightbox::session::Activity;
use lightbox::workers;

use crate::habits::{Storage, unfold};
use crate::window::{SCENE, Window};

#[test]
fn the_picture_as_shown_goes_to_the_clipboard() {
    let mut window = Window::open(SCENE);
    window.key(Modifiers::NONE, Key::E);
    window.wait("a lighter picture", |w| w.snapshot().number > w.seen);
    let shown = window.snapshot().rgb();
    let copied = |window: &Window| {
        let commands = &window.harness.output().platform_output.commands;
        commands.iter().find_map(|command| match command {
            OutputCommand::CopyImage(image) => Some(image.clone()),
            _ => None,
        })
    };
    // Window systems tell of Ctrl+C in their own way.
    window.harness.event(Event::Copy);
    window.harness.step();
    let by_key = copied(&window).expect("a picture");
    window
        .harness
        .get_by_role_and_label(Role::Button, "Copy")
        .click();
    window.harness.step();
    let by_button = copied(&window).expect("a picture");
    for image in [by_key, by_button] {
        let rgb: Vec<u8> = image
            .pixels
            .iter()
            .flat_map(|p| [p.r(), p.g(), p.b()])
            .collect();
        assert!(image.size == [40, 30] && rgb == shown);
    }
    let told = "40 × 30 px, is in the clipboard";
    assert!(window.harness.query_by_label_contains(told).is_some());
    // What is copied from a field is text.
    let field = window
        .harness
        .get_by_role_and_label(Role::SpinButton, "Seed");
    field.click();
    window.harness.run_steps(2);
    window.harness.event(Event::Copy);
    window.harness.step();
    assert!(copied(&window).is_none());
}

/// A place on a slider, in shares of its length, which ends before the number.
fn on_slider(window: &Window, name: &str, share: f32) -> Pos2 {
    let rect = window
        .harness
        .get_by_role_and_label(Role::Slider, name)
        .rect();
    rect.left_center() + egui::vec2(rect.width() * share, 0.0)
}

fn double_click(window: &mut Window, at: Pos2) {
    window.harness.hover_at(at);
    window.harness.run_steps(1);
    for _ in 0..2 {
        // A frame and more between what happens, as between those of fingers.
        window.button(at, PointerButton::Primary, true);
        window.harness.run_steps(2);
        window.button(at, PointerButton::Primary, false);
        window.harness.run_steps(2);
    }
    window.harness.run_steps(12);
}

#[test]
fn a_double_click_brings_a_slider_back_in_one_step() {
    let mut window = Window::open(SCENE);
    let desc = |w: &Window| w.harness.state().model().desc.clone();
    window.click_at(window.at(0.5, 0.5));
    let opened = desc(&window);
    window.set("Depth", 9.0);
    window.set("Mirror", 0.75);
    window.set("Samples", 64.0);
    let edited = desc(&window);
    for (name, share) in [("Depth", 0.6), ("Mirror", 0.1), ("Samples", 0.2)] {
        let before = desc(&window);
        let at = on_slider(&window, name, share);
        double_click(&mut window, at);
        let after = desc(&window);
        assert_ne!(after, before, "{name}");
        window.key(Modifiers::COMMAND, Key::Z);
        assert_eq!(desc(&window), before, "{name}: one step");
        window.key(Modifiers::COMMAND, Key::Y);
        assert_eq!(desc(&window), after, "{name}");
    }
    assert_eq!(desc(&window), opened, "as the file has it");
    for _ in 0..3 {
        window.key(Modifiers::COMMAND, Key::Z);
    }
    assert_eq!(desc(&window), edited);
    // One click goes where it was, and is a step too.
    let at = on_slider(&window, "Mirror", 0.1);
    window.click_at(at);
    let clicked = desc(&window);
    assert!(clicked.materials[0].mirror < 0.5, "{clicked:?}");
    window.key(Modifiers::COMMAND, Key::Z);
    assert_eq!(desc(&window), edited);

    // What no file has goes back to what is usual.
    window.set("Exposure", 3.0);
    let at = on_slider(&window, "Exposure", 0.2);
    double_click(&mut window, at);
    assert_eq!(window.harness.state().model().tone, Default::default());
    unfold(&mut window, "Camera");
    window.set("Field of view", 99.0);
    let at = on_slider(&window, "Field of view", 0.2);
    double_click(&mut window, at);
    assert_eq!(desc(&window).camera, opened.camera);
}

#[test]
fn the_count_of_invalid_samples_leads_to_the_first() {
    let mut window = Window::open(SCENE);
    // Room for every figure in the line at the bottom.
    window.harness.set_size(egui::vec2(1300.0, 1400.0));
    window.harness.run_steps(3);
    assert!(window.harness.query_by_label("1 invalid").is_none());
    let film = window.harness.state().session().film().expect("a film");
    let tile = (0..film.tiles()).find(|i| film.tile_rect(*i).x == 16 && film.tile_rect(*i).y == 16);
    let tile = tile.expect("a tile");
    let (mut batch, samples) = film.batch(tile);
    batch.add([3, 2], samples, 0, Vec3::splat(f32::NAN));
    assert!(film.merge(tile, &batch, samples, samples + 1));
    // The status is told with the next picture.
    window.key(Modifiers::NONE, Key::E);
    window.wait("the count", |w| {
        w.harness.query_by_label("1 invalid").is_some()
    });
    window.click("1 invalid");
    window.wait("the view", |w| w.snapshot().aov == Aov::INVALID);
    assert_eq!(Aov::INVALID.name(), "invalid samples");
    let told = format!("sample {samples} of pixel 19, 18");
    assert!(window.harness.query_by_label_contains(&told).is_some());
    // It is in the middle, close by.
    let middle = window.harness.get_by_label("Picture").rect().center();
    window.harness.hover_at(middle);
    window.harness.run_steps(2);
    let line = window.harness.query_all_by_label_contains("distance");
    let line = line.last().and_then(|n| n.accesskit_node().value());
    let line = line.unwrap_or_default();
    assert!(line.starts_with("19, 18    "), "{line}");
}

#[test]
fn one_pass_is_made_at_a_time() {
    let mut window = Window::open(SCENE);
    window.set("Samples", 65_536.0);
    window.wait("work", |w| w.status().activity == Activity::Rendering);
    window.key(Modifiers::NONE, Key::Space);
    window.wait("a first rest", |w| w.status().activity == Activity::Paused);
    // The pass under way is brought to its end first.
    let film = window.harness.state().session().film().expect("a film");
    let before = film.samples();
    window.key(Modifiers::NONE, Key::Period);
    let even = |w: &Window| {
        let film = w.harness.state().session().film().expect("a film");
        (film.samples() == film.most_samples()).then(|| film.samples())
    };
    window.wait("a whole pass", |w| even(w).is_some_and(|n| n > before));
    window.harness.run_steps(30);
    let mut samples = even(&window).expect("all have as many");
    for _ in 0..3 {
        window.key(Modifiers::NONE, Key::Period);
        window.wait("one more", |w| w.status().samples > samples);
        window.harness.run_steps(30);
        samples += 1;
        assert_eq!(even(&window), Some(samples));
        assert_eq!(window.status().samples, samples);
        assert_eq!(window.status().activity, Activity::Paused);
    }
    // While it goes on, it makes it rest.
    window.key(Modifiers::NONE, Key::Space);
    window.wait("more", |w| w.status().samples > samples);
    window.key(Modifiers::NONE, Key::Period);
    window.wait("a rest", |w| {
        w.status().activity == Activity::Paused && even(w).is_some()
    });
    // What is done says so.
    window.set("Samples", 1.0);
    window.wait("the end", |w| w.status().activity == Activity::Done);
    window.key(Modifiers::NONE, Key::Period);
    let told = "the picture is done";
    assert!(window.harness.query_by_label_contains(told).is_some());
}

#[test]
fn fewer_threads_make_the_same_picture_and_are_remembered() {
    let mut window = Window::open(SCENE);
    let picture = window.snapshot().rgb();
    assert_eq!(window.status().threads, workers::usual());
    unfold(&mut window, "Window");
    let other = if workers::usual() > 1 {
        1
    } else {
        workers::cores()
    };
    window.set("Threads", other as f64);
    window.wait("other threads", |w| w.status().threads == other);
    // No sample is lost.
    assert_eq!(window.status().activity, Activity::Done);
    let mut storage = Storage::default();
    eframe::App::save(window.harness.state_mut(), &mut storage);
    let settings = lightbox::settings::Settings::load(Some(&storage));
    let Window { folder, .. } = window;
    let path = folder.path().join("scene.toml");
    let window = Window::remembering(folder, path, settings);
    assert_eq!(window.status().threads, other);
    assert!(window.snapshot().rgb() == picture);
}

#[test]
fn text_stays_readable() {
    let mut window = Window::open(SCENE);
    for _ in 0..10 {
        window.key(Modifiers::COMMAND, Key::Minus);
        assert!(window.harness.ctx.zoom_factor() >= 0.79);
    }
    assert!(window.harness.ctx.zoom_factor() < 0.85);
    window.key(Modifiers::COMMAND, Key::Plus);
    assert!(window.harness.ctx.zoom_factor() > 0.85);
    // One that was remembered from before.
    window.harness.ctx.set_zoom_factor(0.3);
    window.harness.run_steps(3);
    assert!(window.harness.ctx.zoom_factor() >= 0.79);
}
