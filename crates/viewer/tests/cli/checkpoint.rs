//! `lightbox render --checkpoint`: killed at any moment, the render goes on where it was.

use std::path::Path;
use std::process::Stdio;
use std::time::Duration;

use lightbox_core::part::read_head;

use crate::{Folder, lightbox, render, run, stderr};

const SCENE: &str = "cornell-box";
const OPTIONS: &str = "--size 40x24 --filter lanczos";

fn words(options: &str) -> impl Iterator<Item = &str> {
    ["render", SCENE]
        .into_iter()
        .chain(OPTIONS.split(' '))
        .chain(options.split_whitespace())
}

/// Samples per pixel in a checkpoint, which is whole whenever it is there.
fn held(checkpoint: &Path) -> u64 {
    if !checkpoint.exists() {
        return 0;
    }
    read_head(checkpoint)
        .expect("a whole checkpoint")
        .samples_per_pixel()
}

/// Kills a render `kills` times at random moments, lets it finish, and compares.
fn kill(kills: u64) {
    let folder = Folder::new();
    let [checkpoint, picture, whole] =
        ["a.part", "a.exr", "whole.exr"].map(|name| folder.path(name));
    let (mut last, mut random, mut rises) = (0, 1u64, 0);
    // Sittings too short for a save lose nothing that was saved; there have to be others.
    let mut sittings = 0;
    while sittings < kills || rises < 3 {
        sittings += 1;
        assert!(sittings < kills + 200, "nothing is ever saved");
        let mut child = lightbox()
            .args(words("--spp 1000000000 --every 0.01 --checkpoint"))
            .arg(&checkpoint)
            .arg("-o")
            .arg(&picture)
            .stderr(Stdio::null())
            .spawn()
            .expect("a process");
        random = random
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1);
        // The later ones longer, for machines on which a start takes long.
        std::thread::sleep(Duration::from_millis((random >> 33) % (60 + 4 * sittings)));
        child.kill().expect("a running process");
        assert!(!child.wait().expect("an end").success());
        let now = held(&checkpoint);
        assert!(now >= last, "{now} after {last}");
        rises += u64::from(now > last);
        last = now;
    }
    let samples = 2 * last + 1000; // More than the tile that is furthest has.
    let finish = format!(
        "{OPTIONS} --spp {samples} --checkpoint {}",
        checkpoint.display()
    );
    let report = render(SCENE, &finish, &picture);
    assert_eq!(
        (&report["resumed"], &report["spp"]),
        (&last.into(), &samples.into())
    );
    let uninterrupted = render(SCENE, &format!("{OPTIONS} --spp {samples}"), &whole);
    for figure in ["paths", "rays", "noise"] {
        assert_eq!(report[figure], uninterrupted[figure], "{figure}");
    }
    assert!(
        std::fs::read(&picture).expect("a picture") == std::fs::read(&whole).expect("a picture")
    );
    // What was written when it was killed is gone too.
    assert_eq!(folder.files(), ["a.exr", "a.part", "whole.exr"]);
}

#[test]
fn killed_at_random_moments_it_ends_with_the_same_file() {
    kill(8);
}

/// The long version: `cargo test --release -p lightbox --test cli -- --ignored a_hundred_kills`
#[test]
#[ignore = "takes a minute"]
fn a_hundred_kills_leave_no_trace() {
    kill(100);
}

#[test]
fn a_render_to_a_noise_stops_where_it_would_have() {
    let folder = Folder::new();
    let [checkpoint, picture, whole] =
        ["a.part", "a.exr", "whole.exr"].map(|name| folder.path(name));
    let keep = format!("{OPTIONS} --checkpoint {}", checkpoint.display());
    let limit = "--noise 0.12";
    let report = render(SCENE, &format!("{OPTIONS} {limit}"), &whole);
    assert!(report["spp"].as_u64() > Some(20), "{report}");
    render(SCENE, &format!("{keep} --spp 17"), &picture);
    let resumed = render(SCENE, &format!("{keep} {limit}"), &picture);
    assert_eq!(
        (&resumed["resumed"], &resumed["spp"]),
        (&17.into(), &report["spp"])
    );
    assert!(
        std::fs::read(&picture).expect("a picture") == std::fs::read(&whole).expect("a picture")
    );
    // Done: a third time there is nothing left to do.
    let third = render(SCENE, &format!("{keep} {limit}"), &picture);
    assert_eq!(
        (&third["resumed"], &third["paths"]),
        (&report["spp"], &report["paths"])
    );
    assert!(
        std::fs::read(&picture).expect("a picture") == std::fs::read(&whole).expect("a picture")
    );
}

#[test]
fn a_part_is_its_own_checkpoint() {
    let folder = Folder::new();
    let part = folder.path("a.part");
    let slice = format!(
        "{OPTIONS} --part --samples 3..9 --checkpoint {}",
        part.display()
    );
    let first = render(SCENE, &slice, &part);
    let bytes = std::fs::read(&part).unwrap();
    let again = render(SCENE, &slice, &part);
    assert_eq!(
        (&first["resumed"], &again["resumed"]),
        (&0.into(), &6.into())
    );
    assert_eq!(
        (&first["paths"], &first["rays"]),
        (&again["paths"], &again["rays"])
    );
    assert!(std::fs::read(&part).unwrap() == bytes);
}

#[test]
fn a_checkpoint_that_does_not_fit_is_refused() {
    let folder = Folder::new();
    let (checkpoint, picture) = (folder.path("a.part"), folder.path("b.exr"));
    let keep = format!(
        "--checkpoint {} -o {}",
        checkpoint.display(),
        picture.display()
    );
    assert!(run(words(&format!("{keep} --spp 8"))).status.success());
    std::fs::remove_file(&picture).unwrap();
    let slice = folder.path("b.part");
    let slice = format!(
        "--checkpoint {} --part -o {} --samples 2..9",
        checkpoint.display(),
        slice.display()
    );
    for (options, expected) in [
        (
            format!("{keep} --spp 8 --seed 1"),
            "holds another render (seed 0 instead of 1)",
        ),
        (
            format!("{keep} --spp 7"),
            "holds 8 samples per pixel, more than the 7 asked for",
        ),
        (slice, "samples 0..8 instead of those from 2 on"),
    ] {
        let output = run(words(&options));
        let error = stderr(&output);
        assert_eq!(output.status.code(), Some(1), "{error}");
        assert!(
            error.contains(expected) && error.contains("a.part: "),
            "{error}"
        );
        assert_eq!(error.lines().count(), 1, "{error}");
    }
    let bytes = std::fs::read(&checkpoint).unwrap();
    std::fs::write(&checkpoint, &bytes[..bytes.len() / 2]).unwrap();
    let error = stderr(&run(words(&format!("{keep} --spp 8"))));
    assert!(error.contains("a.part: is cut short"), "{error}");
    assert!(!picture.exists());
}
