//! A window without a screen, and what a user does to it.

use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use egui::accesskit::Role;
use egui::{Event, Key, Modifiers, PointerButton, Pos2, Vec2};
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable as _;
use glam::Vec3;
use lightbox::app::App;
use lightbox::session::{Activity, Snapshot, Status};
use lightbox::settings::Settings;

/// A sphere in front of a lamp and a wall, quick to render.
pub const SCENE: &str = r#"
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
pub const PATIENCE: Duration = Duration::from_secs(60);

pub struct Window {
    pub harness: Harness<'static, App>,
    pub folder: tempfile::TempDir,
    /// Number of the last picture that was waited for.
    pub seen: u64,
}

impl Window {
    /// Opens a scene in a small window and waits until its picture is done, at the size in the
    /// file, so that tests are quick.
    pub fn open(scene: &str) -> Self {
        let folder = tempfile::tempdir().expect("a folder for the scene");
        let path = folder.path().join("scene.toml");
        std::fs::write(&path, scene).expect("the scene is written");
        Self::open_path(folder, path)
    }

    pub fn open_path(folder: tempfile::TempDir, path: PathBuf) -> Self {
        Self::remembering(folder, path, Settings::default())
    }

    /// As one that was used before.
    pub fn remembering(folder: tempfile::TempDir, path: PathBuf, settings: Settings) -> Self {
        // Tall enough for every row of the side panel.
        let builder = Harness::builder()
            .with_size(Vec2::new(620.0, 1400.0))
            .with_step_dt(1.0 / 30.0);
        let harness = builder.build_eframe(|context| {
            let app = App::new(&context.egui_ctx, Some(path)).expect("an engine");
            app.remembering(settings)
        });
        let mut window = Self {
            harness,
            folder,
            seen: 0,
        };
        window.wait("a picture of the window's size", |w| {
            w.harness
                .state()
                .session()
                .snapshot()
                .is_some_and(|s| s.size[0] > 100)
        });
        window.click("as in file");
        window.done();
        window
    }

    pub fn status(&self) -> Status {
        self.harness.state().session().status()
    }

    pub fn snapshot(&self) -> std::sync::Arc<Snapshot> {
        self.harness
            .state()
            .session()
            .snapshot()
            .expect("a picture")
    }

    /// Runs frames until something holds.
    pub fn wait(&mut self, what: &str, holds: impl Fn(&Self) -> bool) {
        let start = Instant::now();
        while !holds(self) {
            assert!(
                start.elapsed() < PATIENCE,
                "waited in vain for {what}: {:?}",
                self.status().activity
            );
            self.harness.step();
            std::thread::sleep(Duration::from_millis(2));
        }
        // The window has to see it too.
        self.harness.run_steps(2);
    }

    /// Waits for a new picture of what the model wants, rendered to the end.
    pub fn done(&mut self) {
        self.harness.run_steps(2);
        self.wait("the picture to be done", |w| {
            let (status, model) = (w.status(), w.harness.state().model());
            status.activity == Activity::Done
                && status.loading.is_none()
                && status.samples == model.desc.render.samples
                && w.is_current(&status)
                && w.snapshot().preview.is_none()
                && w.snapshot().number > w.seen
        });
        self.seen = self.snapshot().number;
    }

    /// Whether the scene in use has every edit. The status is read once: of two, the first may tell of
    /// the picture before, that was done, and the second of the scene of the next one.
    pub fn is_current(&self, status: &Status) -> bool {
        let model = self.harness.state().model();
        let same_scene = status.scene.as_ref().is_some_and(|s| {
            let (old, new) = (s.desc(), &model.desc);
            (&old.materials, &old.quads, old.render.accel)
                == (&new.materials, &new.quads, new.render.accel)
        });
        let size = [
            model.desc.render.width as usize,
            model.desc.render.height as usize,
        ];
        same_scene && *status.desc == model.desc && self.snapshot().size == size
    }

    pub fn click(&mut self, name: &str) {
        self.harness
            .get_by_role_and_label(Role::Button, name)
            .click();
        self.harness.run_steps(2);
    }

    pub fn set(&mut self, slider: &str, value: f64) {
        self.harness
            .get_by_role_and_label(Role::Slider, slider)
            .set_value_accesskit(value);
        self.harness.run_steps(2);
    }

    /// A place in the picture, in shares of its width and height.
    pub fn at(&self, x: f32, y: f32) -> Pos2 {
        let space = self.harness.get_by_label("Picture").rect();
        let size = self.snapshot().size;
        let scale = (space.width() / size[0] as f32).min(space.height() / size[1] as f32);
        let picture = Vec2::new(size[0] as f32, size[1] as f32) * scale;
        space.center() + Vec2::new((x - 0.5) * picture.x, (y - 0.5) * picture.y)
    }

    pub fn button(&self, pos: Pos2, button: PointerButton, pressed: bool) {
        self.harness.event(Event::PointerButton {
            pos,
            button,
            pressed,
            modifiers: Modifiers::NONE,
        });
    }

    pub fn drag(&mut self, button: PointerButton, from: Pos2, by: Vec2) {
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

    pub fn click_at(&mut self, pos: Pos2) {
        self.harness.hover_at(pos);
        self.button(pos, PointerButton::Primary, true);
        self.button(pos, PointerButton::Primary, false);
        // Sooner, the next click would count as the second of a double-click.
        self.harness.run_steps(12);
    }

    pub fn key(&mut self, modifiers: Modifiers, key: Key) {
        self.harness.key_press_modifiers(modifiers, key);
        self.harness.run_steps(3);
    }

    pub fn eye(&self) -> Vec3 {
        self.harness.state().model().desc.camera.eye
    }

    /// Lets go of a file over the window.
    pub fn drop_file(&mut self, path: &Path) {
        let file = std::sync::Arc::new(Dropped(path.to_owned()));
        self.harness.input_mut().dropped_files.push(file);
        self.harness.run_steps(2);
    }

    /// A file beside the scene.
    pub fn file(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }
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
