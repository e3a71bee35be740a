//! Advice as text and as JSON.

use std::fmt::Write as _;

use lightbox_core::forecast::{Forecast, Goal, Span};
use serde_json::{Value, json};

use super::{Adviser, Trial};
use crate::panels::format::seconds;

/// For people.
pub(super) fn text(
    adviser: &Adviser,
    best: &Trial,
    command: &str,
    outcome: Option<(u64, f64, f64)>,
) -> String {
    let mut text = String::new();
    let width = adviser
        .stages
        .iter()
        .map(|s| s.name.len())
        .max()
        .unwrap_or(0);
    for stage in &adviser.stages {
        let tried: Vec<String> = stage
            .tried
            .iter()
            .map(|(v, w)| format!("{v} {w}"))
            .collect();
        // Writing to a string cannot fail.
        let _ = writeln!(
            text,
            "{:width$}  {} ({})",
            stage.name,
            stage.chosen,
            tried.join("; ")
        );
    }
    let f = &best.forecast;
    let noise = f.noise.map_or_else(String::new, |n| {
        format!(
            ", error {:.3} % ({:.3} to {:.3})",
            100.0 * n.value,
            100.0 * n.low,
            100.0 * n.high
        )
    });
    let _ = writeln!(
        text,
        "foretold: {:.0} spp in {} ({} to {}){noise}\n{command}",
        f.samples.value.ceil(),
        seconds(f.seconds.value),
        seconds(f.seconds.low),
        seconds(f.seconds.high)
    );
    if let Some((samples, time, error)) = outcome {
        let verdict = if holds(f, adviser.goal, time, error) {
            "as foretold"
        } else {
            "not as foretold"
        };
        let _ = writeln!(
            text,
            "took: {samples} spp in {}, error {:.3} %: {verdict}",
            seconds(time),
            100.0 * error
        );
    }
    text
}

/// Whether what was not given lies in its band.
fn holds(forecast: &Forecast, goal: Goal, seconds: f64, error: f64) -> bool {
    match goal {
        Goal::Seconds(_) => forecast.noise.is_some_and(|n| n.holds(error)),
        _ => forecast.seconds.holds(seconds),
    }
}

/// For programs.
pub(super) fn json(
    adviser: &Adviser,
    best: &Trial,
    command: &str,
    outcome: Option<(u64, f64, f64)>,
) -> Value {
    let stages: Vec<Value> = adviser
        .stages
        .iter()
        .map(|s| json!({"setting": s.name, "chosen": s.chosen, "tried": s.tried}))
        .collect();
    let span = |s: Span| json!([s.value, s.low, s.high]);
    let f = &best.forecast;
    json!({
        "scene": adviser.scene.path().to_string_lossy(),
        "stages": stages,
        "spp": span(f.samples), "seconds": span(f.seconds), "error": f.noise.map(span),
        "command": command,
        "outcome": outcome.map(|(samples, seconds, error)| json!({
            "spp": samples, "seconds": seconds, "error": error,
            "as_foretold": holds(f, adviser.goal, seconds, error),
        })),
    })
}
