//! When a picture is done, what that will take, and how good such forecasts were.

use lightbox_core::forecast::{Forecast, Goal, Mark};

use super::history::{Point, Run};
use crate::pace::{Limits, foretell};

/// When a picture is done.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Budget {
    /// When it has the samples that its settings ask for.
    #[default]
    Samples,
    /// After so many seconds of tracing, to the nearest sample per pixel.
    Seconds(f64),
    /// When its noise is at most this.
    Noise(f64),
}

impl Budget {
    /// The goal, for settings that ask for some samples per pixel.
    pub(super) fn goal(self, samples: u64) -> Goal {
        match self {
            Self::Samples => Goal::Samples(samples),
            Self::Seconds(seconds) => Goal::Seconds(seconds),
            Self::Noise(noise) => Goal::Noise(noise),
        }
    }

    /// Where to stop for it.
    pub(super) fn limits(self, samples: u64) -> Limits {
        Limits::at(self.goal(samples))
    }
}

/// What is foretold of a picture.
#[derive(Default)]
pub(super) struct Outlook {
    /// Told from all that is known.
    pub forecast: Option<Forecast>,
    /// What was told first, to be held against the outcome.
    pub promise: Option<Forecast>,
    /// What the promise was about: curve and goal.
    about: Option<(u64, Goal)>,
}

impl Outlook {
    /// Looks ahead to a goal once more.
    pub fn update(&mut self, run: &Run, goal: Goal, is_done: bool) {
        let mark = |p: &Point| Mark {
            samples: p.samples,
            seconds: p.seconds,
            noise: p.noise,
        };
        let marks: Vec<Mark> = run.points.iter().map(mark).collect();
        self.forecast = foretell(&marks, goal);
        if self.about != Some((run.id, goal)) {
            (self.about, self.promise) = (Some((run.id, goal)), None);
        }
        if self.promise.is_none() && !is_done {
            let now = marks.last().map_or(0.0, |mark| mark.samples as f64);
            let is_ahead = |f: &Forecast| f.noise.is_some() && f.samples.value > now;
            self.promise = self.forecast.filter(is_ahead);
        }
    }
}
