//! What goes to standard output: help, reports, JSON.

use std::ffi::OsStr;
use std::path::Path;

use lightbox_core::image_io::read;
use serde_json::Value;

use crate::{Folder, TRIANGLE, json, ok, render, run, stderr};

#[test]
fn help_names_every_command_and_option() {
    let help = ok(["--help"]);
    for word in [
        "render",
        "info",
        "compare",
        "SCENE",
        "cornell-box",
        "teddy-diffuse",
    ] {
        assert!(help.contains(word), "{word} is not in\n{help}");
    }
    let help = ok(["render", "--help"]);
    for word in [
        "--output",
        "--spp",
        "--seconds",
        "--noise",
        "--size",
        "--depth",
        "--filter",
        "--method",
        "--accel",
        "--sampler",
        "--seed",
        "--full-model",
        "--threads",
        "--exposure",
        "--offset",
        "--tone",
        "--eye",
        "--target",
        "--up",
        "--fov",
        "--json",
        "naive",
        "nee",
        "caustics",
        "reuse",
        "kdtree",
        "bvh",
        "brute",
        "sobol",
        "independent",
        "lanczos",
        "filmic",
    ] {
        assert!(help.contains(word), "{word} is not in\n{help}");
    }
    assert!(ok(["--version"]).contains(env!("CARGO_PKG_VERSION")));
}

#[test]
fn scenes_are_found_by_file_and_by_bare_name() {
    let folder = Folder::new();
    let mesh = folder.write("a triangle.obj", TRIANGLE);
    for scene in [
        "cornell-box",
        "cornell-box.toml",
        "builtin:cornell-box",
        "builtin:cornell-box.toml",
    ] {
        assert_eq!(
            json(["info", scene, "--json"])["scene"],
            "builtin:cornell-box.toml"
        );
    }
    let report = json([OsStr::new("info"), mesh.as_os_str(), "--json".as_ref()]);
    assert_eq!(report["scene"], mesh.to_str().unwrap());
    assert!(report["triangles"].as_u64() >= Some(1));
}

#[test]
fn the_report_of_render_is_complete() {
    let options = "--size 8x6 --spp 4 --depth unlimited --filter gaussian:1.25 --method nee --accel brute --sampler independent --seed 7 --threads 3";
    let words = ["render", "cornell-box", "--json"]
        .into_iter()
        .chain(options.split_whitespace());
    let report = json(words);
    let fixed = serde_json::json!({
        "scene": "builtin:cornell-box.toml", "output": null, "width": 8, "height": 6, "spp": 4, "paths": 8 * 6 * 4,
        "invalid_samples": 0, "stopped_by": "spp", "threads": 3, "method": "nee", "accel": "brute", "sampler": "independent",
        "filter": "gaussian:1.25", "depth": "unlimited", "seed": 7,
    });
    for (key, value) in fixed.as_object().unwrap() {
        assert_eq!(&report[key], value, "{key}");
    }
    for key in ["seconds", "load_seconds", "build_seconds", "noise"] {
        assert!(report[key].as_f64() > Some(0.0), "{key} is {}", report[key]);
    }
    assert!(report["rays"].as_u64() > report["paths"].as_u64());
    // One sample has no second half to tell the noise from, and "auto" says what it chose.
    let report = json([
        "render",
        "cornell-box",
        "--size",
        "4x4",
        "--spp",
        "1",
        "--depth",
        "3",
        "--json",
    ]);
    assert_eq!(
        (&report["noise"], &report["depth"]),
        (&Value::Null, &3.into())
    );
    assert_eq!(report["accel"], "bvh");
}

#[test]
fn without_json_the_report_is_one_line_for_people() {
    let folder = Folder::new();
    let path = folder.path("a.png");
    let text = ok([
        "render",
        "cornell-box",
        "--size",
        "8x8",
        "--spp",
        "2",
        "-o",
        path.to_str().unwrap(),
    ]);
    assert_eq!(text.lines().count(), 1, "{text}");
    for part in [
        "a.png: 8x8, 2 spp in ",
        " Mrays/s",
        "noise ",
        "lost to depth",
    ] {
        assert!(text.contains(part), "{text}");
    }
}

#[test]
fn info_counts_what_a_scene_holds() {
    let folder = Folder::new();
    let scene = folder.write(
        "census.toml",
        r#"
        [[material]]
        name = "wall"
        [[material]]
        name = "unused"
        mirror = 1
        [[material]]
        name = "half"
        mirror = 0.5
        [[material]]
        name = "clear"
        glass = 1.5
        [[material]]
        name = "lamp"
        emission = [1, 1, 1]
        [[sphere]]
        material = "half"
        center = [0, 0, 0]
        radius = 1
        [[sphere]]
        material = "clear"
        center = [2, 0, 0]
        radius = 0.5
        [[quad]]
        material = "lamp"
        corners = [[0, 2, 0], [1, 2, 0], [1, 3, 0], [0, 3, 0]]
        [[quad]]
        material = "wall"
        corners = [[0, 0, 0], [1, 0, 0], [2, 1, 0], [0, 1, 0]]
        [[mesh]]
        boulder = 20
        material = "wall"
        "#,
    );
    let report = json(["info", scene.to_str().unwrap(), "--json"]);
    assert_eq!(
        (&report["spheres"], &report["quads"], &report["lights"]),
        (&2.into(), &1.into(), &1.into())
    );
    let counts =
        serde_json::json!({"diffuse": 2, "blend": 1, "mirror": 0, "glass": 1, "emitting": 1});
    assert_eq!(report["materials"], counts);
    let triangles = report["triangles"].as_u64().unwrap();
    assert!(
        triangles >= 22,
        "the boulder's and two of the trapezoid: {triangles}"
    );
    assert_eq!(report["objects"], 5);
    let right = report["bounds"][1][0].as_f64().unwrap();
    assert!((2.5..2.500001).contains(&right), "{right}");
    assert!(report["tree"]["references"].as_u64() >= Some(triangles));
    // 36 bytes of vertices and 4 of a slot each.
    assert!(report["memory"]["primitives"].as_u64() >= Some(40 * triangles));
    assert!(report["load_seconds"].is_number() && report["build_seconds"].is_number());

    let nothing = folder.write("nothing.toml", "background = [1, 1, 1]\n");
    let report = json(["info", nothing.to_str().unwrap(), "--json"]);
    assert_eq!(
        (&report["bounds"], &report["tree"], &report["triangles"]),
        (&Value::Null, &Value::Null, &0.into())
    );

    let table = ok(["info", scene.to_str().unwrap()]);
    assert!(
        table.contains("2 diffuse, 1 blend, 0 mirror, 1 glass; 1 emitting"),
        "{table}"
    );
    let columns = table.lines().map(|line| {
        let label = line.find("  ").expect("a gap");
        label + line[label..].find(|c| c != ' ').expect("a value")
    });
    assert_eq!(
        columns.collect::<std::collections::BTreeSet<_>>().len(),
        1,
        "{table}"
    );
}

#[test]
fn the_report_tells_what_is_lost_and_where_the_time_goes() {
    let options = ["--size", "64x32", "--spp", "1024", "--json", "--depth"];
    let report = |depth: &str| {
        json(
            ["render", "sphere-mirror"]
                .iter()
                .chain(&options)
                .chain(&[depth]),
        )
    };
    let shallow = report("2");
    let lost = &shallow["lost_light"];
    assert_eq!(lost["roulette"], 0.0);
    let share = lost["depth"]["share"]
        .as_f64()
        .expect("paths were followed");
    let error = lost["depth"]["error"].as_f64().expect("on many tiles");
    assert!(
        (0.05..0.9).contains(&share) && error > 0.0 && error < 0.5 * share,
        "{lost}"
    );
    assert!(lost["enough_depth"].as_u64() > Some(2), "{lost}");
    let times = shallow["times"].as_object().expect("times");
    for (stage, seconds) in times {
        // Nothing is shown.
        assert!(
            seconds.as_f64() > Some(0.0) || stage == "display",
            "{stage}: {times:?}"
        );
    }
    assert_eq!(times.len(), 10);
    let unlimited = report("unlimited");
    assert_eq!(unlimited["lost_light"]["depth"]["share"], 0.0);
    assert_eq!(
        shallow["left_out"],
        serde_json::json!(["tree", "light-choice"])
    );
}

#[test]
fn the_full_model_gives_the_same_picture() {
    let folder = Folder::new();
    let [planned, full] = ["a.exr", "b.exr"].map(|name| folder.path(name));
    let options = "--size 20x16 --spp 4 --method nee --depth 2";
    render("sphere-mirror", options, &planned);
    let report = render("sphere-mirror", &format!("{options} --full-model"), &full);
    assert_eq!(report["left_out"], serde_json::json!([]));
    assert_eq!(report["accel"], "bvh");
    let [planned, full] = [planned, full].map(|path| read(&path).unwrap());
    assert!(crate::bits(&planned) == crate::bits(&full));
}

#[test]
fn info_tells_the_plan_and_what_it_saves() {
    let report = json(["info", "cornell-box", "--json"]);
    let plan = &report["plan"];
    assert_eq!(plan["left_out"], serde_json::json!(["light-choice"]));
    let savings = &plan["savings"];
    assert!(savings["full_ms"].as_f64() > Some(0.0), "{savings}");
    let parts = savings["parts"].as_array().expect("parts");
    assert_eq!(parts.len(), 1);
    assert!(
        parts
            .iter()
            .all(|part| part[1]["error"].as_f64() >= Some(0.0))
    );
    assert_eq!(report["light_kinds"]["rectangles"], 1);
    let table = ok(["info", "cornell-box"]);
    for words in ["without choice of light", "ms per sample of every pixel"] {
        assert!(table.contains(words), "{table}");
    }
}

#[test]
fn compare_measures_pictures() {
    let folder = Folder::new();
    let path = |name: &str| folder.path(name).to_str().unwrap().to_owned();
    render(
        "cornell-box",
        "--size 16x16 --spp 4",
        Path::new(&path("a.exr")),
    );
    render(
        "cornell-box",
        "--size 16x16 --spp 4 --seed 1",
        Path::new(&path("b.exr")),
    );
    render(
        "cornell-box",
        "--size 16x8 --spp 1",
        Path::new(&path("c.exr")),
    );
    let same = json(["compare", &path("a.exr"), &path("a.exr"), "--json"]);
    assert_eq!((&same["relMSE"], &same["rmse"]), (&0.0.into(), &0.0.into()));
    assert_eq!(same["mean_ratio"], serde_json::json!([1.0, 1.0, 1.0]));

    let report = json(["compare", &path("a.exr"), &path("b.exr"), "--json"]);
    let [a, b] = ["a.exr", "b.exr"].map(|name| read(Path::new(&path(name))).unwrap());
    let expected = a.pixels.iter().zip(&b.pixels).map(|(x, r)| {
        let (x, r) = (x.as_dvec3(), r.as_dvec3());
        ((x - r) * (x - r) / (r * r + 0.01)).element_sum()
    });
    let expected = expected.sum::<f64>() / (3.0 * 256.0);
    let measured = report["relMSE"].as_f64().unwrap();
    assert!(
        (measured / expected - 1.0).abs() < 1e-12 && measured > 0.0,
        "{measured} {expected}"
    );
    assert!(report["worst_pixel"][1].as_u64() < Some(16));
    assert_eq!(
        ok(["compare", &path("a.exr"), &path("b.exr")])
            .lines()
            .count(),
        4
    );

    for (reference, expected) in [
        ("c.exr", "render both at one size"),
        ("none.exr", "none.exr: no such file"),
    ] {
        let result = run(["compare", &path("a.exr"), &path(reference)]);
        assert_eq!(result.status.code(), Some(1));
        let error = stderr(&result);
        assert!(
            error.starts_with("error: ") && error.contains(expected) && error.lines().count() == 1,
            "{error}"
        );
    }
}
