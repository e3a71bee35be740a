//! `lightbox submit`, without Slurm: its scripts run by hand, and a stand-in for `sbatch`. With
//! Slurm: `tests/slurm/run.sh`.

use std::fs::{self, Permissions};
use std::os::unix::fs::PermissionsExt as _;
use std::path::Path;
use std::process::{Command, Output};

use lightbox_core::part::read_head;

use crate::{Folder, TRIANGLE, lightbox, ok, stderr, stdout};

/// Submits from a folder, and with the programs that are in it.
fn submit(folder: &Folder, scene: &str, options: &str, output: &str) -> Output {
    lightbox()
        .args(["submit", scene])
        .args(options.split_whitespace())
        .args(["-o", output])
        .current_dir(folder.0.path())
        .env("PATH", folder.0.path())
        .output()
        .expect("the binary starts")
}

/// The one line of a refusal.
fn refusal(output: &Output) -> String {
    let error = stderr(output);
    assert_eq!(output.status.code(), Some(1), "{error}");
    assert!(
        error.starts_with("error: ") && error.lines().count() == 1,
        "{error}"
    );
    assert_eq!(stdout(output), "");
    error
}

/// Runs a script as a node would; returns what goes to its log.
fn bash(script: &Path, slice: u64) -> String {
    let output = Command::new("bash")
        .arg(script)
        .env("SLURM_ARRAY_TASK_ID", slice.to_string())
        .current_dir("/")
        .output()
        .expect("bash");
    assert!(output.status.success(), "{}", stderr(&output));
    stdout(&output)
}

/// A stand-in for `sbatch`, which notes what it is given.
fn sbatch(folder: &Folder, answer: &str) {
    let text = format!("#!/bin/sh\necho \"$@\" >> \"${{0%/*}}/calls\"\n{answer}\n");
    let path = folder.write("sbatch", &text);
    fs::set_permissions(path, Permissions::from_mode(0o755)).expect("permissions");
}

#[test]
fn the_scripts_make_the_file_of_one_run() {
    let folder = Folder::new();
    // Whatever a shell, and sbatch, would make something of.
    let odd = "it's 50% \"of\" $HOME; #1 \\x";
    fs::create_dir(folder.path(odd)).unwrap();
    let mesh = format!("{odd}/a mesh's.obj");
    folder.write(&mesh, TRIANGLE);
    let saved = folder.path("saved.png");
    let tone = "--exposure=-1.5 --tone filmic";
    let words = format!("render cornell-box --size 16x12 --spp 1 {tone} -o");
    ok(words.split(' ').chain([saved.to_str().unwrap()]));
    let settings = "--size 20x13 --filter mitchell --seed 5 --depth 4 --method mis --accel brute \
                    --sampler independent --full-model --eye=1,2,5 --target=0.1,0.2,-0.3 --up=0,1,0.1 \
                    --fov 50";
    for (i, (scene, options)) in [
        (mesh.as_str(), format!("{settings} {tone}")),
        ("cornell-box", "--size 16x12".to_owned()),
        // The part of a saved picture has its tone, unless told otherwise.
        (
            saved.to_str().unwrap(),
            "--tone linear --exposure 0".to_owned(),
        ),
        (saved.to_str().unwrap(), String::new()),
    ]
    .into_iter()
    .enumerate()
    {
        for kind in ["png", "exr"] {
            let output = format!("{odd}/{i} {kind}.{kind}");
            let slices = format!("{options} --spp 8 --slices 3");
            let submitted = submit(&folder, scene, &slices, &output);
            let error = refusal(&submitted);
            assert!(
                error.contains("there is no sbatch here; by hand") && error.contains("afterok"),
                "{error}"
            );
            let output = folder.path(&output);
            let jobs = output.with_extension("slices");
            let array = jobs.join("array.sbatch");
            for slice in [2, 0, 1] {
                let log = bash(&array, slice);
                assert!(log.starts_with(&format!("slice {slice} on ")), "{log}");
            }
            // One that is requeued finds what it has done.
            assert!(bash(&array, 1).contains("3 spp (3 of them before)"));
            for (slice, samples) in [0..3, 3..6, 6..8].into_iter().enumerate() {
                let head = read_head(&jobs.join(format!("parts/{slice}.part"))).unwrap();
                assert_eq!(head.samples().collect::<Vec<_>>(), [samples]);
            }
            bash(&jobs.join("merge.sbatch"), 0);
            let whole = folder.path(&format!("whole.{kind}"));
            let words = format!("render {options} --spp 8 -o");
            // A picture's text names its scene.
            let scene = match scene {
                "cornell-box" => scene.to_owned(),
                file => folder.path(file).to_str().unwrap().to_owned(),
            };
            let words = words.split_whitespace();
            ok(words.chain([whole.to_str().unwrap(), &scene]));
            assert!(
                fs::read(&output).unwrap() == fs::read(&whole).unwrap(),
                "{kind} of {scene} {options}"
            );
        }
    }
}

#[test]
fn a_dry_run_prints_the_scripts_and_leaves_nothing() {
    let folder = Folder::new();
    let options = "--dry-run --slices 3 --spp 8 --threads 2 --every 5";
    let printed = submit(&folder, "cornell-box", options, "a 50%.png");
    assert_eq!(printed.status.code(), Some(0), "{}", stderr(&printed));
    let printed = stdout(&printed);
    for line in [
        "#SBATCH --job-name='a 50%'",
        "#SBATCH --array=0-2",
        "#SBATCH --cpus-per-task=2",
        "#SBATCH --requeue",
        "#SBATCH --open-mode=append",
        "#SBATCH --kill-on-invalid-dep=yes",
        "  --threads 2 --part --checkpoint \"$part\" -o \"$part\"",
    ] {
        assert!(printed.lines().any(|l| l == line), "{line}: {printed}");
    }
    let home = folder.path("a 50%.slices");
    let home = home.to_str().unwrap();
    for words in [
        format!("# {home}/array.sbatch\n#!/bin/bash\n"),
        format!("# {home}/merge.sbatch\n#!/bin/bash\n"),
        // To sbatch, % begins a pattern.
        format!(
            "#SBATCH --output='{}/logs/%a.log'\n",
            home.replace('%', "%%")
        ),
        " --every 5 \\\n".to_owned(),
    ] {
        assert!(printed.contains(&words), "{words}: {printed}");
    }
    assert!(folder.files().is_empty(), "{:?}", folder.files());
}

#[test]
fn the_merge_waits_for_the_array_and_the_report_tells_both_jobs() {
    let folder = Folder::new();
    sbatch(
        &folder,
        "case $* in *merge.sbatch) echo 42;; *) echo '41;cluster';; esac",
    );
    let options = "--size 8x8 --slices 2 --spp 5";
    let done = submit(&folder, "cornell-box", options, "a.exr");
    assert_eq!(done.status.code(), Some(0), "{}", stderr(&done));
    let home = folder.path("a.slices");
    let home = home.to_str().unwrap();
    assert_eq!(
        fs::read_to_string(folder.path("calls")).unwrap(),
        format!(
            "--parsable {home}/array.sbatch\n--parsable --dependency=afterok:41 {home}/merge.sbatch\n"
        )
    );
    let report = stdout(&done);
    for words in [
        "job 41: 2 slices of 2 or 3 samples per pixel",
        "job 42: when all are rendered",
        "squeue -j 41,42",
        "scancel 41 42",
        home,
    ] {
        assert!(report.contains(words), "{words}: {report}");
    }
    // Again: the same scripts, and what is rendered is kept; not so an edited one.
    let again = submit(&folder, "cornell-box", options, "a.exr");
    assert_eq!(again.status.code(), Some(0), "{}", stderr(&again));
    let array = folder.path("a.slices/array.sbatch");
    fs::write(&array, "#SBATCH --time=5\n").unwrap();
    let error = refusal(&submit(&folder, "cornell-box", options, "a.exr"));
    assert!(
        error.contains("array.sbatch: is of another picture, or edited"),
        "{error}"
    );
    assert_eq!(fs::read_to_string(&array).unwrap(), "#SBATCH --time=5\n");
}

#[test]
fn what_sbatch_refuses_is_told_in_its_words() {
    for (answer, expected) in [
        (
            "echo 'sbatch: first' >&2; echo 'sbatch: error: no such partition' >&2; exit 1",
            vec!["not submitted: sbatch: error: no such partition; by hand"],
        ),
        (
            "case $* in *merge.sbatch) echo no room >&2; exit 1;; *) echo 41;; esac",
            vec![
                "job 41 renders, but the merge is not submitted: no room",
                "--dependency=afterok:41",
                "scancel 41",
            ],
        ),
        ("echo hello", vec!["sbatch answers \"hello\""]),
    ] {
        let folder = Folder::new();
        sbatch(&folder, answer);
        let options = "--size 8x8 --slices 2 --spp 5";
        let error = refusal(&submit(&folder, "cornell-box", options, "a.exr"));
        for words in expected {
            assert!(error.contains(words), "{words}: {error}");
        }
    }
}

#[test]
fn what_cannot_be_is_refused_before_anything_is_written() {
    let folder = Folder::new();
    for (scene, output, options, expected) in [
        (
            "cornell-box",
            "a.png",
            "--spp 5 --slices 6",
            "6 slices of 5 samples: some would be empty; use --slices 5 or fewer",
        ),
        ("cornell-box", "a.png", "--slices 257", "257 slices of 256"),
        (
            "cornell-box",
            "a.jpg",
            "--slices 2",
            "name it *.png or *.exr",
        ),
        (
            "no-such",
            "no such/a.png",
            "--slices 2",
            "cannot be written",
        ),
        (
            "cornel-box",
            "a.png",
            "--slices 2",
            "did you mean \"cornell-box\"?",
        ),
        (
            "cornell-box",
            "a\nb.png",
            "--slices 2",
            "a\\nb.png\": no name for a script",
        ),
        (
            "cornell-box",
            "a.png",
            "--slices 2 --eye 278,273,0",
            "eye and target are the same point",
        ),
    ] {
        let error = refusal(&submit(&folder, scene, options, output));
        assert!(error.contains(expected), "{expected}: {error}");
    }
    for (options, expected) in [
        ("", "--slices"),
        ("--slices 0", "from 1 to"),
        // More than bash can count.
        (
            "--slices 2 --spp 9223372036854775808",
            "use a whole number from 1 to 9223372036854775807",
        ),
        ("--slices 2 --threads 0", "--threads"),
        ("--slices 2 --every 0", "positive"),
    ] {
        let result = submit(&folder, "no-such", options, "a.png");
        assert_eq!(result.status.code(), Some(2), "{options}");
        assert!(stderr(&result).contains(expected), "{}", stderr(&result));
    }
    assert!(folder.files().is_empty(), "{:?}", folder.files());
}
