//! The engine behind the window: one thread that always renders the newest wish.
//!
//! Messages go in ([`Session::open`], [`Session::edit`], …), snapshots and a status come out;
//! the newest of each wins and nobody waits. A change starts a new film, so a tile of an older
//! picture has nowhere to land. While wishes keep coming, coarse previews are shown, sized so
//! that each takes a fraction of a frame; they never enter a film. Done or paused, the thread
//! sleeps.

mod background;
mod engine;
mod picture;
mod preview;
#[cfg(test)]
mod test;

use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::thread::JoinHandle;

use lightbox_core::color::ToneMap;
use lightbox_core::image_io::{self, check_writable};
use lightbox_core::scene::{CameraDesc, Phase, Scene, Source};
use lightbox_core::{Film, SceneDesc, View};

use crate::saved;
use background::Loading;

/// A picture ready to be shown.
#[derive(Debug)]
pub struct Snapshot {
    /// Pixels across and down.
    pub size: [usize; 2],
    /// sRGB bytes, row by row from the top.
    pub rgb: Vec<u8>,
    /// Pixels across and down of the picture that it stands for.
    pub picture: [usize; 2],
    /// Where any of it is a preview: how many pixels of the picture one of the preview's covers,
    /// across and down.
    pub preview: Option<u32>,
    /// Rises with every snapshot.
    pub number: u64,
}

/// What the engine is doing.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Activity {
    /// There is no scene yet.
    #[default]
    Empty,
    /// Samples are being added.
    Rendering,
    /// Asked to rest before the picture is done.
    Paused,
    /// Every sample asked for has been taken.
    Done,
}

/// A line for the user.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Notice {
    /// One line.
    pub text: String,
    /// Whether something failed.
    pub is_error: bool,
}

/// The state of the engine, for display.
#[derive(Clone, Debug, Default)]
pub struct Status {
    /// What it is doing.
    pub activity: Activity,
    /// The scene being opened or rebuilt in the background, and how far that is.
    pub loading: Option<(String, Phase)>,
    /// The scene being rendered.
    pub scene: Option<Arc<Scene>>,
    /// Its description with the newest edits: what panels start from.
    pub desc: Arc<SceneDesc>,
    /// Whether the scene differs from its file in more than camera and settings.
    pub is_edited: bool,
    /// How the file wants to be shown: known of a saved picture.
    pub tone: Option<ToneMap>,
    /// Rises when another file has been opened.
    pub opened: u64,
    /// Samples per pixel in the picture.
    pub samples: u64,
    /// Seconds spent tracing the picture.
    pub seconds: f64,
    /// Rays cast for it.
    pub rays: u64,
    /// Paths traced for it.
    pub paths: u64,
    /// Estimated relative error of the picture (noise, not bias).
    pub noise: Option<f64>,
    /// Samples that were not numbers.
    pub invalid: u64,
    /// Seconds until done, from the speed so far.
    pub eta: Option<f64>,
    /// Worker threads.
    pub threads: usize,
}

/// What the user wants and the engine has not taken up yet.
#[derive(Default)]
struct Inbox {
    /// An edit, and which scene it was meant for: the number that [`Status::opened`] had.
    edit: Option<(u64, Arc<SceneDesc>)>,
    /// A file, or why it cannot be opened.
    opened: Option<Result<Box<Loaded>, String>>,
    /// The scene with edited shapes, and the number of that work.
    rebuilt: Option<(u64, Result<Scene, String>)>,
    tone: Option<ToneMap>,
    paused: Option<bool>,
    quit: bool,
}

impl Inbox {
    fn is_empty(&self) -> bool {
        let Self {
            edit,
            opened,
            rebuilt,
            tone,
            paused,
            quit,
        } = self;
        let is_same_scene = opened.is_none() && rebuilt.is_none() && edit.is_none();
        is_same_scene && tone.is_none() && paused.is_none() && !quit
    }
}

/// A scene from a file; the tone map if the file has one.
type Loaded = (Source, Scene, Option<ToneMap>);

/// The picture being made, for saving.
#[derive(Clone)]
struct Shown {
    view: View,
    /// What `view` was made from.
    camera: CameraDesc,
    film: Arc<Film>,
    is_edited: bool,
}

/// What the engine has for the user.
#[derive(Default)]
struct Outbox {
    status: Status,
    snapshot: Option<Arc<Snapshot>>,
    notices: Vec<Notice>,
    shown: Option<Shown>,
    tone: ToneMap,
    /// The file being opened.
    opening: Option<Loading>,
    /// The accelerator being built for edited shapes.
    rebuilding: Option<Loading>,
    /// Works started so far.
    works: u64,
}

/// State shared between the window, the engine and loaders. Locks are held for moments only, the
/// outbox's before the inbox's.
struct Shared {
    inbox: Mutex<Inbox>,
    arrived: Condvar,
    /// Set with every message that makes the work in hand pointless.
    cancel: AtomicBool,
    outbox: Mutex<Outbox>,
    /// Tells the window that there is something new.
    wake: Box<dyn Fn() + Send + Sync>,
}

/// A lock whose holder may have panicked: every state behind one is valid at each step.
fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

impl Shared {
    fn new(wake: impl Fn() + Send + Sync + 'static) -> Self {
        Self {
            inbox: Mutex::default(),
            arrived: Condvar::new(),
            cancel: AtomicBool::new(false),
            outbox: Mutex::default(),
            wake: Box::new(wake),
        }
    }

    fn send(&self, interrupt: bool, put: impl FnOnce(&mut Inbox)) {
        let mut inbox = lock(&self.inbox);
        put(&mut inbox);
        if interrupt {
            self.cancel.store(true, Ordering::Relaxed);
        }
        drop(inbox);
        self.arrived.notify_one();
    }

    fn notify(&self, text: String, is_error: bool) {
        lock(&self.outbox).notices.push(Notice { text, is_error });
        (self.wake)();
    }
}

/// Handle to the engine; dropping it ends the engine.
pub struct Session {
    shared: Arc<Shared>,
    engine: Option<JoinHandle<()>>,
}

impl Session {
    /// Starts an engine with some worker threads (0: one per core) and no scene. `wake` is called
    /// from other threads when there is something new to show.
    pub fn new(threads: usize, wake: impl Fn() + Send + Sync + 'static) -> Result<Self, String> {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .thread_name(|i| format!("lightbox-trace-{i}"))
            .build()
            .map_err(|e| format!("cannot start worker threads ({e})"))?;
        let shared = Arc::new(Shared::new(wake));
        lock(&shared.outbox).status.threads = pool.current_num_threads();
        let for_engine = shared.clone();
        let engine = std::thread::Builder::new()
            .name("lightbox-engine".into())
            .spawn(move || engine::run(&for_engine, &pool))
            .map_err(|e| format!("cannot start a thread ({e})"))?;
        Ok(Self {
            shared,
            engine: Some(engine),
        })
    }

    /// Opens a scene, a mesh or a saved picture in the background; the present scene stays until it
    /// is ready.
    pub fn open(&self, path: &Path) {
        let path = path.to_owned();
        self.shared.start(
            |outbox| &mut outbox.opening,
            path.display().to_string(),
            move |progress| {
                let (source, tone) = saved::load(&path)?;
                let scene = source.build(progress).map_err(|e| e.to_string())?;
                Ok(Box::new((source, scene, tone)))
            },
            |inbox, _, opened| inbox.opened = Some(opened),
        );
    }

    /// Shows an edited description of the scene that [`Status::opened`] counted: camera, settings,
    /// materials, shapes. Whatever the edit does
    /// not touch is kept; an edit that needs a new accelerator is made in the background.
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

    /// Changes how the picture is shown; samples are kept.
    pub fn set_tone(&self, tone: ToneMap) {
        lock(&self.shared.outbox).tone = tone;
        self.shared.send(false, |inbox| inbox.tone = Some(tone));
    }

    /// The newest picture.
    pub fn snapshot(&self) -> Option<Arc<Snapshot>> {
        lock(&self.shared.outbox).snapshot.clone()
    }

    /// The present state.
    pub fn status(&self) -> Status {
        let outbox = lock(&self.shared.outbox);
        let loading = outbox.opening.as_ref().or(outbox.rebuilding.as_ref());
        Status {
            loading: loading.map(|l| (l.label.clone(), l.phase)),
            ..outbox.status.clone()
        }
    }

    /// Lines for the user since the last call.
    pub fn take_notices(&self) -> Vec<Notice> {
        std::mem::take(&mut lock(&self.shared.outbox).notices)
    }

    /// Writes the picture as it is now, in the background; a notice tells how it went. In the midst
    /// of a pass, tiles that lag behind are brought up to the others in a copy: only a picture with
    /// as many samples everywhere can be made again.
    pub fn save(&self, path: PathBuf) {
        let (shown, tone) = {
            let outbox = lock(&self.shared.outbox);
            (outbox.shown.clone(), outbox.tone)
        };
        let Some(shown) = shown else {
            self.shared
                .notify("there is no picture to save yet".into(), true);
            return;
        };
        let shared = self.shared.clone();
        let run = move || match shown.write(&path, tone) {
            Ok(()) => shared.notify(format!("saved {}", path.display()), false),
            Err(message) => shared.notify(message, true),
        };
        if let Err(e) = std::thread::Builder::new()
            .name("lightbox-save".into())
            .spawn(run)
        {
            self.shared
                .notify(format!("cannot start a thread ({e})"), true);
        }
    }
}

impl Shown {
    fn write(&self, path: &Path, tone: ToneMap) -> Result<(), String> {
        check_writable(path)?;
        let film = (*self.film).clone();
        let samples = film.most_samples().max(1);
        self.view.render(&film, samples, &AtomicBool::new(false));
        let scene = &self.view.scene;
        let desc = SceneDesc {
            camera: self.camera,
            render: self.view.settings,
            ..scene.desc().clone()
        };
        // Of edits, only the picture itself knows.
        let named = if self.is_edited { path } else { scene.path() };
        let mut line = crate::replay::line(named, &desc, samples);
        line.push_str(&crate::replay::tone_options(tone));
        let text = saved::text(&line, desc, samples, scene.path(), tone);
        image_io::write(path, &film.develop(), tone, &text)
    }
}

impl Drop for Session {
    fn drop(&mut self) {
        self.shared.send(true, |inbox| inbox.quit = true);
        if let Some(engine) = self.engine.take() {
            let _ = engine.join(); // A panicked engine has nothing left to clean up.
        }
    }
}
