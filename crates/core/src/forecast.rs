//! What a render will have cost and reached, told from how it went so far.
//!
//! The noise of independent samples falls as N^(−1/2), that of the Sobol sampler somewhat faster.
//! The curve is drawn on from its newest place, which knows all samples of the older ones, with
//! the slope between there and sixteen times fewer samples, held near −1/2 as far as that is
//! uncertain (a Bayesian regression, Gelman et al. 2013, chapter 14). A place is as uncertain as
//! the error estimate says, and somewhat more while samples are few. Time goes on at the pace of
//! the newest samples. Bands are to hold in nine cases of ten; docs/speed-and-accuracy.md has
//! how many they held.

use crate::film::ErrorEstimate;

/// A place on the curve of a render.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Mark {
    /// Samples per pixel.
    pub samples: u64,
    /// Seconds of tracing.
    pub seconds: f64,
    /// Relative error with its band, where it is known.
    pub noise: Option<Span>,
}

/// When a render is to end.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Goal {
    /// At so many samples per pixel.
    Samples(u64),
    /// After so many seconds of tracing.
    Seconds(f64),
    /// At this relative error.
    Noise(f64),
}

/// A figure foretold, in whatever unit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Span {
    /// What to expect.
    pub value: f64,
    /// What it stays above in 19 cases of 20.
    pub low: f64,
    /// What it stays below in 19 cases of 20.
    pub high: f64,
}

impl Span {
    /// An estimated error, as [`ErrorEstimate::noise`].
    pub fn noise_of(error: &ErrorEstimate) -> Self {
        let [low, high] = error.band();
        Self {
            value: error.noise(),
            low,
            high,
        }
    }

    /// A figure that is certain.
    pub fn exact(value: f64) -> Self {
        Self {
            value,
            low: value,
            high: value,
        }
    }

    /// Whether an outcome is in the band.
    pub fn holds(&self, outcome: f64) -> bool {
        (self.low..=self.high).contains(&outcome)
    }
}

/// How a render will end.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct Forecast {
    /// Samples per pixel.
    pub samples: Span,
    /// Seconds of tracing.
    pub seconds: Span,
    /// Relative error; unknown as long as the curve is too short.
    pub noise: Option<Span>,
}

/// Samples from which on the estimate of the noise is good enough to be drawn on.
const FIRST: u64 = 8;

/// The slope is taken over samples that grew by at most this factor.
const OCTAVES: f64 = 16.0;

/// Slope of the noise on logarithmic axes, and its standard deviation over scenes and methods.
const SLOPE: [f64; 2] = [-0.51, 0.04];

/// Standard deviation of the logarithm of the noise at one sample, beyond what the estimate's band
/// says, and the power of the samples with which it falls: light that few paths bring is first
/// missed, then overrated.
const EARLY: [f64; 2] = [0.5, -0.75];

/// Least growth of the samples from one rate to the next: closer ones tell the same.
const STEP: f64 = 1.19;

/// Least uncertainty of the pace, relative.
const LEAST_JITTER: f64 = 0.02;

/// Half the width of a band, in standard deviations.
const BAND: f64 = 1.645;

/// Foretells how a render with some curve, oldest mark first, will end. `None` before the first
/// whole sample, and for a noise that the curve does not lead to.
pub fn forecast(marks: &[Mark], goal: Goal) -> Option<Forecast> {
    let now = *marks.iter().rfind(|m| m.samples > 0)?;
    let (pace, trend) = (Pace::of(marks, now), Trend::of(marks));
    let noise_at = |samples: Span| {
        let trend = trend.as_ref()?;
        let [best, low, high] = [samples.value, samples.high, samples.low].map(|n| trend.at(n));
        Some(Span {
            value: best.value,
            low: low.low,
            high: high.high,
        })
    };
    Some(match goal {
        Goal::Samples(samples) => {
            let samples = Span::exact(samples.max(now.samples) as f64);
            Forecast {
                samples,
                seconds: pace.seconds(samples),
                noise: noise_at(samples),
            }
        }
        Goal::Seconds(seconds) => {
            let samples = pace.samples(seconds);
            Forecast {
                samples,
                seconds: Span::exact(seconds),
                noise: noise_at(samples),
            }
        }
        Goal::Noise(noise) => {
            let Span { value, low, high } = trend?.reaching(noise)?;
            let least = now.samples as f64;
            let samples = Span {
                value: value.max(least),
                low: low.max(least),
                high: high.max(least),
            };
            Forecast {
                samples,
                seconds: pace.seconds(samples),
                noise: Some(Span::exact(noise)),
            }
        }
    })
}

/// How fast samples come.
struct Pace {
    now: Mark,
    /// Seconds per sample, and the relative uncertainty of that.
    per_sample: f64,
    jitter: f64,
}

impl Pace {
    /// From the newest half of the samples, cut into pieces that are compared with each other.
    fn of(marks: &[Mark], now: Mark) -> Self {
        let mut rates = Vec::new();
        let mut to = now;
        for mark in marks.iter().rev() {
            let samples = to.samples.saturating_sub(mark.samples);
            if samples == 0 || to.samples as f64 / (mark.samples.max(1) as f64) < STEP {
                continue;
            }
            rates.push((to.seconds - mark.seconds) / samples as f64);
            to = *mark;
            if mark.samples < now.samples / 4 {
                break;
            }
        }
        if rates.is_empty() {
            rates.push(now.seconds / now.samples as f64);
        }
        let mean = rates.iter().sum::<f64>() / rates.len() as f64;
        let square = rates.iter().map(|r| (r - mean) * (r - mean)).sum::<f64>();
        let scatter = match rates.len() {
            1 => 0.2, // Nothing to compare with.
            n => (square / (n - 1) as f64).sqrt() / mean.max(f64::MIN_POSITIVE),
        };
        Self {
            now,
            per_sample: mean,
            jitter: scatter.max(LEAST_JITTER),
        }
    }

    fn seconds(&self, samples: Span) -> Span {
        let after = |n: f64, jitters: f64| {
            let left = (n - self.now.samples as f64).max(0.0) * self.per_sample;
            self.now.seconds + left * (1.0 + jitters * self.jitter).max(0.0)
        };
        Span {
            value: after(samples.value, 0.0),
            low: after(samples.low, -BAND),
            high: after(samples.high, BAND),
        }
    }

    fn samples(&self, seconds: f64) -> Span {
        let left = (seconds - self.now.seconds).max(0.0);
        let after = |jitters: f64| {
            let per_sample = self.per_sample * (1.0 + jitters * self.jitter).max(0.1);
            // At least one is taken, whatever it takes.
            self.now.samples as f64 + left / per_sample.max(f64::MIN_POSITIVE)
        };
        Span {
            value: after(0.0),
            low: after(BAND),
            high: after(-BAND),
        }
    }
}

/// A noise that is known, in logarithms.
#[derive(Clone, Copy)]
struct Place {
    samples: f64,
    noise: f64,
    /// Of the noise.
    variance: f64,
}

impl Place {
    fn of(mark: &Mark) -> Option<Self> {
        let noise = mark.noise.filter(|n| n.low > 0.0 && n.high.is_finite())?;
        let [early, power] = EARLY;
        let early = early * (mark.samples as f64).powf(power);
        let own = (noise.high / noise.low).ln() / (2.0 * BAND);
        (mark.samples >= FIRST).then(|| Self {
            samples: (mark.samples as f64).ln(),
            noise: noise.value.ln(),
            variance: early * early + own * own,
        })
    }

    /// Variance of the noise from here to where there are more samples: these are among them.
    fn variance_to(&self, samples: f64) -> f64 {
        self.variance * -(self.samples - samples).min(0.0).exp_m1()
    }
}

/// The curve's newest place and slope, in logarithms of samples and noise.
struct Trend {
    newest: Place,
    slope: f64,
    slope_variance: f64,
}

impl Trend {
    fn of(marks: &[Mark]) -> Option<Self> {
        let mut places = marks.iter().rev().filter_map(Place::of);
        let newest = places.next()?;
        let way = |place: &Place| newest.samples - place.samples;
        let oldest = places.take_while(|p| way(p) <= OCTAVES.ln()).last();
        let [expected, leeway] = SLOPE;
        let (mut slope, mut precision) = (expected, 1.0 / (leeway * leeway));
        if let Some(oldest) = oldest.filter(|p| way(p) > 0.0) {
            let found = (newest.noise - oldest.noise) / way(&oldest);
            let variance = oldest.variance_to(newest.samples) / (way(&oldest) * way(&oldest));
            let both = precision + 1.0 / variance;
            slope = (slope * precision + found / variance) / both;
            precision = both;
        }
        Some(Self {
            newest,
            slope,
            slope_variance: 1.0 / precision,
        })
    }

    /// Uncertainty of the logarithm of the noise at a logarithm of samples.
    fn deviation(&self, x: f64) -> f64 {
        let way = x - self.newest.samples;
        (self.newest.variance_to(x) + self.slope_variance * way * way).sqrt()
    }

    fn at(&self, samples: f64) -> Span {
        let x = samples.max(1.0).ln();
        let y = self.newest.noise + self.slope * (x - self.newest.samples);
        let half = BAND * self.deviation(x);
        Span {
            value: y.exp(),
            low: (y - half).exp(),
            high: (y + half).exp(),
        }
    }

    fn reaching(&self, noise: f64) -> Option<Span> {
        let is_reached = self.slope < -0.1 && noise > 0.0;
        if !is_reached {
            return None;
        }
        let x = self.newest.samples + (noise.ln() - self.newest.noise) / self.slope;
        let half = BAND * self.deviation(x) / -self.slope;
        Some(Span {
            value: x.exp(),
            low: (x - half).exp(),
            high: (x + half).exp(),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A noise known to within a hundredth.
    fn known(noise: f64) -> Option<Span> {
        Some(Span {
            value: noise,
            low: noise / 1.01,
            high: noise * 1.01,
        })
    }

    /// A curve with some slope, a sample in 10 ms, up to some samples.
    fn curve(slope: f64, until: u64) -> Vec<Mark> {
        (1..=until)
            .map(|samples| Mark {
                samples,
                seconds: samples as f64 * 0.01,
                noise: known((samples as f64).powf(slope)).filter(|_| samples > 1),
            })
            .collect()
    }

    fn close(a: f64, b: f64) -> bool {
        (a / b - 1.0).abs() < 0.01
    }

    #[test]
    fn a_straight_curve_is_drawn_on() {
        for slope in [-0.5, -0.6] {
            let marks = curve(slope, 256);
            let end = forecast(&marks, Goal::Samples(4096)).expect("a forecast");
            assert!(close(end.seconds.value, 40.96), "{end:?}");
            let noise = end.noise.expect("a noise");
            let truth = 4096f64.powf(slope);
            assert!(noise.holds(truth), "{slope}: {noise:?} not {truth}");
            assert!(noise.high / noise.low < 1.5, "{noise:?}");
            let end = forecast(&marks, Goal::Seconds(40.96)).expect("a forecast");
            assert!(close(end.samples.value, 4096.0), "{end:?}");
            assert!(end.noise.expect("a noise").holds(truth));
            let end = forecast(&marks, Goal::Noise(truth)).expect("a forecast");
            assert!(end.samples.holds(4096.0), "{end:?}");
            assert!(end.seconds.holds(40.96), "{end:?}");
        }
    }

    #[test]
    fn a_short_curve_is_taken_for_an_ordinary_one() {
        let end = forecast(&curve(-0.5, 8), Goal::Samples(64)).expect("a forecast");
        assert!(end.noise.expect("a noise").holds(0.125), "{end:?}");
        // Few samples: the time can be told, the noise cannot.
        let end = forecast(&curve(-0.5, 7), Goal::Samples(64)).expect("a forecast");
        assert!(
            close(end.seconds.value, 0.64) && end.noise.is_none(),
            "{end:?}"
        );
        assert_eq!(forecast(&curve(-0.5, 1), Goal::Noise(0.1)), None);
        assert_eq!(forecast(&[], Goal::Samples(64)), None);
    }

    #[test]
    fn the_pace_is_that_of_the_newest_samples() {
        let mut marks = curve(-0.5, 100);
        // Ten times slower from then on.
        marks.extend((101..=1000).map(|samples| Mark {
            samples,
            seconds: 1.0 + (samples - 100) as f64 * 0.1,
            noise: None,
        }));
        let end = forecast(&marks, Goal::Samples(2000)).expect("a forecast");
        assert!(close(end.seconds.value, 191.0), "{end:?}");
        assert!(end.seconds.high - end.seconds.low < 20.0, "{end:?}");
    }

    #[test]
    fn uneven_pace_and_noise_widen_the_bands() {
        let even = curve(-0.5, 256);
        let mut uneven = even.clone();
        let mut seconds = 0.0;
        for (i, mark) in uneven.iter_mut().enumerate() {
            seconds += if i / 16 % 2 == 0 { 0.005 } else { 0.015 };
            mark.seconds = seconds;
            mark.noise = mark.noise.map(|n| Span {
                low: n.low / 1.1,
                high: n.high * 1.1,
                ..n
            });
        }
        let width = |marks: &[Mark]| {
            let end = forecast(marks, Goal::Samples(1024)).expect("a forecast");
            let relative = |s: Span| (s.high - s.low) / s.value;
            (relative(end.seconds), relative(end.noise.expect("a noise")))
        };
        let (even, uneven) = (width(&even), width(&uneven));
        assert!(uneven.0 > 2.0 * even.0 && uneven.1 > 2.0 * even.1);
    }

    #[test]
    fn bands_are_in_order_whatever_the_goal() {
        let marks = curve(-0.5, 64);
        for goal in [Goal::Samples(512), Goal::Seconds(5.12), Goal::Noise(0.04)] {
            let end = forecast(&marks, goal).expect("a forecast");
            for span in [end.samples, end.seconds, end.noise.expect("a noise")] {
                assert!(
                    span.low <= span.value && span.value <= span.high,
                    "{goal:?}: {span:?}"
                );
            }
        }
    }

    #[test]
    fn numbers_without_sense_give_no_nonsense() {
        let flat: Vec<Mark> = curve(0.0, 300);
        // Noise that does not fall is not reached.
        assert_eq!(forecast(&flat, Goal::Noise(0.5)), None);
        let mut silent = curve(-0.5, 100);
        for mark in &mut silent {
            (mark.noise, mark.seconds) = (Some(Span::exact(0.0)), 0.0);
        }
        for goal in [Goal::Samples(1000), Goal::Seconds(3.0)] {
            let end = forecast(&silent, goal).expect("a forecast");
            assert!(end.noise.is_none());
            for span in [end.samples, end.seconds] {
                assert!(span.low <= span.value && span.value <= span.high);
                assert!(!span.value.is_nan());
            }
        }
        // What is reached already takes no more time.
        let marks = curve(-0.5, 100);
        let end = forecast(&marks, Goal::Samples(50)).expect("a forecast");
        assert_eq!(end.seconds.value, 1.0);
    }
}
