//! The command line: what can be asked for.

mod settings;
mod values;

use std::ops::Range;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use clap::error::ErrorKind;
use clap::{CommandFactory as _, Parser, Subcommand};
use lightbox_core::suggest;

use crate::commands::{scene_path, written};
use crate::replay::quoted;
pub use settings::SettingsArgs;
use values::{count, depth, positive, samples, size};

// Headings of the help.
const STOP: &str = "Stop";
const SETTINGS: &str = "Settings (default: the scene's)";
const SLICES: &str = "Slices and sittings";

/// Open a scene or mesh in the viewer, or run a command without a window.
#[derive(Debug, Parser)]
#[command(name = "lightbox", version, args_conflicts_with_subcommands = true, after_help = builtin_scenes())]
pub struct Args {
    /// What to do; without it, the viewer opens.
    #[command(subcommand)]
    pub command: Option<Command>,
    /// What to open: a .toml scene, an .obj mesh, a saved picture or a built-in scene [default: a built-in scene]
    pub scene: Option<PathBuf>,
}

/// What can be done without a window.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// Render a scene to a PNG or EXR file
    Render(Box<RenderArgs>),
    /// Add up parts written by `render --part`: the bits of one run over all their samples
    Merge(MergeArgs),
    /// Render in slices on a Slurm cluster: write the scripts and submit them
    Submit(Box<SubmitArgs>),
    /// Show what a scene holds and what it costs
    Info(InfoArgs),
    /// Measure how far a picture is from a reference
    Compare(CompareArgs),
    /// Run the stability lab: where tracing methods fail, by the naive method and by lightbox
    Lab(LabArgs),
    /// Race methods against each other: error against time, and whether they agree
    Race(RaceArgs),
    /// Find the cheapest settings that reach an error, or the best ones for some seconds
    Advise(AdviseArgs),
}

/// Arguments of `lightbox advise`.
#[derive(Debug, clap::Args)]
#[command(after_help = builtin_scenes(), group(clap::ArgGroup::new("goal").required(true).args(["error", "seconds"])))]
pub struct AdviseArgs {
    /// A .toml scene, an .obj mesh, a picture saved by lightbox, or a built-in scene
    pub scene: PathBuf,
    /// Relative error to reach, such as 0.01 for one per cent
    #[arg(long, value_name = "E", allow_negative_numbers = true)]
    pub error: Option<f64>,
    /// Seconds of tracing to spend
    #[arg(long, value_name = "S", allow_negative_numbers = true)]
    pub seconds: Option<f64>,
    /// Render as advised, and tell what came of it
    #[arg(long)]
    pub check: bool,
    /// Print one JSON object
    #[arg(long)]
    pub json: bool,
    /// Width and height in pixels
    #[arg(long, value_name = "WxH", value_parser = size, allow_hyphen_values = true, help_heading = SETTINGS)]
    pub size: Option<[u32; 2]>,
    /// Worker threads [default: all]
    #[arg(long, value_name = "T", value_parser = clap::value_parser!(u16).range(1..), allow_negative_numbers = true)]
    pub threads: Option<u16>,
}

/// Arguments of `lightbox render`. It stops at whichever of `--spp`, `--seconds` and `--noise` is
/// reached first.
#[derive(Debug, clap::Args)]
#[command(after_help = builtin_scenes())]
pub struct RenderArgs {
    /// A .toml scene, an .obj mesh, a picture or part saved by lightbox, or a built-in scene
    pub scene: PathBuf,
    /// File to write: *.png (as shown) or *.exr (as measured), *.part with --part; optional with --json
    #[arg(short, long, value_name = "FILE", required_unless_present = "json")]
    pub output: Option<PathBuf>,

    /// Stop at N samples per pixel [default: the scene's, unless --seconds or --noise is given]
    #[arg(long, value_name = "N", value_parser = count, allow_negative_numbers = true, help_heading = STOP)]
    pub spp: Option<u64>,
    /// Stop after S seconds of tracing, to the nearest whole sample per pixel, at least one
    #[arg(long, value_name = "S", value_parser = positive, allow_negative_numbers = true, help_heading = STOP)]
    pub seconds: Option<f64>,
    /// Stop when the estimated relative noise is at most R, from 16 samples per pixel on
    #[arg(long, value_name = "R", value_parser = positive, allow_negative_numbers = true, help_heading = STOP)]
    pub noise: Option<f64>,

    /// What to render otherwise than the scene wants.
    #[command(flatten)]
    pub settings: SettingsArgs,

    /// Write the sums of the samples, for `lightbox merge`, instead of a picture
    #[arg(long, requires = "output", help_heading = SLICES)]
    pub part: bool,
    /// Render only the samples from index A up to B, without B
    #[arg(long, value_name = "A..B", value_parser = samples, allow_hyphen_values = true, requires = "part",
          conflicts_with_all = ["spp", "seconds", "noise"], help_heading = SLICES)]
    pub samples: Option<Range<u64>>,
    /// Save the samples to this *.part now and then; if it is there already, go on from it
    #[arg(long, value_name = "FILE", help_heading = SLICES)]
    pub checkpoint: Option<PathBuf>,
    /// Seconds between two saves to the checkpoint [default: 60]
    #[arg(long, value_name = "S", value_parser = positive, requires = "checkpoint", help_heading = SLICES)]
    pub every: Option<f64>,

    /// Worker threads; the picture does not depend on them [default: all]
    #[arg(long, value_name = "T", value_parser = clap::value_parser!(u16).range(1..), allow_negative_numbers = true)]
    pub threads: Option<u16>,
    /// Print one JSON object
    #[arg(long)]
    pub json: bool,
}

/// Arguments of `lightbox submit`.
#[derive(Debug, clap::Args)]
#[command(after_help = builtin_scenes())]
pub struct SubmitArgs {
    /// A .toml scene, an .obj mesh, a picture or part saved by lightbox, or a built-in scene
    pub scene: PathBuf,
    /// Picture that the jobs make: *.png or *.exr; scripts, parts and logs go into *.slices beside it
    #[arg(short, long, value_name = "FILE")]
    pub output: PathBuf,
    /// Samples per pixel, of all slices together [default: the scene's]
    #[arg(long, value_name = "N", value_parser = count, allow_negative_numbers = true)]
    pub spp: Option<u64>,
    /// Slices of the samples, each a task of the job array
    #[arg(long, value_name = "K", value_parser = count, allow_negative_numbers = true)]
    pub slices: u64,
    /// Worker threads, and CPUs to ask for, of each slice
    #[arg(long, value_name = "T", value_parser = clap::value_parser!(u16).range(1..), default_value_t = 1,
          allow_negative_numbers = true)]
    pub threads: u16,
    /// Seconds between two saves of a slice: what the loss of a node may cost [default: 60]
    #[arg(long, value_name = "S", value_parser = positive, allow_negative_numbers = true)]
    pub every: Option<f64>,
    /// Print the scripts; write and submit nothing
    #[arg(long)]
    pub dry_run: bool,

    /// What to render otherwise than the scene wants.
    #[command(flatten)]
    pub settings: SettingsArgs,
}

/// Arguments of `lightbox merge`.
#[derive(Debug, clap::Args)]
pub struct MergeArgs {
    /// Parts of one picture, in any order
    #[arg(required = true, value_name = "PART")]
    pub parts: Vec<PathBuf>,
    /// File to write: *.png (as shown), *.exr (as measured), or *.part to go on merging
    #[arg(short, long, value_name = "FILE")]
    pub output: PathBuf,
    /// Print one JSON object
    #[arg(long)]
    pub json: bool,
}

/// Arguments of `lightbox info`.
#[derive(Debug, clap::Args)]
pub struct InfoArgs {
    /// A .toml scene, an .obj mesh or a built-in scene
    pub scene: PathBuf,
    /// Print one JSON object
    #[arg(long)]
    pub json: bool,
}

/// Arguments of `lightbox compare`.
#[derive(Debug, clap::Args)]
pub struct CompareArgs {
    /// Picture to judge, EXR or PNG
    pub image: PathBuf,
    /// Picture of the same size that counts as right
    pub reference: PathBuf,
    /// Print one JSON object
    #[arg(long)]
    pub json: bool,
}

/// Arguments of `lightbox lab`.
#[derive(Debug, clap::Args)]
pub struct LabArgs {
    /// Cases to run, such as S01 [default: all]
    pub ids: Vec<String>,
    /// List the cases and run none
    #[arg(long, conflicts_with_all = ["json", "output"])]
    pub list: bool,
    /// Markdown report to write; its pictures go into the folder "lab" beside it
    #[arg(short, long, value_name = "FILE.md")]
    pub output: Option<PathBuf>,
    /// Print one JSON object
    #[arg(long)]
    pub json: bool,
}

/// Arguments of `lightbox race`. Each combination of the lists is a contestant. The reference
/// is rendered first, for as long as all contestants race together.
#[derive(Debug, clap::Args)]
#[command(after_help = builtin_scenes())]
pub struct RaceArgs {
    /// .toml scenes, .obj meshes or built-in scenes
    #[arg(required = true, value_name = "SCENE")]
    pub scenes: Vec<PathBuf>,
    /// Folder for chart.svg, chart.csv, race.json and maps; of several scenes, each has one in it
    #[arg(short, long, value_name = "DIR")]
    pub output: PathBuf,
    /// Methods, such as naive,mis [default: all]
    #[arg(long, value_name = "M,...")]
    pub methods: Option<String>,
    /// Accelerators, such as kdtree,bvh [default: the scene's]
    #[arg(long, value_name = "A,...")]
    pub accels: Option<String>,
    /// Samplers, such as sobol,independent [default: the scene's]
    #[arg(long, value_name = "S,...")]
    pub samplers: Option<String>,
    /// Pixel filters, such as box,gaussian:1.5 [default: the scene's]
    #[arg(long, value_name = "F,...")]
    pub filters: Option<String>,
    /// Seconds of tracing for each contestant and seed
    #[arg(
        long,
        value_name = "S",
        default_value_t = 2.0,
        allow_negative_numbers = true
    )]
    pub seconds: f64,
    /// Runs of each contestant, with different random numbers
    #[arg(
        long,
        value_name = "N",
        default_value_t = 4,
        allow_negative_numbers = true
    )]
    pub seeds: u64,
    /// Picture that counts as right, EXR [default: rendered with reuse]
    #[arg(long, value_name = "FILE")]
    pub reference: Option<PathBuf>,
    /// Width and height in pixels
    #[arg(long, value_name = "WxH", value_parser = size, allow_hyphen_values = true, help_heading = SETTINGS)]
    pub size: Option<[u32; 2]>,
    /// Most segments of a path, or "unlimited"
    #[arg(long, value_name = "D", value_parser = depth, allow_hyphen_values = true, help_heading = SETTINGS)]
    pub depth: Option<u32>,
    /// Worker threads [default: all]
    #[arg(long, value_name = "T", value_parser = clap::value_parser!(u16).range(1..), allow_negative_numbers = true)]
    pub threads: Option<u16>,
}

/// Tells what is wrong with the command line, or the help asked for; returns the program's status, or an error of one
/// line.
pub fn tell(error: clap::Error) -> Result<ExitCode, String> {
    let words: Vec<String> = std::env::args_os()
        .skip(1)
        .map(|word| word.to_string_lossy().into_owned())
        .collect();
    let kind = error.kind();
    let is_wrong =
        error.use_stderr() && kind != ErrorKind::DisplayHelpOnMissingArgumentOrSubcommand;
    let error = match misplaced(&words, kind) {
        Some(text) => clap::Error::raw(kind, text + "\n"),
        None if is_wrong => clap::Error::raw(kind, in_one_line(&error.to_string()) + "\n"),
        None => error,
    };
    let printed = error.print();
    if !error.use_stderr() {
        written(printed)?;
    }
    Ok(ExitCode::from(error.exit_code() as u8))
}

/// What is wrong, and clap's tips, without its usage.
fn in_one_line(text: &str) -> String {
    let joined = |text: &str| text.split_whitespace().collect::<Vec<_>>().join(" ");
    let end = ["\n\nUsage:", "\n\nFor more information"]
        .iter()
        .filter_map(|usage| text.rfind(usage))
        .min();
    let line = joined(&text[..end.unwrap_or(text.len())]).replace(" tip: ", "; ");
    line.strip_prefix("error: ").unwrap_or(&line).to_owned()
}

/// What is wrong if the first word is no command: clap takes it for the scene of a window.
fn misplaced(words: &[String], kind: ErrorKind) -> Option<String> {
    let [first, rest @ ..] = words else {
        return None;
    };
    let commands = Args::command();
    let names: Vec<&str> = commands.get_subcommands().map(|c| c.get_name()).collect();
    if first.starts_with('-') || names.contains(&first.as_str()) {
        return None;
    }
    let is_scene = scene_path(Path::new(first)).is_ok();
    match kind {
        // A scene and a second word, which exclude each other, or an option of a command.
        ErrorKind::ArgumentConflict | ErrorKind::UnknownArgument if !is_scene => {
            let remedy = suggest::among(first, &names);
            Some(format!("no command is called \"{first}\"{remedy}"))
        }
        ErrorKind::ArgumentConflict => Some(format!(
            "a window shows one scene; \"{}\" is one too many",
            rest.first()?
        )),
        ErrorKind::UnknownArgument => {
            let names_output =
                |word: &String| word.starts_with("-o") || word.starts_with("--output");
            let is_part = words.iter().any(|word| word == "--part");
            let output = match (words.iter().any(names_output), is_part) {
                (true, _) => "",
                (_, true) => " -o FILE.part",
                _ => " -o FILE.png",
            };
            let words: Vec<String> = words.iter().map(|word| quoted(word)).collect();
            Some(format!(
                "a window takes no options; without one: lightbox render {}{output}",
                words.join(" ")
            ))
        }
        _ => None,
    }
}

/// Lists the built-in scenes under the help.
fn builtin_scenes() -> String {
    format!(
        "Built-in scenes: {}",
        crate::commands::builtin_names().join(", ")
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_definition_is_consistent() {
        use clap::CommandFactory as _;
        Args::command().debug_assert();
    }
}
