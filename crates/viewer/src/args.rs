//! The command line: what can be asked for, and the first check of each value.

use std::ops::Range;
use std::path::{Path, PathBuf};
use std::str::FromStr;

use crate::commands::scene_path;
use clap::builder::{PossibleValuesParser, TypedValueParser};
use clap::error::ErrorKind;
use clap::{CommandFactory as _, Parser, Subcommand};
use glam::Vec3;
use lightbox_core::color::{ToneCurve, ToneMap};
use lightbox_core::settings::{MAX_SEED, MAX_SIZE, parse_depth};
use lightbox_core::{AccelKind, Camera, Filter, Method, SamplerKind, SceneDesc, suggest};

// Headings of the help.
const STOP: &str = "Stop";
const SETTINGS: &str = "Settings (default: the scene's)";
const CAMERA: &str = "Camera (default: the scene's)";
const PNG: &str = "PNG";
const SLICES: &str = "Slices and sittings";

/// Most samples and slices: as far as scene files, parts and the scripts of `submit` can count.
const MAX_COUNT: u64 = i64::MAX as u64;

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
    #[arg(long, value_name = "WxH", value_parser = size, help_heading = SETTINGS)]
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
    #[arg(long, value_name = "A..B", value_parser = samples, requires = "part",
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

/// What to render otherwise than the scene wants.
#[derive(Debug, clap::Args)]
pub struct SettingsArgs {
    /// Width and height in pixels
    #[arg(long, value_name = "WxH", value_parser = size, help_heading = SETTINGS)]
    pub size: Option<[u32; 2]>,
    /// Most segments of a path, or "unlimited"; 1 sees emitters only, 2 adds direct light
    #[arg(long, value_name = "D", value_parser = depth, help_heading = SETTINGS)]
    pub depth: Option<u32>,
    /// Pixel filter: box, tent, gaussian, mitchell, blackman-harris or lanczos, and its radius in pixels
    #[arg(long, value_name = "F[:RADIUS]", help_heading = SETTINGS)]
    pub filter: Option<Filter>,
    /// How light is found
    #[arg(long, value_name = "M", value_parser = named(Method::ALL, Method::name), help_heading = SETTINGS)]
    pub method: Option<Method>,
    /// How rays find surfaces
    #[arg(long, value_name = "A", value_parser = named(AccelKind::ALL, AccelKind::name), help_heading = SETTINGS)]
    pub accel: Option<AccelKind>,
    /// Where the random numbers come from
    #[arg(long, value_name = "S", value_parser = named(SamplerKind::ALL, SamplerKind::name), help_heading = SETTINGS)]
    pub sampler: Option<SamplerKind>,
    /// Chooses the random numbers
    #[arg(long, value_name = "K", value_parser = seed, allow_negative_numbers = true, help_heading = SETTINGS)]
    pub seed: Option<u64>,
    /// Leave out nothing, not even what the scene does not need: the same picture, later
    #[arg(long, help_heading = SETTINGS)]
    pub full_model: bool,

    /// Pinhole
    #[arg(long, value_name = "X,Y,Z", value_parser = point, allow_hyphen_values = true, help_heading = CAMERA)]
    pub eye: Option<Vec3>,
    /// Point in the middle of the picture
    #[arg(long, value_name = "X,Y,Z", value_parser = point, allow_hyphen_values = true, help_heading = CAMERA)]
    pub target: Option<Vec3>,
    /// Direction that is up in the picture
    #[arg(long, value_name = "X,Y,Z", value_parser = point, allow_hyphen_values = true, help_heading = CAMERA)]
    pub up: Option<Vec3>,
    /// Vertical field of view, degrees
    #[arg(long, value_name = "DEGREES", value_parser = field_of_view, help_heading = CAMERA)]
    pub fov: Option<f32>,

    /// Brightness of a PNG in photographic stops [default: 0, or a saved picture's]
    #[arg(long, value_name = "E", value_parser = finite, allow_negative_numbers = true, help_heading = PNG)]
    pub exposure: Option<f32>,
    /// Light added to a PNG after that [default: 0, or a saved picture's]
    #[arg(long, value_name = "O", value_parser = finite, allow_negative_numbers = true, help_heading = PNG)]
    pub offset: Option<f32>,
    /// Tone curve of a PNG [default: linear, or a saved picture's]
    #[arg(long, value_name = "T", value_parser = named(&ToneCurve::ALL, ToneCurve::name), help_heading = PNG)]
    pub tone: Option<ToneCurve>,
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
    #[arg(long, value_name = "N", default_value_t = 4)]
    pub seeds: u64,
    /// Picture that counts as right, EXR [default: rendered with reuse]
    #[arg(long, value_name = "FILE")]
    pub reference: Option<PathBuf>,
    /// Width and height in pixels
    #[arg(long, value_name = "WxH", value_parser = size, help_heading = SETTINGS)]
    pub size: Option<[u32; 2]>,
    /// Most segments of a path, or "unlimited"
    #[arg(long, value_name = "D", value_parser = depth, help_heading = SETTINGS)]
    pub depth: Option<u32>,
    /// Worker threads [default: all]
    #[arg(long, value_name = "T", value_parser = clap::value_parser!(u16).range(1..), allow_negative_numbers = true)]
    pub threads: Option<u16>,
}

/// Ends the program with what is wrong with the command line, or with the help asked for.
pub fn exit(error: clap::Error) -> ! {
    let words: Vec<String> = std::env::args().skip(1).collect();
    match misplaced(&words, error.kind()) {
        Some(text) => clap::Error::raw(error.kind(), text + "\n").exit(),
        None => error.exit(),
    }
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
        ErrorKind::UnknownArgument => Some(format!(
            "a window takes no options; without one: lightbox render {} -o FILE.png",
            words.join(" ")
        )),
        _ => None,
    }
}

impl SettingsArgs {
    /// Puts what was asked for in place of what the scene wants; the error is one line.
    pub fn apply(&self, spp: Option<u64>, desc: &mut SceneDesc) -> Result<(), String> {
        let (render, camera) = (&mut desc.render, &mut desc.camera);
        let scene_render = *render;
        [render.width, render.height] = self.size.unwrap_or([render.width, render.height]);
        render.samples = spp.unwrap_or(render.samples);
        render.depth = self.depth.unwrap_or(render.depth);
        render.filter = self.filter.unwrap_or(render.filter);
        render.method = self.method.unwrap_or(render.method);
        render.accel = self.accel.unwrap_or(render.accel);
        render.sampler = self.sampler.unwrap_or(render.sampler);
        render.seed = self.seed.unwrap_or(render.seed);
        render.full_model |= self.full_model;
        let scene_camera = *camera;
        camera.eye = self.eye.unwrap_or(camera.eye);
        camera.target = self.target.unwrap_or(camera.target);
        camera.up = self.up.unwrap_or(camera.up);
        camera.fov = self.fov.unwrap_or(camera.fov);
        // Here, because later the scene file would get the blame.
        if *render != scene_render
            && let Some(problem) = render.problem()
        {
            return Err(problem);
        }
        if *camera != scene_camera {
            Camera::new(camera, render.width, render.height)?;
        }
        Ok(())
    }

    /// Puts what was asked for in place of how the scene wants to be shown.
    pub fn tone_map(&self, scene: ToneMap) -> ToneMap {
        ToneMap {
            exposure: self.exposure.unwrap_or(scene.exposure),
            offset: self.offset.unwrap_or(scene.offset),
            curve: self.tone.unwrap_or(scene.curve),
        }
    }
}

/// Lists the built-in scenes under the help.
fn builtin_scenes() -> String {
    format!(
        "Built-in scenes: {}",
        crate::commands::builtin_names().join(", ")
    )
}

/// Accepts the names of some values, and shows them in the help.
fn named<T>(all: &[T], name: fn(T) -> &'static str) -> impl TypedValueParser<Value = T> + use<T>
where
    T: Copy + FromStr<Err = String> + Send + Sync + 'static,
{
    PossibleValuesParser::new(all.iter().map(|value| name(*value))).try_map(|name| name.parse())
}

fn size(text: &str) -> Result<[u32; 2], String> {
    let pixels = |text: &str| text.parse().ok().filter(|n| (1..=MAX_SIZE).contains(n));
    let size = text
        .split_once('x')
        .and_then(|(width, height)| Some([pixels(width)?, pixels(height)?]));
    size.ok_or_else(|| format!("write WxH, each from 1 to {MAX_SIZE} pixels, for example 640x480"))
}

fn depth(text: &str) -> Result<u32, String> {
    match parse_depth(text)? {
        0 => Err("use 1 (emitters only) or more, or \"unlimited\"".into()),
        depth => Ok(depth),
    }
}

fn count(text: &str) -> Result<u64, String> {
    let number = text.parse().ok().filter(|n| (1..=MAX_COUNT).contains(n));
    number.ok_or_else(|| format!("use a whole number from 1 to {MAX_COUNT}"))
}

fn seed(text: &str) -> Result<u64, String> {
    let seed = text.parse().ok().filter(|seed| *seed <= MAX_SEED);
    seed.ok_or_else(|| format!("use a whole number from 0 to {MAX_SEED}"))
}

fn positive(text: &str) -> Result<f64, String> {
    let number = text
        .parse()
        .ok()
        .filter(|x: &f64| *x > 0.0 && x.is_finite());
    number.ok_or_else(|| "use a positive number".into())
}

fn samples(text: &str) -> Result<Range<u64>, String> {
    let index = |text: &str| text.parse().ok().filter(|i| *i <= MAX_COUNT);
    text.split_once("..")
        .and_then(|(start, end)| Some(index(start)?..index(end)?))
        .filter(|samples| !samples.is_empty())
        .ok_or_else(|| "write A..B with A less than B, for example 64..128".into())
}

fn finite(text: &str) -> Result<f32, String> {
    text.parse()
        .ok()
        .filter(|x: &f32| x.is_finite())
        .ok_or_else(|| "use a number".into())
}

fn field_of_view(text: &str) -> Result<f32, String> {
    let fov = text
        .parse()
        .ok()
        .filter(|fov: &f32| *fov > 0.0 && *fov < 180.0);
    fov.ok_or_else(|| "use more than 0 and less than 180 degrees".into())
}

fn point(text: &str) -> Result<Vec3, String> {
    let numbers: Result<Vec<f32>, String> = text
        .split(',')
        .map(|number| finite(number.trim()))
        .collect();
    match numbers.as_deref() {
        Ok(&[x, y, z]) => Ok(Vec3::new(x, y, z)),
        _ => Err("write three numbers with commas between them, for example 0,1.5,-2".into()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_definition_is_consistent() {
        use clap::CommandFactory as _;
        Args::command().debug_assert();
    }

    #[test]
    fn values_survive_the_way_through_text() {
        for x in [
            0.1f32,
            -0.0,
            f32::MIN_POSITIVE,
            1e-45,
            16_777_217.0,
            -f32::MAX,
        ] {
            let v = Vec3::new(x, -x, 1.0 / 3.0);
            let read = point(&format!("{},{},{}", v.x, v.y, v.z)).unwrap();
            assert_eq!(
                read.to_array().map(f32::to_bits),
                v.to_array().map(f32::to_bits)
            );
        }
    }

    #[test]
    fn values_out_of_range_are_refused() {
        for text in [
            "", "abc", "0x10", "10x0", "99999x1", "10", "10x10x10", "-1x5", "1.5x2",
        ] {
            assert!(size(text).is_err(), "{text}");
        }
        assert_eq!(size("16384x1"), Ok([16384, 1]));
        for text in ["", "1,2", "1,2,3,4", "nan,0,0", "1,,2", "inf,0,0"] {
            assert!(point(text).is_err(), "{text}");
        }
        for text in ["0", "-1", "nan", "inf", "x"] {
            assert!(positive(text).is_err(), "{text}");
        }
        for text in [
            "",
            "5",
            "5..",
            "..5",
            "5..5",
            "6..5",
            "-1..5",
            "0..=5",
            "0..9223372036854775808",
        ] {
            assert!(samples(text).is_err(), "{text}");
        }
        assert_eq!(samples("64..128"), Ok(64..128));
        for text in ["0", "-1", "1.5", "9223372036854775808"] {
            assert!(count(text).is_err(), "{text}");
        }
        assert_eq!(count("9223372036854775807"), Ok(MAX_COUNT));
        assert!(depth("0").is_err() && depth("unlimited").is_ok());
    }
}
