//! Objects: picking, painting, lamps.

use egui::accesskit::Role;
use egui::{Key, Modifiers, PointerButton, Vec2};
use egui_kittest::kittest::Queryable as _;
use glam::Vec3;
use lightbox::model::Selection;
use lightbox_core::scene::ObjectKind;

use crate::window::{SCENE, Window};

#[test]
fn a_clicked_object_can_be_painted() {
    let mut window = Window::open(SCENE);
    window.click_at(window.at(0.5, 0.5));
    let selection = Selection {
        kind: ObjectKind::Sphere(0),
        part: 0,
    };
    assert_eq!(window.harness.state().model().selection, Some(selection));
    assert!(
        window.harness.query_by_label("clay").is_some(),
        "the material is named"
    );
    let before = window.snapshot();
    window.set("Mirror", 1.0);
    window.done();
    assert_eq!(window.status().desc.materials[0].mirror, 1.0);
    assert!(window.snapshot().rgb() != before.rgb());
    window.set("Mirror", 0.0);
    window.done();
    window
        .harness
        .get_by_role_and_label(Role::ColorWell, "Albedo")
        .click();
    window.harness.run_steps(2);
    let before = window.snapshot();
    // Grey has no hue; the one chosen is remembered until there is saturation.
    for (slider, value) in [("Hue", 0.333), ("Saturation", 1.0), ("Brightness", 1.0)] {
        window.set(slider, value);
    }
    window.done();
    let albedo = window.status().desc.materials[0].albedo;
    assert!(albedo.distance(Vec3::Y) < 0.02, "{albedo}");
    assert!(window.snapshot().rgb() != before.rgb());
    // Back in the panel, which the list of sliders has covered.
    window.key(Modifiers::NONE, Key::Escape);

    window
        .harness
        .get_by_role_and_label(Role::CheckBox, "Glass")
        .click();
    window.done();
    assert_eq!(window.status().desc.materials[0].glass, Some(1.5));
    window.set("Refraction", 2.0);
    window.set("Emission", 3.0);
    window.done();
    let material = &window.status().desc.materials[0];
    assert_eq!(
        (material.glass, material.emission),
        (Some(2.0), Vec3::splat(3.0))
    );
    // Both spheres and walls of clay shine now.
    assert_eq!(window.status().scene.expect("a scene").lights().len(), 3);
}

#[test]
fn looking_is_not_editing() {
    // Numbers that no slider would choose, some of them beyond its ends.
    let odd = SCENE
        .replace("fov = 40", "fov = 39.30675")
        .replace("depth = 4", "depth = 100\nfilter = \"tent:1.2345\"")
        .replace(
            "albedo = [0.5, 0.5, 0.5]",
            "albedo = [0.7291, 0.7144, 0.6859]\nmirror = 0.12345",
        )
        .replace(
            "emission = [5, 5, 5]",
            "emission = [17.123, 1234.5, 4]\nglass = 4.56789",
        );
    let mut window = Window::open(&odd);
    let opened = window.harness.state().model().desc.clone();
    window
        .harness
        .get_by_role_and_label(Role::DisclosureTriangle, "Camera")
        .click();
    window.harness.run_steps(2);
    for y in [0.5, 0.05] {
        window.click_at(window.at(0.5, y));
        for name in ["Albedo", "Light colour"] {
            window
                .harness
                .get_by_role_and_label(Role::ColorWell, name)
                .click();
            window.harness.run_steps(3);
            assert!(
                window
                    .harness
                    .query_all_by_label("Saturation")
                    .next()
                    .is_some(),
                "{name} opens its list"
            );
            window.key(Modifiers::NONE, Key::Escape);
            assert!(window.harness.state().model().selection.is_some());
        }
    }
    assert_eq!(window.harness.state().model().desc, opened);
}

#[test]
fn a_click_beside_everything_selects_nothing() {
    let mut window = Window::open(SCENE);
    window.click_at(window.at(0.5, 0.5));
    window.drag(
        PointerButton::Primary,
        window.at(0.5, 0.5),
        Vec2::new(0.0, -400.0),
    );
    window.done();
    window.click_at(window.at(0.02, 0.02));
    assert_eq!(window.harness.state().model().selection, None);
}

#[test]
fn a_dark_scene_gets_a_lamp_by_one_click() {
    let dark = SCENE.replace("emission = [5, 5, 5]", "emission = [0, 0, 0]");
    let mut window = Window::open(&dark);
    assert!(window.snapshot().rgb().iter().all(|v| *v == 0));
    assert!(
        window
            .harness
            .query_by_label("Nothing emits light.")
            .is_some()
    );
    window.click("Add a ceiling lamp");
    window.done();
    assert!(
        window
            .harness
            .query_by_label("Nothing emits light.")
            .is_none()
    );
    let sum: u64 = window.snapshot().rgb().iter().map(|v| u64::from(*v)).sum();
    assert!(sum / 3600 > 20, "the picture is dark: {sum}");
}
