//! What the samples of a pixel tell, in figures.

use lightbox_core::color::luminance;
use lightbox_core::integrator::replay::Strategy;
use lightbox_core::render::autopsy::Autopsy;

/// Number of bars of the histogram.
const BARS: usize = 48;

/// Points of the curve lie at least this factor of samples apart.
const SPACING: f64 = 1.12;

/// One sample in this many belongs to the tail: the brightest.
const TAIL: usize = 100;

/// Share of the variance from which on that tail is heavy. Of exponential noise it has a quarter,
/// of a tail that falls with the power 3 of luminance three fifths, with the power 2 all.
const HEAVY: f64 = 0.75;

/// Light by paths of some number of segments, or by all.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Row {
    /// Mean luminance by strategy, W/(m²·sr).
    pub light: [f64; Strategy::ALL.len()],
    /// Variance of a sample by strategy.
    pub variance: [f64; Strategy::ALL.len()],
}

/// How many samples lie where, evenly along the logarithm of their luminance.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Histogram {
    /// Decimal logarithms of the luminances at its ends.
    pub ends: [f64; 2],
    /// Samples in each bar.
    pub counts: Vec<usize>,
    /// Samples without light.
    pub black: usize,
}

/// The figures; all of luminance, W/(m²·sr).
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Findings {
    /// Number of samples.
    pub samples: usize,
    /// Samples that were no radiance, and are left out below.
    pub invalid: usize,
    /// Their mean.
    pub mean: f64,
    /// Variance of one of them.
    pub variance: f64,
    /// By number of segments, from one on.
    pub rows: Vec<Row>,
    /// Where they lie.
    pub histogram: Histogram,
    /// Shares of the light and of the variance that the brightest hundredth of samples brings; `None`
    /// where there is none, or too few samples to tell.
    pub tail: [Option<f64>; 2],
    /// Number of samples, their mean and its standard error if they were independent.
    pub curve: Vec<[f64; 3]>,
    /// Indices of the brightest samples, brightest first.
    pub brightest: Vec<u64>,
}

impl Findings {
    /// Counts what was found.
    pub fn of(autopsy: &Autopsy, brightest: usize) -> Self {
        let all = autopsy.radiances.iter();
        let valid = all.zip(0..).filter(|(radiance, _)| radiance.is_finite());
        let light: Vec<(f64, u64)> = valid
            .map(|(radiance, i)| (f64::from(luminance(*radiance)), i))
            .collect();
        let n = light.len();
        let curve = curve(light.iter().map(|(x, _)| *x));
        let [mean, error] = curve
            .last()
            .map_or([0.0; 2], |[_, mean, error]| [*mean, *error]);
        let mut sorted = light;
        sorted.sort_unstable_by(|a, b| b.0.total_cmp(&a.0));
        let tallies = autopsy.found.iter();
        let rows = tallies.map(|tallies| Row {
            light: tallies.map(|tally| tally.mean(n.max(1))),
            variance: tallies.map(|tally| tally.variance(n.max(1))),
        });
        let values: Vec<f64> = sorted.iter().map(|(x, _)| *x).collect();
        Self {
            samples: autopsy.radiances.len(),
            invalid: autopsy.radiances.len() - n,
            mean,
            variance: error * error * n as f64,
            rows: rows.collect(),
            histogram: histogram(&values),
            tail: tail(&values, mean),
            curve,
            brightest: sorted.iter().take(brightest).map(|(_, i)| *i).collect(),
        }
    }

    /// Whether rare bright samples make the noise: more samples lower it less than they should.
    pub fn is_heavy(&self) -> bool {
        self.tail[1].is_some_and(|share| share > HEAVY)
    }

    /// The rows together.
    pub fn all(&self) -> [f64; Strategy::ALL.len()] {
        self.rows.iter().fold([0.0; 3], |sum, row| {
            std::array::from_fn(|i| sum[i] + row.light[i])
        })
    }
}

/// The mean as it came about.
fn curve(light: impl Iterator<Item = f64>) -> Vec<[f64; 3]> {
    let mut curve: Vec<[f64; 3]> = Vec::new();
    // After Welford 1962: the mean, and squares about it.
    let (mut mean, mut squares) = (0.0, 0.0);
    let mut light = light.zip(1..).peekable();
    let mut next = 2.0;
    while let Some((x, n)) = light.next() {
        let n = f64::from(n);
        let off = x - mean;
        mean += off / n;
        squares += off * (x - mean);
        if n >= next || (n > 1.0 && light.peek().is_none()) {
            curve.push([n, mean, (squares / (n - 1.0) / n).sqrt()]);
            next = n * SPACING;
        }
    }
    curve
}

/// From the brightest on.
fn histogram(sorted: &[f64]) -> Histogram {
    let bright = sorted.partition_point(|x| *x > 0.0);
    let (bright, black) = (&sorted[..bright], sorted.len() - bright);
    let (Some(high), Some(low)) = (bright.first(), bright.last()) else {
        return Histogram {
            black,
            ..Histogram::default()
        };
    };
    let (mut low, mut high) = (low.log10(), high.log10());
    if high - low < 0.1 {
        (low, high) = (low - 0.05, high + 0.05);
    }
    let mut counts = vec![0; BARS];
    for x in bright {
        let place = (x.log10() - low) / (high - low) * BARS as f64;
        counts[(place as usize).min(BARS - 1)] += 1;
    }
    Histogram {
        ends: [low, high],
        counts,
        black,
    }
}

/// What the brightest bring, from the brightest on.
fn tail(sorted: &[f64], mean: f64) -> [Option<f64>; 2] {
    let count = sorted.len() / TAIL;
    let share = |part: fn(f64, f64) -> f64| {
        let sum = |values: &[f64]| values.iter().map(|x| part(*x, mean)).sum::<f64>();
        let all = sum(sorted);
        (count > 0 && all > 0.0).then(|| sum(&sorted[..count]) / all)
    };
    [share(|x, _| x), share(|x, mean| (x - mean) * (x - mean))]
}

#[cfg(test)]
mod tests {
    use glam::Vec3;

    use super::*;

    fn findings(light: impl Iterator<Item = f64>) -> Findings {
        let radiances = light.map(|x| Vec3::splat(x as f32)).collect();
        let autopsy = Autopsy {
            radiances,
            ..Autopsy::default()
        };
        Findings::of(&autopsy, 2)
    }

    /// Evenly over (0, 1).
    fn even(n: u32) -> impl Iterator<Item = f64> {
        (0..n).map(move |i| (f64::from(i.wrapping_mul(7919) % n) + 0.5) / f64::from(n))
    }

    #[test]
    fn mean_and_variance_are_those_of_the_samples() {
        let found = findings(even(5000));
        assert!((found.mean - 0.5).abs() < 1e-5, "{}", found.mean);
        assert!(
            (found.variance - 1.0 / 12.0).abs() < 1e-4,
            "{}",
            found.variance
        );
        let [n, mean, error] = *found.curve.last().expect("a point");
        assert_eq!((n, mean), (5000.0, found.mean));
        assert!((error - (found.variance / 5000.0).sqrt()).abs() < 1e-9);
        assert!(found.curve.windows(2).all(|w| w[0][0] < w[1][0]));
        assert_eq!(found.curve[0][0], 2.0);
    }

    #[test]
    fn a_tail_that_makes_the_noise_is_flagged() {
        // Chances of more than x: x⁻¹·⁵, x⁻³ and e⁻ˣ.
        let power = |power: f64| findings(even(20_000).map(|u| u.powf(-1.0 / power)));
        let told = |found: &Findings| found.tail.map(|share| share.expect("a share"));
        assert!(power(1.5).is_heavy(), "{:?}", power(1.5).tail);
        let [light, variance] = told(&power(3.0));
        assert!((light - 0.01f64.powf(2.0 / 3.0)).abs() < 0.005, "{light}");
        assert!((variance - 0.61).abs() < 0.05, "{variance}");
        let [_, variance] = told(&findings(even(20_000).map(|u| -u.ln())));
        assert!((variance - 0.22).abs() < 0.05, "{variance}");
        // Rare fireflies over even light.
        let mut fireflies: Vec<f64> = even(1000).collect();
        fireflies[70] = 100.0;
        assert!(findings(fireflies.into_iter()).is_heavy());
        assert!(!findings(even(5000)).is_heavy());
        let [light, variance] = findings(std::iter::repeat_n(1.0, 5000)).tail;
        assert_eq!((light, variance), (Some(0.01), None));
        assert_eq!(findings(even(99)).tail, [None; 2]);
        assert_eq!(findings(std::iter::repeat_n(0.0, 5000)).tail, [None; 2]);
    }

    #[test]
    fn every_sample_is_in_the_histogram_or_black_or_invalid() {
        let light = even(900).chain([0.0; 90]).chain([f64::NAN; 10]);
        let found = findings(light);
        assert_eq!(
            (found.samples, found.invalid, found.histogram.black),
            (1000, 10, 90)
        );
        assert_eq!(found.histogram.counts.iter().sum::<usize>(), 900);
        // Half of all lies in the upper third of a decade.
        let [low, high] = found.histogram.ends;
        let middle = ((0.5f64.log10() - low) / (high - low) * BARS as f64) as usize;
        let upper: usize = found.histogram.counts[middle..].iter().sum();
        assert!((430..520).contains(&upper), "{upper}");
        assert_eq!(findings(std::iter::empty()), Findings::default());
        let constant = findings(std::iter::repeat_n(2.0, 10));
        assert_eq!(constant.histogram.counts.iter().sum::<usize>(), 10);
    }

    #[test]
    fn the_brightest_are_named() {
        let mut light: Vec<f64> = even(300).collect();
        (light[17], light[200]) = (50.0, 70.0);
        let found = findings(light.into_iter());
        assert_eq!(found.brightest, [200, 17]);
    }
}
