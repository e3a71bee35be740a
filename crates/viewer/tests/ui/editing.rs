//! Objects: moved, turned, scaled, copied, deleted, added; each edit one step of undo.

use egui::accesskit::Role;
use egui::{Key, Modifiers};
use egui_kittest::kittest::{NodeT as _, Queryable as _};
use glam::Vec3;
use lightbox::model::Selection;
use lightbox_core::SceneDesc;
use lightbox_core::scene::ObjectKind;

use crate::window::{SCENE, Window};

fn desc(window: &Window) -> SceneDesc {
    window.harness.state().model().desc.clone()
}

fn selected(window: &Window) -> Option<ObjectKind> {
    window.harness.state().model().selection.map(|s| s.kind)
}

/// Waits for the scene with every edit, and for its picture.
fn settled(window: &mut Window) {
    let wanted = desc(window);
    window.wait("the edited scene", |w| {
        let scene = w.status().scene;
        scene.is_some_and(|scene| scene.desc().same_shapes(&wanted))
    });
    window.done();
}

/// Types a number into a field.
fn type_in(window: &mut Window, field: &str, number: &str) {
    let place = |w: &Window| {
        let field = w.harness.get_by_role_and_label(Role::SpinButton, field);
        field.rect().center()
    };
    window.harness.hover_at(place(window));
    window
        .harness
        .get_by_role_and_label(Role::SpinButton, field)
        .click();
    window.harness.run_steps(2);
    window
        .harness
        .key_press_modifiers(Modifiers::COMMAND, Key::A);
    window.harness.event(egui::Event::Text(number.into()));
    window.harness.run_steps(2);
    window.key(Modifiers::NONE, Key::Enter);
}

fn select_ball(window: &mut Window) {
    window.click_at(window.at(0.5, 0.5));
    assert_eq!(selected(window), Some(ObjectKind::Sphere(0)));
}

#[test]
fn a_sphere_is_moved_and_scaled_by_numbers_and_each_is_one_step() {
    let mut window = Window::open(SCENE);
    select_ball(&mut window);
    let mut steps = vec![desc(&window)];
    let before = window.snapshot();
    type_in(&mut window, "Position x", "0.75");
    steps.push(desc(&window));
    assert_eq!(steps[1].spheres[0].center, Vec3::new(0.75, 0.0, 0.0));
    settled(&mut window);
    assert!(
        window.snapshot().rgb() != before.rgb(),
        "the picture follows"
    );
    // The outline goes with it: what is picked there is the ball.
    window.click_at(window.at(0.5 + 0.75 / (2.0 * 4.0 * 0.364 * 4.0 / 3.0), 0.5));
    assert_eq!(selected(&window), Some(ObjectKind::Sphere(0)));
    type_in(&mut window, "Radius of sphere", "0.25");
    steps.push(desc(&window));
    assert_eq!(steps[2].spheres[0].radius, 0.25);
    // No number makes it vanish.
    type_in(&mut window, "Radius of sphere", "-3");
    steps.push(desc(&window));
    assert!(steps[3].spheres[0].radius > 0.0);
    for expected in steps.iter().rev().skip(1) {
        window.key(Modifiers::COMMAND, Key::Z);
        assert_eq!(desc(&window).spheres, expected.spheres);
    }
    assert_eq!(desc(&window), steps[0]);
    for expected in &steps[1..] {
        window.key(Modifiers::COMMAND, Key::Y);
        assert_eq!(desc(&window), *expected);
    }
}

#[test]
fn a_drag_of_a_number_is_one_step() {
    let mut window = Window::open(SCENE);
    select_ball(&mut window);
    let before = desc(&window);
    let field = window
        .harness
        .get_by_role_and_label(Role::SpinButton, "Position y");
    let from = field.rect().center();
    window.drag(egui::PointerButton::Primary, from, egui::vec2(60.0, 0.0));
    window.harness.run_steps(2);
    let dragged = desc(&window);
    assert!(dragged.spheres[0].center.y > 0.1, "{dragged:?}");
    window.key(Modifiers::COMMAND, Key::Z);
    assert_eq!(desc(&window), before);
    window.key(Modifiers::COMMAND, Key::Y);
    assert_eq!(desc(&window), dragged);
}

#[test]
fn a_quad_is_turned_and_stretched_around_its_middle() {
    let mut window = Window::open(SCENE);
    window.click_at(window.at(0.1, 0.5));
    assert_eq!(selected(&window), Some(ObjectKind::Quad(0)));
    type_in(&mut window, "Rotation y", "30");
    type_in(&mut window, "Rotation x", "100");
    type_in(&mut window, "Width", "2");
    let [a, b, c, d] = desc(&window).quads[0].corners;
    let edges = [a.distance(b), a.distance(d)];
    assert!(
        (edges[0] - 2.0).abs() < 1e-4 && (edges[1] - 6.0).abs() < 1e-4,
        "{edges:?}"
    );
    let middle = (a + b + c + d) / 4.0;
    assert!(
        middle.distance(Vec3::new(0.0, 0.0, -2.0)) < 1e-5,
        "{middle}"
    );
    // The angles that were set are still there, beyond the pole too.
    let value = |w: &Window, name| {
        let field = w.harness.get_by_role_and_label(Role::SpinButton, name);
        field.accesskit_node().numeric_value()
    };
    assert_eq!(value(&window, "Rotation x"), Some(100.0));
    assert_eq!(value(&window, "Rotation y"), Some(30.0));
    settled(&mut window);
}

#[test]
fn objects_are_copied_deleted_and_brought_back() {
    let mut window = Window::open(SCENE);
    let opened = desc(&window);
    select_ball(&mut window);
    window.click("Duplicate");
    settled(&mut window);
    let copied = desc(&window);
    assert_eq!(selected(&window), Some(ObjectKind::Sphere(1)));
    assert_eq!(copied.spheres[1].name, "ball 2");
    assert!(copied.spheres[1].center.x > 0.5, "{copied:?}");
    window.key(Modifiers::NONE, Key::Delete);
    settled(&mut window);
    assert_eq!(desc(&window), opened);
    assert_eq!(selected(&window), None);
    // Nothing selected, nothing deleted.
    window.key(Modifiers::NONE, Key::Delete);
    assert_eq!(desc(&window), opened);
    window.key(Modifiers::COMMAND, Key::Z);
    assert_eq!(desc(&window), copied);
    select_ball(&mut window);
    window.key(Modifiers::COMMAND, Key::D);
    assert_eq!(desc(&window).spheres.len(), 3);
    // Down to an empty scene, which is a scene too.
    settled(&mut window);
    window
        .harness
        .get_by_role_and_label(Role::DisclosureTriangle, "Objects (5)")
        .click();
    window.harness.run_steps(20);
    for name in ["ball", "ball 2", "ball 3", "wall", "ceiling lamp"] {
        window.click(name);
        window.key(Modifiers::NONE, Key::Delete);
        settled(&mut window);
    }
    assert!(window.status().scene.expect("a scene").objects().is_empty());
}

#[test]
fn new_objects_appear_where_one_looks() {
    let mut window = Window::open(SCENE);
    for (button, is_new) in [
        ("Add sphere", ObjectKind::Sphere(1)),
        ("Add quad", ObjectKind::Quad(2)),
    ] {
        window.click(button);
        assert_eq!(selected(&window), Some(is_new), "{button}");
        settled(&mut window);
        window.key(Modifiers::NONE, Key::Escape);
        window.click_at(window.at(0.5, 0.5));
        let found = selected(&window);
        assert_eq!(found, Some(is_new), "{button}: it is in the middle");
    }
    // Made of what the ball is made of; lit from then on by a lamp of its own.
    let lights = |w: &Window| w.status().scene.expect("a scene").lights().len();
    let before = lights(&window);
    window.click("Add lamp");
    settled(&mut window);
    assert_eq!(lights(&window), before + 1);
    let lamp = Selection {
        kind: ObjectKind::Quad(3),
        part: 0,
    };
    assert_eq!(window.harness.state().model().selection, Some(lamp));
    window.set("Emission", 2.0);
    settled(&mut window);
    let material = desc(&window).quads[3].material.clone();
    let lit = desc(&window);
    let lit = lit.materials.iter().find(|m| m.name == material);
    assert_eq!(lit.expect("its material").emission, Vec3::splat(2.0));
}

#[test]
fn a_mesh_is_added_moved_and_given_a_material_of_its_own() {
    let mut window = Window::open(SCENE);
    let path = window.file("far.obj");
    // Away from the origin of its file, where it must not swing around.
    let text = "v 100 0 0\nv 102 0 0\nv 101 2 0\nv 101 0 2\nf 1 2 3\nf 1 2 4\nf 2 3 4\nf 3 1 4\n";
    std::fs::write(&path, text).expect("written");
    let ctx = window.harness.ctx.clone();
    window.harness.state_mut().add_mesh(&ctx, path);
    window.wait("the mesh", |w| {
        !w.harness.state().model().desc.meshes.is_empty()
    });
    settled(&mut window);
    assert_eq!(selected(&window), Some(ObjectKind::Mesh(0)));
    let middle = |w: &Window| {
        let scene = w.status().scene.expect("a scene");
        let objects = scene.objects();
        let object = objects.iter().find(|o| o.kind == ObjectKind::Mesh(0));
        desc(w).meshes[0].placement()(object.expect("the mesh").bounds.center())
    };
    let before = middle(&window);
    type_in(&mut window, "Rotation z", "75");
    type_in(&mut window, "Scale", "0.3");
    assert_eq!(desc(&window).meshes[0].rotate, Vec3::new(0.0, 0.0, 75.0));
    assert_eq!(desc(&window).meshes[0].scale, 0.3);
    assert!(middle(&window).distance(before) < 1e-4);
    type_in(&mut window, "Position x", "-0.5");
    assert!((middle(&window).x + 0.5).abs() < 1e-4);
    settled(&mut window);
    window.click("New material");
    settled(&mut window);
    let (material, count) = (
        desc(&window).meshes[0].material.clone(),
        desc(&window).materials.len(),
    );
    assert_eq!((material.as_deref(), count), (Some("material"), 3));
    window.set("Mirror", 1.0);
    settled(&mut window);
    assert_eq!(desc(&window).materials[2].mirror, 1.0);
    window
        .harness
        .get_by_role_and_label(Role::ComboBox, "Made of")
        .click();
    window.harness.run_steps(2);
    window.click("lamp");
    settled(&mut window);
    assert_eq!(desc(&window).meshes[0].material.as_deref(), Some("lamp"));

    // One that is no mesh is answered in a line.
    let path = window.file("broken.obj");
    std::fs::write(&path, "f 1 2 3\n").expect("written");
    window.harness.state_mut().add_mesh(&ctx, path);
    window.wait("the complaint", |w| {
        let lines = w.harness.query_by_label_contains("broken.obj");
        lines.is_some()
    });
    assert_eq!(desc(&window).meshes.len(), 1);
}

#[test]
fn controls_say_what_they_cost() {
    let mut window = Window::open(SCENE);
    select_ball(&mut window);
    let count = |w: &Window, badge: &str| w.harness.query_all_by_label(badge).count();
    assert!(count(&window, "↺") >= 12, "{}", count(&window, "↺"));
    assert!(count(&window, "•") >= 5, "{}", count(&window, "•"));
}
