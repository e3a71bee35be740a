//! A virtual display with a viewer on it, and fingers.

use std::io::Read as _;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, ExitStatus, Stdio};
use std::time::{Duration, Instant};

/// How long a step may take on a busy machine.
pub const PATIENCE: Duration = Duration::from_secs(180);

/// Left part of the window: the picture, in blocks of 16×16 pixels.
pub const PICTURE: (usize, usize) = (60, 42);

/// Processes that end with the test, and the folder they work in.
pub struct Desktop {
    server: Child,
    display: String,
    pub folder: tempfile::TempDir,
    pub viewer: Option<Child>,
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
    pub fn start() -> Option<Self> {
        let folder = tempfile::tempdir().expect("a folder for the test");
        let server = Command::new("Xvfb")
            .args(["-displayfd", "1", "-screen", "0", "1280x720x24"])
            // Or it would start anew, and take nobody in meanwhile, when a window was killed.
            .args(["-noreset", "-fbdir"])
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

    pub fn open(&mut self, file: Option<&Path>) {
        let work = self.folder.path().join("work");
        std::fs::create_dir_all(&work).expect("a folder");
        let mut path = vec![self.folder.path().join("bin")];
        path.extend(std::env::split_paths(
            &std::env::var_os("PATH").unwrap_or_default(),
        ));
        let viewer = Command::new(env!("CARGO_BIN_EXE_lightbox"))
            .args(file)
            .current_dir(work)
            .env("DISPLAY", &self.display)
            .env_remove("WAYLAND_DISPLAY")
            // What another session has left behind is not this test's.
            .env("XDG_DATA_HOME", self.folder.path().join("data"))
            // No file dialogs but those of `answer_dialogs`.
            .env_remove("DBUS_SESSION_BUS_ADDRESS")
            .env("XDG_RUNTIME_DIR", self.folder.path())
            .env("PATH", std::env::join_paths(path).expect("a path"))
            .env("LIBGL_ALWAYS_SOFTWARE", "1")
            .spawn();
        self.viewer = Some(viewer.expect("the viewer starts"));
    }

    /// Lets file dialogs end with this file, or be cancelled: `zenity`, which shows them where the
    /// desktop has nothing better, is a script from now on.
    #[cfg(unix)]
    pub fn answer_dialogs(&self, answer: Option<&Path>) {
        use std::os::unix::fs::PermissionsExt as _;
        let folder = self.folder.path().join("bin");
        std::fs::create_dir_all(&folder).expect("a folder");
        // No person is quicker.
        let log = self.folder.path().join("asked");
        let mut script = format!("#!/bin/sh\necho >> '{}'\nsleep 0.3\n", log.display());
        script += &match answer {
            Some(path) => format!("echo '{}'\n", path.display()),
            None => "exit 1\n".into(),
        };
        let zenity = folder.join("zenity");
        std::fs::write(&zenity, script).expect("a script");
        let mode = std::fs::Permissions::from_mode(0o755);
        std::fs::set_permissions(&zenity, mode).expect("a program");
    }

    /// How many file dialogs there were.
    pub fn dialogs(&self) -> usize {
        std::fs::read(self.folder.path().join("asked")).map_or(0, |log| log.len())
    }

    /// The window's title.
    pub fn title(&self) -> String {
        let output = Command::new("xdotool")
            .args(["search", "--name", "lightbox", "getwindowname"])
            .env("DISPLAY", &self.display)
            .output();
        let output = output.expect("xdotool runs");
        String::from_utf8_lossy(&output.stdout).trim().to_owned()
    }

    /// Waits until the title begins with the name of a scene.
    pub fn wait_for_title(&self, name: &str) {
        let start = Instant::now();
        while !self.title().starts_with(name) {
            if start.elapsed() > PATIENCE {
                self.keep_screenshot("waited in vain for a title");
                panic!("waited in vain for {name}: {}", self.title());
            }
            std::thread::sleep(Duration::from_millis(100));
        }
    }

    /// Whether `xdotool` succeeds.
    pub fn may(&self, args: &[&str]) -> bool {
        let status = Command::new("xdotool")
            .args(args)
            .env("DISPLAY", &self.display)
            .stdout(Stdio::null())
            .stderr(Stdio::null())
            .status();
        status.expect("xdotool runs").success()
    }

    pub fn xdotool(&self, args: &[&str]) {
        assert!(self.may(args), "xdotool {args:?}");
        std::thread::sleep(Duration::from_millis(60));
    }

    /// Presses a key, with Shift if its name says so: held before, as fingers do.
    pub fn key(&self, name: &str) {
        match name.strip_prefix("shift+") {
            Some(key) => {
                self.xdotool(&["keydown", "shift"]);
                self.xdotool(&["key", key]);
                self.xdotool(&["keyup", "shift"]);
            }
            None => self.xdotool(&["key", name]),
        }
    }

    pub fn mouse_to(&self, x: i32, y: i32) {
        self.xdotool(&["mousemove", &x.to_string(), &y.to_string()]);
    }

    pub fn click(&self, (x, y): (i32, i32)) {
        self.mouse_to(x, y);
        self.xdotool(&["mousedown", "1"]);
        self.xdotool(&["mouseup", "1"]);
    }

    pub fn drag(&self, from: (i32, i32), to: (i32, i32)) {
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
    pub fn blocks(&self) -> Vec<f64> {
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
    pub fn wait_until(&self, what: &str, condition: impl Fn(&[f64]) -> bool) -> Vec<f64> {
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
    pub fn end_of_viewer(&mut self, what: &str) -> ExitStatus {
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

    pub fn keep_screenshot(&self, what: &str) {
        if let Some(folder) = std::env::var_os("LIGHTBOX_SCREENSHOTS") {
            let name = PathBuf::from(folder)
                .join(what.replace(' ', "-"))
                .with_extension("xwd");
            std::fs::copy(self.folder.path().join("Xvfb_screen0"), name).expect("a screenshot");
        }
    }
}
