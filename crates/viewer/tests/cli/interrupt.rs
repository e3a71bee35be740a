//! Ctrl-C.

use std::path::Path;
use std::process::{Command, Output, Stdio};
use std::time::Duration;

use lightbox_core::image_io::read;
use serde_json::Value;

use crate::{Folder, bits, lightbox, replay, replay_line, stderr, stdout};

/// Whether a process listens for Ctrl-C.
fn listens(pid: u32) -> bool {
    const SIGINT: u64 = 2;
    let status = std::fs::read_to_string(format!("/proc/{pid}/status")).unwrap_or_default();
    let caught = status.lines().find_map(|line| line.strip_prefix("SigCgt:"));
    caught.is_some_and(|mask| {
        u64::from_str_radix(mask.trim(), 16).expect("hexadecimal") >> (SIGINT - 1) & 1 == 1
    })
}

/// Runs words, with the output last, and interrupts that so many milliseconds after it listens.
fn interrupted(words: &str, output: &Path, after: u64) -> Output {
    let child = lightbox()
        .args(words.split(' '))
        .arg(output)
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .expect("lightbox runs");
    while !listens(child.id()) {
        std::thread::sleep(Duration::from_millis(10));
    }
    std::thread::sleep(Duration::from_millis(after));
    let kill = Command::new("kill")
        .args(["-INT", &child.id().to_string()])
        .status();
    assert!(kill.expect("kill runs").success());
    let output = child.wait_with_output().expect("it ends");
    assert_eq!(output.status.code(), Some(130), "{}", stderr(&output));
    output
}

#[test]
fn ctrl_c_saves_what_was_rendered() {
    let folder = Folder::new();
    let (path, again) = (folder.path("a.exr"), folder.path("again.exr"));
    let words = "render cornell-box --size 40x40 --seconds 600 --json -o";
    // From here to the first sample it is milliseconds.
    let output = interrupted(words, &path, 500);
    let report: Value = serde_json::from_str(&stdout(&output)).unwrap();
    assert_eq!(report["stopped_by"], "interrupt");
    let spp = report["spp"].as_u64().unwrap();
    assert!(
        spp > 0 && report["paths"].as_u64() == Some(spp * 1600),
        "{report}"
    );
    // Every pixel holds as many samples, so the picture can be made again.
    let line = replay_line(&path);
    assert!(line.contains(&format!("--spp {spp} ")), "{line}");
    replay(&line, &again);
    assert_eq!(bits(&read(&path).unwrap()), bits(&read(&again).unwrap()));
    assert_eq!(folder.files(), ["a.exr", "again.exr"]);
}

/// A picture or part that is there is worth more than one without a sample in most pixels.
#[test]
fn ctrl_c_before_every_pixel_has_a_sample_leaves_the_file_there_is() {
    let folder = Folder::new();
    for (name, option) in [("a.png", "-o"), ("a.part", "--part -o")] {
        let path = folder.write(name, "what was there before");
        let words = "render glass-sphere --size 1600x1600 --spp 64 --threads 1";
        let output = interrupted(&format!("{words} {option}"), &path, 200);
        let warning = stderr(&output);
        assert!(
            warning.contains("before every pixel had a sample; nothing is saved"),
            "{warning}"
        );
        assert_eq!(stdout(&output), "");
        let text = std::fs::read_to_string(&path).unwrap();
        assert_eq!(text, "what was there before");
    }
}

#[test]
fn ctrl_c_ends_a_race_that_keeps_what_it_has() {
    let folder = Folder::new();
    let out = folder.path("race");
    let words = "race cornell-box --size 16x16 --methods mis --seconds 1 --seeds 600 -o";
    interrupted(words, &out, 500);
    let text = std::fs::read_to_string(out.join("race.json")).unwrap();
    let report: Value = serde_json::from_str(&text).unwrap();
    assert_eq!(report["interrupted"], true);
    assert!(out.join("chart.svg").exists() && out.join("chart.csv").exists());
}
