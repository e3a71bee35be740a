//! `lightbox race`: error against time of several ways to make one picture.

mod chart;
mod report;

use std::fs;
use std::path::{Path, PathBuf};
use std::str::FromStr;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Instant;

use glam::Vec3;
use indicatif::{ProgressBar, ProgressFinish, ProgressStyle};
use lightbox_core::agreement::Agreement;
use lightbox_core::film::ErrorEstimate;
use lightbox_core::race::{self, Curve, Record, Rules};
use lightbox_core::{
    AccelKind, Filter, Image, Method, RenderSettings, SamplerKind, Scene, View, image_io,
};

use super::{Outcome, interrupt_flag, open, print_warnings, scene_path};
use crate::args::RaceArgs;

/// Steps of the progress bar.
const BAR_STEPS: u64 = 1000;

/// What one of the contestants does.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Entry {
    method: Method,
    accel: AccelKind,
    sampler: SamplerKind,
    filter: Filter,
}

/// What the contestants of a scene are measured against.
struct Reference {
    image: Image,
    filter: Filter,
    /// Its file, or how it was rendered.
    origin: report::Origin,
    error: Option<ErrorEstimate>,
}

/// A scene's race when it is over.
struct Race {
    scene: Arc<Scene>,
    settings: RenderSettings,
    entries: Vec<Entry>,
    labels: Vec<String>,
    references: Vec<Reference>,
    rules: Rules,
    records: Vec<Record>,
    curves: Vec<Curve>,
    /// Pairs of contestants that differ in their method only.
    agreements: Vec<(usize, usize, Agreement)>,
    interrupted: bool,
}

/// What is wished for, checked and read: no work is done before all of it is right.
struct Plan {
    methods: Vec<Method>,
    accels: Vec<AccelKind>,
    samplers: Vec<SamplerKind>,
    filters: Vec<Filter>,
    rules: Rules,
    reference: Option<(String, Image)>,
    /// Each scene and the folder for its files.
    scenes: Vec<(PathBuf, PathBuf)>,
}

/// Races; returns the tables. The error is one line.
pub fn run(args: &RaceArgs) -> Result<Outcome, String> {
    let plan = Plan::new(args)?;
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(args.threads.map_or(0, usize::from))
        .thread_name(|i| format!("lightbox-trace-{i}"))
        .build()
        .map_err(|e| format!("cannot start worker threads ({e})"))?;
    pool.install(|| {
        let scenes = plan
            .scenes
            .iter()
            .map(|(scene, folder)| Ok((plan.entries(scene, args)?, folder)))
            .collect::<Result<Vec<_>, String>>()?;
        let cancel = interrupt_flag()?;
        let mut report = String::new();
        for (contestants, folder) in scenes {
            let race = plan.race(contestants, &cancel)?;
            report += &report::write(&race, folder)?;
            if race.interrupted {
                break;
            }
        }
        let status = if cancel.load(Ordering::Relaxed) {
            super::INTERRUPTED
        } else {
            0
        };
        Ok(Outcome { report, status })
    })
}

/// The values of a list with commas; the error is one line.
fn list<T: FromStr<Err = String> + PartialEq>(text: Option<&str>) -> Result<Vec<T>, String> {
    let mut values = Vec::new();
    for word in text.into_iter().flat_map(|text| text.split(',')) {
        let value = word.trim().parse()?;
        if !values.contains(&value) {
            values.push(value);
        }
    }
    Ok(values)
}

/// What was asked for, or else what the scene has.
fn or<T: Copy>(asked: &[T], scene: T) -> Vec<T> {
    if asked.is_empty() {
        vec![scene]
    } else {
        asked.to_vec()
    }
}

/// A scene with everyone who races in it.
struct Contestants {
    scene: Arc<Scene>,
    entries: Vec<Entry>,
    views: Vec<View>,
}

impl Plan {
    fn new(args: &RaceArgs) -> Result<Self, String> {
        let positive = args.seconds > 0.0 && args.seconds.is_finite();
        if !positive || args.seeds == 0 {
            return Err(format!(
                "--seconds {} --seeds {}: nobody can race for that long; use more than 0 of both",
                args.seconds, args.seeds
            ));
        }
        let filters: Vec<Filter> = list(args.filters.as_deref())?;
        let methods = match list(args.methods.as_deref())? {
            none if none.is_empty() => Method::ALL.to_vec(),
            some => some,
        };
        let reference = match &args.reference {
            None => None,
            Some(path) if args.scenes.len() > 1 || filters.len() > 1 => {
                return Err(format!(
                    "{}: one reference fits one scene with one filter; name one of each",
                    path.display()
                ));
            }
            Some(path) => Some((path.display().to_string(), image_io::read(path)?)),
        };
        let mut scenes = Vec::new();
        for given in &args.scenes {
            let scene = scene_path(given)?;
            let folder = match args.scenes.len() {
                1 => args.output.clone(),
                _ => args.output.join(stem(&scene)),
            };
            if scenes.iter().any(|(_, other)| *other == folder) {
                return Err(format!(
                    "{}: two scenes of this name would write into one folder; race them apart",
                    given.display()
                ));
            }
            check_folder(&folder)?;
            scenes.push((scene, folder));
        }
        Ok(Self {
            methods,
            accels: list(args.accels.as_deref())?,
            samplers: list(args.samplers.as_deref())?,
            filters,
            rules: Rules {
                seconds: args.seconds,
                seeds: args.seeds,
            },
            reference,
            scenes,
        })
    }

    /// Opens a scene and lines up who races in it.
    fn entries(&self, path: &Path, args: &RaceArgs) -> Result<Contestants, String> {
        let opened = open(
            path,
            |desc| {
                let render = &mut desc.render;
                [render.width, render.height] = args.size.unwrap_or([render.width, render.height]);
                render.depth = args.depth.unwrap_or(render.depth);
                render.problem().map_or(Ok(()), Err)
            },
            &|_| (),
        )?;
        let scene = opened.scene;
        print_warnings(&scene);
        if scene.lights().is_empty() && scene.desc().background == Vec3::ZERO {
            return Err(format!(
                "{}: nothing emits light, so there is no error to race for; give a material an emission, or set background",
                path.display()
            ));
        }
        let base = scene.desc().render;
        if let Some((name, image)) = &self.reference
            && (image.width, image.height) != (base.width, base.height)
        {
            return Err(format!(
                "{name}: is {}x{} but the race {}x{}; use --size {}x{}",
                image.width, image.height, base.width, base.height, image.width, image.height
            ));
        }
        let accels = or(&self.accels, base.accel);
        let samplers = or(&self.samplers, base.sampler);
        let filters = or(&self.filters, base.filter);
        let (mut entries, mut views) = (Vec::new(), Vec::new());
        for accel in accels {
            let mut desc = scene.desc().clone();
            desc.render.accel = accel;
            let scene = Arc::new(scene.edit(desc, &|_| ()).map_err(|e| e.to_string())?);
            for filter in &filters {
                for sampler in &samplers {
                    for method in &self.methods {
                        let entry = Entry {
                            method: *method,
                            accel,
                            sampler: *sampler,
                            filter: *filter,
                        };
                        views.push(View::new(
                            scene.clone(),
                            &scene.desc().camera,
                            entry.on(base),
                        )?);
                        entries.push(entry);
                    }
                }
            }
        }
        Ok(Contestants {
            scene,
            entries,
            views,
        })
    }

    fn race(&self, contestants: Contestants, cancel: &AtomicBool) -> Result<Race, String> {
        let Contestants {
            scene,
            entries,
            views,
        } = contestants;
        // On standard error, and only if that is a terminal.
        let bar = ProgressBar::new(BAR_STEPS).with_finish(ProgressFinish::AndClear);
        if let Ok(style) = ProgressStyle::with_template("{bar:24} {msg}") {
            bar.set_style(style);
        }
        let begin = Instant::now();
        let show = |what: &str, share: f64| {
            bar.set_position((share * BAR_STEPS as f64) as u64);
            let left = begin.elapsed().as_secs_f64() * (1.0 - share) / share;
            let left = if left.is_finite() { left.ceil() } else { 0.0 };
            bar.set_message(format!("{what}, {left:.0} s left"));
        };
        let clock = || begin.elapsed().as_secs_f64();
        let settings = views[0].settings;
        let references = self.references(&entries, &views, &clock, cancel, &|share| {
            show("reference", share / 2.0);
        });
        let lanes: Option<Vec<(View, &Image)>> = entries
            .iter()
            .zip(&views)
            .map(|(entry, view)| {
                let reference = references.iter().find(|r| r.filter == entry.filter)?;
                Some((view.clone(), &reference.image))
            })
            .collect();
        let records = match lanes {
            Some(lanes) => race::run(&lanes, self.rules, &clock, cancel, &mut |share| {
                let done = if self.reference.is_some() {
                    share
                } else {
                    (1.0 + share) / 2.0
                };
                show("race", done);
            })?,
            None => vec![Record::default(); entries.len()],
        };
        bar.finish_and_clear();
        let runs: Vec<_> = records
            .iter()
            .map(|record| record.runs.as_slice())
            .collect();
        let curves = race::curves(&runs);
        let agreements = agreements(&entries, &records);
        Ok(Race {
            labels: labels(&entries),
            scene,
            settings,
            entries,
            references,
            rules: self.rules,
            records,
            curves,
            agreements,
            interrupted: cancel.load(Ordering::Relaxed),
        })
    }

    /// One reference for each filter, rendered for as long as all contestants race together; fewer
    /// if interrupted.
    fn references(
        &self,
        entries: &[Entry],
        views: &[View],
        clock: &dyn Fn() -> f64,
        cancel: &AtomicBool,
        progress: &dyn Fn(f64),
    ) -> Vec<Reference> {
        let mut filters: Vec<Filter> = Vec::new();
        for entry in entries {
            if !filters.contains(&entry.filter) {
                filters.push(entry.filter);
            }
        }
        if let Some((name, image)) = &self.reference {
            return vec![Reference {
                image: image.clone(),
                filter: filters[0],
                origin: report::Origin::File(name.clone()),
                error: None,
            }];
        }
        let total = self.rules.seconds * self.rules.seeds as f64 * entries.len() as f64;
        let seconds = total / filters.len() as f64;
        let mut references = Vec::new();
        for (i, filter) in filters.iter().enumerate() {
            let mut view = views[0].clone();
            let best = Entry {
                method: Method::Mis,
                sampler: SamplerKind::Sobol,
                filter: *filter,
                accel: AccelKind::Auto,
            };
            // The scene of `views[0]` has some accelerator, which changes no bit.
            if let Ok(other) = View::new(
                view.scene.clone(),
                &view.scene.desc().camera,
                best.on(view.settings),
            ) {
                view = other;
            }
            let film = race::reference(&view, seconds, clock, cancel, &mut |share| {
                progress((i as f64 + share) / filters.len() as f64);
            });
            let Some(film) = film else {
                break;
            };
            references.push(Reference {
                image: film.develop(),
                filter: *filter,
                origin: report::Origin::Rendered {
                    method: best.method,
                    sampler: best.sampler,
                    samples: film.samples(),
                    seconds,
                    seed: race::reference_seed(view.settings.seed),
                },
                error: film.error(),
            });
        }
        references
    }
}

impl Entry {
    /// The settings of a contestant: the scene's, but for what it does differently.
    fn on(self, base: RenderSettings) -> RenderSettings {
        RenderSettings {
            method: self.method,
            accel: self.accel,
            sampler: self.sampler,
            filter: self.filter,
            ..base
        }
    }

    fn words(self) -> [String; 4] {
        [
            self.method.to_string(),
            self.accel.to_string(),
            self.sampler.to_string(),
            self.filter.to_string(),
        ]
    }
}

/// Names of the contestants: their method, and whatever else is not the same for all.
fn labels(entries: &[Entry]) -> Vec<String> {
    let words: Vec<[String; 4]> = entries.iter().map(|entry| entry.words()).collect();
    let differs = |k: usize| k == 0 || words.iter().any(|w| w[k] != words[0][k]);
    let label = |w: &[String; 4]| {
        let told: Vec<&str> = (0..4)
            .filter(|k| differs(*k))
            .map(|k| w[k].as_str())
            .collect();
        told.join(" ")
    };
    words.iter().map(label).collect()
}

/// Every pair that differs in its method only, and so should make one picture.
fn agreements(entries: &[Entry], records: &[Record]) -> Vec<(usize, usize, Agreement)> {
    let mut found = Vec::new();
    for (i, a) in entries.iter().enumerate() {
        for (j, b) in entries.iter().enumerate().skip(i + 1) {
            let alike = Entry {
                method: b.method,
                ..*a
            } == *b;
            if alike && let (Some(x), Some(y)) = (&records[i].light, &records[j].light) {
                found.push((i, j, Agreement::between(x, y)));
            }
        }
    }
    found
}

/// The scene's name without folder and extension.
fn stem(scene: &Path) -> String {
    let name = scene.to_string_lossy();
    let name = name.strip_prefix(super::BUILTIN_PREFIX).unwrap_or(&name);
    Path::new(name).file_stem().map_or_else(
        || "scene".to_owned(),
        |stem| stem.to_string_lossy().into_owned(),
    )
}

/// Makes a folder and checks that files can be written there.
fn check_folder(folder: &Path) -> Result<(), String> {
    let probe = folder.join(format!(".race.{}.part", std::process::id()));
    fs::create_dir_all(folder)
        .and_then(|()| fs::write(&probe, ""))
        .and_then(|()| fs::remove_file(&probe))
        .map_err(|e| cannot_write(folder, &e))
}

fn cannot_write(path: &Path, e: &std::io::Error) -> String {
    format!(
        "{}: cannot be written ({e}); choose a folder that you may write to",
        path.display()
    )
}
