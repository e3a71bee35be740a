//! A window that is killed at random moments and opened again on the part that it keeps.

use std::ffi::OsStr;
use std::fs;
use std::os::unix::process::ExitStatusExt as _;
use std::path::Path;
use std::process::Command;
use std::time::{Duration, Instant};

use lightbox_core::part::read_head;

use crate::desktop::Desktop;

/// Sittings, each of which ends by a kill.
const KILLS: u64 = 100;

/// Every so many sittings one lasts until the window saves by its clock; in the others it is paused
/// again and again, at which it saves too.
const LONG: u64 = 25;

/// Most milliseconds that a sitting lasts, and what a long one lasts at least: the minute after which
/// the window saves, and what it takes to open.
const SHORT_MS: u64 = 5000;
const MINUTE_MS: u64 = 70_000;

/// Most milliseconds from the last key to the kill: about what it takes to save.
const SAVE_MS: u64 = 80;

/// Large enough that writing it takes a while.
const SIZE: &str = "640x400";

/// Samples that some tiles may be ahead of the others when the window is killed.
const AHEAD: u64 = 64;

/// Random numbers, the same in every run (Knuth's multiplier).
struct Random(u64);

impl Random {
    fn below(&mut self, limit: u64) -> u64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005);
        self.0 = self.0.wrapping_add(1);
        (self.0 >> 33) % limit
    }
}

/// Runs a command of the program under test.
fn lightbox<S: AsRef<OsStr>>(args: impl IntoIterator<Item = S>) {
    let mut command = Command::new(env!("CARGO_BIN_EXE_lightbox"));
    let output = command.args(args).output().expect("the binary starts");
    let error = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{error}");
}

/// Pauses and goes on at random moments until `end`, and then a last time, a moment before.
fn toggle_until(desktop: &Desktop, end: Instant, random: &mut Random) {
    let mut focused = false;
    let mut toggle = || {
        // Once the window is there: no window manager gives it the keyboard.
        focused |= desktop.may(&["search", "--name", "lightbox", "windowfocus"]);
        if focused {
            desktop.may(&["key", "space"]);
        }
    };
    loop {
        let pause = Duration::from_millis(50 + random.below(400));
        let left = end.saturating_duration_since(Instant::now());
        std::thread::sleep(pause.min(left));
        toggle();
        if pause >= left {
            return std::thread::sleep(Duration::from_millis(random.below(SAVE_MS)));
        }
    }
}

/// Files beside the part that someone was writing when killed: by the process that did.
fn asides(folder: &Path) -> Vec<String> {
    let files = fs::read_dir(folder).expect("the folder").flatten();
    let names = files.map(|file| file.file_name().to_string_lossy().into_owned());
    names.filter(|name| name.ends_with(".aside")).collect()
}

/// `cargo test --release -p lightbox --test window -- --ignored --nocapture`
#[test]
#[ignore = "takes a quarter of an hour"]
fn a_hundred_kills_of_the_window_leave_no_trace() {
    let Some(mut desktop) = Desktop::start() else {
        return;
    };
    let home = desktop.folder.path().join("kept");
    fs::create_dir(&home).expect("a folder");
    let [scene, part, picture, whole] =
        ["scene.toml", "a.part", "a.exr", "whole.exr"].map(|name| home.join(name));
    let endless = "[render]\nsamples = 1_000_000_000\n";
    let shipped = concat!(env!("CARGO_MANIFEST_DIR"), "/../../scenes/cornell-box.toml");
    let text = fs::read_to_string(shipped).expect("a shipped scene");
    fs::write(&scene, text + "\n" + endless).expect("a scene");
    let words = |rest: &str| {
        let words = format!("render --size {SIZE} {rest}");
        let words: Vec<String> = words.split_whitespace().map(str::to_owned).collect();
        words
    };
    let name = |path: &Path| path.to_str().expect("UTF-8").to_owned();
    let first = words("--part --samples 0..1 -o");
    lightbox(first.into_iter().chain([name(&part), name(&scene)]));

    let mut random = Random(1);
    let (mut held, mut saving, mut rises) = (1, 0, 0);
    for sitting in 1..=KILLS {
        let start = Instant::now();
        desktop.open(Some(&part));
        let is_long = sitting % LONG == 0;
        if is_long {
            let moment = MINUTE_MS + random.below(SHORT_MS);
            std::thread::sleep(Duration::from_millis(moment));
        } else {
            let end = start + Duration::from_millis(random.below(SHORT_MS));
            toggle_until(&desktop, end, &mut random);
        }
        let mut viewer = desktop.viewer.take().expect("the viewer runs");
        viewer.kill().expect("a running process");
        let end = viewer.wait().expect("an end");
        assert_eq!(end.signal(), Some(9), "it has ended by itself: {end}");
        let aside = format!(".{}.aside", viewer.id());
        saving += usize::from(asides(&home).iter().any(|name| name.ends_with(&aside)));
        let now = read_head(&part).expect("a whole part").samples_per_pixel();
        assert!(now >= held, "{now} after {held}");
        assert!(!is_long || now > held, "nothing was saved in a minute");
        rises += u64::from(now > held);
        held = now;
    }
    println!(
        "{KILLS} kills, {saving} of them in the middle of a save; {rises} sittings had saved something, {held} samples per pixel in all"
    );
    assert!(rises > KILLS / LONG, "nothing was saved in a pause");

    let samples = held + AHEAD;
    let finish = words(&format!("--spp {samples} --checkpoint"));
    let finish = finish.into_iter().chain([name(&part), name(&scene)]);
    lightbox(finish.chain(["-o".into(), name(&picture)]));
    let run = words(&format!("--spp {samples} -o"));
    lightbox(run.into_iter().chain([name(&whole), name(&scene)]));
    assert!(fs::read(&picture).expect("a picture") == fs::read(&whole).expect("a picture"));
    assert_eq!(asides(&home), [""; 0], "what was left is cleared away");
}
