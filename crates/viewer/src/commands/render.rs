//! `lightbox render`: from a scene to a file.

use std::borrow::Cow;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Instant;

use indicatif::{ProgressBar, ProgressFinish, ProgressStyle};
use lightbox_core::color::ToneMap;
use lightbox_core::render::Work;
use lightbox_core::scene::Phase;
use lightbox_core::settings::UNLIMITED;
use lightbox_core::{AccelKind, Film, Method, SamplerKind, View, image_io};
use serde::Serialize;

use super::{Opened, Outcome, json_line, open, print_warning, print_warnings};
use crate::args::RenderArgs;
use crate::pace::{Limits, Progress, Stop};
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
    spp: u64,
    paths: u64,
    rays: u64,
    /// Of tracing only.
    seconds: f64,
    load_seconds: f64,
    build_seconds: f64,
    noise: Option<f64>,
    invalid_samples: u64,
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

/// Renders and writes a picture. The error is one line.
pub fn run(args: &RenderArgs) -> Result<Outcome, String> {
    if let Some(output) = &args.output {
        image_io::check_writable(output)?;
    }
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(args.threads.map_or(0, usize::from))
        .thread_name(|i| format!("lightbox-trace-{i}"))
        .build()
        .map_err(|e| format!("cannot start worker threads ({e})"))?;
    pool.install(|| render(args))
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
            Phase::BuildingAccelerator(n) => {
                format!("building the accelerator over {n} primitives")
            }
            Phase::Ready => String::new(),
        });
    };
    let Opened {
        scene,
        tone,
        load_seconds,
        build_seconds,
    } = open(&args.scene, |desc| args.apply(desc), &announce)?;
    bar.suspend(|| print_warnings(&scene));

    let tone = args.tone_map(tone);
    let view = View::of(scene.clone())?;
    let film = view.film();
    let is_limited = args.seconds.is_some() || args.noise.is_some();
    let default_samples = (!is_limited).then_some(view.settings.samples);
    let limits = Limits {
        samples: args.spp.or(default_samples),
        seconds: args.seconds,
        noise: args.noise,
    };
    let (progress, work, stop) = trace(&view, &film, &limits, &bar)?;
    bar.finish_and_clear();

    let status = match stop {
        Stop::Interrupt => super::INTERRUPTED,
        _ => 0,
    };
    if work.paths == 0 {
        print_warning("interrupted before anything was rendered; nothing is saved");
        return Ok(Outcome {
            report: String::new(),
            status,
        });
    }
    let settings = view.settings;
    let replay = replay_line(&view, tone, &progress, work);
    if let Some(output) = &args.output {
        let desc = scene.desc().clone();
        let text = saved::text(&replay, desc, progress.samples.max(1), scene.path(), tone);
        image_io::write(output, &film.develop(), tone, &text)?;
    }
    let (invalid_samples, places) = film.invalid();
    if let Some(first) = places.first() {
        let [x, y] = first.pixel;
        print_warning(&format!(
            "{invalid_samples} samples are not finite and were left out, such as sample {} of pixel {x},{y}",
            first.sample
        ));
    }
    let accel = scene.geometry().accel();
    let report = Report {
        scene: scene.path().to_string_lossy(),
        output: args.output.as_ref().map(|path| path.to_string_lossy()),
        width: settings.width,
        height: settings.height,
        spp: progress.samples,
        paths: work.paths,
        rays: work.rays,
        seconds: progress.seconds,
        load_seconds,
        build_seconds,
        noise: film.noise(),
        invalid_samples,
        stopped_by: stop,
        threads: rayon::current_num_threads(),
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

/// The command that makes the picture again.
fn replay_line(view: &View, tone: ToneMap, progress: &Progress, work: Work) -> String {
    let (scene, settings) = (&view.scene, &view.settings);
    let mut line = replay::line(scene.path(), scene.desc(), progress.samples.max(1));
    line += &replay::tone_options(tone);
    let pixels = u64::from(settings.width) * u64::from(settings.height);
    if work.paths != progress.samples * pixels {
        line += " # interrupted: some parts of the picture hold other samples";
    }
    line
}

/// Adds samples until a limit is reached or Ctrl-C is pressed; a second Ctrl-C ends the process.
fn trace(
    view: &View,
    film: &Film,
    limits: &Limits,
    bar: &ProgressBar,
) -> Result<(Progress, Work, Stop), String> {
    let interrupted = Arc::new(AtomicBool::new(false));
    let flag = interrupted.clone();
    ctrlc::set_handler(move || {
        if flag.swap(true, Ordering::Relaxed) {
            #[expect(
                clippy::disallowed_methods,
                reason = "the second Ctrl-C is not to wait for main"
            )]
            std::process::exit(super::INTERRUPTED.into());
        }
    })
    .map_err(|e| format!("cannot listen for Ctrl-C ({e})"))?;

    let never = AtomicBool::new(false);
    let shows_noise = !bar.is_hidden() || limits.noise.is_some();
    let (mut progress, mut work) = (Progress::default(), Work::default());
    loop {
        let target = match limits.next(&progress) {
            Ok(target) => target,
            Err(stop) => return Ok((progress, work, stop)),
        };
        if interrupted.load(Ordering::Relaxed) {
            return Ok((progress, work, Stop::Interrupt));
        }
        let expected = progress.seconds_per_sample() * (target - progress.samples) as f64;
        let waits = progress.samples > 0 && expected <= PATIENCE;
        let start = Instant::now();
        work = work + view.render(film, target, if waits { &never } else { &interrupted });
        progress.seconds += start.elapsed().as_secs_f64();
        progress.samples = film.samples();
        if shows_noise && progress.samples >= progress.next_check {
            progress.checked(film.noise());
        }
        show(bar, limits, &progress, work);
    }
}

fn show(bar: &ProgressBar, limits: &Limits, progress: &Progress, work: Work) {
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
        mega_rays(work.rays, progress.seconds)
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
    let interrupted = if report.stopped_by == Stop::Interrupt {
        ", interrupted"
    } else {
        ""
    };
    let speed = mega_rays(*rays, *seconds);
    format!(
        "{output}{width}x{height}, {spp} spp in {seconds:.2} s ({speed:.2} Mrays/s){noise}{interrupted}\n"
    )
}
