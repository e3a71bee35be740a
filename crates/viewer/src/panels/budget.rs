//! One control for when the picture is done: by samples, seconds or error. What the other two come
//! to is foretold, and at the end held against the forecast.

use egui::{Label, Response, RichText, SliderClamping, Ui};
use lightbox_core::forecast::Span;

use super::format::{count, percent, percent_within, seconds, seconds_within};
use super::widgets::{KEEPS, badge, headed, section, slider};
use crate::model::Model;
use crate::session::{Activity, Budget, Status};

/// Most samples the slider offers; more can be typed.
const SAMPLES: std::ops::RangeInclusive<u64> = 1..=65_536;

/// Seconds the slider offers; others can be typed.
const SECONDS: std::ops::RangeInclusive<f64> = 0.5..=3600.0;

/// Errors the slider offers, per cent; others can be typed.
const PERCENT: std::ops::RangeInclusive<f64> = 0.1..=50.0;

/// What a double-click on the sliders of seconds and of error comes to.
const USUAL_SECONDS: f64 = 60.0;
const USUAL_PERCENT: f64 = 1.0;

/// Least budget of seconds or of error: zero would never or always be met.
const LEAST: f64 = 1e-6;

/// Samples, seconds and error: one is set, two follow.
pub fn budget_ui(ui: &mut Ui, model: &mut Model, status: &Status) {
    section(ui, "Budget", true, |ui| {
        samples(ui, model, status);
        time(ui, model, status);
        error(ui, model, status);
    });
}

fn samples(ui: &mut Ui, model: &mut Model, status: &Status) {
    let tip = format!("Done at so many samples per pixel. {KEEPS}");
    let forecast = status.forecast.map(|f| f.samples);
    if model.budget != Budget::Samples {
        let line = Line {
            name: "Samples",
            tip: &tip,
            forecast,
            promise: status.promise.map(|f| f.samples),
            outcome: Some(status.samples as f64),
            text: |n| count(round(n)),
            within: |n, half| format!("{} ± {}", count(round(n)), count(round(half).max(1))),
            verb: "took",
        };
        if line.ui(ui, status) {
            model.budget = Budget::Samples;
            // Goes on to where it would have gone.
            if let Some(forecast) = forecast {
                model.desc.render.samples = round(forecast.value).max(1);
            }
        }
        return;
    }
    let (samples, usual) = (&mut model.desc.render.samples, model.file.render.samples);
    set(ui, "Samples", &tip, |ui| {
        slider(ui, samples, usual, SAMPLES, |s| {
            s.logarithmic(true).clamping(SliderClamping::Never)
        })
    });
    // Typed numbers are not clamped by the slider.
    *samples = (*samples).max(1);
}

fn time(ui: &mut Ui, model: &mut Model, status: &Status) {
    let tip =
        format!("Done after so many seconds of tracing, to the nearest sample per pixel. {KEEPS}");
    if let Budget::Seconds(wanted) = &mut model.budget {
        set(ui, "Seconds", &tip, |ui| {
            slider(ui, wanted, USUAL_SECONDS, SECONDS, |s| {
                let times = s.logarithmic(true).suffix(" s");
                times.max_decimals(1).clamping(SliderClamping::Never)
            })
        });
        *wanted = wanted.max(LEAST);
        return;
    }
    let forecast = status.forecast.map(|f| f.seconds);
    let line = Line {
        name: "Seconds",
        tip: &tip,
        forecast,
        promise: status.promise.map(|f| f.seconds),
        outcome: Some(status.seconds),
        text: seconds,
        within: seconds_within,
        verb: "took",
    };
    if line.ui(ui, status) {
        let expected = forecast.map_or(status.seconds, |f| f.value);
        model.budget = Budget::Seconds(two_digits(expected.max(*SECONDS.start())));
    }
}

fn error(ui: &mut Ui, model: &mut Model, status: &Status) {
    let tip = format!(
        "Done when the estimated relative error (noise, not bias) is as low as this, from 16 samples per pixel on. {KEEPS}"
    );
    if let Budget::Noise(wanted) = &mut model.budget {
        let mut shown = *wanted * 100.0;
        let response = set(ui, "Error", &tip, |ui| {
            slider(ui, &mut shown, USUAL_PERCENT, PERCENT, |s| {
                let errors = s.logarithmic(true).suffix(" %");
                errors.max_decimals(2).clamping(SliderClamping::Never)
            })
        });
        if response.changed() {
            *wanted = (shown / 100.0).max(LEAST);
        }
        return;
    }
    let forecast = status.forecast.and_then(|f| f.noise);
    let line = Line {
        name: "Error",
        tip: &tip,
        forecast,
        promise: status.promise.and_then(|f| f.noise),
        outcome: status.noise,
        text: percent,
        within: percent_within,
        verb: "got",
    };
    if line.ui(ui, status) {
        let expected = forecast.map(|f| f.value).or(status.noise).unwrap_or(0.01);
        model.budget = Budget::Noise(two_digits(expected.max(LEAST)));
    }
}

/// The line of the figure that is set.
fn set(ui: &mut Ui, name: &str, tip: &str, add: impl FnOnce(&mut Ui) -> Response) -> Response {
    let head = |ui: &mut Ui| {
        radio(ui, true, name, tip);
    };
    headed(ui, head, add)
        .on_hover_text(tip)
        .accessible_name(name)
}

fn radio(ui: &mut Ui, is_set: bool, name: &str, tip: &str) -> bool {
    let radio = ui.radio(is_set, name).on_hover_text(tip);
    badge(ui, tip);
    radio.clicked()
}

/// The line of a figure that follows.
struct Line<'a> {
    name: &'a str,
    tip: &'a str,
    forecast: Option<Span>,
    promise: Option<Span>,
    outcome: Option<f64>,
    text: fn(f64) -> String,
    within: fn(f64, f64) -> String,
    /// What an outcome did.
    verb: &'a str,
}

impl Line<'_> {
    /// Whether the user wants to set it instead.
    fn ui(&self, ui: &mut Ui, status: &Status) -> bool {
        let mut is_wanted = false;
        let head = |ui: &mut Ui| is_wanted = radio(ui, false, self.name, self.tip);
        let is_done = status.activity == Activity::Done;
        headed(ui, head, |ui| {
            let (text, is_off) = self.words(is_done);
            let mut text = RichText::new(text);
            if is_off {
                text = text.color(ui.visuals().warn_fg_color);
            }
            let tip = if is_done {
                "How it ended, and the first forecast with the band in which nine outcomes of ten should be."
            } else {
                "Foretold from the curve so far, with the band in which nine outcomes of ten should be."
            };
            ui.add(Label::new(text).truncate().selectable(false))
                .on_hover_text(tip);
        });
        is_wanted
    }

    /// What is foretold or has come of it, and whether that is outside the band.
    fn words(&self, is_done: bool) -> (String, bool) {
        let foretold = |span: Span| {
            let half = (span.high - span.value).max(span.value - span.low);
            (self.within)(span.value, half)
        };
        match (is_done, self.outcome, self.promise) {
            (true, Some(outcome), Some(promise)) => {
                let text = format!(
                    "said {}, {} {}",
                    foretold(promise),
                    self.verb,
                    (self.text)(outcome)
                );
                (text, !promise.holds(outcome))
            }
            (true, Some(outcome), None) => ((self.text)(outcome), false),
            _ => (self.forecast.map_or_else(|| "-".into(), foretold), false),
        }
    }
}

/// A whole number of samples, however far away.
fn round(x: f64) -> u64 {
    x.round() as u64
}

/// Rounded to two digits: what a person would have typed.
fn two_digits(x: f64) -> f64 {
    format!("{x:.1e}").parse().unwrap_or(x)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn line(outcome: f64) -> Line<'static> {
        let span = |value: f64, half: f64| {
            Some(Span {
                value,
                low: value - half / 2.0,
                high: value + half,
            })
        };
        Line {
            name: "Seconds",
            tip: "",
            forecast: span(13.0, 1.0),
            promise: span(12.0, 2.0),
            outcome: Some(outcome),
            text: seconds,
            within: seconds_within,
            verb: "took",
        }
    }

    #[test]
    fn forecasts_are_scored_at_the_end() {
        assert_eq!(line(5.0).words(false), ("13.0 s ± 1.0".into(), false));
        let (text, is_off) = line(12.9).words(true);
        assert_eq!((&*text, is_off), ("said 12.0 s ± 2.0, took 12.9 s", false));
        assert!(line(14.1).words(true).1 && line(10.9).words(true).1);
        let without = Line {
            promise: None,
            ..line(12.9)
        };
        assert_eq!(without.words(true), ("12.9 s".into(), false));
    }

    #[test]
    fn budgets_begin_at_round_numbers() {
        assert_eq!([12.34, 0.01387, 9.96].map(two_digits), [12.0, 0.014, 10.0]);
    }
}
