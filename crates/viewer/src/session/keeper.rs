//! Keeping the samples of a picture in a file, so that a crash loses a minute of them at most.

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use lightbox_core::color::ToneMap;
use lightbox_core::part::{self, Head};
use lightbox_core::{Film, Scene, View};

use super::{Shared, lock};

/// How often a picture in the making is saved. When it rests it is saved at once.
const EVERY: Duration = Duration::from_secs(60);

/// Keeps one film in one file. Each writing has a thread of its own: neither the picture nor the
/// window waits for the disk.
pub(super) struct Keeper {
    path: PathBuf,
    film: Arc<Film>,
    head: Head,
    /// Samples per pixel in the file.
    saved: u64,
    since: Instant,
    writing: Option<JoinHandle<()>>,
}

/// What a part holds of the picture that it opens as.
pub(super) struct Taken {
    pub film: Film,
    /// Of tracing so far.
    pub seconds: f64,
}

impl Taken {
    /// Reads the samples of the part at `path`, whose scene is `scene`. `None` if it is a slice
    /// that does not begin with the first sample: the window shows whole pictures. The error is one
    /// line.
    pub fn read(path: &Path, scene: &Arc<Scene>) -> Result<Option<Self>, String> {
        let head = part::read_head(path)?;
        let mut runs = head.samples();
        if !(runs.next().is_some_and(|run| run.start == 0) && runs.next().is_none()) {
            return Ok(None);
        }
        let view = View::of(scene.clone())?;
        let taken = part::resume(path, &view, 0)?;
        Ok(taken.map(|(film, seconds)| Self { film, seconds }))
    }
}

impl Keeper {
    /// Keeps the film of a view in a file that holds `saved` samples per pixel of it.
    pub fn new(path: PathBuf, view: &View, tone: ToneMap, film: Arc<Film>, saved: u64) -> Self {
        Self {
            head: Head::new(view, tone, &film, 0.0),
            path,
            film,
            saved,
            since: Instant::now(),
            writing: None,
        }
    }

    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Writes what there is after `seconds` of tracing, if it is time to: now, if the picture
    /// `rests`. The samples per pixel that were written come to the inbox.
    pub fn tend(&mut self, shared: &Arc<Shared>, seconds: f64, rests: bool) {
        let samples = self.film.samples();
        let is_due = rests || self.since.elapsed() >= EVERY;
        if self.writing.is_some() || samples == self.saved || !is_due {
            return;
        }
        let (path, film) = (self.path.clone(), self.film.clone());
        let (head, to) = (self.head.renewed(&film, seconds), shared.clone());
        let write = move || {
            let kept = part::write(&path, &head, &film).map(|()| samples);
            to.send(false, |inbox| inbox.kept = Some((path, kept)));
        };
        let thread = std::thread::Builder::new().name("lightbox-keep".into());
        match thread.spawn(write) {
            Ok(thread) => self.writing = Some(thread),
            Err(e) => shared.notify(format!("cannot start a thread ({e})"), true),
        }
    }

    /// Takes note of a writing that has ended; whether it was the first.
    pub fn written(&mut self, samples: u64) -> bool {
        let is_first = self.saved == 0;
        self.writing = None;
        (self.saved, self.since) = (samples, Instant::now());
        is_first
    }

    /// Writes what is not in the file yet, before the program ends.
    pub fn close(mut self, shared: &Shared, seconds: f64) {
        if let Some(writing) = self.writing.take() {
            let _ = writing.join(); // What failed is tried again.
            if let Some((_, Ok(samples))) = lock(&shared.inbox).kept.take() {
                self.saved = samples;
            }
        }
        if self.film.samples() != self.saved {
            let head = self.head.renewed(&self.film, seconds);
            if let Err(e) = part::write(&self.path, &head, &self.film) {
                eprintln!("error: {e}");
            }
        }
    }
}
