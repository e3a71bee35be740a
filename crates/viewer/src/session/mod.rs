//! The engine behind the window: one thread that always renders the newest wish.
//!
//! Messages go in ([`Session::open`], [`Session::edit`], …), snapshots and a status come out;
//! the newest of each wins and nobody waits. A change starts a new film, so a tile of an older
//! picture has nowhere to land. While wishes keep coming, coarse previews are shown, sized so
//! that each takes a fraction of a frame; they never enter a film. Done or paused, the thread
//! sleeps.

mod background;
mod budget;
mod engine;
mod history;
mod keeper;
mod look;
mod patches;
mod picture;
mod preview;
mod reference;
mod shared;
mod shown;
mod status;
#[cfg(test)]
mod test;

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::thread::JoinHandle;

use lightbox_core::color::ToneMap;
use lightbox_core::compare::check_size;
use lightbox_core::film::Pixel;
use lightbox_core::part;
use lightbox_core::scene;
use lightbox_core::{Film, SceneDesc, View};
use rayon::ThreadPool;

use crate::spent::Opening;
use crate::{saved, workers};
use background::Loading;
use keeper::Taken;

pub use budget::Budget;
pub use history::{History, Moment, Point, Run};
pub use look::Look;
pub use patches::Patches;
pub use reference::Reference;
use shared::{Inbox, Kept, Loaded, Outbox, Referring, Shared, lock};
use shown::Shown;
pub use status::{Activity, Notice, Snapshot, Status};

/// Left, top, right and bottom of a part of the picture, in shares of it.
pub type Region = [f32; 4];

/// Handle to the engine; dropping it ends the engine.
pub struct Session {
    shared: Arc<Shared>,
    engine: Option<JoinHandle<()>>,
}

impl Session {
    /// Starts an engine with some worker threads (0: one per core) and no scene. `wake` is called
    /// from other threads when there is something new to show.
    pub fn new(threads: usize, wake: impl Fn() + Send + Sync + 'static) -> Result<Self, String> {
        let pool = tracers(threads)?;
        let shared = Arc::new(Shared::new(wake));
        lock(&shared.outbox).status.threads = pool.current_num_threads();
        let for_engine = shared.clone();
        let engine = std::thread::Builder::new()
            .name("lightbox-engine".into())
            .spawn(move || engine::run(&for_engine, pool))
            .map_err(|e| format!("cannot start a thread ({e})"))?;
        Ok(Self {
            shared,
            engine: Some(engine),
        })
    }

    /// Opens a scene, a mesh, a saved picture or a part in the background; the present scene stays
    /// until it is ready. The samples of a part are taken up, and kept there from then on.
    pub fn open(&self, path: &Path) {
        let path = path.to_owned();
        self.shared.start(
            |outbox| &mut outbox.opening,
            path.display().to_string(),
            move |watcher| {
                let opening = Opening::start();
                let (source, tone) = saved::load(&path)?;
                let observe = |phase| {
                    opening.observe(phase);
                    watcher(phase)
                };
                let scene = source.build(&observe).map_err(|e| e.to_string())?;
                let scene = Arc::new(scene);
                let taken = match part::is_part(&path) {
                    true => Taken::read(&path, &scene)?,
                    false => None,
                };
                Ok(Box::new(Loaded {
                    source,
                    scene,
                    tone,
                    opening: opening.seconds(),
                    taken,
                }))
            },
            |inbox, _, opened| inbox.opened = Some(opened),
        );
    }

    /// What ends the engine from a thread that may not wait for the window: every sample is kept that
    /// is to be kept when it returns.
    pub fn ender(&self) -> impl Fn() + Send + 'static {
        let shared = self.shared.clone();
        move || {
            shared.send(true, |inbox| inbox.quit = true);
            while !lock(&shared.outbox).has_ended {
                std::thread::sleep(std::time::Duration::from_millis(5));
            }
        }
    }

    /// Does not open what is being opened after all.
    pub fn cancel_opening(&self) {
        // Its work goes on for a while; the result has no place to go.
        lock(&self.shared.outbox).opening = None;
    }

    /// Shows an edited description of the scene that [`Status::opened`] counted: camera, settings,
    /// materials, shapes. Whatever the edit does not touch is kept; an edit that needs a new
    /// accelerator is made in the background.
    pub fn edit(&self, opened: u64, desc: SceneDesc) {
        let desc = Arc::new(desc);
        {
            let mut outbox = lock(&self.shared.outbox);
            if outbox.status.opened != opened {
                return; // Meant for a scene that has been replaced meanwhile.
            }
            outbox.status.desc = desc.clone();
        }
        self.shared
            .send(true, |inbox| inbox.edit = Some((opened, desc)));
    }

    /// Rests, or goes on; samples are kept.
    pub fn set_paused(&self, paused: bool) {
        self.shared
            .send(paused, |inbox| inbox.paused = Some(paused));
    }

    /// Ends the pass under way, or makes one of one sample per pixel, and rests again.
    pub fn add_pass(&self) {
        self.shared.send(false, |inbox| inbox.pass = true);
    }

    /// Traces on so many threads from now on; samples are kept.
    pub fn set_threads(&self, threads: usize) {
        self.shared
            .send(true, |inbox| inbox.threads = Some(threads));
    }

    /// Changes when the picture is done; samples are kept.
    pub fn set_budget(&self, budget: Budget) {
        self.shared.send(false, |inbox| inbox.budget = Some(budget));
    }

    /// Changes how the picture is shown; samples are kept.
    pub fn set_look(&self, look: Look) {
        lock(&self.shared.outbox).look = look;
        self.shared.send(false, |inbox| inbox.look = Some(look));
    }

    /// Has exposure and offset fitted to the picture in the background.
    pub fn fit_tone(&self) {
        let (shown, tone) = {
            let outbox = lock(&self.shared.outbox);
            (outbox.shown.clone(), outbox.look.tone)
        };
        let Some(shown) = shown else { return };
        let shared = self.shared.clone();
        self.spawn("lightbox-tone", move || {
            let fitted = tone.fitted(&shown.film.develop().pixels);
            lock(&shared.outbox).fitted = Some(fitted);
            (shared.wake)();
        });
    }

    /// The tone map that [`Session::fit_tone`] has found, once.
    pub fn take_fitted_tone(&self) -> Option<ToneMap> {
        lock(&self.shared.outbox).fitted.take()
    }

    /// The newest picture.
    pub fn snapshot(&self) -> Option<Arc<Snapshot>> {
        lock(&self.shared.outbox).snapshot.clone()
    }

    /// What is known by now of a pixel of the picture in the making.
    pub fn pixel(&self, at: [u32; 2]) -> Option<Pixel> {
        self.film()?.pixel(at)
    }

    /// The film of the picture in the making.
    pub fn film(&self) -> Option<Arc<Film>> {
        let outbox = lock(&self.shared.outbox);
        outbox.shown.as_ref().map(|shown| shown.film.clone())
    }

    /// The picture in the making, to look into its samples.
    pub fn making(&self) -> Option<(View, Arc<Film>)> {
        let shown = lock(&self.shared.outbox).shown.clone()?;
        Some((shown.view, shown.film))
    }

    /// The error curves.
    pub fn history(&self) -> Arc<History> {
        lock(&self.shared.outbox).history.clone()
    }

    /// Drops the curves of earlier pictures.
    pub fn clear_history(&self) {
        self.shared.send(false, |inbox| inbox.clear_history = true);
    }

    /// Has what the plan saves of the present view measured in the background, once; the picture
    /// rests meanwhile.
    pub fn measure_plan(&self) {
        self.shared.send(false, |inbox| inbox.measure_plan = true);
    }

    /// Asks for a kept picture, or for none; rendering goes on.
    pub fn look_back(&self, moment: Option<Moment>) {
        self.shared.send(false, |inbox| inbox.past = Some(moment));
    }

    /// Renders a region first from now on, in every pass; the rest follows, and no sample is lost.
    pub fn prefer(&self, region: Option<Region>) {
        self.shared.send(false, |inbox| inbox.region = Some(region));
    }

    /// The kept picture asked for, once it is ready to be shown.
    pub fn past(&self) -> Option<Arc<Snapshot>> {
        lock(&self.shared.outbox).past.clone()
    }

    /// Reads a picture in the background that is to count as right. One of another size than the
    /// present picture is refused with a notice.
    pub fn load_reference(&self, path: PathBuf) {
        let shared = self.shared.clone();
        self.spawn("lightbox-reference", move || {
            let shown = lock(&shared.outbox).shown.clone();
            let reference = Reference::read(&path).and_then(|reference| {
                let size = shown.map(|s| s.film.size());
                check_size(size.unwrap_or_default(), &reference.image)
                    .map_err(|e| format!("{}: {e}", path.display()))?;
                Ok(Arc::new(reference))
            });
            match reference {
                Ok(reference) => shared.send(false, |inbox| {
                    inbox.reference = Some(Referring::To(reference));
                }),
                Err(message) => shared.notify(message, true),
            }
        });
    }

    /// Takes the picture as it is now for the reference.
    pub fn keep_reference(&self) {
        self.shared
            .send(false, |inbox| inbox.reference = Some(Referring::ToPresent));
    }

    /// Takes a picture for the reference that was one before.
    pub fn set_reference(&self, reference: Arc<Reference>) {
        self.shared.send(false, |inbox| {
            inbox.reference = Some(Referring::To(reference));
        });
    }

    /// Has the reference made ready to be shown beside the picture, or no longer.
    pub fn set_comparing(&self, compares: bool) {
        if std::mem::replace(&mut lock(&self.shared.outbox).compares, compares) != compares {
            let compares = Some(compares);
            self.shared.send(false, |inbox| inbox.compares = compares);
        }
    }

    /// The reference as it is shown, once it is ready.
    pub fn other(&self) -> Option<Arc<Snapshot>> {
        lock(&self.shared.outbox).other.clone()
    }

    /// Goes on without a reference.
    pub fn drop_reference(&self) {
        self.shared
            .send(false, |inbox| inbox.reference = Some(Referring::ToNone));
    }

    /// Runs something in the background.
    fn spawn(&self, name: &str, run: impl FnOnce() + Send + 'static) {
        let thread = std::thread::Builder::new().name(name.into()).spawn(run);
        if let Err(e) = thread {
            self.shared
                .notify(format!("cannot start a thread ({e})"), true);
        }
    }

    /// The present state.
    pub fn status(&self) -> Status {
        let outbox = lock(&self.shared.outbox);
        let told = |loading: &Loading| (loading.label.clone(), loading.phase);
        let opening = outbox.opening.as_ref().map(told);
        Status {
            loading: opening.clone().or(outbox.rebuilding.as_ref().map(told)),
            opening,
            ..outbox.status.clone()
        }
    }

    /// Lines for the user since the last call.
    pub fn take_notices(&self) -> Vec<Notice> {
        std::mem::take(&mut lock(&self.shared.outbox).notices)
    }

    /// The scene as it was written to a file since the last call.
    pub fn take_saved(&self) -> Option<Arc<SceneDesc>> {
        lock(&self.shared.outbox).saved.take()
    }

    /// Samples per pixel of the picture that [`Session::save`] would write now.
    pub fn samples_to_save(&self) -> u64 {
        let shown = lock(&self.shared.outbox).shown.clone();
        shown.map_or(0, |shown| shown.film.most_samples())
    }

    /// Writes the scene with its edits if `path` is a *.toml, else the picture as it is now, in the
    /// background; a notice tells how it went. In the midst of a pass, tiles that lag behind are
    /// brought up to the others in a copy: only a picture with as many samples everywhere can be
    /// made again. If `path` is a *.part, the samples are kept there from now on, as long as the
    /// picture stays what it is.
    pub fn save(&self, path: PathBuf) {
        if part::is_part(&path) {
            return self.shared.send(false, |inbox| inbox.keep = Some(path));
        }
        let is_scene = path
            .extension()
            .is_some_and(|e| e.eq_ignore_ascii_case("toml"));
        let (shown, tone, scene, desc) = {
            let outbox = lock(&self.shared.outbox);
            let Status { scene, desc, .. } = &outbox.status;
            let scene = scene.clone().filter(|_| is_scene);
            (outbox.shown.clone(), outbox.look.tone, scene, desc.clone())
        };
        let shared = self.shared.clone();
        self.spawn("lightbox-save", move || {
            let written = match (scene, shown) {
                (Some(scene), _) => scene::save(&path, &desc, scene.path())
                    .map(|()| lock(&shared.outbox).saved = Some(desc)),
                (None, Some(shown)) => shown.write(&path, tone),
                (None, None) => Err("there is no picture to save yet".into()),
            };
            match written {
                Ok(()) => shared.notify(format!("saved {}", path.display()), false),
                Err(message) => shared.notify(message, true),
            }
        });
    }
}

fn tracers(threads: usize) -> Result<ThreadPool, String> {
    let pool = workers::pool("trace").num_threads(threads).build();
    pool.map_err(|e| format!("cannot start worker threads ({e})"))
}

impl Drop for Session {
    fn drop(&mut self) {
        self.shared.send(true, |inbox| inbox.quit = true);
        if let Some(engine) = self.engine.take() {
            let _ = engine.join(); // A panicked engine has nothing left to clean up.
        }
    }
}
