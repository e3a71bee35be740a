//! The commands without a window. In: arguments. Out: files, one report for standard output, and
//! an error of one line. Nothing here knows egui.

pub mod advise;
mod checkpoint;
pub mod compare;
pub mod info;
pub mod lab;
pub mod merge;
pub mod race;
pub mod render;
pub mod submit;

use std::io::{ErrorKind, Write as _};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use lightbox_core::color::ToneMap;
use lightbox_core::film::InvalidSample;
use lightbox_core::scene::{BUILTIN, BUILTIN_LAB, Watcher};
use lightbox_core::{Scene, SceneDesc, suggest};
use serde::Serialize;

use crate::args::Command;
use crate::spent::Opening;

/// Exit status of a lab in which a case fails.
const CASE_FAILED: u8 = 1;

/// Exit status after Ctrl-C, by the custom of shells.
pub const INTERRUPTED: u8 = 130;

/// What a command that did its work leaves behind.
#[derive(Debug, Default)]
pub struct Outcome {
    /// For standard output; whole lines.
    pub report: String,
    /// Exit status: 0 unless the command has something else to tell.
    pub status: u8,
}

impl Outcome {
    fn done(report: String) -> Self {
        Self { report, status: 0 }
    }
}

/// What has become of writing to standard output; the error is one line.
pub fn written(result: std::io::Result<()>) -> Result<(), String> {
    match result {
        // Who reads no further has read what was wanted.
        Err(e) if e.kind() != ErrorKind::BrokenPipe => {
            Err(format!("standard output: cannot be written ({e})"))
        }
        _ => Ok(()),
    }
}

/// Runs a command; the error is one line.
pub fn run(command: &Command) -> Result<Outcome, String> {
    match command {
        Command::Render(args) => render::run(args),
        Command::Submit(args) => submit::run(args).map(Outcome::done),
        Command::Merge(args) => merge::run(args).map(Outcome::done),
        Command::Info(args) => info::run(args).map(Outcome::done),
        Command::Compare(args) => compare::run(args).map(Outcome::done),
        Command::Lab(args) => lab::run(args),
        Command::Race(args) => race::run(args),
        Command::Advise(args) => advise::run(args),
    }
}

const BUILTIN_PREFIX: &str = "builtin:";

/// The built-in scenes as they may be named on the command line.
pub fn builtin_names() -> Vec<&'static str> {
    BUILTIN.iter().map(|name| bare(name)).collect()
}

fn bare(name: &str) -> &str {
    let name = name.strip_prefix(BUILTIN_PREFIX).unwrap_or(name);
    name.strip_suffix(".toml").unwrap_or(name)
}

/// The scene that a user names: a file, or else a built-in scene with or without prefix and
/// extension. The error is one line.
pub fn scene_path(given: &Path) -> Result<PathBuf, String> {
    let name = given.to_string_lossy();
    let exists = given.exists();
    if exists && !given.is_dir() {
        return Ok(given.to_owned());
    }
    let mut builtin = BUILTIN.iter().chain(BUILTIN_LAB);
    if let Some(path) = builtin.find(|path| bare(path) == bare(&name)) {
        return Ok(path.into());
    }
    if exists {
        return Ok(given.to_owned()); // A folder: loading it tells what to name instead.
    }
    Err(format!(
        "{name}: no such file or built-in scene{}",
        suggest::among(bare(&name), &builtin_names())
    ))
}

/// A scene ready to render, and what it took.
struct Opened {
    scene: Arc<Scene>,
    /// How it wants to be shown.
    tone: ToneMap,
    /// Reading and checking files, seconds.
    load_seconds: f64,
    /// Building the accelerator and what hangs on it, seconds.
    build_seconds: f64,
}

/// Loads and builds the scene that a user names, as changed by `edit`; the error is one line.
fn open(
    given: &Path,
    edit: impl FnOnce(&mut SceneDesc) -> Result<(), String>,
    watcher: Watcher<'_>,
) -> Result<Opened, String> {
    let path = scene_path(given)?;
    let opening = Opening::start();
    let (source, tone) = crate::saved::load(&path)?;
    let mut desc = source.desc.clone();
    edit(&mut desc)?;
    let observe = |phase| {
        opening.observe(phase);
        watcher(phase)
    };
    let scene = source
        .build_edited(desc, &observe)
        .map_err(|e| e.to_string())?;
    let [load_seconds, build_seconds] = opening.seconds();
    Ok(Opened {
        scene: Arc::new(scene),
        tone: tone.unwrap_or_default(),
        load_seconds,
        build_seconds,
    })
}

/// As many worker threads as asked for, or one for each processor; the error is one line.
fn threads(count: Option<u16>) -> Result<rayon::ThreadPool, String> {
    rayon::ThreadPoolBuilder::new()
        .num_threads(count.map_or(0, usize::from))
        .thread_name(|i| format!("lightbox-trace-{i}"))
        .build()
        .map_err(|e| format!("cannot start worker threads ({e})"))
}

/// A flag that Ctrl-C sets; a second Ctrl-C ends the process.
fn interrupt_flag() -> Result<Arc<AtomicBool>, String> {
    let interrupted = Arc::new(AtomicBool::new(false));
    let flag = interrupted.clone();
    ctrlc::set_handler(move || {
        if flag.swap(true, Ordering::Relaxed) {
            #[expect(
                clippy::disallowed_methods,
                reason = "the second Ctrl-C is not to wait for main"
            )]
            std::process::exit(INTERRUPTED.into());
        }
    })
    .map_err(|e| format!("cannot listen for Ctrl-C ({e})"))?;
    Ok(interrupted)
}

/// Tells on standard error what was odd about a scene.
fn print_warnings(scene: &Scene) {
    for warning in scene.warnings() {
        print_warning(&warning.to_string());
    }
}

fn print_warning(line: &str) {
    // If nobody listens, nobody is missed.
    let _ = writeln!(std::io::stderr(), "warning: {line}");
}

/// Tells of samples that were left out: how many, and the places of some.
fn print_invalid(count: u64, places: &[InvalidSample]) {
    if let Some(InvalidSample { pixel, sample }) = places.first() {
        let [x, y] = pixel;
        print_warning(&format!(
            "{count} samples are not finite and were left out, such as sample {sample} of pixel {x},{y}"
        ));
    }
}

/// One JSON object on a line of its own.
fn json_line(report: &impl Serialize) -> Result<String, String> {
    serde_json::to_string(report)
        .map(|line| line + "\n")
        .map_err(|e| format!("the report cannot be written ({e})"))
}

/// Rows of a label and a value, aligned.
fn table(rows: &[(&str, String)]) -> String {
    let width = rows.iter().map(|(label, _)| label.len()).max().unwrap_or(0);
    rows.iter()
        .map(|(label, value)| format!("{label:width$}  {value}\n"))
        .collect()
}
