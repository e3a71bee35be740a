//! The window, driven as a user drives it: by the names of its controls, the pointer and the keys.
//! The engine runs behind it for real; a test waits for results, never for a span of time.

use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use egui::accesskit::Role;
use egui::{Event, Key, Modifiers, MouseWheelUnit, PointerButton, Pos2, Vec2};
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable as _;
use glam::Vec3;
use lightbox::app::App;
use lightbox::model::Selection;
use lightbox::session::{Activity, Snapshot, Status};
use lightbox_core::scene::ObjectKind;
use lightbox_core::settings::UNLIMITED;
use lightbox_core::{AccelKind, FilterKind, Method, SamplerKind};

/// A sphere in front of a lamp and a wall, quick to render.
const SCENE: &str = r#"
[camera]
eye = [0, 0, 4]
target = [0, 0, 0]
fov = 40

[render]
width = 40
height = 30
samples = 16
depth = 4

[[material]]
name = "clay"
albedo = [0.5, 0.5, 0.5]

[[material]]
name = "lamp"
emission = [5, 5, 5]

[[sphere]]
name = "ball"
material = "clay"
center = [0, 0, 0]
radius = 0.5

[[quad]]
name = "wall"
material = "clay"
corners = [[-3, -3, -2], [3, -3, -2], [3, 3, -2], [-3, 3, -2]]

[[quad]]
name = "ceiling lamp"
material = "lamp"
corners = [[-1, 2, -1], [1, 2, -1], [1, 2, 1], [-1, 2, 1]]
"#;

/// How long a test waits for the engine before it gives up.
const PATIENCE: Duration = Duration::from_secs(60);

struct Window {
    harness: Harness<'static, App>,
    folder: tempfile::TempDir,
    /// Number of the last picture that was waited for.
    seen: u64,
}

impl Window {
    /// Opens a scene in a small window and waits until its picture is done, at the size in the
    /// file, so that tests are quick.
    fn open(scene: &str) -> Self {
        let folder = tempfile::tempdir().expect("a folder for the scene");
        let path = folder.path().join("scene.toml");
        std::fs::write(&path, scene).expect("the scene is written");
        Self::open_path(folder, path)
    }

    fn open_path(folder: tempfile::TempDir, path: PathBuf) -> Self {
        // Tall enough for every row of the side panel.
        let builder = Harness::builder().with_size(Vec2::new(620.0, 1400.0)).with_step_dt(1.0 / 30.0);
        let harness = builder.build_eframe(|context| App::new(&context.egui_ctx, Some(path)).expect("an engine"));
        let mut window = Self { harness, folder, seen: 0 };
        window.wait("a picture of the window's size", |w| {
            w.harness.state().session().snapshot().is_some_and(|s| s.size[0] > 100)
        });
        window.click("as in file");
        window.done();
        window
    }

    fn status(&self) -> Status {
        self.harness.state().session().status()
    }

    fn snapshot(&self) -> std::sync::Arc<Snapshot> {
        self.harness.state().session().snapshot().expect("a picture")
    }

    /// Runs frames until something holds.
    fn wait(&mut self, what: &str, holds: impl Fn(&Self) -> bool) {
        let start = Instant::now();
        while !holds(self) {
            assert!(start.elapsed() < PATIENCE, "waited in vain for {what}: {:?}", self.status().activity);
            self.harness.step();
            std::thread::sleep(Duration::from_millis(2));
        }
        // The window has to see it too.
        self.harness.run_steps(2);
    }

    /// Waits for a new picture of what the model wants, rendered to the end.
    fn done(&mut self) {
        self.harness.run_steps(2);
        self.wait("the picture to be done", |w| {
            let (status, model) = (w.status(), w.harness.state().model());
            status.activity == Activity::Done
                && status.loading.is_none()
                && status.samples == model.desc.render.samples
                && w.is_current()
                && w.snapshot().preview.is_none()
                && w.snapshot().number > w.seen
        });
        self.seen = self.snapshot().number;
    }

    /// Whether the scene in use has every edit.
    fn is_current(&self) -> bool {
        let (status, model) = (self.status(), self.harness.state().model());
        let same_scene = status.scene.is_some_and(|s| {
            let (old, new) = (s.desc(), &model.desc);
            (&old.materials, &old.quads, old.render.accel) == (&new.materials, &new.quads, new.render.accel)
        });
        let size = [model.desc.render.width as usize, model.desc.render.height as usize];
        same_scene && *status.desc == model.desc && self.snapshot().size == size
    }

    fn click(&mut self, name: &str) {
        self.harness.get_by_role_and_label(Role::Button, name).click();
        self.harness.run_steps(2);
    }

    fn set(&mut self, slider: &str, value: f64) {
        self.harness.get_by_role_and_label(Role::Slider, slider).set_value_accesskit(value);
        self.harness.run_steps(2);
    }

    /// A place in the picture, in shares of its width and height.
    fn at(&self, x: f32, y: f32) -> Pos2 {
        let space = self.harness.get_by_label("Picture").rect();
        let size = self.snapshot().size;
        let scale = (space.width() / size[0] as f32).min(space.height() / size[1] as f32);
        let picture = Vec2::new(size[0] as f32, size[1] as f32) * scale;
        space.center() + Vec2::new((x - 0.5) * picture.x, (y - 0.5) * picture.y)
    }

    fn button(&self, pos: Pos2, button: PointerButton, pressed: bool) {
        self.harness.event(Event::PointerButton { pos, button, pressed, modifiers: Modifiers::NONE });
    }

    fn drag(&mut self, button: PointerButton, from: Pos2, by: Vec2) {
        self.harness.hover_at(from);
        self.button(from, button, true);
        self.harness.run_steps(1);
        for i in 1..=4 {
            self.harness.hover_at(from + by * (i as f32 / 4.0));
            self.harness.run_steps(1);
        }
        self.button(from + by, button, false);
        self.harness.run_steps(2);
    }

    fn click_at(&mut self, pos: Pos2) {
        self.harness.hover_at(pos);
        self.button(pos, PointerButton::Primary, true);
        self.button(pos, PointerButton::Primary, false);
        self.harness.run_steps(2);
    }

    fn key(&mut self, modifiers: Modifiers, key: Key) {
        self.harness.key_press_modifiers(modifiers, key);
        self.harness.run_steps(3);
    }

    fn eye(&self) -> Vec3 {
        self.harness.state().model().desc.camera.eye
    }

    fn file(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }
}

#[test]
fn opens_a_built_in_scene_without_a_path() {
    let builder = Harness::builder().with_size(Vec2::new(500.0, 300.0));
    let harness = builder.build_eframe(|context| App::new(&context.egui_ctx, None).expect("an engine"));
    let mut window = Window { harness, folder: tempfile::tempdir().expect("a folder"), seen: 0 };
    window.wait("the scene to open", |w| w.status().opened == 1 && w.harness.state().session().snapshot().is_some());
    let scene = window.status().scene.expect("a scene");
    assert_eq!(scene.path(), Path::new(lightbox_core::scene::BUILTIN[0]));
}

#[test]
fn exposure_and_tone_curve_keep_the_samples() {
    let mut window = Window::open(SCENE);
    let before = (window.snapshot(), window.status());
    window.set("Exposure", 1.0);
    window.wait("a brighter picture", |w| w.snapshot().number > before.0.number);
    let sum = |s: &Snapshot| s.rgb.iter().map(|v| u64::from(*v)).sum::<u64>();
    assert!(sum(&window.snapshot()) > sum(&before.0));
    let bright = window.snapshot();
    window.click("filmic");
    window.wait("another curve", |w| w.snapshot().number > bright.number);
    assert!(window.snapshot().rgb != bright.rgb);
    // Neither the samples nor the time they took are touched.
    let after = window.status();
    assert_eq!((after.samples, after.seconds, after.rays), (before.1.samples, before.1.seconds, before.1.rays));
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
    window.harness.get_by_role_and_label(Role::CheckBox, "Unlimited depth").click();
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
    assert_eq!(window.status().desc.render.sampler, SamplerKind::Independent);
    expect_new(&mut window, "sampler");
    window.harness.get_by_role_and_label(Role::DisclosureTriangle, "Camera").click();
    window.harness.run_steps(2);
    window.set("Field of view", 60.0);
    assert_eq!(window.status().desc.camera.fov, 60.0);
    expect_new(&mut window, "field of view");
}

#[test]
fn filters_are_chosen_from_a_list() {
    let mut window = Window::open(SCENE);
    window.harness.get_by_role_and_label(Role::ComboBox, "Filter").click();
    window.harness.run_steps(2);
    window.click("mitchell");
    window.done();
    let filter = window.status().desc.render.filter;
    assert_eq!((filter.kind, filter.radius), (FilterKind::Mitchell, FilterKind::Mitchell.default_radius()));
}

#[test]
fn accelerators_give_the_same_picture() {
    let mut window = Window::open(SCENE);
    let before = window.snapshot();
    for (name, kind) in [("brute", AccelKind::Brute), ("kdtree", AccelKind::KdTree)] {
        window.click(name);
        window.done();
        let scene = window.status().scene.expect("a scene");
        assert_eq!(scene.desc().render.accel, kind);
        assert_eq!(scene.geometry().tree().is_some(), kind == AccelKind::KdTree);
        assert!(window.snapshot().rgb == before.rgb, "{name} gives another picture");
    }
}

#[test]
fn pause_keeps_the_samples_and_resume_goes_on() {
    let mut window = Window::open(SCENE);
    window.set("Samples", 60_000.0);
    window.wait("rendering", |w| w.status().activity == Activity::Rendering && w.status().samples > 16);
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
        assert_eq!(delay(&window), Duration::MAX, "{:?}", window.harness.ctx.repaint_causes());
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
    let selection = Selection { kind: ObjectKind::Sphere(0), part: 0 };
    assert_eq!(window.harness.state().model().selection, Some(selection));
    assert!(window.harness.query_by_label("clay").is_some(), "the material is named");
    let before = window.snapshot();
    window.set("Mirror", 1.0);
    window.done();
    assert_eq!(window.status().desc.materials[0].mirror, 1.0);
    assert!(window.snapshot().rgb != before.rgb);
    window.set("Mirror", 0.0);
    window.done();
    window.harness.get_by_role_and_label(Role::ColorWell, "Albedo").click();
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

    window.harness.get_by_role_and_label(Role::CheckBox, "Glass").click();
    window.done();
    assert_eq!(window.status().desc.materials[0].glass, Some(1.5));
    window.set("Refraction", 2.0);
    window.set("Emission", 3.0);
    window.done();
    let material = &window.status().desc.materials[0];
    assert_eq!((material.glass, material.emission), (Some(2.0), Vec3::splat(3.0)));
    // Both spheres and walls of clay shine now.
    assert_eq!(window.status().scene.expect("a scene").lights().len(), 3);
}

#[test]
fn a_click_beside_everything_selects_nothing() {
    let mut window = Window::open(SCENE);
    window.click_at(window.at(0.5, 0.5));
    window.drag(PointerButton::Primary, window.at(0.5, 0.5), Vec2::new(0.0, -400.0));
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
    assert!(camera(&window).eye.x < -0.1, "orbit to the right: {:?}", camera(&window));
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
        let ([x, _], _) = lightbox::orbit::projected(&moved, Vec3::new(0.0, 0.0, 0.5)).expect("in front");
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
    assert!(framed.target.distance(bounds.center()) < 1e-5 && framed.eye.distance(framed.target) > bounds.diagonal());
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
    assert!((camera.target.z + 2.0).abs() < 1e-4 && camera.target.x < -0.1 && camera.target.y > 0.1, "{camera:?}");
}

#[test]
fn keys_are_left_to_a_text_field() {
    let mut window = Window::open(SCENE);
    window.drag(PointerButton::Primary, window.at(0.5, 0.5), Vec2::new(60.0, 0.0));
    let before = window.status().desc.camera;
    let seed = window.harness.get_by_role_and_label(Role::SpinButton, "Seed");
    seed.click();
    window.harness.run_steps(2);
    window.key(Modifiers::NONE, Key::Home);
    assert_eq!(window.status().desc.camera, before, "Home moves the text cursor only");
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
        window.wait("the file", |w| w.harness.query_by_label_contains(name).is_some());
        let image = lightbox_core::image_io::read(&path).expect("a picture");
        assert_eq!((image.width, image.height), (40, 30));
    }
    window.harness.state().save(window.file("a.gif"));
    window.wait("the complaint", |w| w.harness.query_by_label_contains("a.gif").is_some());
}

#[test]
fn a_bad_file_leaves_the_scene_and_says_why() {
    let mut window = Window::open(SCENE);
    let bad = window.file("bad.toml");
    std::fs::write(&bad, "[camera]\nfov = 400\n").expect("written");
    let before = window.snapshot();
    drop_file(&mut window, &bad);
    window.wait("the complaint", |w| w.harness.query_by_label_contains("fov is 400").is_some());
    assert_eq!(window.status().opened, 1);
    assert_eq!(window.snapshot().number, before.number);
    window.click("Dismiss");
    assert!(window.harness.query_by_label_contains("bad.toml").is_none());
    let picture = window.file("a.jpeg");
    drop_file(&mut window, &picture);
    assert!(window.harness.query_by_label_contains("not a scene").is_some());
}

#[test]
fn a_dropped_mesh_opens_in_a_room() {
    let mut window = Window::open(SCENE);
    let mesh = window.file("tent.obj");
    std::fs::write(&mesh, "v -1 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n").expect("written");
    window.harness.input_mut().hovered_files.push(egui::HoveredFile { path: Some(mesh.clone()), ..Default::default() });
    window.harness.run_steps(1);
    window.harness.input_mut().hovered_files.clear();
    drop_file(&mut window, &mesh);
    window.wait("the mesh", |w| w.status().opened == 2);
    assert_eq!(window.harness.state().model().desc.meshes[0].name, "tent");
    window.wait("its census", |w| w.harness.query_by_label_contains("1 triangle, 6 quads, 1 light").is_some());
}

#[test]
fn a_dark_scene_gets_a_lamp_by_one_click() {
    let dark = SCENE.replace("emission = [5, 5, 5]", "emission = [0, 0, 0]");
    let mut window = Window::open(&dark);
    assert!(window.snapshot().rgb.iter().all(|v| *v == 0));
    assert!(window.harness.query_by_label("Nothing emits light.").is_some());
    window.click("Add a ceiling lamp");
    window.done();
    assert!(window.harness.query_by_label("Nothing emits light.").is_none());
    let sum: u64 = window.snapshot().rgb.iter().map(|v| u64::from(*v)).sum();
    assert!(sum / 3600 > 20, "the picture is dark: {sum}");
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

/// A dropped file, as a window system hands it over.
#[derive(Debug)]
struct Dropped(PathBuf);

impl egui::DroppedFile for Dropped {
    fn path(&self) -> &Path {
        &self.0
    }

    fn bytes(&self) -> Result<Vec<u8>, String> {
        std::fs::read(&self.0).map_err(|e| e.to_string())
    }
}

fn drop_file(window: &mut Window, path: &Path) {
    window.harness.input_mut().dropped_files.push(std::sync::Arc::new(Dropped(path.to_owned())));
    window.harness.run_steps(2);
}
