//! Charts of a pixel: where its samples lie, how their mean came about, who found the light.

use std::ops::RangeInclusive;

use egui::accesskit::Role;
use egui::{Color32, Grid, RichText, Ui, WidgetInfo};
use egui_plot::{Bar, BarChart, FilledArea, GridMark, HLine, Line, LineStyle, Plot, PlotPoints};
use lightbox_core::film::Pixel;
use lightbox_core::integrator::replay::Strategy;

use super::draw::COLORS;
use super::findings::{Findings, Histogram};
use super::within;
use crate::panels::decades::still;
use crate::panels::format::{counted, percent, short, si};

/// Height of a chart, points.
const HEIGHT: f32 = 110.0;

/// Most steps of an upright axis: labels need room.
const MARKS: f64 = 3.5;

/// Most rows of the table; the rest is in its sum.
const ROWS: usize = 12;

/// How a strategy is called.
fn name(strategy: Strategy) -> &'static str {
    match strategy {
        Strategy::Met => "met",
        Strategy::Aimed => "aimed at",
        Strategy::ByMirror => "by mirror",
    }
}

/// Everything about the samples together.
pub fn show(ui: &mut Ui, findings: &Findings, pixel: &Pixel) {
    if findings.mean == 0.0 {
        ui.add_space(6.0);
        ui.label("No camera path has found light here.");
        return light_paths(ui, pixel);
    }
    heading(ui, "Samples by luminance, W/(m²·sr)");
    histogram(ui, &findings.histogram);
    let black = findings.histogram.black;
    if black > 0 {
        let share = percent(black as f64 / findings.samples as f64);
        ui.weak(format!(
            "{} without light, {share}",
            counted(black as u64, "sample")
        ));
    }
    heading(ui, "Mean luminance by number of samples");
    convergence(ui, findings);
    let error = findings.curve.last().map_or(0.0, |[_, _, error]| *error);
    ui.weak(format!(
        "{} W/(m²·sr), as if samples were independent",
        within(findings.mean, error)
    ));
    heading(ui, "Found by, on paths of so many segments");
    table(ui, findings);
    light_paths(ui, pixel);
}

fn heading(ui: &mut Ui, text: &str) {
    ui.add_space(6.0);
    ui.strong(text);
}

fn plot<'a>(id: &str) -> Plot<'a> {
    still(id, HEIGHT).y_axis_min_width(40.0)
}

/// Labels of an axis along decimal logarithms: at powers of ten only.
fn power(mark: GridMark) -> String {
    if (mark.value - mark.value.round()).abs() < 1e-6 {
        short(10f32.powf(mark.value as f32))
    } else {
        String::new()
    }
}

/// Where labels of an upright axis end: higher up they would stand in the heading.
fn below_end(shown: &RangeInclusive<f64>) -> f64 {
    shown.end() - 0.1 * (shown.end() - shown.start())
}

/// Three or so round numbers on an axis, whatever its span.
fn round_marks((low, high): (f64, f64)) -> Vec<GridMark> {
    let span = high - low;
    let power = 10f64.powf((span / MARKS).log10().floor());
    let steps = [1.0, 2.0, 5.0, 10.0].map(|k| k * power);
    let Some(step_size) = steps.into_iter().find(|step| span / step <= MARKS) else {
        return Vec::new(); // The axis has no span.
    };
    let marks = (low / step_size).ceil() as i64..=(high / step_size).floor() as i64;
    let mark = |i: i64| GridMark {
        value: i as f64 * step_size,
        step_size,
    };
    marks.map(mark).collect()
}

fn histogram(ui: &mut Ui, histogram: &Histogram) {
    let Histogram { ends, counts, .. } = histogram;
    let width = (ends[1] - ends[0]) / counts.len().max(1) as f64;
    let bars = counts.iter().enumerate().filter(|(_, n)| **n > 0);
    let bars = bars.map(|(i, n)| {
        // One sample has a height too.
        let height = (*n as f64).log10() + 0.3;
        let middle = ends[0] + (i as f64 + 0.5) * width;
        Bar::new(middle, height)
            .width(width)
            .fill(COLORS[0])
            .stroke(egui::Stroke::NONE)
    });
    let chart = BarChart::new("samples", bars.collect()).allow_hover(false);
    let most = counts.iter().max().copied().unwrap_or(1) as f64;
    let plot = plot("autopsy histogram")
        .include_y(0.0)
        .include_y(most.log10() + 0.4)
        .x_axis_formatter(|mark, _| power(mark))
        .y_axis_formatter(|mark, shown| {
            let n = 10f64.powf(mark.value - 0.3);
            let is_power = ((mark.value - 0.3) - (mark.value - 0.3).round()).abs() < 1e-6;
            if is_power && n > 0.5 && mark.value < below_end(shown) {
                si(n.round())
            } else {
                String::new()
            }
        })
        .y_grid_spacer(|input| {
            let decades = 0..=input.bounds.1.ceil() as i32;
            let mark = |decade| GridMark {
                value: f64::from(decade) + 0.3,
                step_size: 1.0,
            };
            decades.map(mark).collect()
        });
    let shown = plot.show(ui, |plot| plot.bar_chart(chart));
    let info = || WidgetInfo::labeled(Role::Image, true, "Histogram of samples");
    shown.response.widget_info(info);
}

fn convergence(ui: &mut Ui, findings: &Findings) {
    let xs: Vec<f64> = findings.curve.iter().map(|[n, ..]| n.log10()).collect();
    let column = |f: fn(&[f64; 3]) -> f64| findings.curve.iter().map(f).collect::<Vec<f64>>();
    let band = FilledArea::new(
        "",
        &xs,
        &column(|[_, mean, error]| mean - error),
        &column(|[_, mean, error]| mean + error),
    );
    let means = column(|[_, mean, _]| *mean);
    let points: Vec<[f64; 2]> = xs.iter().zip(means).map(|(x, y)| [*x, y]).collect();
    let plot = plot("autopsy convergence")
        .include_y(0.0)
        .x_axis_formatter(|mark, _| match mark.value {
            v if (v - v.round()).abs() < 1e-6 => si(10f64.powf(v).round()),
            _ => String::new(),
        })
        .y_axis_formatter(|mark, shown| match mark.value {
            value if value < below_end(shown) => short(value as f32),
            _ => String::new(),
        })
        .y_grid_spacer(|input| round_marks(input.bounds));
    let weak = ui.visuals().weak_text_color();
    let shown = plot.show(ui, |plot| {
        plot.add(
            band.fill_color(COLORS[0].gamma_multiply(0.25))
                .allow_hover(false),
        );
        let last = HLine::new("", findings.mean).color(weak).allow_hover(false);
        plot.hline(last.style(LineStyle::dashed_dense()));
        let line = Line::new("mean", PlotPoints::from(points)).color(COLORS[0]);
        plot.line(line.allow_hover(false));
    });
    let info = || WidgetInfo::labeled(Role::Image, true, "Convergence of the pixel");
    shown.response.widget_info(info);
}

/// Shares of light and of variance, by number of segments and by strategy.
fn table(ui: &mut Ui, findings: &Findings) {
    let light: f64 = findings.all().iter().sum();
    let share = |part: f64, whole: f64| if whole > 0.0 { part / whole } else { 0.0 };
    let used = Strategy::ALL.map(|s| findings.rows.iter().any(|row| row.light[s as usize] > 0.0));
    let used = || Strategy::ALL.into_iter().filter(|s| used[*s as usize]);
    let cell = |ui: &mut Ui, share: f64, color: Color32| {
        let text = if share > 0.0 {
            percent(share)
        } else {
            "-".into()
        };
        ui.label(RichText::new(text).color(color));
    };
    let grid = Grid::new("autopsy found by")
        .striped(true)
        .spacing([12.0, 3.0]);
    grid.show(ui, |ui| {
        ui.weak("segments");
        for kind in ["light", "variance"] {
            for strategy in used() {
                let text = format!("{kind}\n{}", name(strategy));
                ui.label(RichText::new(text).color(COLORS[strategy as usize]))
                    .on_hover_text(tip(strategy));
            }
        }
        ui.end_row();
        let rows = findings.rows.iter().enumerate().take(ROWS);
        for (i, row) in rows.filter(|(_, row)| row.light.iter().any(|x| *x > 0.0)) {
            ui.label((i + 1).to_string());
            for (parts, whole) in [(row.light, light), (row.variance, findings.variance)] {
                for strategy in used() {
                    let part = parts[strategy as usize];
                    cell(ui, share(part, whole), COLORS[strategy as usize]);
                }
            }
            ui.end_row();
        }
    });
    ui.weak(
        "Shares of the pixel's. Variances of parts that go together do not add up to all of it.",
    );
}

fn tip(strategy: Strategy) -> &'static str {
    match strategy {
        Strategy::Met => {
            "The path ran into a lamp, or left for the background; also what probes found by way of mirrors or glass, and what more camera rays \
             see of the outline of a lamp."
        }
        Strategy::Aimed => "A point of a lamp was aimed at from a surface.",
        Strategy::ByMirror => "A lamp was aimed at by way of a mirror sphere.",
    }
}

/// What light paths bring, which has no samples here.
fn light_paths(ui: &mut Ui, pixel: &Pixel) {
    let [part, all] = [pixel.by_light_paths, pixel.mean].map(lightbox_core::color::luminance);
    if part > 0.0 && all > 0.0 {
        ui.label(format!(
            "Light paths from the lamps bring {} of this pixel; they start anywhere, so none of its samples holds it.",
            percent(f64::from(part / all))
        ));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_axis_has_a_few_round_marks_whatever_its_span() {
        for i in -60..60 {
            let high = 10f64.powf(f64::from(i) / 7.0);
            for low in [0.0, -0.3 * high, 0.9 * high] {
                let marks = round_marks((low, high));
                assert!((1..=4).contains(&marks.len()), "{low} {high}: {marks:?}");
                let within =
                    |m: &GridMark| (low - 1e-9 * high..=high * (1.0 + 1e-9)).contains(&m.value);
                assert!(marks.iter().all(within), "{low} {high}: {marks:?}");
            }
        }
        let values: Vec<f64> = round_marks((0.0, 0.05)).iter().map(|m| m.value).collect();
        assert_eq!(values, [0.0, 0.02, 0.04]);
        assert!(round_marks((0.5, 0.5)).is_empty());
    }
}
