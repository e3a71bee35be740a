//! What is copied in one window can be pasted in another program's.

use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use lightbox_core::scene::{self, CameraDesc};

use crate::desktop::{Desktop, PATIENCE};

fn with_ctrl(desktop: &Desktop, key: &str) {
    desktop.xdotool(&["keydown", "ctrl"]);
    desktop.key(key);
    desktop.xdotool(&["keyup", "ctrl"]);
    std::thread::sleep(Duration::from_secs(1));
}

/// Opens a scene in a window of its own and gives that the keyboard.
fn open(desktop: &mut Desktop, file: &Path) {
    desktop.open(Some(file));
    let name = file.file_stem().expect("a name").to_string_lossy();
    let title = format!("{name} - lightbox");
    let start = Instant::now();
    while !desktop.may(&["search", "--name", &title, "windowfocus"]) {
        assert!(start.elapsed() < PATIENCE, "waited in vain for {title}");
        std::thread::sleep(Duration::from_millis(200));
    }
    std::thread::sleep(Duration::from_secs(2));
}

fn camera(path: &Path) -> CameraDesc {
    scene::load(path).expect("a scene").desc.camera
}

#[test]
fn a_camera_goes_from_one_program_to_another() {
    let Some(mut desktop) = Desktop::start() else {
        return;
    };
    let text = include_str!("../../../../scenes/glass-sphere.toml");
    let [from, to] = ["from.toml", "to.toml"].map(|name| desktop.folder.path().join(name));
    std::fs::write(&to, text).expect("a scene");
    let mut desc = scene::load(&to).expect("a scene").desc;
    desc.camera.eye.x += 0.125;
    desc.camera.fov += 3.0;
    scene::save(&from, &desc, &to).expect("written");
    assert_ne!(camera(&from), camera(&to));

    open(&mut desktop, &from);
    with_ctrl(&desktop, "shift+c");
    // It stays open: what is copied is its own until someone asks for it.
    let mut first = desktop.viewer.take().expect("the first viewer");
    open(&mut desktop, &to);
    with_ctrl(&desktop, "v");
    // Without file dialogs a scene is saved where the window was started. The camera glides there.
    let work = desktop.folder.path().join("work");
    let saved = || -> Vec<PathBuf> {
        let files = std::fs::read_dir(&work).expect("the folder").flatten();
        let files = files.map(|f| f.path());
        files
            .filter(|f| f.extension().is_some_and(|e| e == "toml"))
            .collect()
    };
    let start = Instant::now();
    while !saved().iter().any(|file| camera(file) == desc.camera) {
        if start.elapsed() > PATIENCE {
            desktop.keep_screenshot("not pasted");
            panic!("waited in vain for the camera: {:?}", saved());
        }
        with_ctrl(&desktop, "shift+t");
    }
    let _ = first.kill(); // It would end with the display.
    let _ = first.wait();
}
