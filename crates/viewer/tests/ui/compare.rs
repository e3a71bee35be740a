//! Kept pictures: the strip, the wipe, side by side, and a closer look.

use egui::accesskit::Role;
use egui::{Key, Modifiers, PointerButton, Shape, TextureId, Vec2};
use egui_kittest::kittest::{NodeT as _, Queryable as _};

use crate::window::{SCENE, Window};

fn buttons(window: &Window, part: &str) -> usize {
    window
        .harness
        .query_all_by_role(Role::Button)
        .filter(|n| {
            let label = n.accesskit_node().label().unwrap_or_default();
            label.starts_with(part)
        })
        .count()
}

fn reference(window: &Window) -> Option<String> {
    window.status().reference.map(|r| r.name.clone())
}

fn keep(window: &mut Window) {
    let before = buttons(window, "Compare with");
    window.key(Modifiers::NONE, Key::K);
    window.wait("a kept picture", |w| buttons(w, "Compare with") > before);
}

#[test]
fn kept_pictures_stand_in_a_strip() {
    let mut window = Window::open(SCENE);
    assert_eq!(buttons(&window, "Compare with"), 0);
    let space = window.harness.get_by_label("Picture").rect();
    keep(&mut window);
    assert_eq!(reference(&window).as_deref(), Some("16 spp reuse"));
    window.set("Samples", 32.0);
    window.done();
    keep(&mut window);
    assert_eq!(reference(&window).as_deref(), Some("32 spp reuse"));
    // The strip lies over the picture: its size is what it was.
    assert_eq!(window.harness.get_by_label("Picture").rect(), space);
    // A name of one's own.
    let name = |w: &Window| {
        let field = w.harness.get_by_label("Name of kept picture 1");
        field.accesskit_node().value().unwrap_or_default()
    };
    assert_eq!(name(&window), "16 spp reuse");
    window
        .harness
        .get_by_label("Name of kept picture 1")
        .focus();
    window.harness.run_steps(2);
    window
        .harness
        .get_by_label("Name of kept picture 1")
        .type_text(", early");
    window.harness.run_steps(2);
    assert_eq!(name(&window), "16 spp reuse, early");
    // Chosen, and no longer.
    window.click("Compare with 16 spp reuse, early");
    window.wait("the first", |w| {
        reference(w).as_deref() == Some("16 spp reuse")
    });
    window.click("Compare with 16 spp reuse, early");
    window.wait("no reference", |w| reference(w).is_none());
    // Hidden and shown.
    window.key(Modifiers::SHIFT, Key::K);
    assert_eq!(buttons(&window, "Compare with"), 0);
    window.key(Modifiers::SHIFT, Key::K);
    assert_eq!(buttons(&window, "Compare with"), 2);
    // Forgotten: it is compared with no more.
    window.click("Compare with 32 spp reuse");
    window.wait("the second", |w| reference(w).is_some());
    window.click("Forget 32 spp reuse");
    window.wait("no reference", |w| reference(w).is_none());
    assert_eq!(buttons(&window, "Compare with"), 1);
}

#[test]
fn without_a_kept_picture_there_is_nothing_to_compare_with() {
    let mut window = Window::open(SCENE);
    window.key(Modifiers::NONE, Key::B);
    let text = "nothing to compare with yet: K keeps this picture";
    assert!(window.harness.query_by_label_contains(text).is_some());
}

#[test]
fn comparing_may_be_asked_for_while_the_picture_is_being_kept() {
    let mut window = Window::open(SCENE);
    // In one frame: the engine keeps a picture after its pass, which may take seconds.
    window.harness.key_press(Key::K);
    window.harness.key_press(Key::B);
    window.wait("both", |w| w.harness.state().session().other().is_some());
    let text = "nothing to compare with yet: K keeps this picture";
    assert!(window.harness.query_by_label_contains(text).is_none());
}

#[test]
fn the_kept_picture_is_shown_beside_the_present_one() {
    let mut window = Window::open(SCENE);
    let light = window.snapshot().rgb();
    let other = |w: &Window| w.harness.state().session().other();
    keep(&mut window);
    assert!(other(&window).is_none(), "it is not made ready for nobody");
    window.key(Modifiers::NONE, Key::B);
    window.wait("the other", |w| other(w).is_some());
    assert!(other(&window).is_some_and(|o| o.rgb() == light));
    // It follows exposure, not the camera.
    window.set("Exposure", 1.0);
    window.wait("a lighter one", |w| {
        other(w).is_some_and(|o| o.rgb() != light)
    });
    window.wait("the same", |w| {
        other(w).is_some_and(|o| o.rgb() == w.snapshot().rgb())
    });
    window.set("Exposure", 0.0);
    let line = |w: &Window| {
        let node = w.harness.get_by_role_and_label(Role::Slider, "Wipe");
        node.accesskit_node().numeric_value().expect("a number")
    };
    assert_eq!(line(&window), 0.5);
    let eye = window.eye();
    let (middle, tenth) = (
        window.at(0.5, 0.2),
        window.at(0.6, 0.2) - window.at(0.5, 0.2),
    );
    window.drag(PointerButton::Primary, middle, tenth);
    assert!((line(&window) - 0.6).abs() < 0.02, "{}", line(&window));
    assert_eq!(window.eye(), eye, "the line was dragged, not the camera");
    window.set("Wipe", 0.25);
    assert_eq!(line(&window), 0.25);
    // Side by side, the picture moves to the right half, and keeps its samples.
    let samples = window.status().samples;
    window.key(Modifiers::SHIFT, Key::B);
    window.wait("a wide gap", |w| other(w).is_some());
    let right = window.harness.get_by_label("Picture").rect();
    let right = right.with_min_x(right.center().x);
    window
        .harness
        .hover_at(right.center() + Vec2::new(1.0, 2.0));
    window.harness.run_steps(2);
    let mut readout = window.harness.query_all_by_label_contains("ball, clay");
    assert!(readout.next().is_some());
    drop(readout);
    assert_eq!(window.status().samples, samples);
    window.key(Modifiers::SHIFT, Key::B);
    window.wait("the other to go", |w| other(w).is_none());
}

/// The texture that lies on top in the right half of the space for pictures, and how often its name is told.
fn on_top(window: &Window, caption: &str) -> (Option<TextureId>, usize) {
    let shapes = &window.harness.output().shapes;
    let place = window.at(0.75, 0.5);
    let mut images = shapes.iter().filter_map(|clipped| match &clipped.shape {
        Shape::Mesh(mesh)
            if mesh.texture_id != TextureId::default()
                && clipped.clip_rect.contains(place)
                && mesh.calc_bounds().contains(place) =>
        {
            Some(mesh.texture_id)
        }
        _ => None,
    });
    let texts = shapes.iter().filter_map(|clipped| match &clipped.shape {
        Shape::Text(text) => Some(text.galley.text()),
        _ => None,
    });
    (
        images.next_back(),
        texts.filter(|text| *text == caption).count(),
    )
}

#[test]
fn the_kept_picture_takes_the_place_of_the_present_one_while_a_key_is_held() {
    let mut window = Window::open(SCENE);
    let other = |w: &Window| w.harness.state().session().other();
    let kept = "16 spp reuse, early";
    // With nothing kept it is told what to do.
    window.key(Modifiers::NONE, Key::V);
    let text = "nothing to compare with yet: K keeps this picture";
    assert!(window.harness.query_by_label_contains(text).is_some());
    keep(&mut window);
    let field = "Name of kept picture 1";
    window.harness.get_by_label(field).focus();
    window.harness.run_steps(2);
    window.harness.get_by_label(field).type_text(", early");
    // Those who type see what they type.
    window.harness.key_down(Key::V);
    window.harness.run_steps(4);
    // The name stands in its field.
    let (present, told) = on_top(&window, kept);
    assert!(present.is_some() && told == 1 && other(&window).is_none());
    window.harness.key_up(Key::V);
    let corner = window.at(0.1, 0.1);
    window.click_at(corner);
    window.key(Modifiers::NONE, Key::Escape); // What was clicked is selected.

    for mode in [None, Some(Key::B)] {
        if let Some(key) = mode {
            window.key(Modifiers::SHIFT, key);
            window.wait("both", |w| other(w).is_some());
        }
        let before = on_top(&window, kept);
        assert_eq!(before, (present, 1 + usize::from(mode.is_some())));
        window.harness.key_down(Key::V);
        window.wait("the kept picture alone", |w| {
            let (top, told) = on_top(w, kept);
            top.is_some() && top != present && told == 2
        });
        window.harness.key_up(Key::V);
        window.harness.run_steps(2);
        assert_eq!(on_top(&window, kept), before);
    }
    // Without a key, and until it is chosen no longer.
    window.click("in its place");
    window.wait("the kept picture alone", |w| on_top(w, kept).0 != present);
    window.click("off");
    window.wait("nobody to look at it", |w| other(w).is_none());
    assert_eq!(on_top(&window, kept), (present, 1));
}

/// The pixel under the pointer is this.
fn pixel(window: &Window, text: &str) {
    let found = window.harness.query_all_by_label_contains("RGB");
    let value = |n: egui_kittest::Node<'_>| n.accesskit_node().value();
    let read = found.filter_map(value).next().expect("a readout");
    assert!(read.starts_with(text), "{read}");
}

#[test]
fn pixels_can_be_looked_at_closely() {
    let mut window = Window::open(SCENE);
    let (eye, place) = (window.eye(), window.at(0.25, 0.25));
    window.harness.hover_at(place);
    window.harness.run_steps(2);
    pixel(&window, "10, 7 ");
    for _ in 0..3 {
        window.key(Modifiers::NONE, Key::Plus);
    }
    // What was under the pointer still is; a pixel is eight times as wide.
    pixel(&window, "10, 7 ");
    let wide = window.at(0.35, 0.25) - place;
    window.harness.hover_at(place + wide * 2.0);
    window.harness.run_steps(2);
    pixel(&window, "11, 7 ");
    window.key(Modifiers::NONE, Key::Num0);
    window.harness.run_steps(2);
    pixel(&window, "18, 7 ");
    window.key(Modifiers::NONE, Key::Minus);
    pixel(&window, "18, 7 ");
    assert_eq!(window.eye(), eye);
}

#[test]
fn close_pixels_are_panned_instead_of_the_camera() {
    let mut window = Window::open(SCENE);
    // The middle of a pixel.
    let (camera, middle) = (
        window.status().desc.camera,
        window.at(20.5 / 40.0, 15.5 / 30.0),
    );
    let wide = window.at(21.5 / 40.0, 0.5).x - middle.x;
    for button in [PointerButton::Secondary, PointerButton::Middle] {
        window.harness.hover_at(middle);
        window.harness.run_steps(2);
        pixel(&window, "20, 15 ");
        for _ in 0..2 {
            window.key(Modifiers::NONE, Key::Plus);
        }
        // Two pixels to the left, of which each is four times as wide as one was.
        window.drag(button, middle, Vec2::new(wide * 8.0, 0.0));
        pixel(&window, "20, 15 ");
        window.harness.hover_at(middle);
        window.harness.run_steps(2);
        pixel(&window, "18, 15 ");
        assert_eq!(window.harness.state().model().desc.camera, camera);
        window.key(Modifiers::NONE, Key::Num0);
    }
    window.drag(PointerButton::Middle, middle, Vec2::new(wide, 0.0));
    assert_ne!(window.harness.state().model().desc.camera, camera);
}
