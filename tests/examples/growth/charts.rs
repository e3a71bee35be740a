//! The charts of docs/growth.md.

use std::error::Error;
use std::ops::Range;
use std::path::Path;

use plotters::coord::Shift;
use plotters::prelude::*;

/// Colours that differ for all eyes (Okabe & Ito 2008).
const COLORS: [RGBColor; 2] = [RGBColor(0, 114, 178), RGBColor(213, 94, 0)];

/// Width and height of a panel, pixels.
const PANEL: (u32, u32) = (400, 300);

/// What is foretold is to lie so close to what is measured.
pub const AIM: f64 = 0.15;

type Area<'a> = DrawingArea<SVGBackend<'a>, Shift>;
type Drawn = Result<(), Box<dyn Error>>;

/// A number that grows, and what it costs by number of threads: at, measured, foretold.
pub struct Panel {
    pub x: &'static str,
    pub y: &'static str,
    pub series: [Vec<[f64; 3]>; 2],
}

fn range(values: impl Iterator<Item = f64>) -> Range<f64> {
    let (low, high) = values.fold((f64::INFINITY, 0.0f64), |(low, high), v| {
        (low.min(v), high.max(v))
    });
    low / 1.5..high * 1.5
}

/// 1, 2 and 5 times a power of ten; for others there is no room.
fn label(value: &f64) -> String {
    let text = format!("{value:.0e}");
    let rounded: f64 = text.parse().unwrap_or(0.0);
    if !text.starts_with(['1', '2', '5']) || (value / rounded - 1.0).abs() > 1e-6 {
        return String::new();
    }
    match rounded {
        v if v >= 1e6 => format!("{} M", v / 1e6),
        v if v >= 1e3 => format!("{} k", v / 1e3),
        v => v.to_string(),
    }
}

/// Curves of measured points and of what the model says there.
fn curves(area: &Area<'_>, panel: &Panel) -> Drawn {
    let all = || panel.series.iter().flatten();
    let mut chart = ChartBuilder::on(area)
        .margin(10)
        .x_label_area_size(40)
        .y_label_area_size(56)
        .build_cartesian_2d(
            range(all().map(|p| p[0])).log_scale(),
            range(all().flat_map(|p| [p[1], p[2]])).log_scale(),
        )?;
    chart
        .configure_mesh()
        .x_desc(panel.x)
        .y_desc(panel.y)
        .x_labels(8)
        .y_labels(8)
        .x_label_formatter(&label)
        .y_label_formatter(&label)
        .light_line_style(BLACK.mix(0.04))
        .bold_line_style(BLACK.mix(0.15))
        .draw()?;
    for ((points, color), name) in panel
        .series
        .iter()
        .zip(COLORS)
        .zip(["1 thread", "2 threads"])
    {
        let line = points.iter().map(|p| (p[0], p[2]));
        chart
            .draw_series(LineSeries::new(line, color.stroke_width(2)))?
            .label(name)
            .legend(move |(x, y)| PathElement::new([(x, y), (x + 18, y)], color.stroke_width(2)));
        let dots = points.iter();
        chart.draw_series(dots.map(|p| Circle::new((p[0], p[1]), 4, color.filled())))?;
    }
    chart
        .configure_series_labels()
        .position(SeriesLabelPosition::UpperLeft)
        .background_style(WHITE.mix(0.85))
        .border_style(BLACK.mix(0.3))
        .draw()?;
    Ok(())
}

/// Draws panels, three in a row.
pub fn growth(path: &Path, panels: &[Panel]) -> Result<(), String> {
    let rows = panels.len().div_ceil(3);
    let draw = || -> Drawn {
        let size = (3 * PANEL.0, rows as u32 * PANEL.1);
        let root = SVGBackend::new(path, size).into_drawing_area();
        root.fill(&WHITE)?;
        for (area, panel) in root.split_evenly((rows, 3)).iter().zip(panels) {
            curves(area, panel)?;
        }
        Ok(root.present()?)
    };
    draw().map_err(|e| format!("{}: {e}", path.display()))
}

/// Draws foretold over measured against measured, for each kind of cost: its name and the points.
pub fn unseen(path: &Path, kinds: &[(&str, Vec<[f64; 2]>)]) -> Result<(), String> {
    let draw = || -> Drawn {
        let size = (kinds.len() as u32 * PANEL.0, PANEL.1);
        let root = SVGBackend::new(path, size).into_drawing_area();
        root.fill(&WHITE)?;
        let areas = root.split_evenly((1, kinds.len()));
        for (area, (name, points)) in areas.iter().zip(kinds) {
            let x = range(points.iter().map(|p| p[0]));
            let mut chart = ChartBuilder::on(area)
                .margin(10)
                .x_label_area_size(40)
                .y_label_area_size(56)
                .build_cartesian_2d(x.clone().log_scale(), 0.7..1.3)?;
            chart
                .configure_mesh()
                .x_desc(*name)
                .x_labels(8)
                .y_desc("foretold / measured")
                .x_label_formatter(&label)
                .y_label_formatter(&|ratio| format!("{ratio:.1}"))
                .light_line_style(BLACK.mix(0.04))
                .bold_line_style(BLACK.mix(0.15))
                .draw()?;
            let aim = [(x.start, 1.0 - AIM), (x.end, 1.0 + AIM)];
            chart.draw_series([Rectangle::new(aim, COLORS[0].mix(0.1).filled())])?;
            let dots = points.iter().map(|[measured, foretold]| {
                Circle::new((*measured, foretold / measured), 4, COLORS[0].filled())
            });
            chart.draw_series(dots)?;
        }
        Ok(root.present()?)
    };
    draw().map_err(|e| format!("{}: {e}", path.display()))
}
