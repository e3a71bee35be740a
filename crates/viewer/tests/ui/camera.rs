//! Camera moves by mouse and keys.

use egui::accesskit::Role;
use egui::{Event, Key, Modifiers, MouseWheelUnit, PointerButton, Vec2};
use egui_kittest::kittest::Queryable as _;
use glam::Vec3;

use crate::window::{SCENE, Window};

#[test]
fn every_gesture_works_from_a_fresh_camera() {
    let mut window = Window::open(SCENE);
    let fresh = window.status().desc.camera;
    let middle = window.at(0.5, 0.5);
    let camera = |w: &Window| w.status().desc.camera;

    window.drag(PointerButton::Primary, middle, Vec2::new(60.0, 0.0));
    assert!(
        camera(&window).eye.x < -0.1,
        "orbit to the right: {:?}",
        camera(&window)
    );
    assert_eq!(camera(&window).target, fresh.target);
    window.key(Modifiers::NONE, Key::Home);
    assert_eq!(camera(&window), fresh);

    for button in [PointerButton::Secondary, PointerButton::Middle] {
        let centre = window.snapshot().size;
        window.drag(button, middle, Vec2::new(50.0, 30.0));
        let moved = camera(&window);
        assert!(moved.eye.x < -0.01 && moved.eye.y > 0.01, "{moved:?}");
        assert_eq!(moved.eye - moved.target, fresh.eye - fresh.target);
        // The front of the ball, at depth 3.5, has followed the pointer.
        let ([x, _], _) =
            lightbox::orbit::projected(&moved, Vec3::new(0.0, 0.0, 0.5)).expect("in front");
        let space = window.harness.get_by_label("Picture").rect();
        let height = (space.width() * centre[1] as f32 / centre[0] as f32).min(space.height());
        assert!((x * height - 50.0).abs() < 1.0, "{}", x * height);
        window.key(Modifiers::NONE, Key::Home);
        assert_eq!(camera(&window), fresh);
    }

    let wheel = |window: &mut Window, delta: Vec2| {
        window.harness.hover_at(middle);
        window.harness.event(Event::MouseWheel {
            unit: MouseWheelUnit::Point,
            delta,
            modifiers: Modifiers::NONE,
            phase: egui::TouchPhase::Move,
            source: egui::MouseWheelSource::Unknown,
        });
        window.harness.run_steps(40);
    };
    // With Shift, systems turn the wheel sideways.
    for delta in [Vec2::new(0.0, 80.0), Vec2::new(80.0, 0.0)] {
        wheel(&mut window, delta);
        assert!(window.eye().z < 3.9, "{:?}", camera(&window));
        wheel(&mut window, -delta);
        assert!((window.eye().z - 4.0).abs() < 0.05, "{:?}", camera(&window));
        window.key(Modifiers::NONE, Key::Home);
    }

    window.drag(PointerButton::Primary, middle, Vec2::new(40.0, 40.0));
    window.key(Modifiers::NONE, Key::F);
    let framed = camera(&window);
    let bounds = window.status().scene.expect("a scene").geometry().bounds();
    assert!(
        framed.target.distance(bounds.center()) < 1e-5
            && framed.eye.distance(framed.target) > bounds.diagonal()
    );
    window.key(Modifiers::NONE, Key::Home);
    assert_eq!(camera(&window), fresh);
}

#[test]
fn a_double_click_sets_the_pivot_and_leaves_the_eye() {
    let mut window = Window::open(SCENE);
    let fresh = window.status().desc.camera;
    let pos = window.at(0.3, 0.4);
    window.harness.hover_at(pos);
    for _ in 0..2 {
        window.button(pos, PointerButton::Primary, true);
        window.button(pos, PointerButton::Primary, false);
    }
    window.harness.run_steps(4);
    let camera = window.status().desc.camera;
    assert_eq!(camera.eye, fresh.eye);
    // On the wall, left of and above the middle.
    assert!(
        (camera.target.z + 2.0).abs() < 1e-4 && camera.target.x < -0.1 && camera.target.y > 0.1,
        "{camera:?}"
    );
}

#[test]
fn keys_are_left_to_a_text_field() {
    let mut window = Window::open(SCENE);
    window.drag(
        PointerButton::Primary,
        window.at(0.5, 0.5),
        Vec2::new(60.0, 0.0),
    );
    let before = window.status().desc.camera;
    let seed = window
        .harness
        .get_by_role_and_label(Role::SpinButton, "Seed");
    seed.click();
    window.harness.run_steps(2);
    window.key(Modifiers::NONE, Key::Home);
    assert_eq!(
        window.status().desc.camera,
        before,
        "Home moves the text cursor only"
    );
    window.key(Modifiers::NONE, Key::Enter);
    window.key(Modifiers::NONE, Key::Home);
    assert_ne!(window.status().desc.camera, before);
}
