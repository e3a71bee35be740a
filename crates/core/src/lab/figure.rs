//! What a probe measures, and the bound it has to keep.

use std::fmt;

use serde::Serialize;

/// One measured number.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Figure {
    /// What was measured, with its unit, e.g. `wrong hits of 2001`.
    pub what: &'static str,
    /// What the naive method gives.
    pub naive: Option<f64>,
    /// What lightbox gives.
    pub lightbox: f64,
    /// What it has to be.
    pub bound: Bound,
}

/// What a figure has to be. NaN is never within bounds.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Bound {
    /// This number and no other.
    Exactly(f64),
    /// This or less.
    AtMost(f64),
    /// This or more.
    AtLeast(f64),
    /// No further than `tolerance` from `truth`.
    Within {
        /// The analytic or independent answer.
        truth: f64,
        /// Absolute; for statistical figures the critical distance at the family's significance.
        tolerance: f64,
    },
}

impl Bound {
    /// Whether a number keeps the bound.
    pub fn allows(self, x: f64) -> bool {
        match self {
            Self::Exactly(value) => x == value,
            Self::AtMost(limit) => x <= limit,
            Self::AtLeast(limit) => x >= limit,
            Self::Within { truth, tolerance } => (x - truth).abs() <= tolerance,
        }
    }
}

impl fmt::Display for Bound {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Self::Exactly(value) => write!(f, "= {}", number(value)),
            Self::AtMost(limit) => write!(f, "≤ {}", number(limit)),
            Self::AtLeast(limit) => write!(f, "≥ {}", number(limit)),
            Self::Within { truth, tolerance } => {
                write!(f, "{} ± {}", number(truth), number(tolerance))
            }
        }
    }
}

impl Figure {
    /// A count that has to be 0.
    pub(super) fn none(what: &'static str, naive: Option<usize>, found: usize) -> Self {
        Self {
            what,
            naive: naive.map(|n| n as f64),
            lightbox: found as f64,
            bound: Bound::Exactly(0.0),
        }
    }

    /// A number that must not exceed `limit`.
    pub(super) fn at_most(what: &'static str, naive: Option<f64>, x: f64, limit: f64) -> Self {
        Self {
            what,
            naive,
            lightbox: x,
            bound: Bound::AtMost(limit),
        }
    }

    /// Whether lightbox keeps the bound.
    pub fn holds(&self) -> bool {
        self.bound.allows(self.lightbox)
    }

    /// Whether the naive method breaks it; `None` if it was not tried.
    pub fn naive_fails(&self) -> Option<bool> {
        self.naive.map(|x| !self.bound.allows(x))
    }
}

/// A number for people: whole ones in full, others to four digits.
pub fn number(x: f64) -> String {
    let size = x.abs();
    if x == 0.0 || !x.is_finite() || (x.fract() == 0.0 && size < 1e9) {
        format!("{}", x + 0.0)
    } else if (1e-3..1e6).contains(&size) {
        // As many decimals as make four digits.
        let decimals = (3 - size.log10().floor() as i32).max(0) as usize;
        let text = format!("{x:.decimals$}");
        if text.contains('.') {
            text.trim_end_matches('0').trim_end_matches('.').to_owned()
        } else {
            text
        }
    } else {
        format!("{x:.3e}")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_short() {
        for (x, text) in [
            (0.0, "0"),
            (-0.0, "0"),
            (2001.0, "2001"),
            (1e8, "100000000"),
            (0.5, "0.5"),
            (1.0 / 3.0, "0.3333"),
            (-73.341_41, "-73.34"),
            (12_345.6, "12346"),
            (0.1 + 0.2, "0.3"),
            (2e-5, "2.000e-5"),
            (1.5e20, "1.500e20"),
            (f64::NAN, "NaN"),
            (f64::INFINITY, "inf"),
        ] {
            assert_eq!(number(x), text);
        }
    }

    #[test]
    fn bounds_are_closed_and_refuse_nan() {
        let within = Bound::Within {
            truth: 2.0,
            tolerance: 0.5,
        };
        for (bound, inside, outside) in [
            (Bound::Exactly(0.0), 0.0, f64::MIN_POSITIVE),
            (Bound::AtMost(1.0), 1.0, 1.0f64.next_up()),
            (Bound::AtLeast(1.0), 1.0, 1.0f64.next_down()),
            (within, 2.5, 2.500_001),
        ] {
            assert!(bound.allows(inside), "{bound} {inside}");
            assert!(!bound.allows(outside), "{bound} {outside}");
            assert!(!bound.allows(f64::NAN), "{bound}");
        }
    }
}
