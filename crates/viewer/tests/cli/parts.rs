//! `lightbox render --part` and `lightbox merge`.

use std::path::{Path, PathBuf};

use serde_json::Value;

use crate::{Folder, TRIANGLE, json, ok, render, run, stderr};

/// Merges parts, in this order.
fn merge(parts: &[&Path], output: &Path) -> Value {
    let words = ["merge", "--json", "-o"].map(Path::new);
    json(words.iter().chain([&output]).chain(parts))
}

/// The one line with which words are refused.
fn refusal<S: AsRef<std::ffi::OsStr>>(words: impl IntoIterator<Item = S>) -> String {
    let output = run(words);
    let error = stderr(&output);
    assert_eq!(output.status.code(), Some(1), "{error}");
    assert!(
        error.starts_with("error: ") && error.lines().count() == 1,
        "{error}"
    );
    error
}

#[test]
fn parts_merge_to_the_file_of_one_run_whatever_the_split() {
    let folder = Folder::new();
    let options = "--size 40x23 --filter mitchell --seed 5 --exposure 0.5 --tone filmic";
    let parts: Vec<PathBuf> = [(0, 3), (3, 4), (4, 11), (11, 16)]
        .iter()
        .map(|(start, end)| {
            let path = folder.path(&format!("{start}.part"));
            let slice = format!(
                "{options} --samples {start}..{end} --part --threads {}",
                start % 3 + 1
            );
            let report = render("cornell-box", &slice, &path);
            assert_eq!(
                (&report["first_sample"], &report["spp"], &report["paths"]),
                (
                    &(*start).into(),
                    &(end - start).into(),
                    &((end - start) * 40 * 23).into()
                )
            );
            path
        })
        .collect();
    let [a, b, c, d] = [0, 1, 2, 3].map(|i| parts[i].as_path());
    let (bd, ac) = (folder.path("bd.part"), folder.path("ac.part"));
    merge(&[d, b], &bd);
    merge(&[a, c], &ac);
    for kind in ["exr", "png"] {
        let one = folder.path(&format!("one.{kind}"));
        let whole = render("cornell-box", &format!("{options} --spp 16"), &one);
        for (i, parts) in [vec![a, b, c, d], vec![c, d, a, b], vec![&bd, &ac]]
            .iter()
            .enumerate()
        {
            let merged = folder.path(&format!("{i}.{kind}"));
            let report = merge(parts, &merged);
            for figure in [
                "width",
                "height",
                "spp",
                "paths",
                "rays",
                "noise",
                "invalid_samples",
            ] {
                assert_eq!(report[figure], whole[figure], "{figure}");
            }
            assert!(
                std::fs::read(&merged).unwrap() == std::fs::read(&one).unwrap(),
                "{kind} of split {i}"
            );
        }
    }
    let line = ok([
        Path::new("merge"),
        &bd,
        &ac,
        Path::new("-o"),
        &folder.path("a.png"),
    ]);
    assert!(
        line.contains("40x23, 16 spp of 2 parts") && line.lines().count() == 1,
        "{line}"
    );
    // Nothing written aside is left.
    assert!(
        folder.files().iter().all(|name| !name.starts_with('.')),
        "{:?}",
        folder.files()
    );
}

#[test]
fn parts_that_do_not_make_a_picture_are_told_by_name() {
    let folder = Folder::new();
    let part = |name: &str, options: &str| {
        let path = folder.path(name);
        render(
            "cornell-box",
            &format!("--size 16x16 --part {options}"),
            &path,
        );
        path
    };
    let first = part("first.part", "--samples 0..2");
    let late = part("late.part", "--samples 3..4");
    let next = part("next.part", "--samples 2..3");
    let twice = part("twice.part", "--samples 1..3");
    let foreign = part("foreign.part", "--samples 2..4 --seed 1");
    let output = folder.path("a.png");
    let short = folder.path("short.part");
    let bytes = std::fs::read(&next).unwrap();
    std::fs::write(&short, &bytes[..bytes.len() - 5]).unwrap();
    let damaged = folder.path("damaged.part");
    let mut bad = bytes.clone();
    bad[bytes.len() - 300] ^= 4;
    std::fs::write(&damaged, bad).unwrap();
    let junk = folder.write("junk.part", "not one of ours");
    let absent = folder.path("absent.part");
    for (parts, expected) in [
        (
            vec![&first, &late],
            "late.part: samples 2..3 are missing before it",
        ),
        (vec![&late], "late.part: samples 0..3 are missing before it"),
        (
            vec![&first, &twice],
            "twice.part: holds samples 1..2, as does ",
        ),
        (
            vec![&first, &first],
            "first.part: holds samples 0..2, as does ",
        ),
        (
            vec![&first, &foreign],
            "foreign.part: is of another picture than ",
        ),
        (vec![&first, &foreign], "(seed 1 instead of 0)"),
        (vec![&first, &short], "short.part: is cut short"),
        (vec![&first, &damaged], "damaged.part: is damaged"),
        (vec![&first, &junk], "junk.part: is not a part"),
        (vec![&first, &absent], "absent.part: no such file"),
    ] {
        let words = ["merge", "-o", output.to_str().unwrap()];
        let words = words
            .into_iter()
            .chain(parts.iter().map(|p| p.to_str().unwrap()));
        let error = refusal(words);
        assert!(error.contains(expected), "{expected}: {error}");
    }
    assert!(!output.exists());
    let error = refusal(["merge", "-o", "a.jpg", first.to_str().unwrap()]);
    assert!(error.contains("a.jpg: unknown kind of file"), "{error}");
    for (words, expected) in [
        (
            "render no-such -o a.png --part",
            "a.png: a part holds samples",
        ),
        ("render no-such -o a.part", "a.part: give --part"),
        (
            "render no-such -o a.png --checkpoint a.png",
            "a.png: a part holds samples",
        ),
    ] {
        let error = refusal(words.split(' '));
        assert!(error.contains(expected), "{error}");
    }
}

#[test]
fn a_part_knows_what_was_in_the_files_of_its_scene() {
    let folder = Folder::new();
    let scene = folder.write("mesh.obj", TRIANGLE);
    let [a, b] = ["a.part", "b.part"].map(|name| folder.path(name));
    let scene = scene.to_str().unwrap();
    render(scene, "--size 16x16 --samples 0..1 --part", &a);
    folder.write("mesh.obj", &TRIANGLE.replace("v 0 1 0", "v 0.1 1 0"));
    render(scene, "--size 16x16 --samples 1..2 --part", &b);
    let output = folder.path("a.exr");
    let error = refusal([Path::new("merge"), &a, &b, Path::new("-o"), &output]);
    assert!(error.contains("b.part: is of another picture"), "{error}");
    // A part opens as the scene that is in it.
    let report = render(a.to_str().unwrap(), "--spp 1", &output);
    assert_eq!((&report["width"], &report["spp"]), (&16.into(), &1.into()));
}
