//! Statistics for tests of estimators.

use statrs::distribution::{ChiSquared, ContinuousCDF, StudentsT};

/// Chance that any statistical test of the family fails although nothing is wrong.
pub const FAMILY_ALPHA: f64 = 1e-3;

/// An upper bound on the number of statistical assertions in the family.
pub const FAMILY_SIZE: i32 = 200;

/// Chance of a false alarm left to one assertion (Šidák 1967): 5·10⁻⁶.
pub fn alpha() -> f64 {
    1.0 - (1.0 - FAMILY_ALPHA).powf(1.0 / f64::from(FAMILY_SIZE))
}

/// Independent, identically distributed estimates of one number.
#[derive(Clone, Debug)]
pub struct Replicates {
    values: Vec<f64>,
}

impl Replicates {
    /// At least two estimates.
    pub fn new(values: Vec<f64>) -> Self {
        assert!(
            values.len() >= 2 && values.iter().all(|v| v.is_finite()),
            "{values:?}"
        );
        Self { values }
    }

    /// Their mean.
    pub fn mean(&self) -> f64 {
        self.values.iter().sum::<f64>() / self.values.len() as f64
    }

    /// Estimated variance of the mean.
    pub fn variance_of_mean(&self) -> f64 {
        let (n, mean) = (self.values.len() as f64, self.mean());
        self.values
            .iter()
            .map(|v| (v - mean) * (v - mean))
            .sum::<f64>()
            / (n - 1.0)
            / n
    }

    /// Asserts that the expectation is `truth` (Student's t-test), and that the test could have
    /// seen an error of `resolution` (relative) with a chance of 90 %.
    pub fn assert_mean(&self, truth: f64, resolution: f64, what: &str) {
        let dof = self.values.len() as f64 - 1.0;
        let sigma = self.variance_of_mean().sqrt().max(1e-6 * truth.abs());
        let limit = t_quantile(1.0 - alpha() / 2.0, dof);
        let t = (self.mean() - truth) / sigma;
        let detectable = (limit + 1.3) * sigma / truth.abs();
        assert!(
            t.abs() <= limit,
            "{what}: mean {} instead of {truth} ({:+.3} %, {t:+.1} sigma)",
            self.mean(),
            100.0 * (self.mean() / truth - 1.0)
        );
        assert!(
            detectable <= resolution,
            "{what}: too noisy to see an error below {detectable:.1e}"
        );
    }

    /// Asserts that two estimators have one expectation (Welch's t-test), with the power to see a
    /// relative difference of `resolution`.
    pub fn assert_agrees(&self, other: &Self, resolution: f64, what: &str) {
        let (va, vb) = (self.variance_of_mean(), other.variance_of_mean());
        let (na, nb) = (self.values.len() as f64, other.values.len() as f64);
        let scale = self.mean().abs().max(other.mean().abs());
        let sigma = (va + vb).sqrt().max(1e-6 * scale);
        let dof =
            ((va + vb) * (va + vb) / (va * va / (na - 1.0) + vb * vb / (nb - 1.0))).clamp(1.0, 1e6);
        let dof = if dof.is_nan() { na + nb - 2.0 } else { dof };
        let limit = t_quantile(1.0 - alpha() / 2.0, dof);
        let t = (self.mean() - other.mean()) / sigma;
        let detectable = (limit + 1.3) * sigma / scale;
        assert!(
            t.abs() <= limit,
            "{what}: {} against {} ({t:+.1} sigma)",
            self.mean(),
            other.mean()
        );
        assert!(
            detectable <= resolution,
            "{what}: too noisy to see a difference below {detectable:.1e}"
        );
    }
}

fn t_quantile(p: f64, dof: f64) -> f64 {
    StudentsT::new(0.0, 1.0, dof)
        .expect("a positive number of degrees of freedom")
        .inverse_cdf(p)
}

/// Asserts that counts fit expectations (Pearson's χ² with cells of small expectation pooled). The
/// counts must come from independent numbers. A cell with expectation 0 must be empty.
pub fn assert_chi_square(observed: &[f64], expected: &[f64], what: &str) {
    let mut cells: Vec<(f64, f64)> = Vec::new();
    let mut pool = (0.0, 0.0);
    let mut order: Vec<usize> = (0..expected.len()).collect();
    order.sort_by(|a, b| expected[*a].total_cmp(&expected[*b]));
    for i in order {
        if expected[i] == 0.0 {
            assert!(
                observed[i] == 0.0,
                "{what}: {} samples where the density is 0",
                observed[i]
            );
        } else if pool.1 + expected[i] < 5.0 || pool.1 > 0.0 && pool.1 < 5.0 {
            pool = (pool.0 + observed[i], pool.1 + expected[i]);
        } else {
            cells.push((observed[i], expected[i]));
        }
    }
    if pool.1 > 0.0 {
        cells.push(pool);
    }
    let statistic: f64 = cells.iter().map(|(o, e)| (o - e) * (o - e) / e).sum();
    let dof = cells.len() as f64 - 1.0;
    let p = 1.0
        - ChiSquared::new(dof)
            .expect("at least two cells")
            .cdf(statistic);
    assert!(
        p > alpha(),
        "{what}: chi-square {statistic:.1} with {dof} degrees of freedom, p = {p:.1e}"
    );
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The harness must fail when it should.
    #[test]
    fn wrong_means_are_found() {
        let values = |offset: f64| {
            Replicates::new(
                (0..32)
                    .map(|i| 1.0 + offset + 0.01 * f64::from(i % 5 - 2))
                    .collect(),
            )
        };
        values(0.0).assert_mean(1.0, 0.02, "right");
        for wrong in [0.02, -0.02] {
            assert!(
                std::panic::catch_unwind(|| values(wrong).assert_mean(1.0, 0.05, "wrong")).is_err()
            );
            assert!(
                std::panic::catch_unwind(|| values(wrong).assert_agrees(
                    &values(0.0),
                    0.05,
                    "wrong"
                ))
                .is_err()
            );
        }
        assert!(std::panic::catch_unwind(|| values(0.0).assert_mean(1.0, 1e-4, "blind")).is_err());
    }

    #[test]
    fn wrong_counts_are_found() {
        assert_chi_square(
            &[100.0, 110.0, 95.0, 2.0],
            &[103.0, 103.0, 99.0, 2.0],
            "right",
        );
        assert!(
            std::panic::catch_unwind(|| assert_chi_square(
                &[100.0, 200.0],
                &[150.0, 150.0],
                "wrong"
            ))
            .is_err()
        );
        assert!(
            std::panic::catch_unwind(|| assert_chi_square(&[9.0, 1.0], &[10.0, 0.0], "wrong"))
                .is_err()
        );
    }
}
