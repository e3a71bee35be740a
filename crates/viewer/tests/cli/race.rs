//! `lightbox race`: its files, its table, and what it refuses.

use std::path::Path;

use lightbox_core::image_io::read;
use serde_json::Value;

use crate::{Folder, ok, render, run, stderr};

fn parse(path: &Path) -> Value {
    let text = std::fs::read_to_string(path).expect("a file");
    serde_json::from_str(&text).expect("JSON")
}

#[test]
fn a_race_leaves_chart_table_and_maps() {
    let folder = Folder::new();
    let out = folder.path("race");
    let words = "race cornell-box --size 24x24 --methods naive,mis --seconds 0.15 --seeds 2 -o";
    let table = ok(words.split(' ').chain([out.to_str().unwrap()]));
    for word in ["contestant", "efficiency", "slope", "naive", "mis", "p = "] {
        assert!(table.contains(word), "{table}");
    }
    let report = parse(&out.join("race.json"));
    assert_eq!(report["scene"], "builtin:cornell-box.toml");
    assert_eq!(report["interrupted"], false);
    assert!(report["machine"]["threads"].as_u64() >= Some(1));
    assert!(report["references"][0]["relMSE"].as_f64() > Some(0.0));
    let contestants = report["contestants"].as_array().unwrap();
    assert_eq!(contestants.len(), 2);
    let mut points = 0;
    for contestant in contestants {
        assert!(
            contestant["efficiency"].as_f64() > Some(0.0),
            "{contestant}"
        );
        let runs = contestant["runs"].as_array().unwrap();
        assert_eq!(runs.len(), 2);
        for run in runs {
            let run = run["points"].as_array().unwrap();
            points += run.len();
            assert!(run.len() > 2 && run.last().unwrap()["relMSE"].as_f64() > Some(0.0));
        }
    }
    let agreement = &report["agreement"][0];
    assert!(
        agreement["headline"]
            .as_str()
            .unwrap()
            .starts_with("naive and mis "),
        "{agreement}"
    );
    let csv = std::fs::read_to_string(out.join("chart.csv")).unwrap();
    assert_eq!(csv.lines().count(), points + 1, "{csv}");
    let svg = std::fs::read_to_string(out.join("chart.svg")).unwrap();
    for part in [
        "<svg",
        "seconds of tracing",
        "relative error",
        "naive",
        "mis",
        "1/√N",
    ] {
        assert!(svg.contains(part), "{part} is not in the chart");
    }
    let map = read(&out.join(agreement["map"].as_str().unwrap())).unwrap();
    assert_eq!((map.width, map.height), (24, 24));
}

#[test]
fn several_scenes_and_a_given_reference() {
    let folder = Folder::new();
    let words = "race cornell-box sphere-mirror --size 8x8 --methods mis --samplers sobol,independent --seconds 0.02 --seeds 1 -o";
    ok(words
        .split(' ')
        .chain([folder.path("all").to_str().unwrap()]));
    for scene in ["cornell-box", "sphere-mirror"] {
        let report = parse(&folder.path("all").join(scene).join("race.json"));
        let labels: Vec<&str> = report["contestants"]
            .as_array()
            .unwrap()
            .iter()
            .map(|c| c["label"].as_str().unwrap())
            .collect();
        assert_eq!(labels, ["mis sobol", "mis independent"]);
        assert_eq!(report["agreement"], Value::Array(Vec::new()));
    }
    let reference = folder.path("reference.exr");
    render("cornell-box", "--size 8x8 --spp 64 --seed 9", &reference);
    let words = "race cornell-box --size 8x8 --methods mis --seconds 0.02 --seeds 1 --reference";
    let out = folder.path("given");
    let paths = [&reference, &out].map(|path| path.to_str().unwrap());
    ok(words.split(' ').chain([paths[0], "-o", paths[1]]));
    let report = parse(&out.join("race.json"));
    assert_eq!(report["references"][0]["origin"]["file"], paths[0]);
}

#[test]
fn impossible_races_are_refused_before_they_begin() {
    let folder = Folder::new();
    let reference = folder.path("reference.exr");
    render("cornell-box", "--size 8x8 --spp 1", &reference);
    let reference = reference.to_str().unwrap();
    let dark = folder.write(
        "dark.toml",
        "[[material]]\nname = \"a\"\n[[sphere]]\nmaterial = \"a\"\ncenter = [0, 0, -5]\nradius = 1\n",
    );
    let dark = dark.to_str().unwrap();
    let file = folder.write("file", "");
    let inside_file = file.join("race");
    let out = folder.path("out");
    let (out, inside_file) = (out.to_str().unwrap(), inside_file.to_str().unwrap());
    let (file_name, box_) = (file.to_str().unwrap(), "cornell-box");
    for (words, expected) in [
        (vec![box_, "-o", out, "--seconds", "0"], "use more than 0"),
        (vec![box_, "-o", out, "--seconds", "-1"], "use more than 0"),
        (vec![box_, "-o", out, "--seeds", "0"], "use 1 or more"),
        (
            vec![box_, "-o", out, "--methods", "mis,nea"],
            "did you mean \"nee\"?",
        ),
        (vec![box_, "-o", out, "--filters", "box:0"], "filter radius"),
        (
            vec![box_, "-o", out, "--reference", reference],
            "use --size 8x8",
        ),
        (
            vec![box_, "sphere-mirror", "-o", out, "--reference", reference],
            "one reference fits one scene",
        ),
        (vec![box_, box_, "-o", out], "race them apart"),
        (vec![box_, "-o", file_name], "is a file; choose a folder"),
        (vec![box_, "-o", inside_file], "cannot be written"),
        (vec![dark, "-o", out], "nothing emits light"),
        (
            vec!["cornel-box", "-o", out],
            "did you mean \"cornell-box\"?",
        ),
    ] {
        let result = run(["race"].into_iter().chain(words.clone()));
        let error = stderr(&result);
        let lines: Vec<&str> = error
            .lines()
            .filter(|l| !l.starts_with("warning: "))
            .collect();
        assert_eq!(result.status.code(), Some(1), "{words:?}: {error}");
        assert!(
            lines.len() == 1 && lines[0].starts_with("error: ") && error.contains(expected),
            "{words:?}: {error}"
        );
        assert!(!Path::new(out).join("race.json").exists());
    }
}
