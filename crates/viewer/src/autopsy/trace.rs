//! The samples of a pixel, traced again in the background.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};

use glam::Vec3;
use lightbox_core::View;
use lightbox_core::integrator::replay::Segment;
use lightbox_core::render::autopsy::Autopsy;

use super::findings::Findings;

/// Samples traced first; then as many as there are already, and so on.
const FIRST: u64 = 1 << 10;

/// Most samples.
const MOST: u64 = 1 << 16;

/// Paths that can be looked at: the first ones, and the brightest of all.
const PATHS: u64 = 48;
const BRIGHTEST: usize = 16;

/// A camera path.
#[derive(Clone, Debug)]
pub struct Path {
    /// Index of its sample.
    pub sample: u64,
    /// What the film got, W/(m²·sr).
    pub radiance: Vec3,
    /// Its segments.
    pub segments: Vec<Segment>,
}

/// What is known so far.
#[derive(Clone, Debug, Default)]
pub struct Found {
    /// Figures of all samples.
    pub findings: Findings,
    /// Some paths, in order of their samples.
    pub paths: Vec<Path>,
    /// Whether that is all.
    pub is_done: bool,
}

/// A trace under way or done; ends when it is dropped.
pub struct Trace {
    cancel: Arc<AtomicBool>,
    found: Arc<Mutex<Arc<Found>>>,
}

impl Drop for Trace {
    fn drop(&mut self) {
        self.cancel.store(true, Ordering::Relaxed);
    }
}

impl Trace {
    /// Starts to trace the samples of a pixel, of which the picture has some; `wake` is called
    /// from another thread when there is more to show.
    pub fn start(
        view: View,
        pixel: [u32; 2],
        samples: u64,
        wake: impl Fn() + Send + 'static,
    ) -> Result<Self, String> {
        let trace = Self {
            cancel: Arc::default(),
            found: Arc::default(),
        };
        let (cancel, found) = (trace.cancel.clone(), trace.found.clone());
        let publish = move |new: Found| {
            *found.lock().unwrap_or_else(PoisonError::into_inner) = Arc::new(new);
            wake();
        };
        std::thread::Builder::new()
            .name("lightbox-autopsy".into())
            .spawn(move || run(&view, pixel, samples.clamp(FIRST, MOST), &cancel, publish))
            .map_err(|e| format!("cannot start a thread ({e})"))?;
        Ok(trace)
    }

    /// What is known so far.
    pub fn found(&self) -> Arc<Found> {
        let found = self.found.lock();
        found.unwrap_or_else(PoisonError::into_inner).clone()
    }
}

/// `None` if it was interrupted.
fn run(
    view: &View,
    pixel: [u32; 2],
    goal: u64,
    cancel: &AtomicBool,
    publish: impl Fn(Found),
) -> Option<()> {
    let path = |sample| {
        let (segments, radiance) = view.path(pixel, sample);
        Path {
            sample,
            radiance,
            segments,
        }
    };
    let mut paths: Vec<Path> = (0..PATHS).map(path).collect();
    let mut autopsy = Autopsy::default();
    let mut have = 0;
    while have < goal {
        let end = (2 * have).clamp(FIRST, goal);
        // In pieces that can be interrupted, and whose memory stays small.
        while have < end {
            let next = end.min(have + FIRST);
            autopsy.append(view.autopsy(pixel, have..next, cancel)?);
            have = next;
        }
        let findings = Findings::of(&autopsy, BRIGHTEST);
        let is_done = have == goal;
        if is_done {
            let bright = findings.brightest.iter().filter(|i| **i >= PATHS);
            paths.extend(bright.map(|i| path(*i)));
            paths.sort_unstable_by_key(|path| path.sample);
        }
        publish(Found {
            findings,
            paths: paths.clone(),
            is_done,
        });
    }
    Some(())
}
