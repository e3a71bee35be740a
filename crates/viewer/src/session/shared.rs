//! What the window and the engine tell each other: messages in, snapshots and a status out.

use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};

use lightbox_core::SceneDesc;
use lightbox_core::color::ToneMap;
use lightbox_core::scene::{Scene, Source};

use super::background::Loading;
use super::keeper::Taken;
use super::shown::Shown;
use super::{Budget, History, Look, Moment, Notice, Reference, Region, Snapshot, Status};

/// What the user wants and the engine has not taken up yet.
#[derive(Default)]
pub(super) struct Inbox {
    /// An edit, and which scene it was meant for: the number that [`Status::opened`] had.
    pub(super) edit: Option<(u64, Arc<SceneDesc>)>,
    /// A file, or why it cannot be opened.
    pub(super) opened: Option<Result<Box<Loaded>, String>>,
    /// The scene with edited shapes, and the number of that work.
    pub(super) rebuilt: Option<(u64, Result<Scene, String>)>,
    pub(super) look: Option<Look>,
    pub(super) paused: Option<bool>,
    /// One more pass, though paused.
    pub(super) pass: bool,
    pub(super) threads: Option<usize>,
    pub(super) budget: Option<Budget>,
    pub(super) reference: Option<Referring>,
    pub(super) past: Option<Option<Moment>>,
    pub(super) compares: Option<bool>,
    pub(super) region: Option<Option<Region>>,
    pub(super) clear_history: bool,
    pub(super) measure_plan: bool,
    /// A file to keep the samples in.
    pub(super) keep: Option<PathBuf>,
    pub(super) kept: Option<Kept>,
    pub(super) quit: bool,
}

/// A file of samples, and how many per pixel are in it by now, or why they are not.
pub(super) type Kept = (PathBuf, Result<u64, String>);

/// What becomes of the reference.
pub(super) enum Referring {
    To(Arc<Reference>),
    ToPresent,
    ToNone,
}

impl Inbox {
    pub(super) fn is_empty(&self) -> bool {
        let Self {
            edit,
            opened,
            rebuilt,
            look,
            paused,
            pass,
            threads,
            budget,
            reference,
            past,
            compares,
            region,
            clear_history,
            measure_plan,
            keep,
            kept,
            quit,
        } = self;
        let is_same_scene = opened.is_none() && rebuilt.is_none() && edit.is_none();
        is_same_scene
            && look.is_none()
            && paused.is_none()
            && !pass
            && threads.is_none()
            && budget.is_none()
            && reference.is_none()
            && past.is_none()
            && compares.is_none()
            && region.is_none()
            && !clear_history
            && !measure_plan
            && keep.is_none()
            && kept.is_none()
            && !quit
    }
}

/// A scene from a file.
pub(super) struct Loaded {
    pub(super) source: Source,
    pub(super) scene: Arc<Scene>,
    /// If the file has one.
    pub(super) tone: Option<ToneMap>,
    /// Seconds of loading and of building.
    pub(super) opening: [f64; 2],
    /// If the file has samples.
    pub(super) taken: Option<Taken>,
}

/// What the engine has for the user.
#[derive(Default)]
pub(super) struct Outbox {
    pub(super) status: Status,
    pub(super) snapshot: Option<Arc<Snapshot>>,
    pub(super) past: Option<Arc<Snapshot>>,
    /// Whether the reference is to be shown, and how it looks.
    pub(super) compares: bool,
    pub(super) other: Option<Arc<Snapshot>>,
    pub(super) history: Arc<History>,
    pub(super) notices: Vec<Notice>,
    /// The scene as it was written last.
    pub(super) saved: Option<Arc<SceneDesc>>,
    pub(super) shown: Option<Shown>,
    pub(super) look: Look,
    /// A tone map that fits the picture, for the window.
    pub(super) fitted: Option<ToneMap>,
    /// The file being opened.
    pub(super) opening: Option<Loading>,
    /// The accelerator being built for edited shapes.
    pub(super) rebuilding: Option<Loading>,
    /// Works started so far.
    pub(super) works: u64,
    /// Whether the engine has ended.
    pub(super) has_ended: bool,
}

/// State shared between the window, the engine and loaders. Locks are held for moments only, the
/// outbox's before the inbox's.
pub(super) struct Shared {
    pub(super) inbox: Mutex<Inbox>,
    pub(super) arrived: Condvar,
    /// Set with every message that makes the work in hand pointless.
    pub(super) cancel: AtomicBool,
    pub(super) outbox: Mutex<Outbox>,
    /// Tells the window that there is something new.
    pub(super) wake: Box<dyn Fn() + Send + Sync>,
}

/// A lock whose holder may have panicked: every state behind one is valid at each step.
pub(super) fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

impl Shared {
    pub(super) fn new(wake: impl Fn() + Send + Sync + 'static) -> Self {
        Self {
            inbox: Mutex::default(),
            arrived: Condvar::new(),
            cancel: AtomicBool::new(false),
            outbox: Mutex::default(),
            wake: Box::new(wake),
        }
    }

    pub(super) fn send(&self, interrupt: bool, put: impl FnOnce(&mut Inbox)) {
        let mut inbox = lock(&self.inbox);
        put(&mut inbox);
        if interrupt {
            self.cancel.store(true, Ordering::Relaxed);
        }
        drop(inbox);
        self.arrived.notify_one();
    }

    pub(super) fn notify(&self, text: String, is_error: bool) {
        lock(&self.outbox).notices.push(Notice { text, is_error });
        (self.wake)();
    }
}
