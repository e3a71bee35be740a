//! A race on a thread of its own, watched from the window.

use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Instant;

use lightbox_core::Image;
use lightbox_core::race::{Curve, Record, Rules};

use super::{Contest, Race, curves, labels, report};

/// How far a race is.
pub enum Stage<'a> {
    /// The share of the references that is rendered, 0 to 1.
    Reference(f64),
    /// The share of the race that is over, 0 to 1, and what is measured.
    Race(f64, &'a [Record]),
}

/// What is known of a race.
#[derive(Default)]
pub struct Standing {
    /// Names of the contestants.
    pub labels: Vec<String>,
    /// Their curves so far.
    pub curves: Vec<Curve>,
    /// The share that is done, 0 to 1; the reference counts for half.
    pub share: f64,
    /// Whether the reference is being rendered.
    pub is_preparing: bool,
    /// How it ended.
    pub end: Option<Result<Arc<Race>, String>>,
    /// What became of saving it: a line about it.
    pub saved: Option<Result<String, String>>,
}

/// Handle to a race; dropping it ends the race.
pub struct Live {
    state: Arc<Mutex<Standing>>,
    cancel: Arc<AtomicBool>,
    begin: Instant,
}

impl Live {
    /// Starts a race on as many threads. `wake` is called from another thread when there is
    /// something new.
    pub fn start(
        contest: Contest,
        rules: Rules,
        reference: Option<(String, Arc<Image>)>,
        threads: usize,
        wake: impl Fn() + Send + Sync + 'static,
    ) -> Result<Self, String> {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .thread_name(|i| format!("lightbox-race-{i}"))
            .build()
            .map_err(|e| format!("cannot start worker threads ({e})"))?;
        let live = Self {
            state: Arc::new(Mutex::new(Standing {
                labels: labels(&contest.entries),
                is_preparing: true,
                ..Standing::default()
            })),
            cancel: Arc::default(),
            begin: Instant::now(),
        };
        let (state, cancel) = (live.state.clone(), live.cancel.clone());
        let has_reference = reference.is_some();
        let work = move || {
            let mut measured = 0;
            let end = pool.install(|| {
                contest.hold(rules, reference, &cancel, &mut |stage| {
                    let mut state = lock(&state);
                    match stage {
                        Stage::Reference(share) => state.share = share / 2.0,
                        Stage::Race(share, records) => {
                            state.is_preparing = false;
                            state.share = if has_reference {
                                share
                            } else {
                                0.5 + share / 2.0
                            };
                            let runs = records.iter().flat_map(|r| &r.runs);
                            let points = runs.map(|run| run.points.len()).sum();
                            if measured < points {
                                measured = points;
                                state.curves = curves(records);
                            }
                        }
                    }
                    drop(state);
                    wake();
                })
            });
            let mut state = lock(&state);
            if let Ok(race) = &end {
                state.curves.clone_from(&race.curves);
            }
            state.end = Some(end.map(Arc::new));
            drop(state);
            wake();
        };
        std::thread::Builder::new()
            .name("lightbox-race".into())
            .spawn(work)
            .map_err(|e| format!("cannot start a thread ({e})"))?;
        Ok(live)
    }

    /// What is known so far; to be held for a moment.
    pub fn standing(&self) -> MutexGuard<'_, Standing> {
        lock(&self.state)
    }

    /// Seconds until it is over if it goes on as so far.
    pub fn seconds_left(&self, share: f64) -> f64 {
        let left = self.begin.elapsed().as_secs_f64() * (1.0 - share) / share;
        if left.is_finite() { left.ceil() } else { 0.0 }
    }

    /// Whether it goes on.
    pub fn is_running(&self) -> bool {
        self.standing().end.is_none()
    }

    /// Writes the files of a race that is over, in the background.
    pub fn save(&self, folder: PathBuf, wake: impl FnOnce() + Send + 'static) {
        let Some(Ok(race)) = self.standing().end.clone() else {
            return;
        };
        let state = self.state.clone();
        let write = move || {
            let result = report::check_folder(&folder).and_then(|()| report::write(&race, &folder));
            let line = result.map(|_| format!("Saved in {}.", folder.display()));
            lock(&state).saved = Some(line);
            wake();
        };
        let thread = std::thread::Builder::new().name("lightbox-save".into());
        if let Err(e) = thread.spawn(write) {
            self.standing().saved = Some(Err(format!("cannot start a thread ({e})")));
        }
    }

    /// Ends it soon; what it has is kept.
    pub fn stop(&self) {
        self.cancel.store(true, Ordering::Relaxed);
    }
}

impl Drop for Live {
    fn drop(&mut self) {
        self.stop();
    }
}

/// Every state is valid, even if a holder of the lock has panicked.
fn lock(state: &Mutex<Standing>) -> MutexGuard<'_, Standing> {
    state.lock().unwrap_or_else(PoisonError::into_inner)
}
