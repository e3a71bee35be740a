//! What goes to standard error: errors with their status, and warnings.

use std::ffi::OsStr;

use lightbox_core::image_io::{read, write};
use lightbox_core::simd::Kernel;
use serde_json::Value;

use crate::{Folder, TRIANGLE, run, stderr, stdout};

/// Every kind of bad input: one line on standard error that names file and place, and status 1.
#[test]
fn bad_input_is_told_in_one_line() {
    let folder = Folder::new();
    let scene = |name: &str, text: &str| folder.write(name, text).to_str().unwrap().to_owned();
    let picture = |name: &str, text: &str| {
        let (width, height, pixels) = (1, 1, vec![glam::Vec3::ONE]);
        let image = lightbox_core::Image {
            width,
            height,
            pixels,
        };
        let path = folder.path(name);
        write(&path, &image, Default::default(), text).unwrap();
        path.to_str().unwrap().to_owned()
    };
    let quad = "[[quad]]\nmaterial = \"m\"\ncorners = [[0,0,0],[1,0,0],[1,1,0],[0,1,0]]\n";
    let cases = [
        (
            folder.path("absent.toml").to_str().unwrap().to_owned(),
            "no such file",
            "absent.toml",
        ),
        (
            "cornel-box".into(),
            "did you mean \"cornell-box\"?",
            "cornel-box: no such file or built-in scene",
        ),
        (
            "nothing-like-it".into(),
            "use one of: teddy-diffuse",
            "white-furnace",
        ),
        (
            "builtin:x.obj".into(),
            "no such file or built-in scene",
            "builtin:x.obj",
        ),
        (
            folder.0.path().to_str().unwrap().to_owned(),
            "is a folder",
            ".toml",
        ),
        (scene("junk.toml", "\u{1}\u{2}junk"), "junk.toml:1:", ""),
        (scene("junk.obj", "\u{1}\u{2}junk"), "junk.obj", ""),
        (scene("empty.obj", ""), "empty.obj: is empty", ""),
        (
            scene("method.toml", "[render]\nmethod = \"mic\"\n"),
            "method.toml:2:",
            "did you mean \"mis\"?",
        ),
        (
            scene(
                "far.toml",
                "[[mesh]]\nboulder = 20\ntranslate = [1e19, 0, 0]\n",
            ),
            "far.toml:3:",
            "finite numbers up to 1e18",
        ),
        (
            scene("points.obj", "v 0 0 0\n"),
            "points.obj",
            "nothing to see",
        ),
        (
            scene("flat.obj", "v 0 0 0\nv 1 0 0\nv 2 0 0\nf 1 2 3\n"),
            "flat.obj",
            "no face with an area",
        ),
        (
            scene("nan.obj", &TRIANGLE.replace("v 1 0 0", "v nan 0 0")),
            "nan.obj:2:",
            "",
        ),
        (
            scene("index.obj", &TRIANGLE.replace("f 1 2 3", "f 1 2 9")),
            "index.obj:4:",
            "9",
        ),
        (
            scene("key.toml", "[camera]\nfov = 40\neyes = [0,0,1]\n"),
            "key.toml:3:",
            "did you mean \"eye\"?",
        ),
        (
            scene("fov.toml", "[camera]\nfov = 180\n"),
            "fov.toml:1:",
            "fov is 180",
        ),
        (
            scene("eye.toml", "[camera]\neye = [1, 2]\n"),
            "eye.toml:2:",
            "expected three numbers",
        ),
        (
            scene("word.toml", "[camera]\nfov = \"wide\"\n"),
            "word.toml:2:",
            "expected a number",
        ),
        (
            scene("filter.toml", "[render]\nfilter = \"gausian\"\n"),
            "filter.toml:2:",
            "did you mean \"gaussian\"?",
        ),
        (
            scene("size.toml", "[render]\nwidth = 99999\n"),
            "size.toml:1:",
            "use 1 to 16384",
        ),
        (
            scene("material.toml", quad),
            "material.toml:2:",
            "unknown material \"m\"",
        ),
        (
            scene("mesh.toml", "[[mesh]]\nfile = \"gone.obj\"\n"),
            "mesh.toml:2:",
            "gone.obj",
        ),
        (picture("plain.png", ""), "plain.png", "without a scene"),
        (
            picture("odd.exr", "lightbox render x\n[scene]\nfov = 40\n"),
            "odd.exr: the scene in this picture cannot be read",
            "",
        ),
        (
            scene("junk.png", "\u{1}\u{2}junk"),
            "junk.png: not a picture",
            "",
        ),
        (
            scene("junk.exr", "\u{1}\u{2}junk"),
            "junk.exr: not a picture",
            "",
        ),
    ];
    let output = folder.path("a.png");
    for (path, expected, too) in &cases {
        for command in ["render", "info"] {
            let tail: &[&str] = if command == "render" {
                &["-o", output.to_str().unwrap()]
            } else {
                &[]
            };
            let result = run([command, path].iter().chain(tail));
            let error = stderr(&result);
            assert_eq!(result.status.code(), Some(1), "{command} {path}: {error}");
            assert!(
                error.starts_with("error: ") && error.lines().count() == 1,
                "{command} {path}: {error}"
            );
            assert!(
                error.contains(expected) && error.contains(too),
                "{command} {path}: {error}"
            );
            assert_eq!(stdout(&result), "");
        }
    }
    assert!(!output.exists());
}

/// What was to be told and cannot be is an error, but for a reader who has gone.
#[cfg(target_os = "linux")]
#[test]
fn a_full_disk_behind_standard_output_is_told() {
    for words in ["info cornell-box", "render --help", "--version"] {
        let full = std::fs::File::create("/dev/full").unwrap();
        let result = crate::lightbox()
            .args(words.split(' '))
            .stdout(full)
            .output()
            .unwrap();
        let error = stderr(&result);
        assert_eq!(result.status.code(), Some(1), "{words}: {error}");
        assert!(
            error.starts_with("error: standard output") && error.lines().count() == 1,
            "{words}: {error}"
        );
    }
}

/// Wrong usage: status 2, before anything is read.
#[test]
fn bad_usage_has_status_two() {
    let cases = [
        ("", "--output"),
        ("-o a.png --filter gausian", "did you mean \"gaussian\"?"),
        ("-o a.png --filter gaussian:0.1", "from 0.5 to 8"),
        ("-o a.png --size 0x10", "from 1 to 16384"),
        ("-o a.png --size 99999x10", "from 1 to 16384"),
        ("-o a.png --size abc", "640x480"),
        ("-o a.png --size -10x1", "640x480"),
        ("-o a.png --spp 0", "--spp"),
        ("-o a.png --spp -1", "from 1 to"),
        ("-o a.png --seed -1", "from 0 to"),
        ("-o a.png --threads -1", "-1"),
        ("-o a.png --seconds 0", "positive"),
        ("-o a.png --seconds inf", "positive"),
        ("-o a.png --noise nan", "positive"),
        ("-o a.png --depth 0", "emitters only"),
        ("-o a.png --depth deep", "unlimited"),
        ("-o a.png --depth -1", "unlimited"),
        ("-o a.png --depth 4294967296", "not too large"),
        ("-o a.png --method miss", "mis"),
        ("-o a.png --accel kdtre", "kdtree"),
        ("-o a.png --sampler halton", "sobol"),
        ("-o a.png --threads 0", "--threads"),
        ("-o a.png --eye 1,2", "three numbers"),
        ("-o a.png --eye nan,0,0", "three numbers"),
        ("-o a.png --fov 180", "180"),
        ("-o a.png --exposure inf", "number"),
        ("-o a.png --tone rosy", "filmic"),
        ("-o a.png --seed 9223372036854775808", "--seed"),
        ("-o a.png --metod mis", "--method"),
        ("-o a.png --samples 0..4", "--part"),
        ("-o a.part --part --samples 4..4", "A less than B"),
        ("-o a.part --part --samples 4", "64..128"),
        ("-o a.part --part --samples -1..5", "64..128"),
        ("-o a.part --part --samples 0..4 --spp 8", "--spp"),
        ("--part --json", "--output"),
        ("-o a.png --every 5", "--checkpoint"),
        ("-o a.png --checkpoint a.part --every 0", "positive"),
    ];
    for (options, expected) in cases {
        let result = run(["render", "no-such-scene"]
            .into_iter()
            .chain(options.split_whitespace()));
        assert_eq!(
            result.status.code(),
            Some(2),
            "{options}: {}",
            stderr(&result)
        );
        let error = stderr(&result);
        assert!(error.contains(expected), "{options}: {error}");
        assert!(
            error.starts_with("error: ") && error.lines().count() == 1,
            "{options}: {error}"
        );
    }
}

/// An empty line in a value does not cut the message.
#[test]
fn a_value_of_lines_is_told_in_one() {
    let result = run(["render", "no-such-scene", "--size", "4\n\nx\n\n4"]);
    let error = stderr(&result);
    assert_eq!(result.status.code(), Some(2), "{error}");
    assert!(
        error.contains("4 x 4") && error.contains("640x480") && error.lines().count() == 1,
        "{error}"
    );
}

#[test]
fn a_misspelt_command_is_told_from_a_scene() {
    for (words, expected) in [
        ("rendr cornell-box", "did you mean \"render\"?"),
        ("inf cornell-box", "did you mean \"info\"?"),
        ("rendr cornell-box --spp 3", "did you mean \"render\"?"),
        ("cornell-box --part --spp 3", "-o FILE.part"),
        (
            "cornell-box --spp 3",
            "lightbox render cornell-box --spp 3 -o FILE.png\n",
        ),
        (
            "cornell-box -o a.png",
            "lightbox render cornell-box -o a.png\n",
        ),
        (
            "cornell-box glass-sphere",
            "one scene; \"glass-sphere\" is one too many",
        ),
    ] {
        let result = run(words.split(' '));
        assert_eq!(result.status.code(), Some(2));
        let error = stderr(&result);
        assert!(error.contains(expected), "{error}");
        assert_eq!(error.lines().count(), 1, "{error}");
    }
}

#[test]
fn the_output_is_checked_before_the_scene_is_read() {
    let folder = Folder::new();
    let file = folder.write("file", "");
    let kept = folder.write("kept.png", "");
    let mut permissions = kept.metadata().unwrap().permissions();
    permissions.set_readonly(true);
    std::fs::set_permissions(&kept, permissions).unwrap();
    for (output, expected) in [
        (kept.clone(), "write-protected"),
        (folder.path("no such folder/a.png"), "cannot be written"),
        (file.join("a.png"), "cannot be written"),
        (folder.path("a.jpg"), "name it *.png or *.exr"),
        (folder.path("png"), "name it *.png or *.exr"),
    ] {
        let result = run(["render", "no-such-scene", "-o", output.to_str().unwrap()]);
        let error = stderr(&result);
        assert_eq!(result.status.code(), Some(1), "{error}");
        assert!(
            error.starts_with("error: ") && error.contains(output.to_str().unwrap()),
            "{error}"
        );
        assert!(
            error.contains(expected) && error.lines().count() == 1,
            "{error}"
        );
    }
    assert_eq!(folder.files(), ["file", "kept.png"]);
}

#[test]
fn a_camera_that_cannot_look_is_blamed_on_the_command_line() {
    let result = run(["render", "cornell-box", "--json", "--eye", "278,273,0"]);
    assert_eq!(result.status.code(), Some(1));
    assert_eq!(
        stderr(&result),
        "error: camera: eye and target are the same point; move one\n"
    );
}

#[test]
fn oddities_of_a_scene_are_warnings() {
    let folder = Folder::new();
    let dark = folder.write(
        "dark.toml",
        "[[material]]\nname = \"m\"\n[[sphere]]\nmaterial = \"m\"\ncenter = [0, 0, 0]\nradius = 1\n",
    );
    let output = folder.path("dark.exr");
    let result = run([
        "render",
        dark.to_str().unwrap(),
        "--size",
        "4x4",
        "--spp",
        "2",
        "-o",
        output.to_str().unwrap(),
    ]);
    assert_eq!(result.status.code(), Some(0));
    let warnings = stderr(&result);
    assert!(
        warnings.starts_with("warning: nothing emits light") && warnings.lines().count() == 1,
        "{warnings}"
    );
    assert!(
        read(&output)
            .unwrap()
            .pixels
            .iter()
            .all(|p| *p == glam::Vec3::ZERO)
    );

    let mesh = folder.write("lines.obj", &format!("{TRIANGLE}l 1 2\nl 2 3\n"));
    let result = run(["info", mesh.to_str().unwrap(), "--json"]);
    assert_eq!(result.status.code(), Some(0));
    let warnings = stderr(&result);
    assert!(
        warnings.starts_with("warning: ") && warnings.contains("lines.obj:5:"),
        "{warnings}"
    );
    let report: Value = serde_json::from_str(&stdout(&result)).unwrap();
    assert_eq!(
        format!("warning: {}\n", report["warnings"][0].as_str().unwrap()),
        warnings
    );
}

#[cfg(target_os = "linux")]
#[test]
fn without_a_display_the_viewer_names_the_command_to_use() {
    let output = crate::lightbox()
        .env_remove("DISPLAY")
        .env_remove("WAYLAND_DISPLAY")
        .env_remove("WAYLAND_SOCKET")
        .output()
        .unwrap();
    let error = stderr(&output);
    assert_eq!(output.status.code(), Some(1), "{error}");
    assert!(
        error.starts_with("error: ")
            && error.lines().count() == 1
            && error.contains("lightbox render"),
        "{error}"
    );
    // A scene that is not there is told first, as everywhere.
    let output = crate::lightbox().arg("cornel-box").output().unwrap();
    assert!(
        stderr(&output).contains("did you mean \"cornell-box\"?"),
        "{}",
        stderr(&output)
    );
}

/// With and without a window: what the environment asks for is either done or refused.
#[test]
fn a_kernel_that_this_machine_does_not_have_is_refused() {
    let start = |kernel: &OsStr, args: &[&str]| {
        crate::lightbox()
            .args(args)
            .env("LIGHTBOX_KERNEL", kernel)
            .env_remove("DISPLAY")
            .env_remove("WAYLAND_DISPLAY")
            .output()
            .unwrap()
    };
    for args in [&["info", "cornell-box"] as &[_], &[]] {
        for name in ["avx3", "Portable", "a\nb"] {
            let output = start(name.as_ref(), args);
            let error = stderr(&output);
            assert_eq!(output.status.code(), Some(1), "{error}");
            assert!(
                error.starts_with("error: LIGHTBOX_KERNEL in the environment is \"")
                    && error.contains("use one of: portable")
                    && error.lines().count() == 1,
                "{error}"
            );
            assert_eq!(stdout(&output), "");
        }
    }
    let kernels = Kernel::available().into_iter().map(Kernel::name);
    for name in kernels.chain([""]) {
        let output = start(name.as_ref(), &["info", "cornell-box"]);
        assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    }
}
