//! Knobs in the picture that move, turn and scale the selected object.

use egui::accesskit::Role;
use egui::{Key, Modifiers, PointerButton, Pos2, Vec2};
use egui_kittest::kittest::Queryable as _;
use glam::Vec3;
use lightbox::objects;
use lightbox_core::SceneDesc;

use crate::window::{SCENE, Window};

fn desc(window: &Window) -> SceneDesc {
    window.harness.state().model().desc.clone()
}

fn knob(window: &Window, name: &str) -> Option<Pos2> {
    let name = format!("{name} in the picture");
    let node = window.harness.query_by_label(&name)?;
    Some(node.rect().center())
}

/// Drags a knob from where it is; the scene before.
fn drag(window: &mut Window, name: &str, by: Vec2) -> SceneDesc {
    let before = desc(window);
    let from = knob(window, name).expect("a knob");
    window.drag(PointerButton::Primary, from, by);
    window.harness.run_steps(3);
    before
}

/// Selects what is seen at a place, and stays there with the pointer.
fn select(window: &mut Window, x: f32, y: f32) {
    window.click_at(window.at(x, y));
    assert!(window.harness.state().model().selection.is_some());
}

/// Scene units per point, at the middle of the scene.
fn unit(window: &Window) -> f32 {
    let height = window.at(0.0, 1.0).y - window.at(0.0, 0.0).y;
    2.0 * 4.0 * 20f32.to_radians().tan() / height
}

#[test]
fn an_object_is_moved_along_an_axis_in_one_step() {
    let mut window = Window::open(SCENE);
    select(&mut window, 0.5, 0.5);
    let before = desc(&window);
    let (from, unit) = (
        knob(&window, "Move along x").expect("a knob"),
        unit(&window),
    );
    // Held, it is seen at once.
    window.harness.hover_at(from);
    window.button(from, PointerButton::Primary, true);
    window.harness.run_steps(1);
    // What goes across the axis counts for nothing.
    window.harness.hover_at(from + Vec2::new(40.0, 0.0));
    window.harness.run_steps(2);
    let moved = desc(&window).spheres[0].center;
    let expected = Vec3::X * 40.0 * unit;
    assert!(moved.distance(expected) < 1e-3, "{moved} {expected}");
    assert_eq!(*window.status().desc, desc(&window), "the engine knows");
    assert!(
        knob(&window, "Move along y").is_none(),
        "the others make room"
    );
    // Back where it began, all is as it was.
    window.harness.hover_at(from);
    window.harness.run_steps(2);
    assert_eq!(desc(&window), before);
    window.harness.hover_at(from + Vec2::new(-20.0, 0.0));
    window.harness.run_steps(2);
    window.button(from + Vec2::new(-20.0, 0.0), PointerButton::Primary, false);
    window.harness.run_steps(3);
    let moved = desc(&window);
    assert!((moved.spheres[0].center.x + 20.0 * unit).abs() < 1e-3);
    assert_eq!(moved.camera, before.camera);
    assert!(window.harness.state().model().selection.is_some());
    window.key(Modifiers::COMMAND, Key::Z);
    assert_eq!(desc(&window), before);
    window.key(Modifiers::COMMAND.plus(Modifiers::SHIFT), Key::Z);
    assert_eq!(desc(&window), moved);
    window.done();
}

#[test]
fn along_an_axis_that_leads_away_an_object_follows_the_pointer() {
    let mut window = Window::open(SCENE);
    // From the side and above, where every axis is seen.
    window.drag(
        PointerButton::Primary,
        window.at(0.5, 0.5),
        Vec2::new(60.0, 50.0),
    );
    select(&mut window, 0.5, 0.5);
    for (name, axis) in [
        ("Move along x", Vec3::X),
        ("Move along y", Vec3::Y),
        ("Move along z", Vec3::Z),
    ] {
        let from = knob(&window, name).expect("a knob");
        let middle = window.at(0.5, 0.5);
        let by = (from - middle) * 0.5;
        let before = drag(&mut window, name, by);
        let moved = desc(&window).spheres[0].center - before.spheres[0].center;
        assert!(moved.dot(axis) > 0.05, "{name}: {moved}");
        assert!(moved.cross(axis).length() < 1e-6, "{name}: {moved}");
        // The knob stands off its object as before; both have gone with the pointer, but for what
        // the distance from the camera changes.
        window.harness.run_steps(2);
        let off = knob(&window, name).expect("a knob") - (from + by);
        assert!(off.length() < 10.0, "{name}: {off:?}");
        window.key(Modifiers::COMMAND, Key::Z);
    }
}

#[test]
fn an_object_is_scaled_and_turned_around_its_middle() {
    let mut window = Window::open(SCENE);
    select(&mut window, 0.5, 0.5);
    let turns = ["Turn about x", "Turn about y", "Turn about z"];
    assert!(turns.iter().all(|name| knob(&window, name).is_none()));
    let before = drag(&mut window, "Scale", Vec2::new(60.0, 5.0));
    let [was, is] = [before, desc(&window)].map(|d| d.spheres[0].clone());
    assert!((is.radius / was.radius - 0.4f32.exp()).abs() < 1e-3);
    assert_eq!(is.center, was.center);

    // The wall behind it, of which only a turn in the picture's plane can be aimed at.
    select(&mut window, 0.15, 0.5);
    assert_eq!(
        turns.map(|name| knob(&window, name).is_some()),
        [false, false, true]
    );
    let from = knob(&window, turns[2]).expect("a knob") - window.at(0.5, 0.5);
    // A quarter of a turn to the left.
    let by = Vec2::new(from.y, -from.x) - from;
    let before = drag(&mut window, turns[2], by);
    let [was, is] = [before, desc(&window)].map(|d| d.quads[0].corners);
    let turned = objects::angles(&is) - objects::angles(&was);
    assert!(turned.distance(Vec3::Z * 90.0) < 0.5, "{turned}");
    let before = drag(&mut window, "Scale", Vec2::new(-60.0, 0.0));
    let [was, is] = [before, desc(&window)].map(|d| objects::edges(&d.quads[0].corners));
    assert!((is[0] / was[0] - (-0.4f32).exp()).abs() < 1e-3);
    window.key(Modifiers::COMMAND, Key::Z);
    window.key(Modifiers::COMMAND, Key::Z);
    assert_eq!(objects::edges(&desc(&window).quads[0].corners), [6.0, 6.0]);
}

#[test]
fn knobs_are_there_while_the_pointer_is_at_a_selected_object() {
    let mut window = Window::open(SCENE);
    window.harness.hover_at(window.at(0.5, 0.5));
    window.harness.run_steps(2);
    assert!(knob(&window, "Scale").is_none(), "nothing is selected");
    select(&mut window, 0.5, 0.5);
    assert!(knob(&window, "Move along x").is_some());
    assert!(
        knob(&window, "Move along z").is_none(),
        "it leads to the eye"
    );
    // Whoever is busy in the panel sees the picture alone.
    let slider = window.harness.get_by_role_and_label(Role::Slider, "Mirror");
    window.harness.hover_at(slider.rect().center());
    window.harness.run_steps(2);
    assert!(knob(&window, "Move along x").is_none());
}
