//! Statistics of the probes. Seeds are fixed, so every figure is deterministic: green stays green
//! until the code or a seed changes. Only then does the chance of a false alarm matter; it is
//! [`FAMILY_ALPHA`] over all comparisons together.

use rayon::prelude::*;

use super::{Bound, Figure};

/// Chance that any comparison of the family fails although nothing is wrong.
pub const FAMILY_ALPHA: f64 = 1e-3;

/// An upper bound on the number of comparisons in the family. Most are the pairs of dimensions of
/// the sampler.
pub const FAMILY_SIZE: i32 = 4000;

/// Chance of a false alarm left to one comparison (Šidák 1967): 2.5·10⁻⁷.
pub fn alpha() -> f64 {
    1.0 - (1.0 - FAMILY_ALPHA).powf(1.0 / f64::from(FAMILY_SIZE))
}

/// Independent estimates that make a mean.
pub const REPLICATES: usize = 32;

/// Quantile 1 − α/2 of Student's t with 31 degrees of freedom (recomputed by a test).
pub const T_31: f64 = 6.562_73;

/// Quantile 1 − α of χ² with 63 degrees of freedom (recomputed by a test).
pub const CHI_SQUARE_63: f64 = 136.357;

/// Bias, in true standard deviations of the mean, with which Student's t of 31 degrees of freedom
/// exceeds [`T_31`] nine times of ten: by the noncentral distribution (recomputed by a test).
pub const BIAS_31: f64 = 8.180_34;

/// What a true standard deviation is at most, over one estimated from 32 values, in 99 of 100
/// cases: √(31/χ²) at the quantile 0.01 (recomputed by a test). The power of a comparison is told
/// from a single estimate, which is as often too small as too large.
pub const SPREAD_31: f64 = 1.407_17;

/// Independent, identically distributed estimates of one number.
#[derive(Clone, Debug)]
pub struct Replicates([f64; REPLICATES]);

impl Replicates {
    /// Estimates by number, computed in parallel.
    pub fn of(estimate: impl Fn(u64) -> f64 + Sync) -> Self {
        let mut values = [0.0; REPLICATES];
        values
            .par_iter_mut()
            .enumerate()
            .for_each(|(i, value)| *value = estimate(i as u64));
        Self(values)
    }

    /// Their mean.
    pub fn mean(&self) -> f64 {
        self.0.iter().sum::<f64>() / REPLICATES as f64
    }

    /// Estimated variance of the mean.
    fn variance_of_mean(&self) -> f64 {
        let mean = self.mean();
        let squares: f64 = self.0.iter().map(|v| (v - mean) * (v - mean)).sum();
        squares / ((REPLICATES - 1) * REPLICATES) as f64
    }

    /// Root of the mean squared distance from `truth`.
    pub fn rmse(&self, truth: f64) -> f64 {
        let squares: f64 = self.0.iter().map(|v| (v - truth) * (v - truth)).sum();
        (squares / REPLICATES as f64).sqrt()
    }
}

/// Comparisons of means, of which the worst counts.
#[derive(Clone, Copy, Debug, Default)]
pub struct Comparisons {
    /// Largest deviation, in critical distances: above 1 is a failure.
    pub deviation: f64,
    /// Largest relative error that a comparison would miss one time in ten, or less often: with
    /// the spread at its upper 99 % limit.
    pub blindness: f64,
}

impl Comparisons {
    /// Compares a mean with its analytic value (Student's t).
    pub fn mean(&mut self, estimates: &Replicates, truth: f64) {
        // Where there is no noise, rounding takes its place.
        let sigma = estimates.variance_of_mean().sqrt().max(1e-6 * truth.abs());
        self.add(estimates.mean() - truth, sigma, truth.abs());
    }

    /// Compares two estimators of one unknown number (Welch's t). Their degrees of freedom lie
    /// between 31 and 62; the critical value is that of 31, the larger.
    pub fn agree(&mut self, a: &Replicates, b: &Replicates) {
        let scale = a.mean().abs().max(b.mean().abs());
        let variance = a.variance_of_mean() + b.variance_of_mean();
        self.add(
            a.mean() - b.mean(),
            variance.sqrt().max(1e-6 * scale),
            scale,
        );
    }

    fn add(&mut self, difference: f64, sigma: f64, scale: f64) {
        let deviation = difference.abs() / (T_31 * sigma);
        // NaN must not hide behind `max`.
        if !(deviation <= self.deviation) {
            self.deviation = deviation;
        }
        let blindness = BIAS_31 * SPREAD_31 * sigma / scale;
        if !(blindness <= self.blindness) {
            self.blindness = blindness;
        }
    }

    /// The worst comparison, and that even the weakest had the power to see a relative error of
    /// `resolution`.
    pub fn figures(self, what: &'static str, naive: Option<Self>, resolution: f64) -> Vec<Figure> {
        vec![
            Figure {
                what,
                naive: naive.map(|n| n.deviation),
                lightbox: self.deviation,
                bound: Bound::AtMost(1.0),
            },
            Figure {
                what: "relative error that is found 9 times of 10, or more often",
                naive: None,
                lightbox: self.blindness,
                bound: Bound::AtMost(resolution),
            },
        ]
    }
}

/// Pearson's χ² of counts in 64 cells. They must come from independent numbers; a cell of
/// expectation 0 must be empty, and the others need an expectation of 5.
pub fn chi_square(observed: &[f64; 64], expected: &[f64; 64]) -> f64 {
    let cells = observed.iter().zip(expected);
    cells
        .map(|(o, e)| {
            if *e == 0.0 {
                if *o == 0.0 { 0.0 } else { f64::INFINITY }
            } else {
                debug_assert!(*e >= 5.0, "{e} expected in a cell");
                (o - e) * (o - e) / e
            }
        })
        .sum()
}

/// The cell, of 8×8, of a point in the unit square.
pub fn cell([x, y]: [f64; 2]) -> usize {
    let index = |x: f64| ((x * 8.0) as usize).min(7);
    index(y) * 8 + index(x)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn values(offset: f64) -> Replicates {
        Replicates::of(|i| 1.0 + offset + 0.01 * (i % 5) as f64 - 0.0197)
    }

    #[test]
    fn wrong_means_are_found() {
        let deviation = |compare: &dyn Fn(&mut Comparisons)| {
            let mut comparisons = Comparisons::default();
            compare(&mut comparisons);
            comparisons.deviation
        };
        assert!(deviation(&|c| c.mean(&values(0.0), 1.0)) < 0.1);
        // Against another estimate the critical distance is √2 of that against the truth.
        for wrong in [0.02, -0.02, f64::NAN] {
            assert!(!(deviation(&|c| c.mean(&values(wrong), 1.0)) <= 1.0));
            assert!(!(deviation(&|c| c.agree(&values(1.5 * wrong), &values(0.0))) <= 1.0));
        }
    }

    #[test]
    fn blindness_is_told() {
        let mut comparisons = Comparisons::default();
        comparisons.mean(&values(0.0), 1.0);
        // σ of 0.0144 over √32 times 8.18 · 1.407.
        assert!((comparisons.blindness - 0.0293).abs() < 0.001);
        assert!(!comparisons.figures("mean", None, 0.02)[1].holds());
    }

    #[test]
    fn wrong_counts_are_found() {
        let even = [1000.0; 64];
        let mut observed = even;
        observed[3] -= 200.0;
        observed[9] += 200.0;
        assert!(chi_square(&even, &even) < CHI_SQUARE_63);
        assert!(chi_square(&observed, &even) < CHI_SQUARE_63);
        observed[9] += 200.0;
        assert!(chi_square(&observed, &even) > CHI_SQUARE_63);
        let mut expected = even;
        expected[0] = 0.0;
        assert_eq!(chi_square(&even, &expected), f64::INFINITY);
    }
}
