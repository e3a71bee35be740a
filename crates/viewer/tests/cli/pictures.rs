//! The files that `lightbox render` writes.

use std::path::Path;

use lightbox_core::Image;
use lightbox_core::color::{ToneCurve, ToneMap, linear_from_srgb};
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
        assert_eq!(shown, as_shown(&measured, ToneMap::default()), "{scene}");
    }
}

/// A picture as it comes back from a PNG.
fn as_shown(image: &Image, tone: ToneMap) -> Image {
    let pixels = image.pixels.iter();
    let pixels = pixels
        .map(|p| tone.apply(*p).map(linear_from_srgb).into())
        .collect();
    Image { pixels, ..*image }
}

#[test]
fn exposure_and_tone_shape_a_png_and_leave_an_exr_alone() {
    let folder = Folder::new();
    let (exr, same, png) = (
        folder.path("a.exr"),
        folder.path("b.exr"),
        folder.path("a.png"),
    );
    let size = "--size 20x12 --spp 2";
    render("cornell-box", size, &exr);
    render(
        "cornell-box",
        &format!("{size} --exposure -1.5 --tone filmic --offset 0.1"),
        &same,
    );
    render(
        "cornell-box",
        &format!("{size} --exposure -1.5 --tone filmic --offset 0.1"),
        &png,
    );
    let measured = read(&exr).unwrap();
    assert_eq!(measured, read(&same).unwrap());
    let tone = ToneMap {
        exposure: -1.5,
        curve: ToneCurve::Filmic,
        offset: 0.1,
    };
    assert_eq!(read(&png).unwrap(), as_shown(&measured, tone));
}

/// A link stays one: what it leads to is written.
#[cfg(unix)]
#[test]
fn a_picture_is_written_through_a_link() {
    let folder = Folder::new();
    let (file, link) = (folder.write("file.png", ""), folder.path("link.png"));
    std::os::unix::fs::symlink("file.png", &link).unwrap();
    render("cornell-box", "--size 8x8 --spp 1", &link);
    assert!(link.is_symlink());
    assert!(read(&file).is_ok());
    assert_eq!(folder.files(), ["file.png", "link.png"]);
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
    let camera = "--eye -0.1,273.3,-799.9 --target 278,273,1e-3 --up 0.1,1,-0 --fov 33.37";
    let other = "--depth unlimited --filter mitchell:1.7 --method naive --accel kdtree --sampler independent --seed 9223372036854775807";
    let looks = format!("{camera} {other} --exposure -1.3 --tone filmic --offset -0.05");
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
    let line = replay_line(&folder.path("2.png"));
    // What was asked for is what the line asks for.
    for word in looks
        .split("--")
        .map(str::trim)
        .filter(|word| !word.is_empty())
    {
        let (name, value) = word.split_once(' ').expect("a name and a value");
        let value = value.replace("1e-3", "0.001");
        let written = [format!("--{name} {value} "), format!("--{name}={value} ")];
        assert!(
            written.iter().any(|w| format!("{line} ").contains(w)),
            "{word} is not in {line}"
        );
    }
    // The picture itself is a scene that wants all of it.
    for name in ["png", "exr"] {
        let from = folder.path(&format!("{}.{name}", if name == "png" { 2 } else { 3 }));
        let again = folder.path(&format!("from picture.{name}"));
        render(from.to_str().unwrap(), "", &again);
        assert_eq!(read(&from).unwrap(), read(&again).unwrap());
    }
    let [plain, looked] = [1, 3].map(|i| bits(&read(&folder.path(&format!("{i}.exr"))).unwrap()));
    assert!(plain != looked, "the options change nothing");
}
