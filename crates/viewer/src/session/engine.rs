//! The engine thread: takes the newest wishes, renders, publishes.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::PathBuf;
use std::sync::atomic::Ordering;
use std::sync::{Arc, PoisonError};

use lightbox_core::image_io::tone_mapped;
use lightbox_core::part;
use lightbox_core::scene::Source;
use lightbox_core::{Image, RenderSettings, Scene, SceneDesc, View};
use rayon::ThreadPool;

use super::budget::{Budget, Outlook};
use super::history::{History, Moment, Point};
use super::keeper::{Keeper, Taken};
use super::look::Look;
use super::picture::Picture;
use super::preview::Governor;
use super::{
    Activity, Inbox, Kept, Loaded, Reference, Referring, Region, Shared, Shown, Snapshot, lock,
};
use crate::aov::Aov;
use crate::savings::{Savings, Trial};

struct Engine<'a> {
    shared: &'a Arc<Shared>,
    pool: &'a ThreadPool,
    source: Option<Source>,
    scene: Option<Arc<Scene>>,
    desc: Arc<SceneDesc>,
    /// Counts files, as `Status::opened` does.
    opened: u64,
    /// The work that builds an accelerator, and the description it is for.
    rebuilding: Option<(u64, Arc<SceneDesc>)>,
    picture: Option<Picture>,
    governor: Governor,
    look: Look,
    paused: bool,
    /// Whether what is shown lags behind the look.
    stale: bool,
    snapshots: u64,
    /// Shared with the window, which reads it at leisure.
    history: Arc<History>,
    /// What is looked back to.
    past: Option<Moment>,
    reference: Option<Arc<Reference>>,
    /// Whether the reference is shown beside the picture.
    compares: bool,
    /// What is rendered first.
    region: Option<Region>,
    budget: Budget,
    outlook: Outlook,
    /// Seconds that it took to load and to build the scene of the file.
    opening: [f64; 2],
    /// Measures what the plan saves.
    trial: Option<Trial>,
    savings: Option<Savings>,
    /// Keeps the samples in a file.
    keeper: Option<Keeper>,
}

/// Serves a session until it ends.
pub(super) fn run(shared: &Arc<Shared>, pool: &ThreadPool) {
    let mut engine = Engine {
        shared,
        pool,
        source: None,
        scene: None,
        desc: Arc::default(),
        opened: 0,
        rebuilding: None,
        picture: None,
        governor: Governor::default(),
        look: Look::default(),
        paused: false,
        stale: false,
        snapshots: 0,
        history: Arc::default(),
        past: None,
        reference: None,
        compares: false,
        region: None,
        budget: Budget::default(),
        outlook: Outlook::default(),
        opening: [0.0; 2],
        trial: None,
        savings: None,
        keeper: None,
    };
    while let Some(inbox) = engine.next_messages() {
        // A defect must cost one picture, not the window.
        let step = AssertUnwindSafe(|| {
            engine.apply(inbox);
            engine.work();
        });
        if catch_unwind(step).is_err() {
            engine.picture = None;
            shared.notify(
                "rendering failed by a defect in lightbox; please report it".into(),
                true,
            );
        }
    }
    if let (Some(keeper), Some(picture)) = (engine.keeper, &engine.picture) {
        keeper.close(shared, picture.progress.seconds);
    }
    lock(&shared.outbox).has_ended = true;
}

impl Engine<'_> {
    /// What has arrived since; sleeps if there is nothing else to do. `None` at the end.
    fn next_messages(&mut self) -> Option<Inbox> {
        let idle = !self.has_work();
        let mut inbox = lock(&self.shared.inbox);
        while idle && inbox.is_empty() {
            inbox = self
                .shared
                .arrived
                .wait(inbox)
                .unwrap_or_else(PoisonError::into_inner);
        }
        // Under the lock: a message that comes later sets it again.
        self.shared.cancel.store(false, Ordering::Relaxed);
        (!inbox.quit).then(|| std::mem::take(&mut *inbox))
    }

    fn has_work(&self) -> bool {
        let Some(picture) = &self.picture else {
            return false;
        };
        let rests = self.paused || picture.is_done();
        self.stale || picture.has_previews() || self.trial.is_some() || !rests
    }

    fn apply(&mut self, inbox: Inbox) {
        if let Some(paused) = inbox.paused {
            self.paused = paused;
        }
        let mut looks_back = inbox.past.is_some();
        self.past = inbox.past.unwrap_or(self.past);
        let other_tone = inbox.look.is_some_and(|look| look.tone != self.look.tone);
        if let Some(look) = inbox.look {
            self.stale |= look != self.look;
            looks_back |= other_tone;
            self.look = look;
        }
        match inbox.opened {
            Some(Ok(loaded)) => self.open(*loaded),
            Some(Err(message)) => self.shared.notify(message, true),
            None => {}
        }
        if let Some((number, scene)) = inbox.rebuilt {
            self.take_up(number, scene);
        }
        match inbox.edit {
            Some((opened, desc)) if opened == self.opened => self.edit(desc),
            _ => {} // None, or meant for the scene before.
        }
        if let Some(budget) = inbox.budget {
            self.budget = budget;
            self.budget();
        }
        if let Some(region) = inbox.region {
            self.region = region;
            if let Some(picture) = &mut self.picture {
                picture.prefer(region);
            }
        }
        if inbox.clear_history {
            Arc::make_mut(&mut self.history).clear();
        }
        let shows_other = inbox.compares.is_some() || inbox.reference.is_some();
        self.compares = inbox.compares.unwrap_or(self.compares);
        if let Some(referring) = inbox.reference {
            self.refer(referring);
        }
        if shows_other || other_tone {
            self.show_other();
        }
        if looks_back {
            self.look_back();
        }
        if inbox.measure_plan {
            self.measure_plan();
        }
        if let Some(path) = inbox.keep {
            self.keep(path);
        }
        if let Some(kept) = inbox.kept {
            self.kept(kept);
        }
    }

    /// Keeps the samples of the picture in a file from now on.
    fn keep(&mut self, path: PathBuf) {
        let checked = part::check_writable(&path).and_then(|()| match &self.picture {
            Some(picture) if picture.film.samples() > 0 => Ok(picture),
            _ => Err("there are no samples to save yet".into()),
        });
        match checked {
            Ok(picture) => {
                if let Some(before) = self.keeper.take() {
                    before.close(self.shared, picture.progress.seconds);
                }
                let (view, film, tone) = (&picture.view, picture.film.clone(), self.look.tone);
                self.keeper = Some(Keeper::new(path, view, tone, film, 0));
                self.tend(true);
            }
            Err(message) => self.shared.notify(message, true),
        }
    }

    /// Has the samples written if it is time to, or `now`.
    fn tend(&mut self, now: bool) {
        let (Some(keeper), Some(picture)) = (&mut self.keeper, &self.picture) else {
            return;
        };
        let rests = now || self.paused || picture.is_done();
        keeper.tend(self.shared, picture.progress.seconds, rests);
    }

    /// Takes note of how a writing went.
    fn kept(&mut self, (path, kept): Kept) {
        let Some(keeper) = self.keeper.as_mut().filter(|k| k.path() == path) else {
            return;
        };
        match kept {
            Ok(samples) if keeper.written(samples) => {
                let path = keeper.path().display();
                let text =
                    format!("saved {path}; kept up to date as long as the picture is the same");
                self.shared.notify(text, false);
            }
            Ok(_) => {}
            Err(message) => {
                self.keeper = None;
                self.shared.notify(message, true);
            }
        }
    }

    /// Sets up what the plan of the present view is measured by.
    fn measure_plan(&mut self) {
        let Some(picture) = &self.picture else { return };
        match Trial::new(&picture.view, &picture.camera) {
            Ok(trial) => self.trial = trial,
            Err(message) => self.shared.notify(message, true),
        }
    }

    /// Tells the picture when it is done.
    fn budget(&mut self) {
        if let Some(picture) = &mut self.picture {
            picture.limits = self.budget.limits(picture.view.settings.samples);
            // What is done all at once was perhaps not measured yet.
            self.stale |= picture.is_done() && !picture.is_measured();
        }
        self.foretell();
    }

    fn foretell(&mut self) {
        if let (Some(picture), Some(run)) = (&self.picture, &self.history.present) {
            let goal = self.budget.goal(picture.view.settings.samples);
            self.outlook.update(run, goal, picture.is_done());
        }
    }

    /// Readies the picture that is looked back to.
    fn look_back(&mut self) {
        let kept = self.past.and_then(|moment| self.history.picture(moment));
        let past = kept.map(|(point, image)| {
            self.snapshots += 1;
            Arc::new(still(image, self.look, self.snapshots, Some(*point)))
        });
        lock(&self.shared.outbox).past = past;
    }

    /// Readies the reference to be shown beside the picture.
    fn show_other(&mut self) {
        let reference = self.reference.as_ref().filter(|_| self.compares);
        let other = reference.map(|reference| {
            self.snapshots += 1;
            Arc::new(still(&reference.image, self.look, self.snapshots, None))
        });
        lock(&self.shared.outbox).other = other;
        (self.shared.wake)();
    }

    fn refer(&mut self, referring: Referring) {
        self.reference = match (referring, &self.picture) {
            (Referring::To(reference), _) => Some(reference),
            (Referring::ToPresent, Some(picture)) if picture.film.samples() > 0 => {
                let settings = &picture.view.settings;
                Some(Arc::new(Reference {
                    image: self.pool.install(|| picture.film.develop()).into(),
                    name: format!("{} spp {}", picture.film.samples(), settings.method),
                    stream: Some((settings.sampler, settings.seed)),
                }))
            }
            (Referring::ToPresent, _) => return,
            (Referring::ToNone, _) => None,
        };
        Arc::make_mut(&mut self.history).refer(self.reference.as_deref());
        if let Some(picture) = &mut self.picture {
            picture.refer(self.reference.clone());
            // Measured anew as it is drawn.
            self.stale |= picture.film.samples() > 0;
        }
    }

    /// Goes over to another file.
    fn open(&mut self, loaded: Loaded) {
        let Loaded {
            source,
            scene,
            tone,
            opening,
            taken,
        } = loaded;
        self.abandon_rebuild();
        self.source = Some(source);
        self.opening = opening;
        self.scene = Some(scene.clone());
        self.governor = Governor::default();
        self.look.tone = tone.unwrap_or(self.look.tone);
        self.desc = Arc::new(scene.desc().clone());
        self.opened += 1;
        {
            let mut outbox = lock(&self.shared.outbox);
            outbox.status.opened = self.opened;
            outbox.status.tone = tone;
            outbox.status.scene = Some(scene);
            outbox.status.desc = self.desc.clone();
        }
        self.begin(taken);
    }

    /// Goes over to a scene with edited shapes.
    fn take_up(&mut self, number: u64, scene: Result<Scene, String>) {
        let Some((_, wanted)) = self.rebuilding.take_if(|(n, _)| *n == number) else {
            return; // It has been superseded.
        };
        match scene {
            Ok(scene) => {
                self.scene = Some(Arc::new(scene));
                // Edits may have come while the accelerator was built.
                self.edit(self.desc.clone());
            }
            Err(message) => {
                self.shared.notify(message, true);
                if wanted != self.desc {
                    // What was wrong may have been put right while the accelerator was built.
                    self.edit(self.desc.clone());
                }
            }
        }
    }

    /// Goes over to an edited description with as little new work as it allows.
    fn edit(&mut self, desc: Arc<SceneDesc>) {
        let Some(mut scene) = self.scene.clone() else {
            return;
        };
        self.desc = desc.clone();
        if scene.rebuilds_for(&desc) {
            self.rebuild(&scene, desc.clone());
            // The old shapes from the new place, until the new are ready.
            let shows = |picture: &Picture| {
                picture.camera == desc.camera && Arc::ptr_eq(&picture.view.scene, &scene)
            };
            if !self.picture.as_ref().is_some_and(shows) {
                self.restart();
            }
            return;
        }
        self.abandon_rebuild();
        let same_surfaces = (&desc.materials, desc.background)
            == (&scene.desc().materials, scene.desc().background)
            && desc.same_assignments(scene.desc());
        if !same_surfaces {
            match scene.edit((*desc).clone(), &lightbox_core::scene::unwatched) {
                Ok(edited) => scene = Arc::new(edited),
                Err(e) => return self.shared.notify(e.to_string(), true),
            }
            self.scene = Some(scene.clone());
        }
        match &mut self.picture {
            Some(picture)
                if Arc::ptr_eq(&picture.view.scene, &scene)
                    && picture.camera == desc.camera
                    && desc.render
                        == (RenderSettings {
                            samples: desc.render.samples,
                            ..picture.view.settings
                        }) =>
            {
                picture.view.settings.samples = desc.render.samples;
                self.budget();
            }
            _ => self.restart(),
        }
    }

    /// Has an accelerator built in the background. One at a time: a drag would start one for each
    /// frame and see none. What has changed since is seen to when it is there.
    fn rebuild(&mut self, scene: &Arc<Scene>, desc: Arc<SceneDesc>) {
        if self.rebuilding.is_some() {
            return;
        }
        let (scene, edited) = (scene.clone(), desc.clone());
        let number = self.shared.start(
            |outbox| &mut outbox.rebuilding,
            scene.path().display().to_string(),
            move |watcher| {
                scene
                    .edit((*edited).clone(), watcher)
                    .map_err(|e| e.to_string())
            },
            |inbox, number, scene| inbox.rebuilt = Some((number, scene)),
        );
        self.rebuilding = Some((number, desc));
    }

    /// Drops an accelerator in the making: what asked for it has been taken back.
    fn abandon_rebuild(&mut self) {
        if self.rebuilding.take().is_some() {
            lock(&self.shared.outbox).rebuilding = None;
        }
    }

    /// Starts the present description's picture anew.
    fn restart(&mut self) {
        self.begin(None);
    }

    /// Starts the present description's picture, with the samples that the file it was opened from
    /// holds.
    fn begin(&mut self, taken: Option<Taken>) {
        let Some(scene) = self.scene.clone() else {
            return;
        };
        match View::new(scene, &self.desc.camera, self.desc.render) {
            Ok(view) => {
                self.tend(true); // What is left behind is kept to its last sample.
                let kept = self.keeper.take();
                (self.trial, self.savings) = (None, None);
                let mut picture = Picture::new(view, self.desc.camera, &self.governor);
                picture.refer(self.reference.clone());
                picture.prefer(self.region);
                self.stale |= taken.is_some() || self.look.aov.is_of_surfaces();
                if let Some(taken) = taken {
                    picture.take_up(taken);
                    let (path, film) = (picture.view.scene.path().to_owned(), &picture.film);
                    let saved = film.samples();
                    let tone = self.look.tone;
                    let keeper = Keeper::new(path, &picture.view, tone, film.clone(), saved);
                    self.keeper = Some(keeper);
                } else if let Some(keeper) = kept {
                    let path = keeper.path().display();
                    let text = format!("{path}: keeps the picture as it was; save this one anew");
                    self.shared.notify(text, false);
                }
                let is_edited = self.source.as_ref().is_some_and(|source| {
                    let (camera, render) = (source.desc.camera, source.desc.render);
                    let desc = picture.view.scene.desc().clone();
                    source.desc
                        != (SceneDesc {
                            camera,
                            render,
                            ..desc
                        })
                });
                let mut outbox = lock(&self.shared.outbox);
                outbox.status.is_edited = is_edited;
                outbox.shown = Some(Shown {
                    view: picture.view.clone(),
                    camera: picture.camera,
                    film: picture.film.clone(),
                    is_edited,
                });
                drop(outbox);
                let was_done = self.picture.as_ref().is_some_and(Picture::is_done);
                let path = picture.view.scene.path().to_owned();
                Arc::make_mut(&mut self.history).begin(self.desc.clone(), path, was_done);
                self.picture = Some(picture);
                self.budget();
            }
            Err(message) => self.shared.notify(message, true),
        }
    }

    /// One step: a preview, a slice of samples, or a fresh look at the samples there are.
    fn work(&mut self) {
        let has_work = self.has_work();
        let (stale, look) = (std::mem::take(&mut self.stale), self.look);
        let (governor, cancel) = (&mut self.governor, &self.shared.cancel);
        let (trial, savings) = (&mut self.trial, &mut self.savings);
        let mut redraws = false;
        let snapshot = match &mut self.picture {
            Some(picture) if has_work => self.pool.install(|| {
                if picture.has_previews() {
                    picture.preview(governor, cancel, look)
                } else if stale {
                    redraws = true;
                    picture.redraw(look, cancel)
                } else if let Some(trial) = trial {
                    trial.round(cancel);
                    *savings = trial.savings();
                    None
                } else {
                    picture.slice(governor, cancel, look)
                }
            }),
            _ => None,
        };
        if self.savings.is_some() {
            self.trial = None;
        }
        self.stale |= stale && !(redraws && snapshot.is_some());
        let snapshot = snapshot.map(|snapshot| {
            self.snapshots += 1;
            let number = self.snapshots;
            Arc::new(Snapshot { number, ..snapshot })
        });
        if has_work {
            self.record();
        }
        self.tend(false);
        self.report(snapshot);
    }

    /// Takes down how good the picture is, once every pixel has as many samples.
    fn record(&mut self) {
        if let Some(picture) = &self.picture
            && let Some(point) = picture.point()
        {
            let develop = || self.pool.install(|| picture.film.develop());
            Arc::make_mut(&mut self.history).record(point, develop);
            self.foretell();
        }
    }

    /// Hands a picture, if there is a new one, and the status to the window, which never sees one
    /// without the other, and wakes it.
    fn report(&self, snapshot: Option<Arc<Snapshot>>) {
        let figures = self
            .picture
            .as_ref()
            .map(|p| (p, p.film.samples(), p.error(), p.film.invalid().0));
        let mut outbox = lock(&self.shared.outbox);
        if snapshot.is_some() {
            outbox.snapshot = snapshot;
        }
        outbox.history.clone_from(&self.history);
        let status = &mut outbox.status;
        status.scene.clone_from(&self.scene);
        status.reference.clone_from(&self.reference);
        if let Some((picture, samples, error, invalid)) = figures {
            status.activity = if picture.is_done() {
                Activity::Done
            } else if self.paused {
                Activity::Paused
            } else {
                Activity::Rendering
            };
            status.samples = samples;
            status.seconds = picture.progress.seconds;
            (status.rays, status.paths) = (picture.work.rays, picture.work.paths);
            status.noise = error.map(|e| e.noise());
            status.true_error = picture.true_error();
            status.invalid = invalid;
            (status.lost, status.enough_depth) = (picture.lost(), picture.enough_depth());
            status.left_out = picture.view.plan().left_out().collect();
            status.is_measuring = self.trial.is_some();
            status.savings.clone_from(&self.savings);
            status.spent = picture.spent(self.opening, self.pool.current_num_threads());
            status.share = picture.limits.fraction(&picture.progress);
            (status.budget, status.forecast) = (self.budget, self.outlook.forecast);
            status.promise = self.outlook.promise;
        }
        drop(outbox);
        (self.shared.wake)();
    }
}

/// A picture that no longer changes, as it is shown.
fn still(image: &Image, look: Look, number: u64, past: Option<Point>) -> Snapshot {
    let size = [image.width as usize, image.height as usize];
    Snapshot {
        size,
        rgb: tone_mapped(image, look.tone),
        picture: size,
        preview: None,
        past,
        aov: Aov::COLOR,
        number,
    }
}
