//! What pixels can show, and what is told of the one under the pointer.

use egui::accesskit::Role;
use egui::{Key, Modifiers, Vec2};
use egui_kittest::kittest::{NodeT as _, Queryable as _};
use lightbox::aov::{Aov, error_color};

use crate::window::{SCENE, Window};

fn aov(name: &str) -> Aov {
    Aov::all().find(|aov| aov.name() == name).expect("a view")
}

/// Presses the key of a view and waits until it is shown.
fn show(window: &mut Window, name: &str) -> Vec<u8> {
    let (modifiers, key) = aov(name).keys();
    window.key(modifiers, key);
    shown(window, name)
}

fn shown(window: &mut Window, name: &str) -> Vec<u8> {
    window.wait(name, |w| {
        let snapshot = w.snapshot();
        snapshot.aov == aov(name) && snapshot.preview.is_none()
    });
    window.snapshot().rgb()
}

/// The colour shown at shares of the picture's width and height.
fn color_at(window: &Window, x: f32, y: f32) -> [u8; 3] {
    let snapshot = window.snapshot();
    let [width, height] = snapshot.size.map(|n| n as f32);
    let start = 3 * ((y * height) as usize * snapshot.size[0] + (x * width) as usize);
    std::array::from_fn(|c| snapshot.rgb()[start + c])
}

/// Clicks an entry of the open list: the last button of its name, which a key may follow.
fn click_entry(window: &Window, name: &str) {
    let is_named = |n: &egui_kittest::Node<'_>| {
        let label = n.accesskit_node().label().unwrap_or_default();
        label == name || label.starts_with(&format!("{name} "))
    };
    let mut buttons = window.harness.get_all_by_role(Role::Button);
    buttons.rfind(is_named).expect("an entry").click();
}

#[test]
fn every_view_has_its_key_and_its_entry_and_goes_again() {
    let mut window = Window::open(SCENE);
    let (samples, light) = (window.status().samples, window.snapshot().rgb());
    let space = |w: &Window| w.harness.get_by_label("Picture").rect();
    let before = space(&window);
    for aov in Aov::all().filter(|aov| *aov != Aov::COLOR) {
        let name = aov.name();
        let by_key = show(&mut window, name);
        // There is nothing to compare with.
        assert_eq!(by_key == light, name == "difference", "{name}");
        // A wider panel would start the picture anew.
        assert_eq!(space(&window), before);
        let (modifiers, key) = aov.keys();
        window.key(modifiers, key);
        assert!(shown(&mut window, "colour") == light, "{name}");
        // By the pointer, and back by the key of the light.
        let combo = window.harness.get_by_role_and_label(Role::ComboBox, "View");
        combo.click();
        window.harness.run_steps(2);
        click_entry(&window, name);
        window.harness.run_steps(2);
        assert!(shown(&mut window, name) == by_key, "{name}");
        assert!(show(&mut window, "colour") == light);
    }
    assert_eq!(window.status().samples, samples);
}

#[test]
fn noise_is_shown_in_the_colours_of_its_scale() {
    let mut window = Window::open(SCENE);
    let map = show(&mut window, "noise");
    let is_on_scale = |rgb: &[u8]| {
        let near = |color: [u8; 3]| color.iter().zip(rgb).all(|(a, b)| a.abs_diff(*b) <= 1);
        (0..=3000).any(|i| near(error_color(1e-3 * 10f32.powf(i as f32 / 1000.0))))
    };
    assert!(map.chunks(3).all(is_on_scale));
    window.harness.get_by_label("0.10 %");
    window.harness.get_by_label("100 %");
}

#[test]
fn what_the_screen_cannot_show_is_marked() {
    let mut window = Window::open(SCENE);
    // So that light is lost at both ends.
    window.set("Exposure", 2.0);
    window.set("Offset", -0.2);
    let is_grey = |p: &[u8]| p[0] == p[1] && p[1] == p[2];
    for curve in ["linear", "filmic"] {
        let map = show(&mut window, "clipped");
        let tone = window.harness.state().model().tone;
        assert_eq!(
            (tone.exposure, tone.offset, tone.curve.name()),
            (2.0, -0.2, curve)
        );
        let session = window.harness.state().session();
        let mut counts = [0; 3];
        for (i, shown) in (0..).zip(map.chunks(3)) {
            let mean = session.pixel([i % 40, i / 40]).expect("a pixel").mean;
            let light = mean * 4.0 - 0.2;
            // The curve that bends light comes to white at twelve.
            let [white, clipped] = if curve == "linear" {
                [1.0, 1.02]
            } else {
                [12.0, 15.0]
            };
            let is_bright = light.max_element() > clipped;
            let may_be_bright = light.max_element() > white;
            // Where there is no light, black is right.
            let [is_dark, may_be_dark] =
                [0.0, 0.001].map(|least| mean.max_element() > 0.0 && light.max_element() < least);
            let is_marked = [shown[0] > shown[2], shown[2] > shown[0]];
            assert!(is_marked[0] || !is_bright, "{shown:?}: {light}");
            assert!(may_be_bright || !is_marked[0], "{shown:?}: {light}");
            assert!(is_marked[1] || !is_dark, "{shown:?}: {light}");
            assert!(may_be_dark || !is_marked[1], "{shown:?}: {light}");
            assert!(is_grey(shown) != (is_marked[0] || is_marked[1]));
            let kind = is_marked.iter().position(|is| *is).unwrap_or(2);
            counts[kind] += 1;
        }
        assert!(counts[1] > 0 && counts[2] > 0, "{curve} {counts:?}");
        assert_eq!(counts[0] > 0, curve == "linear", "{curve} {counts:?}");
        window.click("filmic");
        show(&mut window, "colour");
    }
    for text in ["brighter than white", "shown black, but not without light"] {
        assert!(window.harness.query_by_label(text).is_none());
        show(&mut window, "clipped");
        window.harness.get_by_label(text);
        show(&mut window, "colour");
    }
}

#[test]
fn surfaces_are_shown_while_the_samples_go_on() {
    let mut window = Window::open(SCENE);
    // The ball is in the middle, the wall behind it.
    show(&mut window, "object");
    let (ball, wall) = (color_at(&window, 0.5, 0.5), color_at(&window, 0.1, 0.5));
    assert!(ball != wall);
    for name in ["ball", "wall", "ceiling lamp"] {
        window.harness.get_by_label(name);
    }
    show(&mut window, "material");
    assert_eq!(color_at(&window, 0.5, 0.5), color_at(&window, 0.1, 0.5));
    show(&mut window, "front and back");
    assert_eq!(color_at(&window, 0.5, 0.5), color_at(&window, 0.1, 0.5));
    show(&mut window, "depth");
    let lightness = |[r, g, b]: [u8; 3]| u32::from(r) + u32::from(g) + u32::from(b);
    let (near, far) = (color_at(&window, 0.5, 0.5), color_at(&window, 0.1, 0.5));
    assert!(lightness(near) > lightness(far), "{near:?} {far:?}");
    show(&mut window, "normal");
    // They face the camera, which looks along −z.
    let (ball, wall) = (color_at(&window, 0.5, 0.5), color_at(&window, 0.1, 0.5));
    assert!(
        ball[2] > 250 && wall == [128, 128, 255],
        "{ball:?} {wall:?}"
    );
    show(&mut window, "albedo");
    let clay = lightbox_core::color::srgb_from_linear(0.5);
    assert_eq!(color_at(&window, 0.5, 0.5), [clay; 3]);

    // Another camera shows other surfaces, and its samples are taken behind them.
    show(&mut window, "object");
    let before = window.snapshot();
    window.seen = before.number;
    let middle = window.at(0.5, 0.5);
    window.drag(egui::PointerButton::Primary, middle, Vec2::new(40.0, 10.0));
    window.done();
    let after = window.snapshot();
    assert!(after.aov == aov("object") && after.rgb() != before.rgb());
    assert_eq!(window.status().samples, 16);
}

/// What stands at the end of the line about the pixel at a place of the picture.
fn reading(window: &mut Window, at: egui::Pos2) -> String {
    window.harness.hover_at(at);
    window.harness.run_steps(2);
    let text = |n: egui_kittest::Node<'_>| n.accesskit_node().value();
    let all = window.harness.query_all_by_label_contains("distance");
    let line = all.last().and_then(text).unwrap_or_default();
    line.rsplit("    ").next().unwrap_or_default().to_owned()
}

/// Both are told at the lower edge, and in a narrow window there is no room for both beside each other.
#[test]
fn the_legend_makes_way_for_what_is_told_of_a_pixel() {
    let mut window = Window::open(SCENE);
    show(&mut window, "depth");
    let place = |w: &Window, text: &str| {
        let all = w.harness.query_all_by_label_contains(text);
        all.last().expect(text).rect()
    };
    let alone = place(&window, "scene units");
    let at = window.at(0.51, 0.51);
    assert!(reading(&mut window, at).starts_with("distance"));
    window.harness.run_steps(2);
    let (legend, told) = (
        place(&window, "scene units"),
        place(&window, "    distance "),
    );
    assert!(
        alone.intersects(told) && !legend.intersects(told),
        "{legend} {told}"
    );
}

#[test]
fn the_cost_of_rays_is_counted_by_themselves() {
    let mut window = Window::open(SCENE);
    let on_ball = window.at(0.51, 0.51);
    assert!(reading(&mut window, on_ball).starts_with("distance"));
    show(&mut window, "traversal cost");
    window.harness.get_by_label("1\u{a0}000 nodes and shapes");
    // So few shapes need no tree. The ball is before all that could be behind it; beside it the ray
    // comes to both halves of the wall, and nowhere near the lamp.
    assert_eq!(reading(&mut window, on_ball), "0 nodes, 1 shape");
    let beside = window.at(0.9, 0.9);
    assert_eq!(reading(&mut window, beside), "0 nodes, 3 shapes");
    let all = window.snapshot().rgb();
    let ball = all.chunks(3).filter(|p| *p != &all[..3]).count();
    assert!(ball > 40 && ball < 140, "{ball}");
    // Where the ray is not within reach of anything, nothing is.
    let section = window
        .harness
        .get_by_role_and_label(Role::DisclosureTriangle, "Camera");
    section.click();
    window.harness.run_steps(20); // It unfolds.
    // The views have made pictures since the window last was done.
    window.seen = window.snapshot().number;
    window.set("Field of view", 120.0);
    window.done();
    let rgb = window.snapshot().rgb();
    let count = |color: &[u8]| rgb.chunks(3).filter(|p| *p == color).count();
    let (free, wall) = (count(&[68, 1, 84]), count(&all[..3]));
    assert!(free > 0 && wall > 0, "{free} {wall}");
}

#[test]
fn lengths_are_those_of_the_pixel_s_paths() {
    let mut window = Window::open(SCENE);
    show(&mut window, "path length");
    window.harness.get_by_label("4 segments");
    let at = window.at(0.51, 0.51);
    let told = reading(&mut window, at);
    let (view, _) = window.harness.state().session().making().expect("a view");
    let paths = (0..16).map(|sample| view.path([20, 15], sample).0.len());
    let mean = paths.sum::<usize>() as f32 / 16.0;
    assert!(mean > 1.5 && mean < 4.0, "{mean}");
    // As far along the scale as its logarithm.
    let right = error_color(1e-3 * 1000f32.powf(mean.ln() / 4f32.ln()));
    let color = color_at(&window, 0.51, 0.51);
    let off = color.iter().zip(right).map(|(a, b)| a.abs_diff(b)).max();
    assert!(off <= Some(1), "{color:?} {right:?}");
    let mean = lightbox::panels::format::short(mean);
    assert_eq!(told, format!("path length {mean}"));
    // With one segment each, all have as many.
    window.set("Depth", 1.0);
    window.done();
    window.wait("short paths", |w| {
        w.snapshot().rgb().chunks(3).all(|p| *p == [68, 1, 84])
    });
    assert_eq!(reading(&mut window, at), "path length 1");
}

#[test]
fn the_difference_is_that_to_the_reference() {
    let mut window = Window::open(SCENE);
    show(&mut window, "difference");
    assert!(
        window
            .harness
            .query_by_label_contains("no reference to compare with")
            .is_some()
    );
    window.harness.state().session().keep_reference();
    window.wait("a difference to itself", |w| {
        w.snapshot().rgb().iter().all(|v| *v == 0)
    });
    window.set("Samples", 32.0);
    window.done();
    let rgb = &window.snapshot().rgb();
    // Blue where it has become darker, orange where it has become lighter.
    let [blue, orange] = [2, 0].map(|c| rgb.chunks(3).filter(|p| p[c] > p[2 - c]).count() as f32);
    assert!(
        blue > 100.0 && (0.5..2.0).contains(&(blue / orange)),
        "{blue} {orange}"
    );
}

#[test]
fn the_pixel_under_the_pointer_is_read() {
    let mut window = Window::open(SCENE);
    let (on_ball, beside) = (window.at(0.51, 0.51), window.at(0.5, 0.02));
    window.harness.hover_at(on_ball);
    window.harness.run_steps(2);
    let readout = |w: &Window| {
        let all = w.harness.query_all_by_label_contains("RGB");
        let text = |n: egui_kittest::Node<'_>| n.accesskit_node().value();
        all.last().and_then(text).unwrap_or_default()
    };
    let text = readout(&window);
    let pixel = window.harness.state().session().pixel([20, 15]);
    let pixel = pixel.expect("samples");
    assert!(text.starts_with("20, 15    RGB "), "{text}");
    assert!(text.contains("    ball, clay    distance 3.5"), "{text}");
    let numbers = text.split("RGB ").nth(1).expect("numbers");
    let numbers: Vec<f32> = numbers
        .split_whitespace()
        .take(7)
        .filter_map(|word| word.parse().ok())
        .collect();
    let right = [pixel.mean, pixel.error.expect("an error")];
    let right = right.map(|v| v.to_array()).concat();
    assert_eq!(numbers.len(), 6);
    for (shown, right) in numbers.iter().zip(right) {
        assert!((shown - right).abs() <= 0.005 * right, "{text}: {right}");
    }
    window.harness.hover_at(beside);
    window.harness.run_steps(2);
    assert!(
        readout(&window).contains("    wall, clay    "),
        "{}",
        readout(&window)
    );
    // Other views do not change what is read.
    window.harness.hover_at(on_ball);
    window.key(Modifiers::NONE, Key::F10);
    shown(&mut window, "normal");
    assert_eq!(readout(&window), text);
}

#[test]
fn exposure_and_offset_have_tev_s_keys() {
    let mut window = Window::open(SCENE);
    let tone = |w: &Window| w.harness.state().model().tone;
    window.key(Modifiers::NONE, Key::O);
    window.key(Modifiers::NONE, Key::O);
    window.key(Modifiers::SHIFT, Key::O);
    assert_eq!((tone(&window).exposure, tone(&window).offset), (0.0, 0.1));
    window.wait("a lighter picture", |w| {
        // No pixel is darker than what was added.
        let least = lightbox_core::color::srgb_from_linear(0.1);
        w.snapshot().rgb().iter().all(|v| *v >= least)
    });
    window.key(Modifiers::NONE, Key::N);
    window.wait("a tone that fits", |w| tone(w).exposure != 0.0);
    let fitted = tone(&window);
    let session = window.harness.state().session();
    let pixels = (0..40 * 30).map(|i| session.pixel([i % 40, i / 40]).expect("a pixel").mean);
    let pixels: Vec<_> = pixels.collect();
    assert_eq!(fitted, tone(&window).fitted(&pixels));
    // What fits may need no offset.
    window.key(Modifiers::NONE, Key::O);
    assert!(tone(&window).exposure != 0.0 && tone(&window).offset != 0.0);
    window.key(Modifiers::NONE, Key::R);
    assert_eq!(tone(&window), Default::default());
}
