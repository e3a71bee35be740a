//! A race on a thread of its own, watched from the window.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Instant;

use lightbox_core::Image;
use lightbox_core::race::{Curve, Record, Rules};

use super::{Contest, Race, curves, labels, report};
use crate::workers;

/// What a race is at, and the share of all that is done, 0 to 1.
pub enum Stage<'a> {
    /// References are being rendered, half of all.
    Reference(f64),
    /// The race itself, and what is measured so far.
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
        let pool = workers::pool("race")
            .num_threads(threads)
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
        let work = move || {
            let mut measured = 0;
            let mut watch = |stage: Stage<'_>| {
                let (share, records) = match stage {
                    Stage::Reference(share) => (share, None),
                    Stage::Race(share, records) => (share, Some(records)),
                };
                // Before the lock, for which the window may wait.
                let points = records.map_or(0, |records| {
                    let runs = records.iter().flat_map(|r| &r.runs);
                    runs.map(|run| run.points.len()).sum()
                });
                let news = records.filter(|_| points > measured).map(curves);
                measured = points;
                let mut state = lock(&state);
                state.share = share;
                state.is_preparing = records.is_none();
                if let Some(curves) = news {
                    state.curves = curves;
                }
                drop(state);
                wake();
            };
            // Whatever happens, the picture may go on.
            let hold = || pool.install(|| contest.hold(rules, reference, &cancel, &mut watch));
            let end = catch_unwind(AssertUnwindSafe(hold))
                .unwrap_or_else(|_| Err("The race broke by a defect in lightbox.".into()));
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

#[cfg(test)]
mod tests {
    use std::time::Duration;

    use lightbox_core::scene;

    use super::*;
    use crate::race::Choice;

    fn contest(size: u32) -> Contest {
        let source = scene::load("builtin:cornell-box.toml".as_ref()).unwrap();
        let scene = Arc::new(source.build(&scene::unwatched).unwrap());
        let desc = scene.desc();
        let mut settings = desc.render;
        (settings.width, settings.height) = (size, size);
        let choice = Choice {
            methods: vec![lightbox_core::Method::Naive, settings.method],
            accels: vec![settings.accel],
            samplers: vec![settings.sampler],
            filters: vec![settings.filter],
        };
        let camera = desc.camera;
        Contest::new(scene, camera, settings, &choice).unwrap()
    }

    const RULES: Rules = Rules {
        seconds: 0.05,
        seeds: 1,
    };

    fn wait(what: &str, holds: impl Fn() -> bool) {
        let start = Instant::now();
        while !holds() {
            assert!(start.elapsed() < Duration::from_secs(60), "{what}");
            std::thread::sleep(Duration::from_millis(1));
        }
    }

    #[test]
    fn a_race_is_watched_and_saved() {
        let live = Live::start(contest(16), RULES, None, 2, || ()).unwrap();
        wait("the end", || !live.is_running());
        assert_eq!(live.standing().labels, ["naive", "reuse"]);
        assert!(live.standing().curves.iter().all(|c| !c.points.is_empty()));
        let folder = tempfile::tempdir().unwrap();
        let out = folder.path().join("race");
        live.save(out.clone(), || ());
        wait("the files", || live.standing().saved.is_some());
        assert!(live.standing().saved.as_ref().unwrap().is_ok());
        for name in ["chart.svg", "chart.csv", "race.json"] {
            assert!(out.join(name).is_file(), "{name}");
        }
        // A file stands where the folder should be.
        live.save(out.join("chart.svg"), || ());
        wait("a refusal", || {
            matches!(live.standing().saved, Some(Err(_)))
        });
    }

    /// The picture in the window rests until the race has ended, however it ends.
    #[test]
    fn a_race_that_breaks_ends() {
        let wake = || panic!("a defect");
        let live = Live::start(contest(16), RULES, None, 1, wake).unwrap();
        wait("the end", || !live.is_running());
        let standing = live.standing();
        let problem = standing.end.as_ref().unwrap().as_ref().err();
        assert!(problem.unwrap().contains("defect"));
    }

    #[test]
    fn a_reference_of_another_size_ends_the_race() {
        let image = Image {
            width: 1,
            height: 1,
            pixels: vec![glam::Vec3::ONE],
        };
        let reference = Some(("other.exr".to_owned(), Arc::new(image)));
        let live = Live::start(contest(16), RULES, reference, 1, || ()).unwrap();
        wait("the end", || !live.is_running());
        assert!(matches!(live.standing().end, Some(Err(_))));
    }
}
