//! The files that `lightbox render` writes.

use std::path::Path;

use lightbox_core::image_io::read;
use lightbox_core::scene::BUILTIN;

use crate::{Folder, bits, render, replay, replay_line};

#[test]
fn every_built_in_scene_renders_to_both_formats() {
    let folder = Folder::new();
    let lean = |scene: &&&str| !scene.contains("million"); // Its accelerator takes seconds.
    for scene in BUILTIN.iter().filter(lean) {
        let (exr, png) = (folder.path("a.exr"), folder.path("a.png"));
        let report = render(scene, "--size 20x12 --spp 2", &exr);
        assert_eq!(
            (&report["width"], &report["height"], &report["spp"]),
            (&20.into(), &12.into(), &2.into()),
            "{scene}"
        );
        render(scene, "--size 20x12 --spp 2", &png);
        let (measured, shown) = (read(&exr).unwrap(), read(&png).unwrap());
        assert_eq!((measured.width, measured.height), (20, 12));
        assert!(
            measured.pixels.iter().any(|p| p.min_element() > 0.0),
            "{scene} is black"
        );
        for (m, s) in measured.pixels.iter().zip(&shown.pixels) {
            for (m, s) in m.to_array().into_iter().zip(s.to_array()) {
                // Half a step of 8-bit sRGB near white is 0.45 %.
                assert!(
                    (m.min(1.0) - s).abs() < 0.0046,
                    "{scene}: {m} is shown as {s}"
                );
            }
        }
    }
}

#[test]
fn threads_do_not_change_a_byte() {
    let folder = Folder::new();
    let files = [1, 2, 8].map(|threads| {
        let path = folder.path(&format!("{threads}.exr"));
        render(
            "cornell-box",
            &format!("--size 50x35 --spp 5 --filter lanczos --threads {threads}"),
            &path,
        );
        std::fs::read(path).unwrap()
    });
    assert!(files[0] == files[1] && files[0] == files[2]);
    let path = folder.path("other.exr");
    render(
        "cornell-box",
        "--size 50x35 --spp 5 --filter lanczos --seed 1",
        &path,
    );
    assert!(
        read(&path).unwrap() != read(&folder.path("1.exr")).unwrap(),
        "the seed changes nothing"
    );
}

#[test]
fn the_replay_line_makes_the_same_picture_again() {
    let folder = Folder::new();
    let scene = folder.write(
        "it's a $cene.toml",
        &std::fs::read_to_string(
            Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes/cornell-box.toml"),
        )
        .unwrap(),
    );
    let camera = "--eye -0.1,273.3,-799.9 --target 278,273,1e-3 --up 0.1,1,-0 --fov 33.3";
    let other = "--depth unlimited --filter mitchell:1.7 --method naive --accel kdtree --sampler independent --seed 18446744073709551615";
    let looks = format!("{camera} {other} --exposure -1.3 --tone filmic");
    for (i, (name, options)) in [
        ("png", ""),
        ("exr", ""),
        ("png", looks.as_str()),
        ("exr", looks.as_str()),
    ]
    .into_iter()
    .enumerate()
    {
        let (first, again) = (
            folder.path(&format!("{i}.{name}")),
            folder.path(&format!("{i} again.{name}")),
        );
        let report = render(
            scene.to_str().unwrap(),
            &format!("--size 33x17 --spp 3 {options}"),
            &first,
        );
        let line = replay_line(&first);
        assert_eq!(report["replay"], line);
        replay(&line, &again);
        assert!(
            std::fs::read(&first).unwrap() == std::fs::read(&again).unwrap(),
            "{line}"
        );
    }
    let [plain, looked] = [1, 3].map(|i| bits(&read(&folder.path(&format!("{i}.exr"))).unwrap()));
    assert!(plain != looked, "the options change nothing");
}
