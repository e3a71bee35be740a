//! The engine thread: takes the newest wishes, renders, publishes.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::atomic::Ordering;
use std::sync::{Arc, PoisonError};

use lightbox_core::color::ToneMap;
use lightbox_core::scene::Source;
use lightbox_core::{RenderSettings, Scene, SceneDesc, View};
use rayon::ThreadPool;

use super::picture::Picture;
use super::preview::Governor;
use super::{Activity, Inbox, Opened, Shared, Shown, Snapshot, lock};

struct Engine<'a> {
    shared: &'a Arc<Shared>,
    pool: &'a ThreadPool,
    source: Option<Source>,
    scene: Option<Arc<Scene>>,
    desc: Arc<SceneDesc>,
    picture: Option<Picture>,
    governor: Governor,
    tone: ToneMap,
    paused: bool,
    /// Whether what is shown lags behind the tone map.
    stale: bool,
    snapshots: u64,
}

/// Serves a session until it ends.
pub(super) fn run(shared: &Arc<Shared>, pool: &ThreadPool) {
    let mut engine = Engine {
        shared,
        pool,
        source: None,
        scene: None,
        desc: Arc::default(),
        picture: None,
        governor: Governor::default(),
        tone: ToneMap::default(),
        paused: false,
        stale: false,
        snapshots: 0,
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
        self.stale || picture.has_previews() || !(self.paused || picture.is_done())
    }

    fn apply(&mut self, mut inbox: Inbox) {
        if let Some(paused) = inbox.paused {
            self.paused = paused;
        }
        if let Some(tone) = inbox.tone {
            self.stale |= tone != self.tone;
            self.tone = tone;
        }
        if let Some(opened) = inbox.opened {
            if opened.is_new {
                inbox.desc = None; // It was meant for the scene before.
            }
            self.take_up(*opened);
        }
        if let Some(desc) = inbox.desc {
            self.edit(desc);
        }
    }

    fn take_up(
        &mut self,
        Opened {
            source,
            scene,
            is_new,
            tone,
        }: Opened,
    ) {
        self.source = Some(source);
        self.scene = Some(scene.clone());
        if is_new {
            self.governor = Governor::default();
            self.tone = tone.unwrap_or(self.tone);
            let desc = Arc::new(scene.desc().clone());
            {
                let mut outbox = lock(&self.shared.outbox);
                outbox.status.opened += 1;
                outbox.status.tone = tone;
                outbox.status.scene = Some(scene.clone());
                outbox.status.desc = desc.clone();
            }
            self.desc = desc;
            self.restart();
        } else {
            // Edits may have come while the accelerator was built.
            self.restart();
            self.edit(self.desc.clone());
        }
    }

    /// Goes over to an edited description with as little new work as it allows.
    fn edit(&mut self, desc: Arc<SceneDesc>) {
        let Some(scene) = self.scene.clone() else {
            return;
        };
        let old = std::mem::replace(&mut self.desc, desc.clone());
        if scene.rebuilds_for(&desc) {
            self.rebuild(scene, desc.clone());
            if desc.camera != old.camera {
                self.restart(); // The old shapes from the new place, until the new are ready.
            }
            return;
        }
        self.shared.abandon_rebuild();
        let same_surfaces = (&desc.materials, desc.background)
            == (&scene.desc().materials, scene.desc().background)
            && desc.same_assignments(scene.desc());
        if !same_surfaces {
            match scene.edit((*desc).clone(), &|_| ()) {
                Ok(scene) => self.scene = Some(Arc::new(scene)),
                Err(e) => return self.shared.notify(e.to_string(), true),
            }
        }
        let samples_only = |a: &SceneDesc, b: &SceneDesc| {
            let render = RenderSettings {
                samples: b.render.samples,
                ..a.render
            };
            (a.camera, render) == (b.camera, b.render)
        };
        match &mut self.picture {
            Some(picture) if same_surfaces && samples_only(&old, &desc) => {
                picture.view.settings.samples = desc.render.samples;
            }
            _ => self.restart(),
        }
    }

    /// Has an accelerator built in the background, unless that is under way already.
    fn rebuild(&self, scene: Arc<Scene>, desc: Arc<SceneDesc>) {
        let Some(source) = self.source.clone() else {
            return;
        };
        let mut rebuilding = lock(&self.shared.rebuilding);
        if rebuilding
            .as_ref()
            .is_some_and(|wanted| wanted.same_shapes(&desc))
        {
            return;
        }
        *rebuilding = Some(desc.clone());
        drop(rebuilding);
        let label = scene.path().display().to_string();
        self.shared.load(label, false, move |progress| {
            let scene = scene
                .edit((*desc).clone(), progress)
                .map_err(|e| e.to_string())?;
            Ok((source, scene, None))
        });
    }

    /// Starts the present description's picture anew.
    fn restart(&mut self) {
        let Some(scene) = self.scene.clone() else {
            return;
        };
        match View::new(scene, &self.desc.camera, self.desc.render) {
            Ok(view) => {
                let picture = Picture::new(view, self.desc.camera, &self.governor);
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
                self.picture = Some(picture);
            }
            Err(message) => self.shared.notify(message, true),
        }
    }

    /// One step: a preview, a slice of samples, or a fresh look at the samples there are.
    fn work(&mut self) {
        let has_work = self.has_work();
        let (stale, tone) = (std::mem::take(&mut self.stale), self.tone);
        let (governor, cancel) = (&mut self.governor, &self.shared.cancel);
        let snapshot = match &mut self.picture {
            Some(picture) if has_work => self.pool.install(|| {
                if picture.has_previews() {
                    picture.preview(governor, cancel, tone)
                } else if stale {
                    Some(picture.redraw(tone))
                } else {
                    picture.slice(governor, cancel, tone)
                }
            }),
            _ => None,
        };
        if let Some(snapshot) = snapshot {
            self.show(snapshot);
        }
        self.report();
    }

    /// Hands a picture to the window.
    fn show(&mut self, snapshot: Snapshot) {
        self.snapshots += 1;
        let number = self.snapshots;
        lock(&self.shared.outbox).snapshot = Some(Arc::new(Snapshot { number, ..snapshot }));
    }

    /// Brings the status up to date and wakes the window.
    fn report(&self) {
        let figures = self
            .picture
            .as_ref()
            .map(|p| (p, p.film.samples(), p.noise(), p.film.invalid().0));
        let mut outbox = lock(&self.shared.outbox);
        let status = &mut outbox.status;
        status.scene.clone_from(&self.scene);
        if let Some((picture, samples, noise, invalid)) = figures {
            let target = picture.view.settings.samples;
            status.activity = if picture.is_done() {
                Activity::Done
            } else if self.paused {
                Activity::Paused
            } else {
                Activity::Rendering
            };
            status.samples = samples;
            status.seconds = picture.seconds;
            (status.rays, status.paths) = (picture.work.rays, picture.work.paths);
            status.noise = noise;
            status.invalid = invalid;
            let per_sample = picture.seconds / samples.max(1) as f64;
            status.eta = (samples > 0).then(|| per_sample * target.saturating_sub(samples) as f64);
        }
        drop(outbox);
        (self.shared.wake)();
    }
}
