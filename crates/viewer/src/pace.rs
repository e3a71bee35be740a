//! How far to render next and when to stop. Pure: it is told the time, and whatever it is told,
//! the samples themselves stay the same.

use lightbox_core::forecast::{Forecast, Goal, Mark, forecast};
use serde::Serialize;

/// How long a batch of samples should take, seconds: rare enough to cost nothing, often enough
/// to stop in time.
const BATCH: f64 = 0.2;

/// Samples per pixel at which the noise is measured first: with fewer, the estimate itself is
/// too noisy to stop by.
pub const FIRST_CHECK: u64 = 16;

/// Foretells how a render will end, which does not look at its noise before [`FIRST_CHECK`].
pub fn foretell(marks: &[Mark], goal: Goal) -> Option<Forecast> {
    let foretold = forecast(marks, goal)?;
    match goal {
        Goal::Noise(_) if foretold.samples.value < FIRST_CHECK as f64 => {
            forecast(marks, Goal::Samples(FIRST_CHECK))
        }
        _ => Some(foretold),
    }
}

/// Where a render stops: at whichever is reached first.
#[derive(Clone, Copy, Debug, Default)]
pub struct Limits {
    /// Samples per pixel.
    pub samples: Option<u64>,
    /// Seconds of tracing.
    pub seconds: Option<f64>,
    /// Estimated relative noise.
    pub noise: Option<f64>,
}

/// Why a render stopped.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Stop {
    /// It has the samples asked for.
    Spp,
    /// The time is up.
    Seconds,
    /// The noise is low enough.
    Noise,
    /// It was interrupted.
    Interrupt,
}

/// How far a render is.
#[derive(Clone, Copy, Debug)]
pub struct Progress {
    /// Samples per pixel.
    pub samples: u64,
    /// Seconds of tracing.
    pub seconds: f64,
    /// The last estimate of the noise.
    pub noise: Option<f64>,
    /// Samples per pixel at which it is measured next.
    pub next_check: u64,
}

impl Default for Progress {
    fn default() -> Self {
        Self {
            samples: 0,
            seconds: 0.0,
            noise: None,
            next_check: FIRST_CHECK,
        }
    }
}

impl Progress {
    /// That of a render taken up again: checks stay where they would have been.
    pub fn resumed(samples: u64, seconds: f64) -> Self {
        let mut check = Self::default();
        while check.next_check < samples {
            check.samples = check.next_check;
            check.checked(None);
        }
        Self {
            samples,
            seconds,
            ..check
        }
    }

    /// Takes note of a fresh estimate of the noise. Checks are at even sample counts, where both
    /// half-films hold as many, and an eighth apart, so that they cost little. They depend on
    /// samples only: a render to a given noise stops at the same sample on every machine.
    pub fn checked(&mut self, noise: Option<f64>) {
        self.noise = noise;
        self.next_check = (self.samples + (self.samples / 8).max(2)).next_multiple_of(2);
    }

    /// Seconds for one more sample per pixel.
    pub fn seconds_per_sample(&self) -> f64 {
        self.seconds / self.samples.max(1) as f64
    }
}

impl Limits {
    /// Where to stop for a goal.
    pub fn at(goal: Goal) -> Self {
        let mut limits = Self::default();
        match goal {
            Goal::Samples(samples) => limits.samples = Some(samples),
            Goal::Seconds(seconds) => limits.seconds = Some(seconds),
            Goal::Noise(noise) => limits.noise = Some(noise),
        }
        limits
    }

    /// The samples per pixel to render up to next, or why to stop.
    pub fn next(&self, progress: &Progress) -> Result<u64, Stop> {
        let have = progress.samples;
        if have == 0 {
            return Ok(1);
        }
        if self.samples.is_some_and(|limit| have >= limit) {
            return Err(Stop::Spp);
        }
        if let (Some(limit), Some(noise)) = (self.noise, progress.noise)
            && noise <= limit
        {
            return Err(Stop::Noise);
        }
        let pass = progress.seconds_per_sample();
        // Doubling at most, so that one slow sample at the start does not set the pace.
        let mut more = ((BATCH / pass) as u64).clamp(1, have);
        if let Some(limit) = self.seconds {
            let fitting = ((limit - progress.seconds) / pass).round();
            if fitting < 1.0 {
                return Err(Stop::Seconds);
            }
            more = more.min(fitting as u64);
        }
        let mut target = have
            .saturating_add(more)
            .min(self.samples.unwrap_or(u64::MAX));
        if self.noise.is_some() {
            target = target.min(progress.next_check);
        }
        Ok(target)
    }

    /// Share of the work done, 0 to 1, as far as can be told.
    pub fn fraction(&self, progress: &Progress) -> f64 {
        let samples = self
            .samples
            .map_or(0.0, |limit| progress.samples as f64 / limit as f64);
        let seconds = self.seconds.map_or(0.0, |limit| progress.seconds / limit);
        // Noise falls with the square root of the samples.
        let noise = match (self.noise, progress.noise) {
            (Some(limit), Some(noise)) => (limit / noise).powi(2),
            _ => 0.0,
        };
        samples.max(seconds).max(noise).min(1.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Sample counts at the end of each batch of a render in which a sample takes `pass` seconds
    /// and the noise is `noise(samples)`, and why it stopped.
    fn batches(limits: &Limits, pass: f64, noise: impl Fn(u64) -> f64) -> (Vec<u64>, Stop) {
        let (mut progress, mut ends) = (Progress::default(), Vec::new());
        loop {
            match limits.next(&progress) {
                Err(stop) => return (ends, stop),
                Ok(target) => {
                    assert!(target > progress.samples);
                    progress.samples = target;
                    progress.seconds = target as f64 * pass;
                    if target >= progress.next_check {
                        progress.checked(Some(noise(target)));
                    }
                    ends.push(target);
                }
            }
        }
    }

    #[test]
    fn samples_are_met_exactly_in_batches_that_fit() {
        let (ends, stop) = batches(
            &Limits {
                samples: Some(100),
                ..Limits::default()
            },
            0.01,
            |_| 1.0,
        );
        assert_eq!((ends.last(), stop), (Some(&100), Stop::Spp));
        assert!(ends.windows(2).all(|w| w[1] - w[0] <= 20), "{ends:?}");
        // Free samples: no division by zero, no endless loop.
        assert_eq!(
            batches(
                &Limits {
                    samples: Some(1 << 40),
                    ..Limits::default()
                },
                0.0,
                |_| 1.0
            )
            .1,
            Stop::Spp
        );
    }

    #[test]
    fn time_is_met_to_the_nearest_sample_and_one_is_always_taken() {
        for (pass, expected) in [(0.3, 3), (0.26, 4), (5.0, 1), (0.001, 1000)] {
            let (ends, stop) = batches(
                &Limits {
                    seconds: Some(1.0),
                    ..Limits::default()
                },
                pass,
                |_| 1.0,
            );
            assert_eq!(
                (ends.last(), stop),
                (Some(&expected), Stop::Seconds),
                "{pass}"
            );
        }
    }

    #[test]
    fn a_render_taken_up_anywhere_is_checked_at_the_same_samples() {
        let mut progress = Progress::default();
        let mut checks = vec![];
        while progress.samples < 500 {
            progress.samples = progress.next_check;
            checks.push(progress.next_check);
            progress.checked(None);
        }
        for samples in 0..500 {
            let next = Progress::resumed(samples, 1.0).next_check;
            assert_eq!(
                Some(&next),
                checks.iter().find(|c| **c >= samples),
                "{samples}"
            );
        }
    }

    #[test]
    fn noise_stops_at_the_same_sample_at_any_speed() {
        let limits = Limits {
            noise: Some(0.1),
            ..Limits::default()
        };
        let noise = |samples: u64| 1.0 / (samples as f64).sqrt();
        let slow = batches(&limits, 10.0, noise);
        let fast = batches(&limits, 1e-6, noise);
        assert_eq!((slow.0.last(), slow.1), (fast.0.last(), Stop::Noise));
        let end = *slow.0.last().unwrap();
        assert!((100..=114).contains(&end) && end.is_multiple_of(2), "{end}");
        let (ends, stop) = batches(
            &Limits {
                samples: Some(50),
                ..limits
            },
            0.01,
            noise,
        );
        assert_eq!((ends.last(), stop), (Some(&50), Stop::Spp));
    }
}
