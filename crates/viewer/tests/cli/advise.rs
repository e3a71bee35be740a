//! `lightbox advise`: what it recommends, whether that comes true, and what it refuses.

use serde_json::Value;

use crate::{Folder, ok, run, stderr};

fn advice(words: &str) -> Value {
    let words = format!("advise {words} --json");
    serde_json::from_str(&ok(words.split(' '))).expect("JSON")
}

#[test]
fn the_cheapest_way_to_an_error_is_found_and_checked() {
    let advice = advice("cornell-box --size 32x32 --error 0.2 --check");
    let stages = advice["stages"].as_array().unwrap();
    let names: Vec<&str> = stages
        .iter()
        .map(|s| s["setting"].as_str().unwrap())
        .collect();
    assert_eq!(names, ["method, sampler", "filter", "depth", "accelerator"]);
    // Running into the lamp by luck takes a hundred times as long as aiming at it.
    let method = stages[0]["chosen"].as_str().unwrap();
    assert!(!method.contains("naive"), "{method}");
    assert_eq!(stages[0]["tried"].as_array().unwrap().len(), 8);
    // One bounce is not enough for so closed a box.
    let depth: u32 = stages[2]["chosen"].as_str().unwrap().parse().unwrap();
    assert!((3..=16).contains(&depth), "{depth}");
    let command = advice["command"].as_str().unwrap();
    assert!(command.contains(&format!("--depth {depth} ")), "{command}");
    let outcome = &advice["outcome"];
    assert!(outcome["error"].as_f64() <= Some(0.2), "{outcome}");
    let [spp, foretold] = [&outcome["spp"], &advice["spp"][0]].map(|n| n.as_f64().unwrap());
    assert!(
        spp < 3.0 * foretold.max(16.0) && foretold < 3.0 * spp,
        "{spp} {foretold}"
    );
}

#[test]
fn the_best_for_some_seconds_is_found() {
    let advice = advice("cornell-box --size 32x32 --seconds 0.5");
    assert_eq!(advice["seconds"][0], 0.5);
    assert!(advice["error"][0].as_f64() < advice["error"][2].as_f64());
    assert_eq!(advice["outcome"], Value::Null);
    let method = advice["stages"][0]["chosen"].as_str().unwrap();
    assert!(!method.contains("naive"), "{method}");
}

#[test]
fn impossible_goals_are_refused() {
    let folder = Folder::new();
    let dark = folder.write(
        "dark.toml",
        "[[material]]\nname = \"a\"\n[[sphere]]\nmaterial = \"a\"\ncenter = [0, 0, -5]\nradius = 1\n",
    );
    let dark = format!("{} --error 0.1", dark.display());
    for (words, expected) in [
        ("cornell-box", "--error"),
        ("cornell-box --error 0", "ask for more than 0"),
        ("cornell-box --seconds -1", "ask for more than 0"),
        ("cornell-box --error 0.1 --seconds 1", "cannot be used with"),
        (dark.as_str(), "nothing emits light"),
    ] {
        let result = run(["advise"].into_iter().chain(words.split(' ')));
        let error = stderr(&result);
        assert_ne!(result.status.code(), Some(0), "{words}: {error}");
        assert!(error.contains(expected), "{words}: {error}");
    }
}
