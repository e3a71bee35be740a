//! The engine thread: takes the newest wishes, renders, publishes.

mod beside;
mod scene;

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::atomic::Ordering;
use std::sync::{Arc, PoisonError};

use lightbox_core::scene::Source;
use lightbox_core::{Scene, SceneDesc};
use rayon::ThreadPool;

use super::budget::{Budget, Outlook};
use super::history::{History, Moment};
use super::keeper::Keeper;
use super::look::Look;
use super::picture::Picture;
use super::preview::Governor;
use super::{Activity, Inbox, Reference, Region, Shared, Snapshot, lock};
use crate::savings::{Savings, Trial};

struct Engine<'a> {
    shared: &'a Arc<Shared>,
    pool: ThreadPool,
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
    /// Whether it makes one more pass nevertheless.
    adds_pass: bool,
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
pub(super) fn run(shared: &Arc<Shared>, pool: ThreadPool) {
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
        adds_pass: false,
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
        let rests = (self.paused && !self.adds_pass) || picture.is_done();
        self.stale || picture.has_previews() || self.trial.is_some() || !rests
    }

    fn apply(&mut self, inbox: Inbox) {
        if let Some(paused) = inbox.paused {
            self.paused = paused;
        }
        self.adds_pass = self.paused && (self.adds_pass || inbox.pass);
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
        match inbox.threads.map(super::tracers) {
            Some(Ok(pool)) => self.pool = pool,
            Some(Err(message)) => self.shared.notify(message, true),
            None => {}
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

    /// One step: a preview, a slice of samples, or a fresh look at the samples there are.
    fn work(&mut self) {
        let has_work = self.has_work();
        let (stale, look) = (std::mem::take(&mut self.stale), self.look);
        let (governor, cancel) = (&mut self.governor, &self.shared.cancel);
        let (trial, savings) = (&mut self.trial, &mut self.savings);
        let adds_pass = &mut self.adds_pass;
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
                    picture.one_by_one = *adds_pass;
                    let slice = picture.slice(governor, cancel, look);
                    *adds_pass &= picture.is_in_pass();
                    slice
                }
            }),
            _ => None,
        };
        if self.savings.is_some() {
            self.trial = None;
        }
        let is_drawn = self.picture.as_ref().is_some_and(Picture::is_drawn);
        self.stale |= stale && !(redraws && snapshot.is_some() && is_drawn);
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
        status.threads = self.pool.current_num_threads();
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
            status.spent = picture.spent(self.opening);
            status.share = picture.limits.fraction(&picture.progress);
            (status.budget, status.forecast) = (self.budget, self.outlook.forecast);
            status.promise = self.outlook.promise;
        }
        drop(outbox);
        (self.shared.wake)();
    }
}
