//! The window, driven as a user drives it: by the names of its controls, the pointer and the keys.
//! The engine runs behind it for real; a test waits for results, never for a span of time.

#[path = "ui/window.rs"]
mod window;

use std::path::Path;
use std::time::Duration;

use egui::accesskit::Role;
use egui::{Event, Key, Modifiers, MouseWheelUnit, PointerButton, Vec2};
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable as _;
use glam::Vec3;
use lightbox::app::App;
use lightbox::model::Selection;
use lightbox::session::{Activity, Snapshot};
use lightbox_core::scene::ObjectKind;
use lightbox_core::settings::UNLIMITED;
use lightbox_core::{AccelKind, FilterKind, Method, SamplerKind};

use window::{SCENE, Window};

#[test]
fn opens_a_built_in_scene_without_a_path() {
    let builder = Harness::builder().with_size(Vec2::new(500.0, 300.0));
    let harness =
        builder.build_eframe(|context| App::new(&context.egui_ctx, None).expect("an engine"));
    let mut window = Window {
        harness,
        folder: tempfile::tempdir().expect("a folder"),
        seen: 0,
    };
    window.wait("the scene to open", |w| {
        w.status().opened == 1 && w.harness.state().session().snapshot().is_some()
    });
    let scene = window.status().scene.expect("a scene");
    assert_eq!(scene.path(), Path::new(lightbox_core::scene::BUILTIN[0]));
}

#[test]
fn exposure_and_tone_curve_keep_the_samples() {
    let mut window = Window::open(SCENE);
    let before = (window.snapshot(), window.status());
    window.set("Exposure", 1.0);
    window.wait("a brighter picture", |w| {
        w.snapshot().number > before.0.number
    });
    let sum = |s: &Snapshot| s.rgb.iter().map(|v| u64::from(*v)).sum::<u64>();
    assert!(sum(&window.snapshot()) > sum(&before.0));
    let bright = window.snapshot();
    window.click("filmic");
    window.wait("another curve", |w| w.snapshot().number > bright.number);
    assert!(window.snapshot().rgb != bright.rgb);
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
        assert!(now.rgb != last.rgb, "{what}");
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
    let before = window.snapshot();
    for kind in [AccelKind::Brute, AccelKind::KdTree, AccelKind::Bvh] {
        let name = kind.name();
        window.click(name);
        window.done();
        let scene = window.status().scene.expect("a scene");
        assert_eq!(scene.desc().render.accel, kind);
        assert_eq!(scene.geometry().accel(), kind);
        assert!(
            window.snapshot().rgb == before.rgb,
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
    assert!(window.snapshot().rgb != before.rgb);
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
    assert!(window.snapshot().rgb != before.rgb);
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
        for name in ["Albedo", "Light color"] {
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

#[test]
fn f1_lists_the_keys() {
    let mut window = Window::open(SCENE);
    assert!(window.harness.query_by_label("orbit").is_none());
    window.key(Modifiers::NONE, Key::F1);
    assert!(window.harness.query_by_label("orbit").is_some());
    window.key(Modifiers::NONE, Key::Escape);
    assert!(window.harness.query_by_label("orbit").is_none());
}

#[test]
fn pictures_are_saved_in_both_formats() {
    let mut window = Window::open(SCENE);
    for name in ["a.png", "a.exr"] {
        let path = window.file(name);
        window.harness.state().save(path.clone());
        window.wait("the file", |w| {
            w.harness.query_by_label_contains(name).is_some()
        });
        let image = lightbox_core::image_io::read(&path).expect("a picture");
        assert_eq!((image.width, image.height), (40, 30));
    }
    window.harness.state().save(window.file("a.gif"));
    window.wait("the complaint", |w| {
        w.harness.query_by_label_contains("a.gif").is_some()
    });
}

#[test]
fn a_bad_file_leaves_the_scene_and_says_why() {
    let mut window = Window::open(SCENE);
    let bad = window.file("bad.toml");
    std::fs::write(&bad, "[camera]\nfov = 400\n").expect("written");
    let before = window.snapshot();
    window.drop_file(&bad);
    window.wait("the complaint", |w| {
        w.harness.query_by_label_contains("fov is 400").is_some()
    });
    assert_eq!(window.status().opened, 1);
    assert_eq!(window.snapshot().number, before.number);
    window.click("Dismiss");
    assert!(window.harness.query_by_label_contains("bad.toml").is_none());
    let picture = window.file("a.jpeg");
    window.drop_file(&picture);
    assert!(
        window
            .harness
            .query_by_label_contains("not a scene")
            .is_some()
    );
}

#[test]
fn a_dropped_mesh_opens_in_a_room() {
    let mut window = Window::open(SCENE);
    let mesh = window.file("tent.obj");
    std::fs::write(&mesh, "v -1 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n").expect("written");
    window
        .harness
        .input_mut()
        .hovered_files
        .push(egui::HoveredFile {
            path: Some(mesh.clone()),
            ..Default::default()
        });
    window.harness.run_steps(1);
    window.harness.input_mut().hovered_files.clear();
    window.drop_file(&mesh);
    window.wait("the mesh", |w| w.status().opened == 2);
    assert_eq!(window.harness.state().model().desc.meshes[0].name, "tent");
    window.wait("its census", |w| {
        w.harness
            .query_by_label_contains("1 triangle, 6 quads, 1 light")
            .is_some()
    });
}

#[test]
fn a_dark_scene_gets_a_lamp_by_one_click() {
    let dark = SCENE.replace("emission = [5, 5, 5]", "emission = [0, 0, 0]");
    let mut window = Window::open(&dark);
    assert!(window.snapshot().rgb.iter().all(|v| *v == 0));
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
    let sum: u64 = window.snapshot().rgb.iter().map(|v| u64::from(*v)).sum();
    assert!(sum / 3600 > 20, "the picture is dark: {sum}");
}

#[test]
fn the_panel_does_not_push_the_picture() {
    let mut window = Window::open(SCENE);
    window.click("fit window");
    // As high as the panel before an object is selected, and less than after.
    let camera = window
        .harness
        .get_by_role_and_label(Role::DisclosureTriangle, "Camera");
    let height = camera.rect().bottom() + 60.0;
    window.harness.set_size(Vec2::new(620.0, height));
    window.harness.run_steps(20);
    let width = |w: &Window| w.harness.state().model().desc.render.width;
    let before = width(&window);
    assert!(before > 100);
    window.click_at(window.at(0.5, 0.5));
    assert!(window.harness.state().model().selection.is_some());
    for section in ["Camera", "Objects (3)"] {
        window
            .harness
            .get_by_role_and_label(Role::DisclosureTriangle, section)
            .click();
        window.harness.run_steps(20);
        assert_eq!(width(&window), before, "{section}");
    }
}

#[test]
fn the_picture_follows_the_window_when_it_rests() {
    let mut window = Window::open(SCENE);
    window.click("fit window");
    window.wait("the window's size", |w| w.snapshot().size[0] > 100);
    let size = |w: &Window| [w.status().desc.render.width, w.status().desc.render.height];
    let before = size(&window);
    // In frames of 1/30 s, the size is still for less than it takes.
    let mut frames = 0;
    window.harness.set_size(Vec2::new(630.0, 1400.0));
    while size(&window) == before {
        window.harness.step();
        frames += 1;
        assert!(frames < 100);
    }
    assert_eq!(size(&window), [before[0] + 10, before[1]]);
    assert!(frames > 5, "taken over at once");
}
