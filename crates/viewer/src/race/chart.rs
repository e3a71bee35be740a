//! chart.svg: relative error against seconds, both logarithmic.

use plotters::element::DashedPathElement;
use plotters::prelude::*;

use super::Race;
use crate::model::scene_name;

const SIZE: (u32, u32) = (960, 600);

/// Colours that differ for all eyes (Okabe & Ito 2008); curves beyond are dashed.
const COLORS: [RGBColor; 8] = [
    RGBColor(0, 114, 178),
    RGBColor(213, 94, 0),
    RGBColor(0, 158, 115),
    RGBColor(204, 121, 167),
    RGBColor(230, 159, 0),
    RGBColor(86, 180, 233),
    RGBColor(0, 0, 0),
    RGBColor(150, 140, 20),
];

/// Draws the chart. The error is one line.
pub fn svg(race: &Race) -> Result<String, String> {
    let mut text = String::new();
    draw(race, SVGBackend::with_string(&mut text, SIZE))
        .map_err(|e| format!("the chart cannot be drawn ({e})"))?;
    Ok(text)
}

/// 1, 2 and 5 times a power of ten as a number; for others there is no room.
fn round(value: f64) -> String {
    let text = format!("{value:.0e}");
    if !text.starts_with(['1', '2', '5']) {
        return String::new();
    }
    text.parse().map_or(text, |value: f64| value.to_string())
}

fn draw(race: &Race, backend: SVGBackend<'_>) -> Result<(), Box<dyn std::error::Error>> {
    let root = backend.into_drawing_area();
    root.fill(&WHITE)?;
    // Seconds, error, least and most: relative errors, the roots of what is measured.
    let curves: Vec<Vec<[f64; 4]>> = race
        .curves
        .iter()
        .map(|curve| {
            let positive = curve.points.iter().filter(|p| p.iter().all(|x| *x > 0.0));
            positive
                .map(|[t, mean, least, most]| [*t, mean.sqrt(), least.sqrt(), most.sqrt()])
                .collect()
        })
        .collect();
    let range = |keys: &[usize]| {
        let values = curves
            .iter()
            .flatten()
            .flat_map(|p| keys.iter().map(|k| p[*k]));
        values.fold((f64::INFINITY, 0.0f64), |(lo, hi), v| {
            (lo.min(v), hi.max(v))
        })
    };
    let ((t0, t1), (e0, e1)) = (range(&[0]), range(&[2, 3]));
    let title = format!(
        "{}, {}×{} px",
        scene_name(race.scene.path()),
        race.settings.width,
        race.settings.height
    );
    if !(t0 < t1 && e0 <= e1) {
        root.draw(&Text::new(
            format!("{title}: nothing measured"),
            (20, 20),
            ("sans-serif", 18),
        ))?;
        return Ok(root.present()?);
    }
    let mut chart = ChartBuilder::on(&root)
        .caption(title, ("sans-serif", 20))
        .margin(12)
        .x_label_area_size(44)
        .y_label_area_size(64)
        .build_cartesian_2d(
            (t0 * 0.9..t1 * 1.1).log_scale(),
            (e0 * 0.8..e1 * 1.25).log_scale(),
        )?;
    chart
        .configure_mesh()
        .x_desc("seconds of tracing")
        .y_desc("relative error")
        .x_label_formatter(&|seconds| round(*seconds))
        .y_label_formatter(&|error| match round(100.0 * error) {
            number if number.is_empty() => number,
            number => number + " %",
        })
        .light_line_style(BLACK.mix(0.05))
        .bold_line_style(BLACK.mix(0.15))
        .draw()?;
    // From the best start, as independent samples would go on.
    let starts = curves.iter().filter_map(|c| c.first());
    if let Some(first) = starts.min_by(|a, b| a[1].total_cmp(&b[1])) {
        let end = first[1] * (first[0] / t1).sqrt();
        chart
            .draw_series(DashedLineSeries::new(
                [(first[0], first[1]), (t1, end)],
                6,
                4,
                BLACK.mix(0.5).into(),
            ))?
            .label("1/√N")
            .legend(|(x, y)| PathElement::new([(x, y), (x + 18, y)], BLACK.mix(0.5)));
    }
    for (i, curve) in curves.iter().enumerate() {
        let color = COLORS[i % COLORS.len()];
        let band = curve.iter().map(|p| (p[0], p[3]));
        let band: Vec<_> = band
            .chain(curve.iter().rev().map(|p| (p[0], p[2])))
            .collect();
        chart.draw_series([Polygon::new(band, color.mix(0.15))])?;
        let (line, style) = (curve.iter().map(|p| (p[0], p[1])), color.stroke_width(2));
        let key = |(x, y)| [(x, y), (x + 18, y)];
        // Beyond the colours there are, in dashes.
        if i < COLORS.len() {
            chart
                .draw_series(LineSeries::new(line, style))?
                .label(race.labels[i].as_str())
                .legend(move |at| PathElement::new(key(at), style));
        } else {
            chart
                .draw_series(DashedLineSeries::new(line, 7, 4, style))?
                .label(race.labels[i].as_str())
                .legend(move |at| DashedPathElement::new(key(at), 7, 4, style));
        }
        let front = curve
            .iter()
            .zip(&race.curves[i].front)
            .filter(|(_, front)| **front);
        chart.draw_series(front.map(|(p, _)| Circle::new((p[0], p[1]), 4, color.filled())))?;
    }
    chart
        .configure_series_labels()
        .position(SeriesLabelPosition::LowerLeft)
        .background_style(WHITE.mix(0.85))
        .border_style(BLACK.mix(0.3))
        .draw()?;
    Ok(root.present()?)
}
