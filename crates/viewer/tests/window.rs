//! The viewer in a real window on a virtual display, used with mouse and keyboard: opens, orbits,
//! drags sliders, picks an object, changes the scene, saves, quits, and fails if the picture does
//! not change when it should. Needs Xvfb and xdotool; where they are missing it says so and
//! passes, unless `CI` is set. `LIGHTBOX_SCREENSHOTS=folder` keeps a picture of each step.

#[path = "window/clipboard.rs"]
mod clipboard;
#[path = "window/desktop.rs"]
mod desktop;
#[cfg(unix)]
#[path = "window/kills.rs"]
mod kills;

use std::path::Path;
use std::process::Command;
use std::time::{Duration, Instant};

use desktop::{Desktop, PATIENCE, PICTURE};

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
const BALL: (i32, i32) = (405, 450);
/// Answers to what becomes of edits: over the picture, and in the middle of the window.
const SAVE_FIRST: (i32, i32) = (575, 27);
const SAVE_AND_QUIT: (i32, i32) = (547, 375);

/// Blocks of one row, within the strip of kept pictures to the right of the first.
const STRIP: std::ops::Range<usize> = 36 * PICTURE.0 + 31..36 * PICTURE.0 + 37;

/// Keys of views, each of which looks unlike the one before.
const VIEWS: [(&str, &str); 12] = [
    ("F6", "view noise"),
    ("shift+F6", "view samples"),
    ("shift+F7", "view invalid samples"),
    ("F8", "view false colour"),
    ("shift+F8", "view traversal cost"),
    ("shift+F9", "view path length"),
    ("F9", "view depth"),
    ("F10", "view normal"),
    ("shift+F10", "view front and back"),
    ("F11", "view albedo"),
    ("F12", "view object"),
    ("shift+F12", "view material"),
];

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

    // The strip is even where the teddy was: other changes may be noise.
    let even = |b: &[f64]| b[STRIP].iter().all(|v| (v - b[STRIP.start]).abs() < 0.1);
    // There is something to keep once the first sample is complete.
    let start = Instant::now();
    while !even(&desktop.blocks()) {
        assert!(
            start.elapsed() < PATIENCE,
            "waited in vain: K keeps a picture"
        );
        desktop.key("k");
        std::thread::sleep(Duration::from_secs(3));
    }
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

    // Over edits, no other scene is opened without a question.
    desktop.xdotool(&["keydown", "ctrl"]);
    desktop.xdotool(&["key", "z"]);
    desktop.xdotool(&["keyup", "ctrl"]);
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

/// Edits are saved first, before another scene is opened and before the end: what becomes of them
/// is what a file dialog answers, and as long as it answers nothing, all stays as it is.
#[cfg(unix)]
#[test]
fn edits_are_saved_first() {
    let Some(mut desktop) = Desktop::start() else {
        return;
    };
    let file = |name: &str| desktop.folder.path().join(name);
    let [mine, kept, last] = ["mine.toml", "kept.toml", "last.toml"].map(file);
    let scene = include_str!("../../../scenes/glass-sphere.toml");
    std::fs::write(&mine, scene).expect("a scene");
    let objects = |path: &Path| {
        let desc = lightbox_core::scene::load(path).expect("a scene").desc;
        desc.spheres.len() + desc.quads.len() + desc.meshes.len()
    };
    let all = objects(&mine);
    desktop.open(Some(&mine));
    desktop.wait_for_title("mine");
    desktop.wait_until("the scene appears", |b| mean(b) > 20.0);
    desktop.xdotool(&["search", "--name", "lightbox", "windowfocus"]);
    let delete = |desktop: &Desktop| {
        std::thread::sleep(Duration::from_secs(1));
        desktop.click(BALL);
        std::thread::sleep(Duration::from_secs(1));
        desktop.key("Delete");
    };
    // Until the question is there to be answered.
    let answer = |desktop: &Desktop, ask: &dyn Fn(&Desktop)| {
        let (start, before) = (Instant::now(), desktop.dialogs());
        while desktop.dialogs() == before {
            assert!(start.elapsed() < PATIENCE, "waited in vain: a file dialog");
            ask(desktop);
            std::thread::sleep(Duration::from_millis(700));
        }
        // It has ended too.
        std::thread::sleep(Duration::from_secs(1));
    };

    delete(&desktop);
    desktop.answer_dialogs(None);
    desktop.click(SCENE_LIST);
    std::thread::sleep(Duration::from_millis(700));
    desktop.click(SPHERE_MIRROR);
    answer(&desktop, &|desktop| desktop.click(SAVE_FIRST));
    desktop.keep_screenshot("the question stands again");
    assert!(desktop.title().starts_with("mine"), "{}", desktop.title());
    desktop.answer_dialogs(Some(&kept));
    answer(&desktop, &|desktop| desktop.click(SAVE_FIRST));
    desktop.wait_for_title("sphere-mirror");
    assert_eq!([objects(&mine), objects(&kept)], [all, all - 1]);

    let all = objects(Path::new("builtin:sphere-mirror.toml"));
    delete(&desktop);
    desktop.answer_dialogs(None);
    let quit = |desktop: &Desktop| {
        desktop.xdotool(&["keydown", "ctrl"]);
        desktop.xdotool(&["key", "q"]);
        desktop.xdotool(&["keyup", "ctrl"]);
        std::thread::sleep(Duration::from_millis(700));
        desktop.click(SAVE_AND_QUIT);
    };
    answer(&desktop, &quit);
    let viewer = desktop.viewer.as_mut().expect("the viewer");
    assert!(viewer.try_wait().expect("its status").is_none(), "it stays");
    desktop.answer_dialogs(Some(&last));
    answer(&desktop, &quit);
    let status = desktop.end_of_viewer("the window closes once the scene is saved");
    assert!(status.success(), "{status}");
    assert_eq!(objects(&last), all - 1);
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
