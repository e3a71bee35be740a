//! `lightbox advise`: the cheapest settings that reach an error, or the best ones for some
//! seconds, found by short trials.
//!
//! One setting after the other is tried in all its values while the rest stays at the best so far.
//! Trials are small pictures of the same view, which take turns so that a busy machine is busy for
//! all. They are compared as if their error fell with the root of the time from where they ended:
//! a slope fitted to a short curve would decide by chance what is far off. The forecast is that of
//! the curve of the best.

mod report;

use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::time::Instant;

use lightbox_core::compare::relative_square;
use lightbox_core::filter::FilterKind;
use lightbox_core::forecast::{Forecast, Goal, Mark, Span};
use lightbox_core::{
    AccelKind, Film, Filter, Image, RenderSettings, SamplerKind, Scene, SceneDesc, View,
};

use super::{Opened, Outcome, json_line, open, print_warnings, threads};
use crate::args::AdviseArgs;
use crate::pace::{Limits, Progress, foretell};
use crate::panels::format::seconds;
use crate::replay;

/// Samples per pixel of a trial: doubled from one mark of its curve to the next.
const MARKS: [u64; 5] = [4, 8, 16, 32, 64];

/// About how long a trial takes, seconds.
const TRIAL: f64 = 0.4;

/// The pace of a whole picture is within this factor of that of a small one nine times of ten: less
/// of it stays in the caches, and threads wait less often for the last tile.
const PACE: f64 = 1.25;

/// Another value must be better by this factor: less is noise.
const CLEAR: f64 = 0.95;

/// Light lost to depth may come to this share of the error.
const LOSS: f64 = 0.1;

/// Edge of the blocks whose means are compared to tell what a depth loses, pixels.
const BLOCK: u32 = 8;

/// Depths that are tried, if the scene's is greater.
const DEPTHS: [u32; 8] = [2, 3, 4, 6, 8, 12, 16, 32];

/// What a trial of some settings says of the whole picture.
#[derive(Clone)]
struct Trial {
    settings: RenderSettings,
    forecast: Forecast,
    /// Seconds to the error, or error after the seconds, that are asked for.
    cost: f64,
    image: Image,
}

/// What was tried of one setting.
struct Stage {
    name: &'static str,
    chosen: String,
    /// Each value and what it comes to.
    tried: Vec<(String, String)>,
}

struct Adviser {
    scene: Arc<Scene>,
    goal: Goal,
    /// Pixels of the picture for each of a trial.
    ratio: f64,
    size: [u32; 2],
    stages: Vec<Stage>,
}

/// Tries; returns the advice. The error is one line.
pub fn run(args: &AdviseArgs) -> Result<Outcome, String> {
    let (value, goal) = match (args.error, args.seconds) {
        (Some(error), _) => (error, Goal::Noise(error)),
        (_, seconds) => (
            seconds.unwrap_or(0.0),
            Goal::Seconds(seconds.unwrap_or(0.0)),
        ),
    };
    if !(value > 0.0 && value.is_finite()) {
        let option = if args.error.is_some() {
            "--error"
        } else {
            "--seconds"
        };
        return Err(format!(
            "{option} {value}: cannot be reached; ask for more than 0"
        ));
    }
    threads(args.threads)?.install(|| advise(args, goal))
}

fn advise(args: &AdviseArgs, goal: Goal) -> Result<Outcome, String> {
    let Opened { scene, .. } = open(
        &args.scene,
        |desc| {
            let render = &mut desc.render;
            [render.width, render.height] = args.size.unwrap_or([render.width, render.height]);
            render.problem().map_or(Ok(()), Err)
        },
        &lightbox_core::scene::unwatched,
    )?;
    print_warnings(&scene);
    if scene.is_dark() {
        return Err(format!(
            "{}: nothing emits light, so every setting gives the same black picture; give a material an emission, or set background",
            scene.path().display()
        ));
    }
    let mut adviser = Adviser::new(scene, goal)?;
    let best = adviser.try_all()?;
    let scene = adviser.scene.clone();
    let desc = SceneDesc {
        render: RenderSettings {
            samples: (best.forecast.samples.value.ceil() as u64).max(1),
            width: scene.desc().render.width,
            height: scene.desc().render.height,
            ..best.settings
        },
        ..scene.desc().clone()
    };
    let command = replay::command(scene.path(), &desc, desc.render.samples);
    let outcome = if args.check {
        Some(check(scene, &desc, goal)?)
    } else {
        None
    };
    let report = if args.json {
        json_line(&report::json(&adviser, &best, &command, outcome))?
    } else {
        report::text(&adviser, &best, &command, outcome)
    };
    Ok(Outcome { report, status: 0 })
}

impl Adviser {
    fn new(scene: Arc<Scene>, goal: Goal) -> Result<Self, String> {
        let desc = scene.desc();
        let [width, height] = [desc.render.width, desc.render.height];
        // How large a trial may be, from one sample of a small picture.
        let small = |share: f64| {
            [width, height].map(|n| ((f64::from(n) * share).ceil() as u32).clamp(1, n))
        };
        let pixels = f64::from(width) * f64::from(height);
        let size = small((4096.0 / pixels).sqrt().min(1.0));
        let settings = RenderSettings {
            width: size[0],
            height: size[1],
            ..desc.render
        };
        let view = View::new(scene.clone(), &desc.camera, settings)?;
        let begin = Instant::now();
        let work = view.render(&view.film(), 2, &AtomicBool::new(false));
        let cost = begin.elapsed().as_secs_f64() / work.paths as f64;
        let fitting = TRIAL / (cost * MARKS[MARKS.len() - 1] as f64);
        let size = small((fitting.max(1024.0) / pixels).sqrt().min(1.0));
        Ok(Self {
            ratio: pixels / (f64::from(size[0]) * f64::from(size[1])),
            scene,
            goal,
            size,
            stages: Vec::new(),
        })
    }

    fn try_all(&mut self) -> Result<Trial, String> {
        let own = self.scene.desc().render;
        let mut candidates = Vec::new();
        for method in self.scene.methods() {
            for sampler in SamplerKind::ALL {
                candidates.push(RenderSettings {
                    method,
                    sampler: *sampler,
                    ..own
                });
            }
        }
        let name = |s: &RenderSettings| format!("{} {}", s.method, s.sampler);
        let best = self.stage("method, sampler", candidates, own, name)?;

        let filters = FilterKind::ALL.map(Filter::new);
        let filters = filters.into_iter().filter(|f| f.kind != own.filter.kind);
        let with = |filter| RenderSettings {
            filter,
            ..best.settings
        };
        let candidates = std::iter::once(own.filter).chain(filters).map(with);
        let name = |s: &RenderSettings| s.filter.to_string();
        let best = self.stage("filter", candidates.collect(), best.settings, name)?;
        let best = self.depth(best)?;

        let with = |accel| RenderSettings {
            accel,
            ..best.settings
        };
        let candidates = AccelKind::ALL.iter().copied().map(with);
        // Every primitive against every ray takes for ever where there are many.
        let few = self.scene.geometry().primitives().len() <= 256;
        let candidates = candidates.filter(|s| few || s.accel != AccelKind::Brute);
        let name = |s: &RenderSettings| s.accel.to_string();
        self.stage("accelerator", candidates.collect(), best.settings, name)
    }

    /// Tries some settings against each other; those in use stay unless others are clearly better.
    fn stage(
        &mut self,
        name: &'static str,
        candidates: Vec<RenderSettings>,
        used: RenderSettings,
        label: impl Fn(&RenderSettings) -> String,
    ) -> Result<Trial, String> {
        let trials = self.trials(&candidates)?;
        let cost = |trial: &Trial| {
            let handicap = if trial.settings == used { CLEAR } else { 1.0 };
            handicap * trial.cost
        };
        let best = trials.iter().min_by(|a, b| cost(a).total_cmp(&cost(b)));
        let best = best.ok_or("nothing was tried")?.clone();
        self.stages.push(Stage {
            name,
            chosen: label(&best.settings),
            tried: trials
                .iter()
                .map(|trial| (label(&trial.settings), self.words(trial)))
                .collect(),
        });
        Ok(best)
    }

    /// The least depth that loses little enough. Paths of one seed are the same but for where they
    /// end, so that pictures of two depths differ by the light lost and next to no noise.
    fn depth(&mut self, best: Trial) -> Result<Trial, String> {
        let depths = DEPTHS.into_iter().filter(|d| *d < best.settings.depth);
        let mut candidates: Vec<RenderSettings> = depths
            .map(|depth| RenderSettings {
                depth,
                ..best.settings
            })
            .collect();
        candidates.push(best.settings);
        let trials = self.trials(&candidates)?;
        let [.., full] = trials.as_slice() else {
            return Ok(best);
        };
        let error = full.forecast.noise.map_or(0.0, |noise| noise.value);
        let losses: Vec<f64> = trials.iter().map(|t| loss(&t.image, &full.image)).collect();
        let fits = |(_, loss): &(&Trial, &f64)| **loss <= LOSS * error;
        let chosen = trials.iter().zip(&losses).find(fits);
        let chosen = chosen.map_or(full, |(trial, _)| trial).clone();
        let label = |s: &RenderSettings| match s.depth {
            lightbox_core::settings::UNLIMITED => "unlimited".to_owned(),
            depth => depth.to_string(),
        };
        self.stages.push(Stage {
            name: "depth",
            chosen: label(&chosen.settings),
            tried: trials
                .iter()
                .zip(&losses)
                .map(|(trial, loss)| {
                    let words = format!("{}, loses {:.2} %", self.words(trial), 100.0 * loss);
                    (label(&trial.settings), words)
                })
                .collect(),
        });
        Ok(chosen)
    }

    /// Trials that take turns.
    fn trials(&self, candidates: &[RenderSettings]) -> Result<Vec<Trial>, String> {
        let mut lanes = Vec::new();
        for settings in candidates {
            let begin = Instant::now();
            let scene = self.scene.with_accel(settings.accel);
            let scene = scene.map_err(|e| e.to_string())?;
            let build = begin.elapsed().as_secs_f64();
            let small = RenderSettings {
                width: self.size[0],
                height: self.size[1],
                ..*settings
            };
            let view = View::new(scene, &self.scene.desc().camera, small)?;
            // A tree that the scene does not have yet counts as time.
            let start = Mark {
                samples: 0,
                seconds: build,
                noise: None,
            };
            lanes.push((view.film(), view, vec![start], *settings));
        }
        for samples in MARKS {
            for (film, view, marks, _) in &mut lanes {
                let begin = Instant::now();
                view.render(film, samples, &AtomicBool::new(false));
                let before = marks.last().map_or(0.0, |m| m.seconds);
                // Only tracing grows with the picture.
                let seconds = before + self.ratio * begin.elapsed().as_secs_f64();
                let noise = film.error().as_ref().map(Span::noise_of);
                marks.push(Mark {
                    samples,
                    seconds,
                    noise,
                });
            }
        }
        let trial = |(film, _, mut marks, settings): (Film, View, Vec<Mark>, RenderSettings)| {
            let cost = self.cost(&marks)?;
            // A curve that has passed the goal foretells nothing: only what comes before it counts.
            while marks.len() > 3 && marks.last().is_some_and(|mark| self.is_past(mark)) {
                marks.pop();
            }
            Some(Trial {
                settings,
                forecast: loosened(foretell(&marks, self.goal)?, self.goal),
                cost,
                image: film.develop(),
            })
        };
        Ok(lanes.into_iter().filter_map(trial).collect())
    }

    fn is_past(&self, mark: &Mark) -> bool {
        match self.goal {
            Goal::Noise(goal) => mark.noise.is_some_and(|noise| noise.value < goal),
            Goal::Seconds(goal) => mark.seconds > goal,
            Goal::Samples(goal) => mark.samples > goal,
        }
    }

    /// What is to be small, from where a curve ends.
    fn cost(&self, marks: &[Mark]) -> Option<f64> {
        let (start, end) = (marks.first()?, marks.last()?);
        let (build, noise) = (start.seconds, end.noise?.value);
        let traced = end.seconds - build;
        Some(match self.goal {
            Goal::Noise(goal) => build + traced * (noise / goal).powi(2),
            Goal::Seconds(goal) => noise * (traced / (goal - build).max(f64::MIN_POSITIVE)).sqrt(),
            Goal::Samples(goal) => build + traced * goal as f64 / end.samples as f64,
        })
    }

    fn words(&self, trial: &Trial) -> String {
        match self.goal {
            Goal::Seconds(_) => format!("{:.3} %", 100.0 * trial.cost),
            _ => seconds(trial.cost),
        }
    }
}

/// A forecast from a small picture, for a whole one.
fn loosened(mut forecast: Forecast, goal: Goal) -> Forecast {
    let loosen = |span: &mut Span, factor: f64| {
        span.low = span.low.min(span.value / factor);
        span.high = span.high.max(span.value * factor);
    };
    match goal {
        Goal::Seconds(_) => {
            loosen(&mut forecast.samples, PACE);
            if let Some(noise) = &mut forecast.noise {
                loosen(noise, PACE.sqrt());
            }
        }
        _ => loosen(&mut forecast.seconds, PACE),
    }
    forecast
}

/// Relative error of a picture against another, both averaged over blocks.
fn loss(image: &Image, full: &Image) -> f64 {
    let (mut sum, mut blocks) = (0.0, 0.0);
    for y in (0..full.height).step_by(BLOCK as usize) {
        for x in (0..full.width).step_by(BLOCK as usize) {
            let mean = |image: &Image| {
                let mut sum = glam::Vec3::ZERO;
                let mut pixels = 0.0;
                for row in y..(y + BLOCK).min(full.height) {
                    for column in x..(x + BLOCK).min(full.width) {
                        sum += image.pixels[(row * full.width + column) as usize];
                        pixels += 1.0;
                    }
                }
                sum / pixels
            };
            sum += relative_square(mean(image), mean(full));
            blocks += 3.0;
        }
    }
    f64::sqrt(sum / blocks)
}

/// Renders as advised; returns samples, seconds and error.
fn check(scene: Arc<Scene>, desc: &SceneDesc, goal: Goal) -> Result<(u64, f64, f64), String> {
    let scene = scene.with_accel(desc.render.accel);
    let view = View::new(scene.map_err(|e| e.to_string())?, &desc.camera, desc.render)?;
    let limits = Limits::at(goal);
    let (film, mut progress) = (view.film(), Progress::default());
    while let Ok(target) = limits.next(&progress) {
        let begin = Instant::now();
        view.render(&film, target, &AtomicBool::new(false));
        progress.seconds += begin.elapsed().as_secs_f64();
        progress.samples = film.samples();
        if progress.samples >= progress.next_check {
            progress.checked(film.error().map(|e| e.noise()));
        }
    }
    let error = film.error().map_or(0.0, |e| e.noise());
    Ok((progress.samples, progress.seconds, error))
}
