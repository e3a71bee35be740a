//! `lightbox submit`: a render in slices on a Slurm cluster. Two plain scripts do the work, a job
//! array that renders the slices and a job that merges them once all are there; what is here
//! writes them and hands them to `sbatch`.

use std::fs;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};
use std::process::Command;

use lightbox_core::color::ToneMap;
use lightbox_core::{Scene, SceneDesc, image_io};

use super::{open, print_warnings, table};
use crate::args::SubmitArgs;
use crate::replay::{quoted, tone_words, words};

/// The scripts, and where they go.
struct Jobs {
    /// For scripts, parts and logs.
    folder: PathBuf,
    array: Script,
    merge: Script,
    /// Both jobs, for the report.
    summary: [String; 2],
}

struct Script {
    path: PathBuf,
    text: String,
}

/// Writes the scripts and submits them, or prints them only. The error is one line.
pub fn run(args: &SubmitArgs) -> Result<String, String> {
    image_io::check_writable(&args.output)?;
    let jobs = Jobs::new(args)?;
    if args.dry_run {
        let text = |Script { path, text }: &Script| format!("# {}\n{text}", path.display());
        return Ok(format!("{}\n{}", text(&jobs.array), text(&jobs.merge)));
    }
    jobs.write()?;
    jobs.submit()
}

/// A path that holds on every node, as a script can hold it. The error is one line.
fn absolute(path: &Path) -> Result<String, String> {
    let absolute = std::path::absolute(path)
        .map_err(|e| format!("{}: has no absolute path ({e})", path.display()))?;
    // A line break would end a line that begins with #SBATCH.
    let text = absolute.to_str().filter(|t| !t.contains(char::is_control));
    text.map(str::to_owned).ok_or_else(|| {
        format!("{absolute:?}: no name for a script; rename it in UTF-8 without control characters")
    })
}

impl Jobs {
    fn new(args: &SubmitArgs) -> Result<Self, String> {
        let output = absolute(&args.output)?;
        let given = super::scene_path(&args.scene)?;
        // Elsewhere than on disk, names are the same on every node.
        let scene = if given.exists() {
            PathBuf::from(absolute(&given)?)
        } else {
            given
        };
        let lightbox = std::env::current_exe()
            .map_err(|e| format!("the program's own file is unknown ({e})"))
            .and_then(|path| absolute(&path))?;
        // All of it is built, so that no node meets what could have been told here.
        let edit = |desc: &mut SceneDesc| args.settings.apply(args.spp, desc);
        let opened = open(&scene, edit, &lightbox_core::scene::unwatched)?;
        print_warnings(&opened.scene);
        let samples = opened.scene.desc().render.samples;
        let slices = args.slices;
        if slices > samples {
            return Err(format!(
                "{slices} slices of {samples} samples: some would be empty; use --slices {samples} or fewer, or a larger --spp"
            ));
        }
        let tone = args.settings.tone_map(opened.tone);
        let folder = Path::new(&output).with_extension("slices");
        let home = folder.to_string_lossy();
        let name = quoted(&crate::model::scene_name(Path::new(&output)));
        let each = match (samples / slices, samples % slices) {
            (each, 0) => each.to_string(),
            (each, _) => format!("{each} or {}", each + 1),
        };
        let log = |name: &str| {
            // To sbatch, % begins a pattern.
            quoted(&format!("{}/logs/{name}.log", home.replace('%', "%%")))
        };
        let head = |what: &str, log: &str| {
            format!(
                "#!/bin/bash\n# {what}\n#SBATCH --job-name={name}\n#SBATCH --output={log}\n\
                 #SBATCH --open-mode=append\n#SBATCH --requeue\n"
            )
        };
        let array = format!(
            "{}#SBATCH --array=0-{}\n#SBATCH --cpus-per-task={}\nset -eu\n\n{}",
            head(
                "Renders slices of a picture; one that is requeued goes on from its part.",
                &log("%a")
            ),
            slices - 1,
            args.threads,
            render(args, &lightbox, &opened.scene, tone, &home)
        );
        let merge = format!(
            "{}#SBATCH --kill-on-invalid-dep=yes\nset -eu\n\n\
             exec {} merge {}/parts/{{0..{}}}.part -o {}\n",
            head(
                &format!(
                    "Merges the slices, when all are rendered:\n# {}",
                    by_hand(&folder)
                ),
                &log("merge")
            ),
            quoted(&lightbox),
            quoted(&home),
            slices - 1,
            quoted(&output)
        );
        let [array, merge] = [("array", array), ("merge", merge)].map(|(name, text)| Script {
            path: folder.join(format!("{name}.sbatch")),
            text,
        });
        let tasks = if slices == 1 { "slice" } else { "slices" };
        Ok(Self {
            summary: [
                format!("{slices} {tasks} of {each} samples per pixel"),
                format!("when all are rendered, to {output}"),
            ],
            folder,
            array,
            merge,
        })
    }

    /// Writes the scripts. Where they are already, parts of the same picture may be too, and are
    /// gone on from; other scripts are somebody's work.
    fn write(&self) -> Result<(), String> {
        let scripts = [&self.array, &self.merge];
        for Script { path, text } in scripts {
            if fs::read(path).is_ok_and(|there| there != text.as_bytes()) {
                return Err(format!(
                    "{}: is of another picture, or edited; remove its folder, name another picture, or submit by hand: {}",
                    path.display(),
                    by_hand(&self.folder)
                ));
            }
        }
        let cannot_write = |path: &Path, e: std::io::Error| {
            format!(
                "{}: cannot be written ({e}); choose a folder that you may write to",
                path.display()
            )
        };
        for name in ["parts", "logs"] {
            let folder = self.folder.join(name);
            fs::create_dir_all(&folder).map_err(|e| cannot_write(&folder, e))?;
        }
        for Script { path, text } in scripts {
            fs::write(path, text).map_err(|e| cannot_write(path, e))?;
        }
        Ok(())
    }

    fn submit(&self) -> Result<String, String> {
        let folder = self.folder.display();
        let array = sbatch(&self.array.path, &[]).map_err(|problem| {
            format!(
                "{folder}: scripts are written, but not submitted: {problem}; by hand, on a machine of the cluster: {}",
                by_hand(&self.folder)
            )
        })?;
        let after = format!("--dependency=afterok:{array}");
        let merge = sbatch(&self.merge.path, &[&after]).map_err(|problem| {
            format!(
                "job {array} renders, but the merge is not submitted: {problem}; by hand: sbatch {after} {}, or end the job: scancel {array}",
                quoted(&self.merge.path.to_string_lossy())
            )
        })?;
        let [slices, result] = &self.summary;
        let logs = quoted(&self.folder.join("logs").to_string_lossy());
        Ok(table(&[
            ("render", format!("job {array}: {slices}")),
            ("merge", format!("job {merge}: {result}")),
            ("files", format!("{folder}: scripts, parts, logs")),
            (
                "watch",
                format!("squeue -j {array},{merge}; tail -n 1 {logs}/*.log"),
            ),
            ("cancel", format!("scancel {array} {merge}")),
        ]))
    }
}

/// The lines that render a task's slice.
fn render(args: &SubmitArgs, lightbox: &str, scene: &Scene, tone: ToneMap, home: &str) -> String {
    let samples = scene.desc().render.samples;
    let (each, rest) = (samples / args.slices, samples % args.slices);
    let mut options = words(scene.path(), scene.desc(), "--samples $start..$end");
    // Spelt out, as a saved picture may have a tone of its own.
    options += &tone_words(tone);
    if scene.desc().render.full_model {
        options += " --full-model"; // The picture's text holds it.
    }
    if let Some(seconds) = args.every {
        options += &format!(" --every {seconds}");
    }
    format!(
        "slice=$SLURM_ARRAY_TASK_ID\n\
         # {samples} samples in {} slices, of which the first {rest} have one more than the others.\n\
         start=$((slice * {each} + (slice < {rest} ? slice : {rest})))\n\
         end=$((start + {each} + (slice < {rest})))\n\
         part={}/parts/$slice.part\n\
         echo \"slice $slice on ${{SLURMD_NODENAME:-$HOSTNAME}}\"\n\n\
         exec {} {options} \\\n  --threads {} --part --checkpoint \"$part\" -o \"$part\"\n",
        args.slices,
        quoted(home),
        quoted(lightbox),
        args.threads
    )
}

/// The command that submits both scripts.
fn by_hand(folder: &Path) -> String {
    let [array, merge] = ["array", "merge"]
        .map(|name| quoted(&folder.join(format!("{name}.sbatch")).to_string_lossy()));
    format!("sbatch --dependency=afterok:$(sbatch --parsable {array}) {merge}")
}

/// Submits a script; returns the job's number. The error is a part of a line.
fn sbatch(script: &Path, options: &[&str]) -> Result<String, String> {
    let output = Command::new("sbatch")
        .arg("--parsable")
        .args(options)
        .arg(script)
        .output()
        .map_err(|e| match e.kind() {
            ErrorKind::NotFound => "there is no sbatch here".to_owned(),
            _ => format!("sbatch cannot be started ({e})"),
        })?;
    let last_line = |bytes: &[u8]| {
        let text = String::from_utf8_lossy(bytes);
        text.trim().lines().last().unwrap_or_default().to_owned()
    };
    let answer = last_line(&output.stdout);
    // The cluster's name may follow.
    let job = answer.split(';').next().unwrap_or_default();
    if output.status.success() && !job.is_empty() && job.bytes().all(|b| b.is_ascii_digit()) {
        return Ok(job.to_owned());
    }
    Err(match last_line(&output.stderr) {
        error if error.is_empty() => format!("sbatch answers \"{answer}\""),
        error => error,
    })
}
