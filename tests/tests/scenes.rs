//! Scene files: what ships builds, and what is wrong gets one line with file, line and remedy.

use std::path::Path;

use lightbox_core::scene::{BUILTIN, BUILTIN_LAB, Source, load, parse};
use lightbox_tests::{scenes_folder, shipped_scenes};

#[test]
fn every_shipped_scene_is_built_in_and_builds() {
    let files = shipped_scenes();
    assert_eq!(files.len(), BUILTIN.len());
    for file in &files {
        let name = file
            .file_name()
            .expect("a name")
            .to_string_lossy()
            .into_owned();
        let builtin = format!("builtin:{name}");
        assert!(BUILTIN.contains(&builtin.as_str()), "{name}");
        let (a, b) = (load(file), load(Path::new(&builtin)));
        assert_eq!(a.expect("a file").desc, b.expect("a built-in").desc);
        if name != "million.toml" {
            let scene = load(Path::new(&builtin))
                .and_then(|s| s.build(&lightbox_core::scene::unwatched))
                .unwrap_or_else(|e| panic!("{e}"));
            assert_eq!(scene.warnings(), [], "{name}");
        }
    }
}

/// The example in docs/scenes.md has every key there is, in a scene that builds.
#[test]
fn the_manual_shows_every_key() {
    let folder = scenes_folder().join("../docs");
    let manual = std::fs::read_to_string(folder.join("scenes.md")).expect("the manual");
    let (_, rest) = manual.split_once("```toml\n").expect("an example");
    let (example, _) = rest.split_once("```").expect("its end");
    let path = folder.join("example.toml");
    let desc = parse(example, &path).unwrap_or_else(|e| panic!("{e}"));
    let scene = Source::from_desc(desc.clone(), &path).build(&lightbox_core::scene::unwatched);
    assert_eq!(scene.unwrap_or_else(|e| panic!("{e}")).warnings(), []);
    // As the program itself writes a scene that has everything.
    let mut full = desc;
    full.render.full_model = true;
    full.materials[0].texture = Some("wood.png".into());
    full.meshes[0].file = Some("teddy.obj".into());
    let text = toml::to_string(&full).expect("TOML");
    let keys = text.lines().filter_map(|line| line.split_once(" = "));
    for (key, _) in keys {
        let has = |line: &str| {
            line.trim_start_matches("# ")
                .starts_with(&format!("{key} ="))
        };
        assert!(example.lines().any(has), "{key}");
    }
}

#[test]
fn every_scene_of_the_lab_is_built_in() {
    let folder = scenes_folder().join("lab");
    let mut names: Vec<String> = std::fs::read_dir(folder)
        .expect("a folder")
        .map(|entry| entry.expect("an entry").file_name())
        .map(|name| format!("builtin:lab/{}", name.to_string_lossy()))
        .filter(|name| name.ends_with(".toml"))
        .collect();
    names.sort();
    assert_eq!(names, BUILTIN_LAB);
}

const GOOD: &str = "\
[camera]
eye = [0, 0, 4]

[[material]]
name = 'white'
albedo = [0.7, 0.7, 0.7]

[[sphere]]
material = 'white'
center = [0, 0, 0]
radius = 1

[[quad]]
name = 'floor'
material = 'white'
corners = [[-2, -1, 2], [2, -1, 2], [2, -1, -2], [-2, -1, -2]]
";

fn error_of(text: &str) -> String {
    let path = Path::new("scene.toml");
    let result = parse(text, path).and_then(|_| {
        // With the text at hand, so that lines can be named.
        let folder = std::env::temp_dir().join(format!("lightbox-scenes-{}", std::process::id()));
        std::fs::create_dir_all(&folder).expect("a folder");
        let file = folder.join(format!("{:x}.toml", text.len()));
        std::fs::write(&file, text).expect("a file");
        load(&file).and_then(|source: Source| source.build(&lightbox_core::scene::unwatched))
    });
    result.err().map(|e| e.to_string()).unwrap_or_default()
}

#[test]
fn mistakes_get_one_line_with_place_and_remedy() {
    assert_eq!(error_of(GOOD), "");
    let cases: &[(&str, &str, &[&str])] = &[
        (
            "eye = [0, 0, 4]",
            "eyes = [0, 0, 4]",
            &[":2:", "unknown key \"eyes\"", "\"eye\""],
        ),
        (
            "albedo =",
            "albedo_ =",
            &[":6:", "did you mean \"albedo\"?"],
        ),
        (
            "material = 'white'\ncenter",
            "material = 'whit'\ncenter",
            &[":9:", "did you mean \"white\"?"],
        ),
        ("[0.7, 0.7, 0.7]", "[0.7, 1.7, 0.7]", &[":6:", "0 to 1"]),
        ("[0.7, 0.7, 0.7]", "[0.7, nan, 0.7]", &[":6:", "0 to 1"]),
        (
            "center = [0, 0, 0]",
            "center = [0, inf, 0]",
            &[":10:", "finite"],
        ),
        ("radius = 1", "radius = 0", &[":11:", "positive"]),
        ("radius = 1", "radius = nan", &[":11:", "positive"]),
        ("radius = 1", "radius = 'big'", &[":11:"]),
        ("radius = 1", "", &["radius"]),
        (
            "[2, -1, 2], [2, -1, -2]",
            "[2, -1, -2], [2, -1, 2]",
            &[":16:", "in order around the edge"],
        ),
        ("[2, -1, 2],", "[-2, -1, 2],", &[":16:", "no area"]),
        ("eye = [0, 0, 4]", "eye = [0, 0, 0]", &[":1:", "same point"]),
        (
            "eye = [0, 0, 4]",
            "eye = [0, 0, 4]\nfov = 180",
            &["fov is 180", "less than 180"],
        ),
        (
            "eye = [0, 0, 4]",
            "eye = [0, 0, 4]\nup = [0, 0, 0]",
            &["up is the zero vector"],
        ),
        ("[camera]", "[render]\nwidth = 0\n[camera]", &["width is 0"]),
        (
            "[camera]",
            "[render]\nwidth = 16000\nheight = 16000\n[camera]",
            &["too large"],
        ),
        (
            "[camera]",
            "[render]\nfilter = 'gausian'\n[camera]",
            &[":2:", "did you mean \"gaussian\"?"],
        ),
        (
            "[camera]",
            "[render]\nmethod = 'mos'\n[camera]",
            &[":2:", "mis"],
        ),
        (
            "[camera]",
            "[render]\ndepth = 'deep'\n[camera]",
            &[":2:", "unlimited"],
        ),
        ("[camera]", "[camera", &[":1:"]),
        (
            "[[sphere]]",
            "[[mesh]]\nfile = 'nowhere.obj'\n[[sphere]]",
            &[":9:", "nowhere.obj", "no such file"],
        ),
        ("[[sphere]]", "[[mesh]]\n[[sphere]]", &[":8:", "file ="]),
    ];
    for (right, wrong, expected) in cases {
        let text = GOOD.replacen(right, wrong, 1);
        assert_ne!(text, GOOD, "{right}");
        let error = error_of(&text);
        assert_eq!(error.lines().count(), 1, "{wrong}: {error}");
        for part in *expected {
            assert!(
                error.contains(part),
                "{wrong}: {error:?} should contain {part:?}"
            );
        }
    }
}

#[test]
fn odd_scenes_load_with_a_warning() {
    let warnings = |text: &str| {
        let desc = parse(text, Path::new("scene.toml")).expect("a scene");
        let scene = Source::from_desc(desc, &scenes_folder().join("x.toml"))
            .build(&lightbox_core::scene::unwatched)
            .expect("it builds");
        scene
            .warnings()
            .iter()
            .map(ToString::to_string)
            .collect::<Vec<_>>()
            .join("\n")
    };
    assert!(warnings(GOOD).contains("nothing emits light"));
    let inside = GOOD.replace("eye = [0, 0, 4]", "eye = [0, 0, 0.5]");
    assert!(
        warnings(&inside).contains("the camera is inside \"sphere 1\""),
        "{}",
        warnings(&inside)
    );
    assert!(!warnings(&format!("background = [1, 1, 1]\n{GOOD}")).contains("light"));
}

#[test]
fn files_that_are_no_scenes_are_refused() {
    let folder = std::env::temp_dir().join(format!("lightbox-junk-{}", std::process::id()));
    std::fs::create_dir_all(&folder).expect("a folder");
    let cases: &[(&str, &[u8], &str)] = &[
        ("noise.toml", &[0xff, 0xfe, 0, 1, 2], "not UTF-8"),
        ("noise.obj", &[0xff, 0xd8, 0xff, 0xe0, 0, 16], ""),
        ("empty.obj", b"", ""),
        ("points.obj", b"v 0 0 0\nv 1 0 0\nv 0 1 0\n", ""),
    ];
    for (name, bytes, part) in cases {
        let file = folder.join(name);
        std::fs::write(&file, bytes).expect("a file");
        let error = load(&file).err().map(|e| e.to_string()).unwrap_or_default();
        assert!(
            error.contains(name) && error.contains(part) && error.lines().count() == 1,
            "{name}: {error}"
        );
    }
    for (path, part) in [
        (folder.join("missing.toml"), "no such file"),
        (folder.clone(), "folder"),
    ] {
        let error = load(&path).err().map(|e| e.to_string()).unwrap_or_default();
        assert!(error.contains(part), "{error}");
    }
}
