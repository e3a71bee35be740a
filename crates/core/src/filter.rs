//! Pixel filters, applied by importance sampling (Ernst, Stamminger & Greiner 2006): the position
//! of a sample is drawn in proportion to |f|, so that each sample belongs to one pixel and needs
//! no weight.
//!
//! Filters with negative lobes are handled by stratification: samples from positive and from
//! negative regions are averaged apart, and the picture is `positive·mean₊ − negative·mean₋`
//! with the exact areas of f. A constant scene thus stays constant at any sample count, and
//! nothing is ever divided by a sum of weights that may vanish.

use std::fmt;
use std::str::FromStr;

use serde::{Deserialize, Serialize};

/// The shape of a pixel filter; separable, f(x)·f(y).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum FilterKind {
    /// Constant: averages the square.
    Box,
    /// Linear ramp down to the radius.
    Tent,
    /// Gaussian with σ a third of the radius, lowered to reach 0 at the radius.
    Gaussian,
    /// Cubic with B = C = ⅓ (Mitchell & Netravali 1988); negative lobes.
    Mitchell,
    /// Four-term window (Harris 1978); close to a Gaussian, smoother at the ends.
    BlackmanHarris,
    /// Sinc with three zero crossings within the radius under a sinc window; negative lobes.
    Lanczos,
}

/// A pixel filter: a shape and how far it reaches. Written `gaussian` or `gaussian:1.5`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "String", into = "String")]
pub struct Filter {
    /// The shape.
    pub kind: FilterKind,
    /// Half of the width, pixels, within [`Filter::RADII`].
    pub radius: f32,
}

impl FilterKind {
    /// Every shape, in the order of menus.
    pub const ALL: [Self; 6] = [
        Self::Box,
        Self::Tent,
        Self::Gaussian,
        Self::Mitchell,
        Self::BlackmanHarris,
        Self::Lanczos,
    ];

    /// The name in files, on the command line and in the UI.
    pub fn name(self) -> &'static str {
        match self {
            Self::Box => "box",
            Self::Tent => "tent",
            Self::Gaussian => "gaussian",
            Self::Mitchell => "mitchell",
            Self::BlackmanHarris => "blackman-harris",
            Self::Lanczos => "lanczos",
        }
    }

    /// The usual radius, pixels.
    pub fn default_radius(self) -> f32 {
        match self {
            Self::Box => 0.5,
            Self::Tent => 1.0,
            Self::Gaussian | Self::BlackmanHarris => 1.5,
            Self::Mitchell => 2.0,
            Self::Lanczos => 3.0,
        }
    }

    /// Value at `x` radii from the centre, up to a constant factor; 0 beyond 1.
    pub(crate) fn eval(self, x: f64) -> f64 {
        let x = x.abs();
        if x > 1.0 {
            return 0.0;
        }
        match self {
            Self::Box => 1.0,
            Self::Tent => 1.0 - x,
            Self::Gaussian => libm::exp(-4.5 * x * x) - libm::exp(-4.5),
            Self::Mitchell => {
                let (b, c, x) = (1.0 / 3.0, 1.0 / 3.0, 2.0 * x);
                if x > 1.0 {
                    (((-b - 6.0 * c) * x + (6.0 * b + 30.0 * c)) * x + (-12.0 * b - 48.0 * c)) * x
                        + (8.0 * b + 24.0 * c)
                } else {
                    ((12.0 - 9.0 * b - 6.0 * c) * x + (-18.0 + 12.0 * b + 6.0 * c)) * x * x
                        + (6.0 - 2.0 * b)
                }
            }
            Self::BlackmanHarris => {
                let a = std::f64::consts::PI * (x + 1.0);
                0.35875 - 0.48829 * libm::cos(a) + 0.14128 * libm::cos(2.0 * a)
                    - 0.01168 * libm::cos(3.0 * a)
            }
            Self::Lanczos => sinc(3.0 * x) * sinc(x),
        }
    }
}

/// sin(πx)/(πx), by its series near 0.
pub(crate) fn sinc(x: f64) -> f64 {
    let a = std::f64::consts::PI * x;
    if a.abs() < 1e-4 {
        1.0 - a * a / 6.0
    } else {
        libm::sin(a) / a
    }
}

impl Filter {
    /// Radii that make sense, pixels: below half a pixel light would fall between pixels.
    pub const RADII: std::ops::RangeInclusive<f32> = 0.5..=8.0;

    /// A shape at its usual radius.
    pub fn new(kind: FilterKind) -> Self {
        Self {
            kind,
            radius: kind.default_radius(),
        }
    }
}

impl Default for Filter {
    fn default() -> Self {
        Self::new(FilterKind::Box)
    }
}

impl fmt::Display for Filter {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.radius == self.kind.default_radius() {
            f.write_str(self.kind.name())
        } else {
            write!(f, "{}:{}", self.kind.name(), self.radius)
        }
    }
}

impl From<Filter> for String {
    fn from(filter: Filter) -> Self {
        filter.to_string()
    }
}

impl TryFrom<String> for Filter {
    type Error = String;
    fn try_from(text: String) -> Result<Self, String> {
        text.parse()
    }
}

impl FromStr for Filter {
    type Err = String;
    fn from_str(text: &str) -> Result<Self, String> {
        let (name, radius) = match text.split_once(':') {
            Some((name, radius)) => (name, Some(radius)),
            None => (text, None),
        };
        let kind = FilterKind::ALL
            .into_iter()
            .find(|k| k.name() == name)
            .ok_or_else(|| {
                let names = FilterKind::ALL.map(FilterKind::name);
                format!(
                    "unknown filter \"{name}\"{}",
                    crate::suggest::among(name, &names)
                )
            })?;
        let radius = match radius {
            None => kind.default_radius(),
            Some(text) => text
                .parse()
                .ok()
                .filter(|r| Self::RADII.contains(r))
                .ok_or_else(|| {
                    let (least, most) = (Self::RADII.start(), Self::RADII.end());
                    format!(
                        "filter radius \"{text}\" is not a number from {least} to {most} pixels"
                    )
                })?,
        };
        Ok(Self { kind, radius })
    }
}

/// Intervals of the tabulated inverse of the cumulative |f|.
const TABLE: usize = 1024;

/// Draws sample positions from a [`Filter`].
#[derive(Clone, Debug)]
pub struct FilterSampler {
    /// Inverse of the cumulative |f| in x, pixels from the centre; linear between entries.
    inverse: Box<[f32; TABLE + 1]>,
    /// Distances from the centre, pixels, at which f changes sign; rising, then +∞.
    sign_changes: [f32; 3],
    filter: Filter,
    /// 1/∫f over one axis, pixels⁻¹.
    height: f64,
    /// ∫f over the regions where f(x)·f(y) > 0 and < 0 (as a positive number), with ∫f = 1.
    areas: [f64; 2],
}

impl FilterSampler {
    /// Tabulates a filter.
    pub fn new(filter: Filter) -> Self {
        // A fine midpoint rule over the whole width; the table then inverts it exactly.
        const STEPS: usize = 1 << 16;
        let radius = f64::from(filter.radius);
        let x_at = |i: usize| (2.0 * i as f64 / STEPS as f64 - 1.0) * radius;
        let mut cumulative = Vec::with_capacity(STEPS + 1);
        let (mut positive, mut negative) = (0.0, 0.0);
        cumulative.push(0.0);
        for i in 0..STEPS {
            let f = filter
                .kind
                .eval((2.0 * (i as f64 + 0.5) / STEPS as f64) - 1.0);
            if f > 0.0 {
                positive += f
            } else {
                negative -= f
            }
            cumulative.push(positive + negative);
        }
        let total = positive + negative;
        let mut inverse = Box::new([0.0; TABLE + 1]);
        let mut i = 0;
        for (k, x) in inverse.iter_mut().enumerate() {
            let target = total * k as f64 / TABLE as f64;
            while i + 1 < STEPS && cumulative[i + 1] < target {
                i += 1;
            }
            let step = cumulative[i + 1] - cumulative[i];
            let fraction = if step > 0.0 {
                (target - cumulative[i]) / step
            } else {
                0.0
            };
            *x = (x_at(i) + fraction.clamp(0.0, 1.0) * 2.0 * radius / STEPS as f64) as f32;
        }
        inverse[0] = -filter.radius;
        inverse[TABLE] = filter.radius;
        let sign_changes = match filter.kind {
            FilterKind::Mitchell => [
                mitchell_zero() * filter.radius,
                f32::INFINITY,
                f32::INFINITY,
            ],
            FilterKind::Lanczos => [
                filter.radius / 3.0,
                filter.radius * 2.0 / 3.0,
                f32::INFINITY,
            ],
            _ => [f32::INFINITY; 3],
        };
        let (a, b) = (
            positive / (positive - negative),
            negative / (positive - negative),
        );
        Self {
            inverse,
            sign_changes,
            filter,
            height: STEPS as f64 / ((positive - negative) * 2.0 * radius),
            areas: [a * a + b * b, 2.0 * a * b],
        }
    }

    /// Number of strata: 2 if the filter has negative lobes, else 1.
    pub fn strata(&self) -> usize {
        if self.sign_changes[0].is_finite() {
            2
        } else {
            1
        }
    }

    /// Weight of each stratum's mean in the picture: the areas of f, the second one negated.
    pub fn weights(&self) -> [f64; 2] {
        [self.areas[0], -self.areas[1]]
    }

    /// Half of the width, pixels.
    pub(crate) fn radius(&self) -> f32 {
        self.filter.radius
    }

    /// What light at some offset from a pixel's centre counts there: f, with ∫f = 1.
    pub(crate) fn weight(&self, offset: [f32; 2]) -> f32 {
        if self.filter == Filter::default() {
            return 1.0; // Within the pixel, which is all that is asked of this one.
        }
        let f =
            offset.map(|x| self.height * self.filter.kind.eval(f64::from(x / self.filter.radius)));
        (f[0] * f[1]) as f32
    }

    /// Offset from the pixel's centre, pixels, and the stratum: 0 where f > 0, 1 where f < 0.
    pub(crate) fn sample(&self, u: [f32; 2]) -> ([f32; 2], usize) {
        let offset = u.map(|u| {
            let scaled = u * TABLE as f32;
            let i = (scaled as usize).min(TABLE - 1);
            let (lo, hi) = (self.inverse[i], self.inverse[i + 1]);
            lo + (scaled - i as f32) * (hi - lo)
        });
        let negative = offset.map(|x| {
            self.sign_changes
                .iter()
                .filter(|change| x.abs() > **change)
                .count()
                & 1
        });
        (offset, negative[0] ^ negative[1])
    }
}

/// Where the Mitchell filter crosses zero, in radii: the root of the outer cubic, by bisection.
fn mitchell_zero() -> f32 {
    let (mut lo, mut hi) = (0.5, 0.9);
    for _ in 0..60 {
        let mid = 0.5 * (lo + hi);
        if FilterKind::Mitchell.eval(mid) > 0.0 {
            lo = mid
        } else {
            hi = mid
        }
    }
    lo as f32
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Samples fall where |f| says: compared with the integral of |f| over 32 intervals, and the
    /// stratum is the sign of f there.
    #[test]
    fn samples_follow_the_filter() {
        for kind in FilterKind::ALL {
            let filter = Filter::new(kind);
            let sampler = FilterSampler::new(filter);
            let n = 1 << 16;
            let mut counts = [0.0; 32];
            let mut expected = [0.0; 32];
            for i in 0..n {
                let ([x, y], stratum) = sampler.sample([(i as f32 + 0.5) / n as f32, 0.5]);
                assert!(
                    y.abs() < 1e-3 * filter.radius && x.abs() <= filter.radius,
                    "{kind:?}"
                );
                let relative = f64::from(x / filter.radius);
                if kind.eval(relative).abs() > 1e-3 {
                    assert_eq!(
                        stratum,
                        usize::from(kind.eval(relative) < 0.0),
                        "{kind:?} at {relative}"
                    );
                }
                counts[(((relative + 1.0) * 16.0) as usize).min(31)] += 1.0 / f64::from(n);
            }
            for i in 0..3200 {
                expected[i / 100] += kind.eval((i as f64 + 0.5) / 1600.0 - 1.0).abs();
            }
            let total: f64 = expected.iter().sum();
            for (count, e) in counts.iter().zip(expected) {
                assert!(
                    (count - e / total).abs() < 5e-4,
                    "{kind:?}: {count} instead of {}",
                    e / total
                );
            }
        }
    }

    /// The areas of the two strata make up an integral of 1, and a filter without negative lobes
    /// has one stratum.
    #[test]
    fn strata_sum_to_one() {
        for kind in FilterKind::ALL {
            let sampler = FilterSampler::new(Filter::new(kind));
            let [positive, negative] = sampler.weights();
            assert!((positive + negative - 1.0).abs() < 1e-12, "{kind:?}");
            let strata = if negative < 0.0 { 2 } else { 1 };
            assert_eq!(sampler.strata(), strata, "{kind:?}");
        }
    }

    #[test]
    fn names_round_trip_and_mistakes_are_answered() {
        for kind in FilterKind::ALL {
            for radius in [kind.default_radius(), 2.5] {
                let filter = Filter { kind, radius };
                assert_eq!(filter.to_string().parse(), Ok(filter));
            }
        }
        assert!(
            "gausian"
                .parse::<Filter>()
                .unwrap_err()
                .contains("did you mean \"gaussian\"?")
        );
        assert!(
            "box:0.1"
                .parse::<Filter>()
                .unwrap_err()
                .contains("0.5 to 8")
        );
        assert!("box:nan".parse::<Filter>().is_err());
    }
}
