//! To fly, to tumble, to look along axes, to go back: each from a fresh camera.

use egui::{Event, Key, Modifiers, OutputCommand, PointerButton, Vec2};
use egui_kittest::kittest::Queryable as _;
use glam::Vec3;
use lightbox_core::scene::CameraDesc;

use crate::window::{SCENE, Window};

fn camera(window: &Window) -> CameraDesc {
    window.harness.state().model().desc.camera
}

/// Back to the camera of the file, whatever was done before.
fn fresh(window: &mut Window) -> CameraDesc {
    window.key(Modifiers::NONE, Key::Home);
    window.harness.run_steps(30);
    camera(window)
}

/// Holds a key for some frames.
fn hold(window: &mut Window, modifiers: Modifiers, key: Key, frames: usize) {
    press(window, modifiers, key);
    window.harness.run_steps(frames);
    window.harness.key_up(key);
    window
        .harness
        .event(Event::ModifiersChanged(Modifiers::NONE));
    window.harness.run_steps(2);
}

/// Presses a key and holds it, and what is held with it.
fn press(window: &mut Window, modifiers: Modifiers, key: Key) {
    window.harness.event(Event::ModifiersChanged(modifiers));
    window.harness.run_steps(1);
    window.harness.event(Event::Key {
        key,
        physical_key: None,
        pressed: true,
        repeat: false,
        modifiers,
    });
}

/// Lets an eased move come to its end.
fn arrived(window: &mut Window) -> CameraDesc {
    window.harness.run_steps(30);
    camera(window)
}

#[test]
fn keys_fly_while_the_right_button_is_held() {
    let mut window = Window::open(SCENE);
    let middle = window.at(0.5, 0.5);
    let exposure = |w: &Window| w.harness.state().model().tone.exposure;
    let ways = [
        (Key::W, Vec3::NEG_Z),
        (Key::S, Vec3::Z),
        (Key::A, Vec3::NEG_X),
        (Key::D, Vec3::X),
        (Key::Q, Vec3::NEG_Y),
        (Key::E, Vec3::Y),
    ];
    for (key, way) in ways {
        let before = fresh(&mut window);
        window.harness.hover_at(middle);
        window.button(middle, PointerButton::Secondary, true);
        window.harness.run_steps(1);
        hold(&mut window, Modifiers::NONE, key, 5);
        window.button(middle, PointerButton::Secondary, false);
        window.harness.run_steps(2);
        let after = camera(&window);
        let moved = after.eye - before.eye;
        assert!(
            moved.dot(way) > 0.1 && moved.cross(way).length() < 1e-4,
            "{key:?}: {moved}"
        );
        assert!((after.target - before.target).distance(moved) < 1e-5);
        // And nothing else happens: E alone would brighten.
        assert_eq!(exposure(&window), 0.0);
        window.key(Modifiers::NONE, key);
    }
    assert_eq!(exposure(&window), 0.5, "E without the button is brighter");
}

#[test]
fn shift_flies_fast_and_alt_slowly() {
    let mut window = Window::open(SCENE);
    let middle = window.at(0.5, 0.5);
    let mut far = |modifiers: Modifiers| {
        let before = fresh(&mut window);
        window.harness.hover_at(middle);
        window.button(middle, PointerButton::Secondary, true);
        window.harness.run_steps(1);
        hold(&mut window, modifiers, Key::D, 6);
        window.button(middle, PointerButton::Secondary, false);
        window.harness.run_steps(2);
        camera(&window).eye.distance(before.eye)
    };
    let [usual, fast, slow] = [Modifiers::NONE, Modifiers::SHIFT, Modifiers::ALT].map(&mut far);
    assert!((fast / usual - 10.0).abs() < 0.1, "{fast} / {usual}");
    assert!((slow / usual - 0.1).abs() < 0.001, "{slow} / {usual}");
}

#[test]
fn the_mouse_looks_around_while_one_flies() {
    let mut window = Window::open(SCENE);
    let before = fresh(&mut window);
    let middle = window.at(0.5, 0.5);
    window.key(Modifiers::SHIFT, Key::F);
    assert!(window.harness.query_by_label("Picture").is_some());
    window.drag(PointerButton::Primary, middle, Vec2::new(60.0, 20.0));
    let looked = camera(&window);
    assert_eq!(looked.eye, before.eye);
    assert!(
        looked.target.x > 0.1 && looked.target.y < -0.05,
        "{looked:?}"
    );
    // No button is needed to fly.
    hold(&mut window, Modifiers::NONE, Key::W, 5);
    let flown = camera(&window).eye - before.eye;
    assert!(flown.dot(looked.target - looked.eye) > 0.1, "{flown}");
    window.key(Modifiers::NONE, Key::Escape);
    let before = fresh(&mut window);
    hold(&mut window, Modifiers::NONE, Key::W, 5);
    assert_eq!(camera(&window), before, "Escape has ended it");
    // With the right button, a drag looks around once a key flies, and pans without.
    window.harness.hover_at(middle);
    window.button(middle, PointerButton::Secondary, true);
    window.harness.key_down(Key::E);
    window.harness.run_steps(1);
    window.harness.hover_at(middle + Vec2::new(40.0, 0.0));
    window.harness.run_steps(2);
    window.harness.key_up(Key::E);
    window.button(middle, PointerButton::Secondary, false);
    window.harness.run_steps(2);
    let looked = camera(&window);
    assert!((looked.target - looked.eye).x > 0.1, "{looked:?}");
    assert!((looked.eye - before.eye).x.abs() < 1e-5);
}

#[test]
fn letting_go_of_the_window_lets_go_of_the_keys() {
    let mut window = Window::open(SCENE);
    fresh(&mut window);
    window.key(Modifiers::SHIFT, Key::F);
    window.harness.key_down(Key::W);
    window.harness.run_steps(3);
    window.harness.event(Event::WindowFocused(false));
    window.harness.run_steps(2);
    let left = camera(&window);
    window.harness.run_steps(10);
    assert_eq!(camera(&window), left);
}

#[test]
fn alt_and_the_left_button_orbit_too() {
    let mut window = Window::open(SCENE);
    let before = fresh(&mut window);
    let from = window.at(0.5, 0.5);
    window.harness.hover_at(from);
    for (pos, pressed) in [(from, Some(true)), (from + Vec2::new(50.0, 0.0), None)] {
        match pressed {
            Some(pressed) => window.harness.event_modifiers(
                Event::PointerButton {
                    pos,
                    button: PointerButton::Primary,
                    pressed,
                    modifiers: Modifiers::ALT,
                },
                Modifiers::ALT,
            ),
            None => window
                .harness
                .event_modifiers(Event::PointerMoved(pos), Modifiers::ALT),
        }
        window.harness.run_steps(2);
    }
    window.button(from + Vec2::new(50.0, 0.0), PointerButton::Primary, false);
    window.harness.run_steps(2);
    let orbited = camera(&window);
    assert_eq!(orbited.target, before.target);
    assert!(orbited.eye.x < -0.1, "{orbited:?}");
}

#[test]
fn a_pinch_moves_towards_the_point_under_it() {
    let mut window = Window::open(SCENE);
    let before = fresh(&mut window);
    window.harness.hover_at(window.at(0.5, 0.5));
    window.harness.event(Event::Zoom(1.25));
    window.harness.run_steps(3);
    let nearer = camera(&window);
    // The front of the ball is at 0.5.
    let ratio = (nearer.eye.z - 0.5) / (before.eye.z - 0.5);
    assert!((ratio - 0.8).abs() < 0.01, "{nearer:?}");
}

#[test]
fn orbits_stop_at_the_poles_or_go_over_them() {
    let mut window = Window::open(SCENE);
    let before = fresh(&mut window);
    let middle = window.at(0.5, 0.5);
    let down = window.at(0.5, 1.0) - window.at(0.5, 0.0);
    for _ in 0..3 {
        window.drag(PointerButton::Primary, middle, down);
    }
    let top = camera(&window);
    assert!(top.eye.y > 3.99 && top.up == Vec3::Y, "{top:?}");
    window.drag(PointerButton::Primary, middle, -0.2 * down);
    assert!(camera(&window).eye.y < 3.9, "the way back is open");

    fresh(&mut window);
    window.key(Modifiers::NONE, Key::T);
    let mut highest = 0.0f32;
    for _ in 0..3 {
        window.drag(PointerButton::Primary, middle, 0.25 * down);
        highest = highest.max(camera(&window).eye.y);
    }
    let over = camera(&window);
    assert!(highest > 3.0 && over.up.y < 0.0, "{over:?}");
    assert!((over.eye.length() - 4.0).abs() < 1e-4);
    // With the horizon level again, up is up.
    window.key(Modifiers::NONE, Key::T);
    assert_eq!(camera(&window).up, before.up);
    assert_eq!(fresh(&mut window), before);
}

#[test]
fn the_camera_has_a_history_of_its_own() {
    let mut window = Window::open(SCENE);
    let mut places = vec![fresh(&mut window)];
    let middle = window.at(0.5, 0.5);
    window.drag(PointerButton::Primary, middle, Vec2::new(60.0, 10.0));
    window.harness.run_steps(2);
    places.push(camera(&window));
    window.key(Modifiers::NONE, Key::F);
    places.push(arrived(&mut window));
    // An edit between the moves belongs to the other history.
    window.set("Depth", 3.0);
    window.drag(PointerButton::Secondary, middle, Vec2::new(30.0, 10.0));
    window.harness.run_steps(2);
    places.push(camera(&window));
    assert!(places.windows(2).all(|pair| pair[0] != pair[1]));
    for place in places.iter().rev().skip(1) {
        window.key(Modifiers::ALT, Key::ArrowLeft);
        assert_eq!(camera(&window), *place);
    }
    window.key(Modifiers::ALT, Key::ArrowLeft);
    assert_eq!(camera(&window), places[0]);
    for place in &places[1..] {
        window.key(Modifiers::ALT, Key::ArrowRight);
        assert_eq!(camera(&window), *place);
    }
    let depth = |w: &Window| w.harness.state().model().desc.render.depth;
    assert_eq!(depth(&window), 3);
    window.key(Modifiers::COMMAND, Key::Z);
    assert_eq!((depth(&window), camera(&window)), (4, places[3]));
}

#[test]
fn digits_bring_the_camera_back() {
    let mut window = Window::open(SCENE);
    let before = fresh(&mut window);
    // In tests nothing is animated otherwise.
    let eased = |style: &mut egui::Style| style.animation_time = 0.1;
    window.harness.ctx.all_styles_mut(eased);
    window.key(Modifiers::NONE, Key::Num3);
    assert!(
        window
            .harness
            .query_by_label_contains("bookmark 3 is empty")
            .is_some()
    );
    assert_eq!(camera(&window), before);
    window.key(Modifiers::COMMAND, Key::Num3);
    let middle = window.at(0.5, 0.5);
    window.drag(PointerButton::Primary, middle, Vec2::new(80.0, 40.0));
    window.key(Modifiers::COMMAND, Key::Num9);
    let there = camera(&window);
    window.harness.key_press(Key::Num3);
    window.harness.run_steps(3);
    let between = camera(&window);
    assert!(
        between != there && between != before,
        "an eased move: {between:?}"
    );
    assert_eq!(arrived(&mut window), before);
    window.key(Modifiers::NONE, Key::Num9);
    assert_eq!(arrived(&mut window), there);
    window.key(Modifiers::ALT, Key::ArrowLeft);
    assert_eq!(camera(&window), before, "one step back");
}

#[test]
fn letters_look_along_the_axes() {
    let mut window = Window::open(SCENE);
    for (key, axis) in [(Key::X, Vec3::X), (Key::Y, Vec3::Y), (Key::Z, Vec3::Z)] {
        for (modifiers, sign) in [(Modifiers::NONE, 1.0), (Modifiers::SHIFT, -1.0)] {
            let before = fresh(&mut window);
            window.key(modifiers, key);
            let after = arrived(&mut window);
            assert!(after.eye.distance(4.0 * sign * axis) < 1e-5, "{after:?}");
            assert_eq!(after.target, before.target);
        }
    }
}

#[test]
fn the_camera_goes_through_the_clipboard_as_text() {
    let mut window = Window::open(SCENE);
    let before = fresh(&mut window);
    let middle = window.at(0.5, 0.5);
    window.drag(PointerButton::Primary, middle, Vec2::new(80.0, 40.0));
    let there = camera(&window);
    let keys = Modifiers::COMMAND.plus(Modifiers::SHIFT);
    press(&mut window, keys, Key::C);
    let mut copied = None;
    for _ in 0..3 {
        window.harness.step();
        for command in &window.harness.output().platform_output.commands {
            if let OutputCommand::CopyText(text) = command {
                copied = Some(text.clone());
            }
        }
    }
    let text = copied.expect("a copied text");
    assert!(text.starts_with("[camera]"), "{text}");
    assert_eq!(fresh(&mut window), before);
    window.harness.event(Event::Paste(text));
    window.harness.run_steps(3);
    assert_eq!(arrived(&mut window), there);
    window.harness.event(Event::Paste("hello".into()));
    window.harness.run_steps(3);
    assert!(
        window
            .harness
            .query_by_label_contains("holds no camera")
            .is_some()
    );
    assert_eq!(camera(&window), there);
}

#[test]
fn the_field_of_view_zooms_and_is_taken_back_with_the_camera() {
    let mut window = Window::open(SCENE);
    let before = fresh(&mut window);
    window
        .harness
        .get_by_role_and_label(egui::accesskit::Role::DisclosureTriangle, "Camera")
        .click();
    window.harness.run_steps(20);
    window.set("Field of view", 60.0);
    window.harness.run_steps(2);
    assert_eq!(
        camera(&window),
        CameraDesc {
            fov: 60.0,
            ..before
        }
    );
    window.key(Modifiers::ALT, Key::ArrowLeft);
    assert_eq!(camera(&window), before);
}

#[test]
fn shift_and_the_left_button_mark_a_region() {
    let mut window = Window::open(SCENE);
    let before = fresh(&mut window);
    let picture = window.snapshot().number;
    let region = |w: &Window| w.harness.state().model().region;
    let drag = |window: &mut Window, from: egui::Pos2, to: egui::Pos2| {
        window
            .harness
            .event(Event::ModifiersChanged(Modifiers::SHIFT));
        window.drag(PointerButton::Primary, from, to - from);
        window
            .harness
            .event(Event::ModifiersChanged(Modifiers::NONE));
        window.harness.run_steps(1);
    };
    let (from, to) = (window.at(0.75, 0.75), window.at(0.25, 0.5));
    drag(&mut window, from, to);
    let [left, top, right, bottom] = region(&window).expect("a region");
    for (is, wanted) in [(left, 0.25), (top, 0.5), (right, 0.75), (bottom, 0.75)] {
        assert!((is - wanted).abs() < 0.01, "{:?}", region(&window));
    }
    assert_eq!(camera(&window), before, "it is no orbit");
    window.harness.run_steps(5);
    assert_eq!(window.snapshot().number, picture, "no sample is lost");
    // A click with Shift takes it away, and selects nothing.
    window
        .harness
        .event(Event::ModifiersChanged(Modifiers::SHIFT));
    window.click_at(window.at(0.5, 0.5));
    window
        .harness
        .event(Event::ModifiersChanged(Modifiers::NONE));
    window.harness.run_steps(1);
    assert_eq!(region(&window), None);
    assert_eq!(window.harness.state().model().selection, None);
    window.drag(PointerButton::Primary, from, to - from);
    assert_ne!(camera(&window), before);
    assert_eq!(region(&window), None);
}
