//! Ways to make one picture against each other: each gets the same time, in alternating slices,
//! and its error against a reference is measured as it falls. The clock belongs to the caller and
//! only tracing is timed; for a given number of samples the error is the same on every machine.

mod curve;

use std::sync::atomic::{AtomicBool, Ordering};

use serde::Serialize;

pub use curve::{Curve, Slope, curves};

use crate::agreement::Light;
use crate::compare::compare;
use crate::settings::MAX_SEED;
use crate::{Film, Image, View};

/// Slices into which the time of a run is cut at least.
const SLICES: f64 = 32.0;

/// A run is measured each time its samples have grown by a factor of this.
const GROWTH: f64 = 1.3;

/// How long everyone races.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rules {
    /// Seconds of tracing for each contestant and seed, more than 0.
    pub seconds: f64,
    /// Runs of each contestant, each with a seed of its own; at least 1.
    pub seeds: u64,
}

/// A measurement on the way.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[non_exhaustive]
pub struct Point {
    /// Seconds of tracing so far.
    pub seconds: f64,
    /// Samples per pixel.
    pub samples: u64,
    /// Rays cast.
    pub rays: u64,
    /// Error against the reference, see [`crate::compare`].
    #[serde(rename = "relMSE")]
    pub rel_mse: f64,
}

/// One contestant with one seed.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[non_exhaustive]
pub struct Run {
    /// Its seed.
    pub seed: u64,
    /// In order of time.
    pub points: Vec<Point>,
}

/// What a race leaves of a contestant.
#[derive(Clone, Debug, Default)]
#[non_exhaustive]
pub struct Record {
    /// One for each seed begun.
    pub runs: Vec<Run>,
    /// The light of all finished runs together; `None` before the first.
    pub light: Option<Light>,
}

/// One picture in the making, and what it took.
struct Lane<'a> {
    view: View,
    film: Film,
    reference: &'a Image,
    seconds: f64,
    rays: u64,
    samples: u64,
    /// When it was last measured.
    measured: u64,
}

impl<'a> Lane<'a> {
    fn new(view: &View, seed: u64, reference: &'a Image) -> Self {
        let mut view = view.clone();
        view.settings.seed = seed;
        Self {
            film: view.film(),
            view,
            reference,
            seconds: 0.0,
            rays: 0,
            samples: 0,
            measured: 0,
        }
    }

    /// Samples per pixel at the end of the next slice; `None` when the time is used up to the
    /// nearest pair of samples. Pairs, because of the two halves; one pair always.
    fn target(&self, seconds: f64) -> Option<u64> {
        if self.samples == 0 {
            return Some(2);
        }
        let pairs = |seconds: f64| seconds * self.samples as f64 / self.seconds / 2.0;
        let left = pairs(seconds - self.seconds);
        // Not if it is nothing or, with a clock that stands, not a number.
        if !(left.round() >= 1.0) {
            return None;
        }
        let growth = (GROWTH - 1.0) * self.samples as f64 / 2.0;
        let more = left.round().min(pairs(seconds / SLICES)).min(growth);
        Some(self.samples + 2 * (more as u64).max(1))
    }

    /// Renders a slice. Returns false if it was interrupted.
    fn advance(&mut self, target: u64, clock: &dyn Fn() -> f64, cancel: &AtomicBool) -> bool {
        let start = clock();
        let work = self.view.render(&self.film, target, cancel);
        self.seconds += clock() - start;
        self.rays += work.rays;
        self.samples = target;
        self.film.samples() == target
    }

    /// The error, if it is time to measure it.
    fn measure(&mut self, seconds: f64) -> Result<Option<Point>, String> {
        let is_due = self.samples as f64 >= GROWTH * self.measured as f64;
        if !is_due && self.target(seconds).is_some() {
            return Ok(None);
        }
        self.measured = self.samples;
        Ok(Some(Point {
            seconds: self.seconds,
            samples: self.samples,
            rays: self.rays,
            rel_mse: compare(&self.film.develop(), self.reference)?.rel_mse,
        }))
    }
}

/// The seed of a contestant in a round: all differ, so that all pictures are independent.
fn seed(base: u64, round: u64, contestant: usize, contestants: usize) -> u64 {
    let offset = round * contestants as u64 + contestant as u64;
    base.wrapping_add(offset) & MAX_SEED
}

/// The seed of references: far from those of [`run`].
pub fn reference_seed(base: u64) -> u64 {
    base ^ (1 << 62)
}

/// Lets the views race, each against its reference. `clock` tells seconds from any start;
/// `progress` is told the share of the work that is done, 0 to 1, and what is measured so far.
/// When `cancel` is set, that is returned. The error, about a reference of another size, is one
/// line.
pub fn run(
    contestants: &[(View, &Image)],
    rules: Rules,
    clock: &dyn Fn() -> f64,
    cancel: &AtomicBool,
    progress: &mut dyn FnMut(f64, &[Record]),
) -> Result<Vec<Record>, String> {
    let mut records = vec![Record::default(); contestants.len()];
    for round in 0..rules.seeds {
        let mut lanes = Vec::new();
        for (i, (view, reference)) in contestants.iter().enumerate() {
            let seed = seed(view.settings.seed, round, i, contestants.len());
            lanes.push(Lane::new(view, seed, reference));
            let points = Vec::new();
            records[i].runs.push(Run { seed, points });
        }
        let all = rules.seeds as f64;
        let finished = race(
            &mut lanes,
            &mut records,
            rules.seconds,
            clock,
            cancel,
            &mut |share, records| progress((round as f64 + share) / all, records),
        )?;
        if !finished {
            break;
        }
        for (lane, record) in lanes.iter().zip(&mut records) {
            if let Some(light) = Light::of(&lane.film) {
                match &mut record.light {
                    Some(all) => all.add(&light),
                    none => *none = Some(light),
                }
            }
        }
    }
    Ok(records)
}

/// One round: whoever has had least time is next. Returns false if it was interrupted.
fn race(
    lanes: &mut [Lane<'_>],
    records: &mut [Record],
    seconds: f64,
    clock: &dyn Fn() -> f64,
    cancel: &AtomicBool,
    progress: &mut dyn FnMut(f64, &[Record]),
) -> Result<bool, String> {
    loop {
        let racing = lanes
            .iter()
            .enumerate()
            .filter_map(|(i, lane)| Some((i, lane.target(seconds)?)))
            .min_by(|(i, _), (j, _)| lanes[*i].seconds.total_cmp(&lanes[*j].seconds));
        let Some((i, target)) = racing else {
            return Ok(true);
        };
        let lane = &mut lanes[i];
        if cancel.load(Ordering::Relaxed) || !lane.advance(target, clock, cancel) {
            return Ok(false);
        }
        if let (Some(point), Some(run)) = (lane.measure(seconds)?, records[i].runs.last_mut()) {
            run.points.push(point);
        }
        let done: f64 = lanes
            .iter()
            .map(|lane| (lane.seconds / seconds).min(1.0))
            .sum();
        progress(done / lanes.len() as f64, records);
    }
}

/// Renders a view for some seconds of tracing, at least two samples per pixel; `None` if
/// interrupted before. The film may be used as a reference and tells its own error.
pub fn reference(
    view: &View,
    seconds: f64,
    clock: &dyn Fn() -> f64,
    cancel: &AtomicBool,
    progress: &mut dyn FnMut(f64),
) -> Option<Film> {
    let nothing = Image {
        width: 0,
        height: 0,
        pixels: Vec::new(),
    };
    let mut lane = Lane::new(view, reference_seed(view.settings.seed), &nothing);
    while let Some(target) = lane.target(seconds) {
        if cancel.load(Ordering::Relaxed) || !lane.advance(target, clock, cancel) {
            break;
        }
        progress((lane.seconds / seconds).min(1.0));
    }
    (lane.film.samples() >= 2).then_some(lane.film)
}

#[cfg(test)]
mod test;
