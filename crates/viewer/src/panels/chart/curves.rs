//! What the error chart shows, in decades.

use std::fmt;

use egui::Color32;
use egui_plot::LineStyle;
use lightbox_core::film::BAND_FROM;
use lightbox_core::forecast::{Forecast, Span};

use super::changes::changes;
use crate::panels::decades::bounds;
use crate::panels::format::{count, si};
use crate::session::{History, Moment, Point, Run};

/// Colour of the present noise.
pub const NOISE: Color32 = Color32::from_rgb(80, 160, 240);

const ERROR: Color32 = Color32::from_rgb(240, 140, 50);

/// What the error is drawn against.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Axis {
    /// Time spent tracing.
    #[default]
    Seconds,
    /// Rays cast.
    Rays,
    /// Samples per pixel.
    Samples,
}

impl Axis {
    pub const ALL: [Self; 3] = [Self::Seconds, Self::Rays, Self::Samples];

    pub fn tip(self) -> &'static str {
        match self {
            Self::Seconds => "Error against seconds spent tracing: what counts in the end.",
            Self::Rays => "Error against rays cast: the same on every machine.",
            Self::Samples => "Error against samples per pixel.",
        }
    }

    fn of(self, point: &Point) -> f64 {
        match self {
            Self::Seconds => point.seconds,
            Self::Rays => point.rays as f64,
            Self::Samples => point.samples as f64,
        }
    }

    /// A round figure on it.
    pub fn text(self, value: f64) -> String {
        match self {
            Self::Seconds => format!("{value} s"),
            Self::Rays => si(value),
            Self::Samples => count(value as u64),
        }
    }
}

impl fmt::Display for Axis {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(match self {
            Self::Seconds => "seconds",
            Self::Rays => "rays",
            Self::Samples => "samples",
        })
    }
}

/// One line of the chart.
pub struct Curve {
    pub run: u64,
    pub name: String,
    pub color: Color32,
    pub width: f32,
    pub style: LineStyle,
    pub points: Vec<[f64; 2]>,
    /// Along, low and high, where the noise has a band.
    pub band: Vec<[f64; 3]>,
    /// Kept pictures on it.
    pub pictures: Vec<(Point, [f64; 2])>,
}

/// All that is drawn, in decades.
pub struct Curves {
    pub curves: Vec<Curve>,
    pub newest: Option<Point>,
    /// Where the guide and "now" are.
    pub now: Option<[f64; 2]>,
    /// Where the present curve should end, and the bands of that: along and up.
    pub end: Option<[Span; 2]>,
    /// Left, right, bottom, top.
    pub bounds: [f64; 4],
}

impl Curves {
    pub fn new(history: &History, forecast: Option<Forecast>, axis: Axis) -> Self {
        let mut curves = Vec::new();
        for run in history.runs_in_order() {
            let is_present = history.present.as_ref().is_some_and(|p| p.id == run.id);
            let differs = || changes(run, history.present.as_ref());
            curves.extend([
                curve(
                    run,
                    axis,
                    |p| p.noise.map(|n| n.value),
                    is_present,
                    "noise",
                    differs,
                ),
                curve(run, axis, |p| p.error, is_present, "error", differs),
            ]);
        }
        curves.retain(|c| !c.points.is_empty());
        let newest = history
            .present
            .as_ref()
            .and_then(|run| run.points.last().copied());
        let now = newest.and_then(|p| place(axis, &p, p.noise.map(|n| n.value)));
        let end = newest.and_then(|p| ending(&forecast?, &p, axis));
        let band = end.map(|[x, y]| [[x.low, y.low], [x.high, y.high]]);
        let points = curves.iter().flat_map(|c| &c.points);
        let bounds = bounds(points.chain(band.iter().flatten()));
        Self {
            curves,
            newest,
            now,
            end,
            bounds,
        }
    }

    /// Kept pictures and where they are drawn.
    pub fn places(&self) -> impl Iterator<Item = ((Moment, Point), [f64; 2])> {
        self.curves.iter().flat_map(|curve| {
            curve.pictures.iter().map(|(point, at)| {
                let moment = Moment {
                    run: curve.run,
                    samples: point.samples,
                };
                ((moment, *point), *at)
            })
        })
    }
}

/// A run's noise or error as a curve: strong if it is the present one, faint if not.
fn curve(
    run: &Run,
    axis: Axis,
    value: impl Fn(&Point) -> Option<f64>,
    is_present: bool,
    what: &str,
    differs: impl Fn() -> String,
) -> Curve {
    let is_error = what == "error";
    let color = match (is_present, is_error) {
        (true, false) => NOISE,
        (true, true) => ERROR,
        // Hues a golden angle apart.
        (false, _) => {
            let hue = (run.id as f32 * 0.618_034).fract();
            Color32::from(egui::ecolor::Hsva::new(hue, 0.55, 0.75, 1.0)).gamma_multiply(0.6)
        }
    };
    let name = if is_present {
        what.to_owned()
    } else {
        format!("{}{}", differs(), if is_error { ", error" } else { "" })
    };
    let at = |point: &Point| place(axis, point, value(point));
    Curve {
        run: run.id,
        name,
        color,
        width: if is_present { 2.0 } else { 1.2 },
        style: if is_error && !is_present {
            LineStyle::dotted_dense()
        } else {
            LineStyle::Solid
        },
        points: run.points.iter().filter_map(at).collect(),
        band: if is_present && !is_error {
            run.points.iter().filter_map(|p| banded(axis, p)).collect()
        } else {
            Vec::new()
        },
        pictures: run
            .pictures
            .iter()
            .filter_map(|(point, _)| Some((*point, at(point)?)))
            .collect(),
    }
}

/// Where the band of a moment's noise is drawn, in decades.
fn banded(axis: Axis, point: &Point) -> Option<[f64; 3]> {
    let noise = point.noise.filter(|_| point.samples >= BAND_FROM)?;
    let [low, high] = [noise.low, noise.high].map(Some);
    let (low, high) = (place(axis, point, low)?, place(axis, point, high)?);
    Some([low[0], low[1], high[1]])
}

/// Where a moment is drawn, in decades; nowhere if it is not on logarithmic axes.
fn place(axis: Axis, point: &Point, value: Option<f64>) -> Option<[f64; 2]> {
    let place = [axis.of(point), value?].map(f64::log10);
    place.iter().all(|x| x.is_finite()).then_some(place)
}

/// Where a picture should end, in decades along and up; nowhere once it is there.
fn ending(forecast: &Forecast, now: &Point, axis: Axis) -> Option<[Span; 2]> {
    let noise = forecast.noise?;
    let along = match axis {
        Axis::Seconds => forecast.seconds,
        Axis::Samples => forecast.samples,
        Axis::Rays => {
            let per_sample = now.rays as f64 / now.samples as f64;
            map(forecast.samples, |n| n * per_sample)
        }
    };
    let is_ahead = forecast.samples.value > now.samples as f64;
    let place = [along, noise].map(|span| map(span, f64::log10));
    let is_drawn = place
        .iter()
        .all(|s| s.low.is_finite() && s.high.is_finite());
    (is_ahead && is_drawn).then_some(place)
}

fn map(span: Span, f: impl Fn(f64) -> f64) -> Span {
    Span {
        value: f(span.value),
        low: f(span.low),
        high: f(span.high),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nothing_without_a_logarithm_is_drawn() {
        let point = Point {
            samples: 64,
            seconds: 0.0,
            rays: 100,
            noise: Some(Span {
                value: 0.1,
                low: 0.05,
                high: 0.2,
            }),
            error: Some(0.0),
        };
        let noise = point.noise.map(|n| n.value);
        assert_eq!(place(Axis::Seconds, &point, noise), None);
        assert_eq!(place(Axis::Rays, &point, point.error), None);
        assert_eq!(place(Axis::Rays, &point, None), None);
        assert_eq!(place(Axis::Rays, &point, noise), Some([2.0, -1.0]));
        assert_eq!(banded(Axis::Seconds, &point), None);
        let [along, low, high] = banded(Axis::Rays, &point).unwrap();
        assert!(along == 2.0 && low < -1.0 && high > -1.0);
        // With fewer samples the band does not hold what it says.
        let early = Point {
            samples: 63,
            ..point
        };
        assert_eq!(banded(Axis::Rays, &early), None);
    }
}
