//! Races of ways to make one picture, for the command and for the window: who takes part, what
//! they are measured against, and what comes of it.

mod chart;
mod live;
pub mod report;

use std::collections::HashMap;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Instant;

use lightbox_core::agreement::Agreement;
use lightbox_core::film::ErrorEstimate;
use lightbox_core::race::{self, Curve, Record, Rules, Run};
use lightbox_core::scene::CameraDesc;
use lightbox_core::{AccelKind, Filter, Image, Method, RenderSettings, SamplerKind, Scene, View};
use serde::Serialize;

pub use live::{Live, Stage, Standing};

/// What one of the contestants does.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Entry {
    /// How it finds light.
    pub method: Method,
    /// How its rays find surfaces.
    pub accel: AccelKind,
    /// Its random numbers.
    pub sampler: SamplerKind,
    /// Its pixel filter.
    pub filter: Filter,
}

/// What is to be tried, every combination of it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Choice {
    /// Methods.
    pub methods: Vec<Method>,
    /// Accelerators.
    pub accels: Vec<AccelKind>,
    /// Samplers.
    pub samplers: Vec<SamplerKind>,
    /// Pixel filters.
    pub filters: Vec<Filter>,
}

/// A picture that is made in several ways.
#[derive(Clone)]
pub struct Contest {
    scene: Arc<Scene>,
    camera: CameraDesc,
    settings: RenderSettings,
    /// Who takes part.
    pub entries: Vec<Entry>,
}

/// What the contestants with one filter are measured against.
#[derive(Clone)]
pub struct Reference {
    /// The picture.
    pub image: Arc<Image>,
    filter: Filter,
    origin: Origin,
    error: Option<ErrorEstimate>,
}

/// Where a reference comes from.
#[derive(Clone, Debug, Serialize)]
#[serde(rename_all = "lowercase")]
enum Origin {
    /// A picture that the user named.
    File(String),
    /// Rendered before the race.
    Rendered {
        method: Method,
        sampler: SamplerKind,
        samples: u64,
        seconds: f64,
        seed: u64,
    },
}

/// A race when it is over.
pub struct Race {
    /// The scene.
    pub scene: Arc<Scene>,
    /// What all contestants have in common.
    pub settings: RenderSettings,
    entries: Vec<Entry>,
    /// Their names.
    pub labels: Vec<String>,
    references: Vec<Reference>,
    rules: Rules,
    /// What was measured.
    pub records: Vec<Record>,
    /// The same, over all seeds.
    pub curves: Vec<Curve>,
    /// Pairs of contestants that differ in their method only.
    pub agreements: Vec<(usize, usize, Agreement)>,
    /// Whether it was stopped before its end.
    pub interrupted: bool,
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

impl Choice {
    /// All combinations.
    pub fn entries(&self) -> Vec<Entry> {
        let mut entries = Vec::new();
        for accel in &self.accels {
            for filter in &self.filters {
                for sampler in &self.samplers {
                    entries.extend(self.methods.iter().map(|method| Entry {
                        method: *method,
                        accel: *accel,
                        sampler: *sampler,
                        filter: *filter,
                    }));
                }
            }
        }
        entries
    }
}

impl Contest {
    /// A contest of every combination. The error, about a view that cannot be, is one line.
    pub fn new(
        scene: Arc<Scene>,
        camera: CameraDesc,
        settings: RenderSettings,
        choice: &Choice,
    ) -> Result<Self, String> {
        if scene.is_dark() {
            return Err(format!(
                "{}: nothing emits light, so there is no error to race for; give a material an emission, or set background",
                scene.path().display()
            ));
        }
        let entries = choice.entries();
        for entry in &entries {
            View::new(scene.clone(), &camera, entry.on(settings))?;
        }
        Ok(Self {
            scene,
            camera,
            settings,
            entries,
        })
    }

    /// Its views, with accelerators built where the scene has another one.
    fn views(&self) -> Result<Vec<View>, String> {
        let mut scenes: HashMap<AccelKind, Arc<Scene>> = HashMap::new();
        let mut views = Vec::new();
        for entry in &self.entries {
            let scene = match scenes.get(&entry.accel) {
                Some(scene) => scene.clone(),
                None => {
                    let scene = self.scene.with_accel(entry.accel);
                    let scene = scene.map_err(|e| e.to_string())?;
                    scenes.entry(entry.accel).or_insert(scene).clone()
                }
            };
            views.push(View::new(scene, &self.camera, entry.on(self.settings))?);
        }
        Ok(views)
    }

    /// Lets them race on the threads of the current rayon pool. Without a `reference`, one is
    /// rendered before for each filter, for as long as all contestants race together. When
    /// `cancel` is set, what there is comes back. The error is one line.
    pub fn hold(
        self,
        rules: Rules,
        reference: Option<(String, Arc<Image>)>,
        cancel: &AtomicBool,
        watch: &mut dyn FnMut(Stage<'_>),
    ) -> Result<Race, String> {
        let begin = Instant::now();
        let clock = || begin.elapsed().as_secs_f64();
        let views = self.views()?;
        let before = if reference.is_some() { 0.0 } else { 0.5 };
        let references = match reference {
            Some((name, image)) => vec![Reference {
                image,
                filter: self.settings.filter,
                origin: Origin::File(name),
                error: None,
            }],
            None => self.references(&views, rules, &clock, cancel, &mut |share| {
                watch(Stage::Reference(before * share));
            }),
        };
        let lanes: Option<Vec<(View, &Image)>> = self
            .entries
            .iter()
            .zip(&views)
            .map(|(entry, view)| {
                let is_its = |r: &&Reference| r.filter == entry.filter;
                let reference = references.iter().find(is_its)?;
                Some((view.clone(), &*reference.image))
            })
            .collect();
        let records = match lanes {
            Some(lanes) => race::run(&lanes, rules, &clock, cancel, &mut |share, records| {
                watch(Stage::Race(before + share * (1.0 - before), records));
            })?,
            None => vec![Record::default(); self.entries.len()],
        };
        Ok(Race {
            labels: labels(&self.entries),
            agreements: agreements(&self.entries, &records),
            curves: curves(&records),
            scene: self.scene,
            settings: self.settings,
            entries: self.entries,
            references,
            rules,
            records,
            interrupted: cancel.load(Ordering::Relaxed),
        })
    }

    /// One reference for each filter; fewer if interrupted.
    fn references(
        &self,
        views: &[View],
        rules: Rules,
        clock: &dyn Fn() -> f64,
        cancel: &AtomicBool,
        progress: &mut dyn FnMut(f64),
    ) -> Vec<Reference> {
        // The first contestant with each.
        let mut firsts: Vec<usize> = Vec::new();
        for (i, entry) in self.entries.iter().enumerate() {
            if firsts
                .iter()
                .all(|j| self.entries[*j].filter != entry.filter)
            {
                firsts.push(i);
            }
        }
        let total = rules.seconds * rules.seeds as f64 * self.entries.len() as f64;
        let seconds = total / firsts.len() as f64;
        let mut references = Vec::new();
        for (done, first) in firsts.iter().enumerate() {
            let view = views[*first].found_by(Method::Reuse, SamplerKind::Sobol);
            let film = race::reference(&view, seconds, clock, cancel, &mut |share| {
                progress((done as f64 + share) / firsts.len() as f64);
            });
            let Some(film) = film else { break };
            references.push(Reference {
                image: film.develop().into(),
                filter: view.settings.filter,
                origin: Origin::Rendered {
                    method: view.settings.method,
                    sampler: view.settings.sampler,
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

/// The curves of all contestants.
pub fn curves(records: &[Record]) -> Vec<Curve> {
    let runs: Vec<&[Run]> = records.iter().map(|r| r.runs.as_slice()).collect();
    race::curves(&runs)
}

/// Names of the contestants: their method, and whatever else is not the same for all.
pub fn labels(entries: &[Entry]) -> Vec<String> {
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
