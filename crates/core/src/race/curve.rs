//! What the runs of a race amount to: curves over all seeds, efficiency, slope, and who is ahead.

use std::fmt;

use serde::Serialize;

use super::{Point, Run};

/// Places at which runs are averaged, evenly spaced in the logarithm of time.
const PLACES: usize = 24;

/// A slope above this is worse than that of independent samples by more than a fit can be off.
const TROUBLE: f64 = -0.9;

/// Power of the samples with which relMSE falls: −1 of independent ones, steeper of Sobol points.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[non_exhaustive]
pub struct Slope {
    /// Mean over seeds.
    pub value: f64,
    /// Standard error of that mean; unknown of one seed.
    pub error: Option<f64>,
    /// Clearly worse than −1: outliers too rare for the time given, or an error that does not
    /// fall at all.
    pub trouble: bool,
}

impl fmt::Display for Slope {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:.2}", self.value)?;
        self.error
            .map_or(Ok(()), |error| write!(f, " ± {error:.2}"))
    }
}

/// A contestant's error against time over all its seeds.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[non_exhaustive]
pub struct Curve {
    /// Seconds, mean relMSE, and the least and the largest of any seed.
    pub points: Vec<[f64; 4]>,
    /// Whether no other contestant had as small an error in as little time, for each point.
    pub front: Vec<bool>,
    /// 1/(relMSE × seconds), at the end.
    pub efficiency: f64,
    /// `None` if there are too few points to fit.
    pub slope: Option<Slope>,
}

/// The curves of all contestants. A run that was interrupted counts as far as it went.
pub fn curves(contestants: &[&[Run]]) -> Vec<Curve> {
    let mut curves: Vec<Curve> = contestants.iter().map(|runs| curve(runs)).collect();
    let ends: Vec<Vec<[f64; 4]>> = curves.iter().map(|c| c.points.clone()).collect();
    for (i, curve) in curves.iter_mut().enumerate() {
        let is_first = |point: &[f64; 4]| {
            let others = ends.iter().enumerate().filter(|(j, _)| *j != i);
            let mut beaten = others.filter_map(|(_, other)| mean_at(other, point[0]));
            beaten.all(|error| point[1] <= error)
        };
        curve.front = curve.points.iter().map(is_first).collect();
    }
    curves
}

fn curve(runs: &[Run]) -> Curve {
    let runs: Vec<&[Point]> = runs
        .iter()
        .map(|run| run.points.as_slice())
        .filter(|points| !points.is_empty())
        .collect();
    let ends: Vec<Point> = runs
        .iter()
        .filter_map(|points| points.last())
        .copied()
        .collect();
    // Where every run has something to tell.
    let first = runs
        .iter()
        .map(|points| points[0].seconds)
        .fold(0.0, f64::max);
    let last = ends.iter().map(|p| p.seconds).fold(f64::INFINITY, f64::min);
    let places = match runs.len() {
        0 => 0,
        _ if first < last => PLACES,
        _ => 1,
    };
    let points = (0..places).map(|i| {
        let share = i as f64 / (PLACES - 1) as f64;
        let seconds = first * (last / first).powf(share);
        let errors: Vec<f64> = runs
            .iter()
            .map(|points| error_at(points, seconds))
            .collect();
        let mean = errors.iter().sum::<f64>() / errors.len() as f64;
        let least = errors.iter().copied().fold(f64::INFINITY, f64::min);
        let most = errors.iter().copied().fold(0.0, f64::max);
        [seconds, mean, least, most]
    });
    let cost: f64 = ends.iter().map(|p| p.rel_mse * p.seconds).sum();
    Curve {
        points: points.collect(),
        front: Vec::new(),
        efficiency: ends.len() as f64 / cost,
        slope: slope(&runs),
    }
}

/// Error of a run at some time, straight between its points on a doubly logarithmic chart.
fn error_at(points: &[Point], seconds: f64) -> f64 {
    let after = points.partition_point(|p| p.seconds < seconds);
    let (a, b) = (
        &points[after.saturating_sub(1)],
        &points[after.min(points.len() - 1)],
    );
    between([a.seconds, a.rel_mse], [b.seconds, b.rel_mse], seconds)
}

/// Mean error of a curve at some time: its end's if it is over, nothing before it begins.
fn mean_at(points: &[[f64; 4]], seconds: f64) -> Option<f64> {
    let after = points.partition_point(|p| p[0] <= seconds);
    let a = points[..after].last()?;
    let b = points.get(after).unwrap_or(a);
    Some(between([a[0], a[1]], [b[0], b[1]], seconds))
}

fn between([x0, y0]: [f64; 2], [x1, y1]: [f64; 2], x: f64) -> f64 {
    if !(x0 < x1 && y0 > 0.0 && y1 > 0.0) {
        return y1;
    }
    y0 * (y1 / y0).powf((x / x0).ln() / (x1 / x0).ln())
}

/// Least squares of log error against log samples, for each run over the later half of its
/// points.
fn slope(runs: &[&[Point]]) -> Option<Slope> {
    let slopes: Vec<f64> = runs
        .iter()
        .filter_map(|points| {
            let later = &points[points.len() / 2..];
            let places: Vec<[f64; 2]> = later
                .iter()
                .filter(|p| p.rel_mse > 0.0)
                .map(|p| [(p.samples as f64).ln(), p.rel_mse.ln()])
                .collect();
            (places.len() >= 3).then(|| fit(&places))
        })
        .collect();
    let n = slopes.len() as f64;
    if slopes.is_empty() {
        return None;
    }
    let value = slopes.iter().sum::<f64>() / n;
    let squares: f64 = slopes.iter().map(|s| (s - value) * (s - value)).sum();
    let error = (n > 1.0).then(|| (squares / (n * (n - 1.0))).sqrt());
    Some(Slope {
        value,
        error,
        trouble: value - 2.0 * error.unwrap_or(0.0) > TROUBLE,
    })
}

fn fit(places: &[[f64; 2]]) -> f64 {
    let n = places.len() as f64;
    let mean = |k: usize| places.iter().map(|p| p[k]).sum::<f64>() / n;
    let (mx, my) = (mean(0), mean(1));
    let products: f64 = places.iter().map(|p| (p[0] - mx) * (p[1] - my)).sum();
    let squares: f64 = places.iter().map(|p| (p[0] - mx) * (p[0] - mx)).sum();
    products / squares
}
