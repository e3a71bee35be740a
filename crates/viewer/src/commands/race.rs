//! `lightbox race`: error against time of several ways to make one picture.

use std::path::{Path, PathBuf};
use std::str::FromStr;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Instant;

use indicatif::{ProgressBar, ProgressFinish, ProgressStyle};
use lightbox_core::race::Rules;
use lightbox_core::{Image, Method, image_io};

use super::{Outcome, interrupt_flag, open, print_warnings, scene_path, threads};
use crate::args::RaceArgs;
use crate::race::{Choice, Contest, Race, Stage, report};

/// Steps of the progress bar.
const BAR_STEPS: u64 = 1000;

/// What is wished for, checked and read: no work is done before all of it is right.
struct Plan {
    /// Where nothing is asked for, what the scene has.
    choice: Choice,
    rules: Rules,
    reference: Option<(String, Arc<Image>)>,
    /// Each scene and the folder for its files.
    scenes: Vec<(PathBuf, PathBuf)>,
}

/// Races; returns the tables. The error is one line.
pub fn run(args: &RaceArgs) -> Result<Outcome, String> {
    let plan = Plan::new(args)?;
    threads(args.threads)?.install(|| {
        let scenes = plan
            .scenes
            .iter()
            .map(|(scene, folder)| Ok((plan.contest(scene, args)?, folder)))
            .collect::<Result<Vec<_>, String>>()?;
        let cancel = interrupt_flag()?;
        let mut report = String::new();
        for (contest, folder) in scenes {
            let race = plan.race(contest, &cancel)?;
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

impl Plan {
    fn new(args: &RaceArgs) -> Result<Self, String> {
        if !(args.seconds > 0.0 && args.seconds.is_finite()) {
            return Err(format!(
                "--seconds {}: nobody can race for that long; use more than 0",
                args.seconds
            ));
        }
        if args.seeds == 0 {
            return Err("--seeds 0: nothing to race; use 1 or more".into());
        }
        let mut choice = Choice {
            methods: list(args.methods.as_deref())?,
            accels: list(args.accels.as_deref())?,
            samplers: list(args.samplers.as_deref())?,
            filters: list(args.filters.as_deref())?,
        };
        if choice.methods.is_empty() {
            choice.methods = Method::ALL.to_vec();
        }
        let reference = match &args.reference {
            None => None,
            Some(path) if args.scenes.len() > 1 || choice.filters.len() > 1 => {
                return Err(format!(
                    "{}: one reference fits one scene with one filter; name one of each",
                    path.display()
                ));
            }
            Some(path) => Some((path.display().to_string(), image_io::read(path)?.into())),
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
            report::check_folder(&folder)?;
            scenes.push((scene, folder));
        }
        Ok(Self {
            choice,
            rules: Rules {
                seconds: args.seconds,
                seeds: args.seeds,
            },
            reference,
            scenes,
        })
    }

    /// Opens a scene and lines up who races in it.
    fn contest(&self, path: &Path, args: &RaceArgs) -> Result<Contest, String> {
        let opened = open(
            path,
            |desc| {
                let render = &mut desc.render;
                [render.width, render.height] = args.size.unwrap_or([render.width, render.height]);
                render.depth = args.depth.unwrap_or(render.depth);
                render.problem().map_or(Ok(()), Err)
            },
            &lightbox_core::scene::unwatched,
        )?;
        let scene = opened.scene;
        print_warnings(&scene);
        let base = scene.desc().render;
        if let Some((name, image)) = &self.reference
            && (image.width, image.height) != (base.width, base.height)
        {
            return Err(format!(
                "{name}: is {}x{} but the race {}x{}; use --size {}x{}",
                image.width, image.height, base.width, base.height, image.width, image.height
            ));
        }
        let choice = Choice {
            methods: self.choice.methods.clone(),
            accels: or(&self.choice.accels, base.accel),
            samplers: or(&self.choice.samplers, base.sampler),
            filters: or(&self.choice.filters, base.filter),
        };
        let camera = scene.desc().camera;
        Contest::new(scene, camera, base, &choice)
    }

    fn race(&self, contest: Contest, cancel: &AtomicBool) -> Result<Race, String> {
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
        let reference = self.reference.clone();
        let race = contest.hold(self.rules, reference, cancel, &mut |stage| match stage {
            Stage::Reference(share) => show("reference", share),
            Stage::Race(share, _) => show("race", share),
        });
        bar.finish_and_clear();
        race
    }
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
