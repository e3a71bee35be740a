//! `lightbox render`: from a scene to a file.

use std::borrow::Cow;
use std::ops::ControlFlow;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressFinish, ProgressStyle};
use lightbox_core::film::Lost;
use lightbox_core::part::{self, Head};
use lightbox_core::plan::Part;
use lightbox_core::scene::Phase;
use lightbox_core::settings::UNLIMITED;
use lightbox_core::work::Times;
use lightbox_core::{AccelKind, Film, Method, SamplerKind, View, image_io};
use serde::Serialize;

use super::checkpoint::Checkpoint;
use super::{
    Opened, Outcome, json_line, open, print_invalid, print_warning, print_warnings, threads,
};
use crate::args::RenderArgs;
use crate::pace::{Limits, Progress, Stop};
use crate::spent::{NEGLIGIBLE, Spent};
use crate::{replay, saved};

/// An interrupt waits this long, seconds, for the samples in work, so that every pixel has as
/// many and the replay line holds.
const PATIENCE: f64 = 1.0;

/// Steps of the progress bar.
const BAR_STEPS: u64 = 1000;

/// The report of `--json`.
#[derive(Serialize)]
struct Report<'a> {
    scene: Cow<'a, str>,
    output: Option<Cow<'a, str>>,
    width: u32,
    height: u32,
    /// Index of the first sample; 0 unless the output is a slice.
    first_sample: u64,
    spp: u64,
    /// Samples per pixel of earlier sittings among them.
    resumed: u64,
    paths: u64,
    rays: u64,
    /// Of tracing only.
    seconds: f64,
    load_seconds: f64,
    build_seconds: f64,
    noise: Option<f64>,
    invalid_samples: u64,
    lost_light: LostLight,
    /// Seconds; from `camera` on, of all threads together.
    times: Spent,
    /// Parts of the model that the scene does not need.
    left_out: Vec<Part>,
    stopped_by: Stop,
    threads: usize,
    method: Method,
    /// What was used: never `auto`.
    accel: AccelKind,
    sampler: SamplerKind,
    filter: String,
    /// A number or "unlimited".
    depth: serde_json::Value,
    seed: u64,
    replay: &'a str,
}

/// Light that is not in the picture, by what keeps it out, as shares of all light.
#[derive(Serialize)]
struct LostLight {
    /// Paths have no more segments than the depth: estimated, none as long as too few paths were
    /// followed further.
    depth: Option<Lost>,
    /// Paths that roulette ends are made up for by those that it spares.
    roulette: f64,
    /// The least depth that would lose less than a tenth of the noise.
    enough_depth: Option<u32>,
}

/// Renders and writes a picture. The error is one line.
pub fn run(args: &RenderArgs) -> Result<Outcome, String> {
    match &args.output {
        Some(output) if args.part => part::check_writable(output)?,
        Some(output) if part::is_part(output) => {
            return Err(format!(
                "{}: give --part to write samples for `lightbox merge`, or name a picture *.png or *.exr",
                output.display()
            ));
        }
        Some(output) => image_io::check_writable(output)?,
        None => {}
    }
    if let Some(checkpoint) = &args.checkpoint {
        part::check_writable(checkpoint)?;
    }
    threads(args.threads)?.install(|| render(args))
}

fn render(args: &RenderArgs) -> Result<Outcome, String> {
    // On standard error, and only if that is a terminal.
    let bar = ProgressBar::new(BAR_STEPS).with_finish(ProgressFinish::AndClear);
    if let Ok(style) = ProgressStyle::with_template("{bar:24} {msg}") {
        bar.set_style(style);
    }
    let announce = |phase| {
        bar.set_message(match phase {
            Phase::Reading => "reading".to_owned(),
            Phase::BuildingAccelerator {
                primitives,
                percent,
            } => format!("building the accelerator over {primitives} primitives, {percent} %"),
            Phase::Ready => String::new(),
        });
        ControlFlow::Continue(())
    };
    let Opened {
        scene,
        tone,
        load_seconds,
        build_seconds,
    } = open(
        &args.scene,
        |desc| args.settings.apply(args.spp, desc),
        &announce,
    )?;
    bar.suspend(|| print_warnings(&scene));

    let tone = args.settings.tone_map(tone);
    let view = View::of(scene.clone())?;
    let first = args.samples.as_ref().map_or(0, |samples| samples.start);
    let resumed = match &args.checkpoint {
        Some(path) => {
            if let Some(output) = &args.output {
                image_io::remove_asides(output); // Of the sitting that was killed.
            }
            part::resume(path, &view, first)?
        }
        None => None,
    };
    let (film, seconds) = resumed.unwrap_or_else(|| (view.film().starting_at(first), 0.0));
    let resumed = film.samples() - first;
    let is_limited = args.seconds.is_some() || args.noise.is_some();
    let default_samples = (!is_limited).then_some(view.settings.samples);
    let limits = Limits {
        samples: match &args.samples {
            Some(samples) => Some(samples.end - samples.start),
            None => args.spp.or(default_samples),
        },
        seconds: args.seconds,
        noise: args.noise,
    };
    let ahead = film.most_samples() - first;
    if let (Some(path), Some(asked)) = (&args.checkpoint, limits.samples)
        && ahead > asked
    {
        return Err(format!(
            "{}: holds {ahead} samples per pixel, more than the {asked} asked for; ask for {ahead} or name another checkpoint",
            path.display()
        ));
    }
    let keeps = args.part || args.checkpoint.is_some();
    let head = keeps.then(|| Head::new(&view, tone, &film, seconds));
    let checkpoint = match (&args.checkpoint, &head) {
        (Some(path), Some(head)) => Some(Checkpoint::new(path, args.every, head, &film)),
        _ => None,
    };
    let progress = Progress::resumed(resumed, seconds);
    let trace = || trace(&view, &film, &limits, progress, &bar);
    let (progress, stop, times, mut measuring) = match &checkpoint {
        Some(checkpoint) => checkpoint.during(trace)??,
        None => trace()?,
    };
    bar.finish_and_clear();
    if let Some(checkpoint) = &checkpoint {
        checkpoint.save(progress.seconds)?;
    }

    let status = match stop {
        Stop::Interrupt => super::INTERRUPTED,
        _ => 0,
    };
    let [paths, rays] = film.work();
    if progress.samples == 0 {
        print_warning(match &args.checkpoint {
            Some(_) if paths > 0 => {
                "interrupted before every pixel had a sample; no picture is written, what there is of it is in the checkpoint"
            }
            _ => "interrupted before every pixel had a sample; nothing is saved",
        });
        return Ok(Outcome {
            report: String::new(),
            status,
        });
    }
    let settings = view.settings;
    let samples = progress.samples;
    let mut display = Duration::ZERO;
    let mut replay = if args.part {
        replay::slice(scene.path(), scene.desc(), first..first + samples)
    } else {
        replay::line(scene.path(), scene.desc(), samples)
    };
    replay += &replay::tone_options(tone);
    if film.most_samples() > film.samples() {
        replay += " # interrupted: some parts of the picture hold other samples";
    }
    if let (Some(output), Some(head), true) = (&args.output, &head, args.part) {
        if args.checkpoint.as_ref() != Some(output) {
            part::write(output, &head.renewed(&film, progress.seconds), &film)?;
        }
        if film.most_samples() > film.samples() {
            let output = output.display();
            print_warning(&format!(
                "{output} is not finished; run the command again with --checkpoint {output}"
            ));
        }
    } else if let Some(output) = &args.output {
        let start = Instant::now();
        let desc = scene.desc().clone();
        let text = saved::text(&replay, desc, samples, scene.path(), tone);
        image_io::write(output, &film.develop(), tone, &text)?;
        display = start.elapsed();
    }
    let start = Instant::now();
    let error = film.error();
    let light = film.light();
    measuring += start.elapsed();
    let threads = rayon::current_num_threads();
    let (invalid_samples, places) = film.invalid();
    print_invalid(invalid_samples, &places);
    let accel = scene.geometry().accel();
    let report = Report {
        scene: scene.path().to_string_lossy(),
        output: args.output.as_ref().map(|path| path.to_string_lossy()),
        width: settings.width,
        height: settings.height,
        first_sample: first,
        spp: progress.samples,
        resumed,
        paths,
        rays,
        seconds: progress.seconds,
        load_seconds,
        build_seconds,
        noise: error.map(|e| e.noise()),
        invalid_samples,
        lost_light: LostLight {
            depth: error.and_then(|e| light.lost(e.mean)),
            roulette: 0.0,
            enough_depth: error.and_then(|e| light.least_depth(NEGLIGIBLE * e.noise(), e.mean)),
        },
        times: Spent::new(
            [load_seconds, build_seconds],
            &times,
            [measuring, display].map(|time| time * threads as u32),
        ),
        left_out: view.plan().left_out().collect(),
        stopped_by: stop,
        threads,
        method: settings.method,
        accel,
        sampler: settings.sampler,
        filter: settings.filter.to_string(),
        depth: if settings.depth == UNLIMITED {
            "unlimited".into()
        } else {
            settings.depth.into()
        },
        seed: settings.seed,
        replay: &replay,
    };
    let report = if args.json {
        json_line(&report)?
    } else {
        summary(&report)
    };
    Ok(Outcome { report, status })
}

/// Adds samples until a limit is reached or Ctrl-C is pressed; a second Ctrl-C ends the process.
fn trace(
    view: &View,
    film: &Film,
    limits: &Limits,
    mut progress: Progress,
    bar: &ProgressBar,
) -> Result<(Progress, Stop, Times, Duration), String> {
    let interrupted = super::interrupt_flag()?;
    let never = AtomicBool::new(false);
    let (mut times, mut measuring) = (Times::default(), Duration::ZERO);
    let shows_noise = !bar.is_hidden() || limits.noise.is_some();
    loop {
        if shows_noise && progress.samples >= progress.next_check {
            let start = Instant::now();
            progress.checked(film.error().map(|e| e.noise()));
            measuring += start.elapsed();
        }
        let target = match limits.next(&progress) {
            Ok(target) => target,
            Err(stop) => return Ok((progress, stop, times, measuring)),
        };
        if interrupted.load(Ordering::Relaxed) {
            return Ok((progress, Stop::Interrupt, times, measuring));
        }
        let expected = progress.seconds_per_sample() * (target - progress.samples) as f64;
        let waits = progress.samples > 0 && expected <= PATIENCE;
        let start = Instant::now();
        // Tiles that an earlier sitting has left ahead of the others wait for them.
        let target = film.most_samples().max(film.first() + target);
        let work = view.render(film, target, if waits { &never } else { &interrupted });
        times += work.times;
        progress.seconds += start.elapsed().as_secs_f64();
        progress.samples = film.samples() - film.first();
        show(bar, limits, &progress, film.work()[1]);
    }
}

fn show(bar: &ProgressBar, limits: &Limits, progress: &Progress, rays: u64) {
    let fraction = limits.fraction(progress);
    bar.set_position((fraction * BAR_STEPS as f64) as u64);
    let noise = progress
        .noise
        .map_or_else(String::new, |noise| format!(", noise {noise:.2e}"));
    // Infinite as long as nothing is known.
    let eta = progress.seconds * (1.0 - fraction) / fraction;
    let eta = if eta.is_finite() {
        format!(", {:.0} s left", eta.ceil())
    } else {
        String::new()
    };
    bar.set_message(format!(
        "{} spp{noise}, {:.2} Mrays/s{eta}",
        progress.samples,
        mega_rays(rays, progress.seconds)
    ));
}

/// Millions of rays per second.
fn mega_rays(rays: u64, seconds: f64) -> f64 {
    rays as f64 / seconds / 1e6
}

/// The report for people: one line.
fn summary(report: &Report<'_>) -> String {
    let Report {
        width,
        height,
        spp,
        seconds,
        rays,
        resumed,
        ..
    } = report;
    let output = report
        .output
        .as_ref()
        .map(|path| format!("{path}: "))
        .unwrap_or_default();
    let noise = report
        .noise
        .map(|noise| format!(", noise {noise:.3e}"))
        .unwrap_or_default();
    let lost = match report.lost_light.depth {
        None => ", light lost to depth unknown".into(),
        Some(lost) if lost.share == 0.0 => ", no light lost to depth".to_owned(),
        Some(lost) => format!(
            ", {:.2} ± {:.2} % of the light lost to depth",
            100.0 * lost.share,
            100.0 * lost.error
        ),
    };
    let interrupted = if report.stopped_by == Stop::Interrupt {
        ", interrupted"
    } else {
        ""
    };
    let speed = mega_rays(*rays, *seconds);
    let resumed = match resumed {
        0 => String::new(),
        spp => format!(" ({spp} of them before)"),
    };
    format!(
        "{output}{width}x{height}, {spp} spp{resumed} in {seconds:.2} s ({speed:.2} Mrays/s){noise}{lost}{interrupted}\n"
    )
}
