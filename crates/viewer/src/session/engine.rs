//! The engine thread: takes the newest wishes, renders, publishes.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::atomic::Ordering;
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::sync::{Arc, PoisonError};
use std::time::{Duration, Instant};

use lightbox_core::color::ToneMap;
use lightbox_core::image_io::tone_mapped;
use lightbox_core::render::Work;
use lightbox_core::scene::Source;
use lightbox_core::{Film, Image, Scene, SceneDesc, View};
use rayon::ThreadPool;

use super::preview::{Governor, enlarge};
use super::{Activity, Inbox, Opened, Shared, Snapshot, lock};

/// How long a batch of samples should take: long enough to be cheap, short enough that numbers
/// on the screen stay fresh. A wish interrupts it anyway.
const BATCH: Duration = Duration::from_millis(200);

/// Least time between two snapshots of a picture in the making.
const SNAPSHOT_INTERVAL: Duration = Duration::from_millis(50);

/// Snapshots may take one part in this many of the engine's time.
const SNAPSHOT_SHARE: u32 = 8;

/// One picture from its first sample on.
struct Picture {
    view: View,
    film: Arc<Film>,
    /// Stands where the film has no samples yet: the last preview, enlarged.
    backdrop: Option<Image>,
    seconds: f64,
    work: Work,
}

struct Engine<'a> {
    shared: &'a Arc<Shared>,
    pool: &'a ThreadPool,
    source: Option<Source>,
    scene: Option<Arc<Scene>>,
    desc: Arc<SceneDesc>,
    picture: Option<Picture>,
    /// Preview scales still to be shown before the film is filled; the last is shown next.
    previews: Vec<u32>,
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
        previews: Vec::new(),
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
        let unfinished = !self.paused && picture.film.samples() < picture.view.settings.samples;
        self.stale || !self.previews.is_empty() || unfinished
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
        self.report();
    }

    fn take_up(
        &mut self,
        Opened {
            source,
            scene,
            is_new,
        }: Opened,
    ) {
        self.source = Some(source);
        self.scene = Some(scene.clone());
        if is_new {
            self.governor = Governor::default();
            let desc = Arc::new(scene.desc().clone());
            {
                let mut outbox = lock(&self.shared.outbox);
                outbox.status.opened += 1;
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
            let render = lightbox_core::RenderSettings {
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
            Ok((source, scene))
        });
    }

    /// Starts the present description's picture anew.
    fn restart(&mut self) {
        let Some(scene) = self.scene.clone() else {
            return;
        };
        match View::new(scene, &self.desc.camera, self.desc.render) {
            Ok(view) => {
                let film = Arc::new(view.film());
                lock(&self.shared.outbox).film = Some(film.clone());
                self.previews = self
                    .governor
                    .scales(view.settings.width, view.settings.height);
                self.picture = Some(Picture {
                    view,
                    film,
                    backdrop: None,
                    seconds: 0.0,
                    work: Work::default(),
                });
            }
            Err(message) => self.shared.notify(message, true),
        }
    }

    /// One step: a preview, a batch of samples, or a fresh look at the samples there are.
    fn work(&mut self) {
        if let Some(scale) = self.previews.pop() {
            self.preview(scale);
        } else if self.stale {
            self.publish();
        } else if self.has_work() {
            self.batch();
        }
        self.report();
    }

    /// Shows a coarse picture. The first one after a wish is never interrupted: if each new wish
    /// did so, a drag would show nothing until it ends.
    fn preview(&mut self, scale: u32) {
        let Some(picture) = &mut self.picture else {
            return;
        };
        let settings = lightbox_core::RenderSettings {
            width: picture.view.settings.width.div_ceil(scale),
            height: picture.view.settings.height.div_ceil(scale),
            ..picture.view.settings
        };
        let is_first = picture.backdrop.is_none();
        let Ok(view) = View::new(picture.view.scene.clone(), &self.desc.camera, settings) else {
            return;
        };
        let film = view.film();
        let never = std::sync::atomic::AtomicBool::new(false);
        let start = Instant::now();
        let cancel = if is_first {
            &never
        } else {
            &self.shared.cancel
        };
        let work = self.pool.install(|| view.render(&film, 1, cancel));
        if film.samples() == 0 {
            return; // Interrupted: a newer wish is waiting.
        }
        self.governor.measured(start.elapsed(), work.paths);
        let image = film.develop();
        picture.backdrop = Some(enlarge(
            &image,
            scale,
            picture.view.settings.width,
            picture.view.settings.height,
        ));
        self.stale = false;
        self.show(&image, Some(scale));
    }

    /// Adds samples for about [`BATCH`], publishing snapshots on the way.
    fn batch(&mut self) {
        let Some(picture) = &self.picture else { return };
        let (view, film, cancel) = (
            picture.view.clone(),
            picture.film.clone(),
            &self.shared.cancel,
        );
        let have = film.samples();
        let per_sample = picture.seconds / have.max(1) as f64;
        let more = if have == 0 {
            1
        } else {
            (BATCH.as_secs_f64() / per_sample.max(1e-9)) as u64
        };
        // Doubling at most, so that one slow sample at the start does not set the pace.
        let target = (have + more.clamp(1, have.max(1))).min(view.settings.samples);

        let start = Instant::now();
        let pool = self.pool;
        let (done, finished) = channel();
        let work = pool.in_place_scope(|scope| {
            scope.spawn(move |_| {
                // Only fails when the engine has gone, and then nobody asks.
                let _ = done.send(view.render(&film, target, cancel));
            });
            let mut interval = SNAPSHOT_INTERVAL;
            loop {
                match finished.recv_timeout(interval) {
                    Ok(work) => return work,
                    Err(RecvTimeoutError::Disconnected) => return Work::default(),
                    Err(RecvTimeoutError::Timeout) => {
                        interval = self.publish().max(SNAPSHOT_INTERVAL)
                    }
                }
            }
        });
        let Some(picture) = &mut self.picture else {
            return;
        };
        picture.seconds += start.elapsed().as_secs_f64();
        picture.work = picture.work + work;
        if !self.shared.cancel.load(Ordering::Relaxed) {
            self.publish();
        }
    }

    /// Shows the film as it is, over the last preview. Returns how long to wait with the next.
    fn publish(&mut self) -> Duration {
        let Some(picture) = &mut self.picture else {
            return SNAPSHOT_INTERVAL;
        };
        let start = Instant::now();
        self.stale = false;
        let image = match (&mut picture.backdrop, picture.film.samples()) {
            (Some(backdrop), 0) => {
                picture.film.develop_over(backdrop);
                backdrop.clone()
            }
            (backdrop, _) => {
                *backdrop = None;
                picture.film.develop()
            }
        };
        self.show(&image, None);
        self.report();
        start.elapsed() * SNAPSHOT_SHARE
    }

    /// Hands a picture to the window.
    fn show(&mut self, image: &Image, preview: Option<u32>) {
        self.snapshots += 1;
        let snapshot = Snapshot {
            size: [image.width as usize, image.height as usize],
            rgb: tone_mapped(image, self.tone),
            preview,
            number: self.snapshots,
        };
        lock(&self.shared.outbox).snapshot = Some(Arc::new(snapshot));
        (self.shared.wake)();
    }

    /// Brings the status up to date.
    fn report(&self) {
        let figures = self
            .picture
            .as_ref()
            .map(|p| (p, p.film.samples(), p.film.noise(), p.film.invalid().0));
        let mut outbox = lock(&self.shared.outbox);
        let status = &mut outbox.status;
        status.scene.clone_from(&self.scene);
        if let Some((picture, samples, noise, invalid)) = figures {
            let target = picture.view.settings.samples;
            status.activity = if samples >= target {
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
