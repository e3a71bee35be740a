//! A render kept on disk while it goes on.

use std::path::Path;
use std::sync::mpsc::{self, RecvTimeoutError};
use std::thread;
use std::time::{Duration, Instant};

use lightbox_core::Film;
use lightbox_core::part::{self, Head};

use super::print_warning;

/// Seconds between two saves, unless asked otherwise: what a crash may cost.
const EVERY: f64 = 60.0;

/// Where and how often to save a film.
pub struct Checkpoint<'a> {
    path: &'a Path,
    every: Duration,
    /// Of the film at the start.
    head: &'a Head,
    film: &'a Film,
}

impl<'a> Checkpoint<'a> {
    /// Saves `film` to `path`, every so many seconds.
    pub fn new(path: &'a Path, every: Option<f64>, head: &'a Head, film: &'a Film) -> Self {
        // A longer pause than a duration holds is for ever.
        let every = Duration::try_from_secs_f64(every.unwrap_or(EVERY)).unwrap_or(Duration::MAX);
        Self {
            path,
            every,
            head,
            film,
        }
    }

    /// Saves what there is after `seconds` of tracing.
    pub fn save(&self, seconds: f64) -> Result<(), String> {
        part::write(self.path, &self.head.renewed(self.film, seconds), self.film)
    }

    /// Renders, and saves all the while: nobody waits for the disk.
    pub fn during<T>(&self, render: impl FnOnce() -> T) -> Result<T, String> {
        let start = Instant::now();
        thread::scope(|scope| {
            let (finish, finished) = mpsc::channel::<()>();
            let save = move || {
                while finished.recv_timeout(self.every) == Err(RecvTimeoutError::Timeout) {
                    let seconds = self.head.seconds + start.elapsed().as_secs_f64();
                    if let Err(e) = self.save(seconds) {
                        print_warning(&e); // The next time may go better.
                    }
                }
            };
            thread::Builder::new()
                .name("lightbox-checkpoint".into())
                .spawn_scoped(scope, save)
                .map_err(|e| format!("cannot start a thread ({e})"))?;
            let result = render();
            drop(finish);
            Ok(result)
        })
    }
}
