//! What a probe measures, and the bound it has to keep.

use std::fmt;

/// One measured number.
#[derive(Clone, Debug, PartialEq)]
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
#[derive(Clone, Copy, Debug, PartialEq)]
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
        match self {
            Self::Exactly(value) => write!(f, "= {value}"),
            Self::AtMost(limit) => write!(f, "≤ {limit}"),
            Self::AtLeast(limit) => write!(f, "≥ {limit}"),
            Self::Within { truth, tolerance } => write!(f, "{truth} ± {tolerance:.2e}"),
        }
    }
}

impl Figure {
    /// Whether lightbox keeps the bound.
    pub fn holds(&self) -> bool {
        self.bound.allows(self.lightbox)
    }

    /// Whether the naive method breaks it; `None` if it was not tried.
    pub fn naive_fails(&self) -> Option<bool> {
        self.naive.map(|x| !self.bound.allows(x))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

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
