//! The viewer in a real window on a virtual display, used with mouse and keyboard: opens, orbits,
//! drags sliders, picks an object, changes the scene, saves, quits, and fails if the picture does
//! not change when it should. Needs Xvfb and xdotool; where they are missing it says so and
//! passes, unless `CI` is set. `LIGHTBOX_SCREENSHOTS=folder` keeps a picture of each step.

use std::path::{Path, PathBuf};
use std::process::{Child, Command, ExitStatus, Stdio};
use std::time::{Duration, Instant};

use std::io::Read as _;

/// How long a step may take on a busy machine.
const PATIENCE: Duration = Duration::from_secs(60);

/// Left part of the window: the picture, in blocks of 16×16 pixels.
const PICTURE: (usize, usize) = (60, 42);

/// Places in the side panel of a window of 1280×720.
const SLIDER_LEFT: i32 = 1073;
const SLIDER_RIGHT: i32 = 1192;
const SCENE_LIST: (i32, i32) = (1168, 37);
const SPHERE_MIRROR: (i32, i32) = (1170, 110);
const SAMPLES_Y: i32 = 181;
const DEPTH_Y: i32 = 284;
const RADIUS_Y: i32 = 353;
const EXPOSURE_Y: i32 = 525;
const BUDGET: (i32, i32) = (1018, 156);
/// Once the section above is folded.
const MIRROR_Y: i32 = 617;
const TEDDY: (i32, i32) = (485, 400);

/// Blocks of one row, within the strip of kept pictures to the right of the first.
const STRIP: std::ops::Range<usize> = 36 * PICTURE.0 + 31..36 * PICTURE.0 + 37;

/// Keys of views, each of which looks unlike the one before.
const VIEWS: [(&str, &str); 10] = [
    ("F6", "view noise"),
    ("shift+F6", "view samples"),
    ("shift+F7", "view invalid samples"),
    ("F8", "view false colour"),
    ("F9", "view depth"),
    ("F10", "view normal"),
    ("shift+F10", "view front and back"),
    ("F11", "view albedo"),
    ("F12", "view object"),
    ("shift+F12", "view material"),
];

/// Processes that end with the test, and the folder they work in.
struct Desktop {
    server: Child,
    display: String,
    folder: tempfile::TempDir,
    viewer: Option<Child>,
}

impl Drop for Desktop {
    fn drop(&mut self) {
        for process in self.viewer.iter_mut().chain([&mut self.server]) {
            let _ = process.kill(); // It may have ended by itself.
            let _ = process.wait();
        }
    }
}

impl Desktop {
    fn start() -> Option<Self> {
        let folder = tempfile::tempdir().expect("a folder for the test");
        let server = Command::new("Xvfb")
            .args(["-displayfd", "1", "-screen", "0", "1280x720x24", "-fbdir"])
            .arg(folder.path())
            .stdout(Stdio::piped())
            .stderr(Stdio::null())
            .spawn();
        let has_xdotool = Command::new("xdotool")
            .arg("version")
            .stdout(Stdio::null())
            .status()
            .is_ok();
        let mut server = match server {
            Ok(server) if has_xdotool => server,
            _ => {
                assert!(
                    std::env::var_os("CI").is_none(),
                    "install xvfb and xdotool to run this test"
                );
                eprintln!("skipped: needs Xvfb and xdotool");
                return None;
            }
        };
        let mut number = [0; 8];
        let read = server
            .stdout
            .as_mut()
            .expect("a pipe")
            .read(&mut number)
            .expect("Xvfb names its display");
        let display = format!(":{}", String::from_utf8_lossy(&number[..read]).trim());
        Some(Self {
            server,
            display,
            folder,
            viewer: None,
        })
    }

    fn open(&mut self, file: Option<&Path>) {
        let work = self.folder.path().join("work");
        std::fs::create_dir(&work).expect("a folder");
        let viewer = Command::new(env!("CARGO_BIN_EXE_lightbox"))
            .args(file)
            .current_dir(work)
            .env("DISPLAY", &self.display)
            .env_remove("WAYLAND_DISPLAY")
            // What another session has left behind is not this test's.
            .env("XDG_DATA_HOME", self.folder.path().join("data"))
            .env("LIBGL_ALWAYS_SOFTWARE", "1")
            .spawn();
        self.viewer = Some(viewer.expect("the viewer starts"));
    }

    fn xdotool(&self, args: &[&str]) {
        let status = Command::new("xdotool")
            .args(args)
            .env("DISPLAY", &self.display)
            .stdout(Stdio::null())
            .status();
        assert!(status.expect("xdotool runs").success(), "xdotool {args:?}");
        std::thread::sleep(Duration::from_millis(60));
    }

    /// Presses a key, with Shift if its name says so: held before, as fingers do.
    fn key(&self, name: &str) {
        match name.strip_prefix("shift+") {
            Some(key) => {
                self.xdotool(&["keydown", "shift"]);
                self.xdotool(&["key", key]);
                self.xdotool(&["keyup", "shift"]);
            }
            None => self.xdotool(&["key", name]),
        }
    }

    fn mouse_to(&self, x: i32, y: i32) {
        self.xdotool(&["mousemove", &x.to_string(), &y.to_string()]);
    }

    fn click(&self, (x, y): (i32, i32)) {
        self.mouse_to(x, y);
        self.xdotool(&["mousedown", "1"]);
        self.xdotool(&["mouseup", "1"]);
    }

    fn drag(&self, from: (i32, i32), to: (i32, i32)) {
        self.mouse_to(from.0, from.1);
        self.xdotool(&["mousedown", "1"]);
        for step in 1..=8 {
            self.mouse_to(
                from.0 + (to.0 - from.0) * step / 8,
                from.1 + (to.1 - from.1) * step / 8,
            );
        }
        self.xdotool(&["mouseup", "1"]);
    }

    /// Mean brightness of each block of the picture, 0 to 255.
    fn blocks(&self) -> Vec<f64> {
        let file =
            std::fs::read(self.folder.path().join("Xvfb_screen0")).expect("the frame buffer");
        // An XWD file: a header of big-endian numbers, a colour table, rows of 32-bit pixels.
        let number = |i: usize| {
            u32::from_be_bytes(file[4 * i..4 * i + 4].try_into().expect("4 bytes")) as usize
        };
        let (start, row) = (number(0) + number(19) * 12, number(12));
        let block = |bx: usize, by: usize| {
            let pixels =
                (0..256).map(|i| start + (by * 16 + i / 16) * row + (bx * 16 + i % 16) * 4);
            pixels
                .map(|at| file[at..at + 3].iter().map(|b| f64::from(*b)).sum::<f64>())
                .sum::<f64>()
                / 768.0
        };
        (0..PICTURE.1)
            .flat_map(|y| (0..PICTURE.0).map(move |x| (x, y)))
            .map(|(x, y)| block(x, y))
            .collect()
    }

    /// Waits until the picture satisfies a condition.
    fn wait_until(&self, what: &str, condition: impl Fn(&[f64]) -> bool) -> Vec<f64> {
        let start = Instant::now();
        loop {
            let blocks = self.blocks();
            if condition(&blocks) {
                self.keep_screenshot(what);
                return blocks;
            }
            if start.elapsed() > PATIENCE {
                self.keep_screenshot(&format!("waited in vain {what}"));
                panic!("waited in vain: {what}");
            }
            std::thread::sleep(Duration::from_millis(100));
        }
    }

    /// How the viewer ends.
    fn end_of_viewer(&mut self, what: &str) -> ExitStatus {
        let mut viewer = self.viewer.take().expect("the viewer runs");
        let start = Instant::now();
        loop {
            if let Some(status) = viewer.try_wait().expect("the viewer's status") {
                return status;
            }
            if start.elapsed() > PATIENCE {
                let _ = viewer.kill();
                panic!("waited in vain: {what}");
            }
            std::thread::sleep(Duration::from_millis(50));
        }
    }

    fn keep_screenshot(&self, what: &str) {
        if let Some(folder) = std::env::var_os("LIGHTBOX_SCREENSHOTS") {
            let name = PathBuf::from(folder)
                .join(what.replace(' ', "-"))
                .with_extension("xwd");
            std::fs::copy(self.folder.path().join("Xvfb_screen0"), name).expect("a screenshot");
        }
    }
}

fn mean(blocks: &[f64]) -> f64 {
    blocks.iter().sum::<f64>() / blocks.len() as f64
}

/// Mean difference of two pictures, in steps of brightness.
fn difference(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b).abs()).sum::<f64>() / a.len() as f64
}

#[test]
fn a_session_with_mouse_and_keyboard() {
    let Some(mut desktop) = Desktop::start() else {
        return;
    };
    desktop.open(None);
    desktop.wait_until("the picture appears", |b| mean(b) > 20.0);
    // Coarse and noisy at first: later pictures are compared with what it comes to.
    let settled = std::cell::RefCell::new(Vec::new());
    let first = desktop.wait_until("the picture settles", |b| {
        std::thread::sleep(Duration::from_millis(700));
        let before = settled.replace(b.to_vec());
        before.len() == b.len() && difference(&before, b) < 0.7
    });

    // There is no window manager to give it the keyboard.
    desktop.xdotool(&["search", "--name", "lightbox", "windowfocus"]);

    desktop.drag((300, 200), (420, 230));
    let turned = desktop.wait_until("orbit turns the view", |b| difference(b, &first) > 6.0);
    desktop.xdotool(&["key", "Home"]);
    let home = desktop.wait_until("Home turns it back", |b| difference(b, &first) < 3.0);
    assert!(difference(&turned, &home) > 6.0);
    desktop.mouse_to(485, 200);
    for _ in 0..4 {
        desktop.xdotool(&["click", "4"]);
    }
    desktop.wait_until("the wheel comes closer", |b| difference(b, &home) > 6.0);
    // The wheel runs out smoothly.
    std::thread::sleep(Duration::from_secs(1));
    desktop.xdotool(&["key", "Home"]);
    desktop.wait_until("Home goes back", |b| difference(b, &first) < 3.0);

    desktop.xdotool(&["key", "F2"]);
    desktop.wait_until("the lab opens", |b| difference(b, &first) > 6.0);
    desktop.xdotool(&["key", "Escape"]);
    desktop.wait_until("the lab closes", |b| difference(b, &first) < 3.0);

    desktop.xdotool(&["key", "F3"]);
    desktop.wait_until("the chart opens", |b| difference(b, &first) > 6.0);
    desktop.mouse_to(120, 560);
    desktop.wait_until("the picture as it was", |b| difference(b, &first) > 6.0);
    desktop.xdotool(&["key", "Escape"]);
    desktop.wait_until("the chart closes", |b| difference(b, &first) < 3.0);

    let mut shown = first.clone();
    for (key, what) in VIEWS {
        desktop.key(key);
        shown = desktop.wait_until(what, |b| difference(b, &shown) > 2.0);
    }
    desktop.key("c");
    desktop.wait_until("the light again", |b| difference(b, &first) < 3.0);

    desktop.mouse_to(TEDDY.0, TEDDY.1);
    desktop.key("p");
    desktop.wait_until("the autopsy opens", |b| difference(b, &first) > 6.0);
    desktop.key("Escape");
    desktop.wait_until("the autopsy closes", |b| difference(b, &first) < 3.0);

    desktop.key("k");
    // The strip is even where the teddy was: other changes may be noise.
    let even = |b: &[f64]| b[STRIP].iter().all(|v| (v - b[STRIP.start]).abs() < 0.1);
    let strip = desktop.wait_until("a kept picture", even);
    desktop.key("shift+b");
    desktop.wait_until("side by side", |b| difference(b, &strip) > 6.0);
    desktop.key("shift+b");
    desktop.wait_until("one picture again", |b| difference(b, &strip) < 3.0);
    desktop.key("shift+k");
    desktop.wait_until("the picture alone", |b| difference(b, &first) < 3.0);

    desktop.drag((1132, EXPOSURE_Y), (1160, EXPOSURE_Y));
    desktop.wait_until("exposure brightens", |b| mean(b) > 1.3 * mean(&first));
    desktop.drag((1160, EXPOSURE_Y), (1132, EXPOSURE_Y));
    desktop.wait_until("exposure darkens again", |b| mean(b) < 1.2 * mean(&first));

    desktop.drag((1151, DEPTH_Y), (SLIDER_LEFT, DEPTH_Y));
    desktop.wait_until("depth 1 leaves the lamp", |b| mean(b) < 0.3 * mean(&first));
    desktop.drag((SLIDER_LEFT, DEPTH_Y), (1151, DEPTH_Y));
    desktop.wait_until("depth brings the light back", |b| {
        mean(b) > 0.8 * mean(&first)
    });

    desktop.drag((SLIDER_LEFT, RADIUS_Y), (SLIDER_RIGHT, RADIUS_Y));
    desktop.wait_until("a wide filter blurs", |b| difference(b, &first) > 1.0);
    desktop.drag((SLIDER_RIGHT, RADIUS_Y), (SLIDER_LEFT, RADIUS_Y));

    desktop.drag((1132, SAMPLES_Y), (SLIDER_LEFT, SAMPLES_Y));
    desktop.wait_until("few samples", |b| difference(b, &first) < 4.0);
    desktop.click(BUDGET);
    desktop.click(TEDDY);
    std::thread::sleep(Duration::from_millis(700));
    // With the outline of the teddy.
    let before = desktop.blocks();
    desktop.drag((SLIDER_LEFT, MIRROR_Y), (SLIDER_RIGHT, MIRROR_Y));
    desktop.wait_until("the teddy becomes a mirror", |b| {
        difference(b, &before) > 1.0
    });

    std::thread::sleep(Duration::from_secs(1));
    let before = desktop.blocks();
    desktop.click(SCENE_LIST);
    std::thread::sleep(Duration::from_millis(700));
    desktop.click(SPHERE_MIRROR);
    desktop.mouse_to(485, 300);
    desktop.wait_until("another scene opens", |b| difference(b, &before) > 4.0);

    let saved = |folder: &Path| {
        std::fs::read_dir(folder)
            .expect("the folder")
            .flatten()
            .any(|f| f.path().extension().is_some_and(|e| e == "png"))
    };
    // There is something to save once the first sample is complete: until then it is asked again.
    let start = Instant::now();
    while !saved(&desktop.folder.path().join("work")) {
        if start.elapsed() > PATIENCE {
            desktop.keep_screenshot("not saved");
            panic!("waited in vain: Ctrl+S saves a picture");
        }
        desktop.xdotool(&["keydown", "ctrl"]);
        desktop.xdotool(&["key", "s"]);
        desktop.xdotool(&["keyup", "ctrl"]);
        std::thread::sleep(Duration::from_secs(2));
    }

    desktop.xdotool(&["keydown", "ctrl"]);
    desktop.xdotool(&["key", "q"]);
    desktop.xdotool(&["keyup", "ctrl"]);
    let status = desktop.end_of_viewer("the window closes");
    assert!(status.success(), "{status}");
}

/// Whoever ends the window from outside loses no sample that is kept in a file.
#[test]
fn a_terminated_window_keeps_its_samples() {
    let Some(mut desktop) = Desktop::start() else {
        return;
    };
    let part = desktop.folder.path().join("kept.part");
    let render = Command::new(env!("CARGO_BIN_EXE_lightbox"))
        .args(["render", "glass-sphere", "--size", "300x200", "--part"])
        .args(["--samples", "0..2", "-o"])
        .arg(&part)
        .output();
    assert!(render.expect("the command").status.success());
    let samples = |path: &Path| {
        let head = lightbox_core::part::read_head(path).expect("a part");
        head.samples_per_pixel()
    };
    assert_eq!(samples(&part), 2);
    desktop.open(Some(&part));
    desktop.wait_until("the kept picture appears", |b| mean(b) > 20.0);
    // It goes on, and would write that down in a minute.
    std::thread::sleep(Duration::from_secs(3));
    assert_eq!(samples(&part), 2, "nothing was written yet");
    let id = desktop.viewer.as_ref().expect("the viewer runs").id();
    let kill = Command::new("kill")
        .args(["-TERM", &id.to_string()])
        .status();
    assert!(kill.expect("kill runs").success());
    let status = desktop.end_of_viewer("SIGTERM ends the window");
    assert_eq!(status.code(), Some(130), "{status}");
    assert!(samples(&part) > 2);
}
