//! Error curves on logarithmic axes. The pointer finds the nearest kept picture.

use egui::accesskit::Role;
use egui::{Align2, Color32, Ui, WidgetInfo};
use egui_plot::{FilledArea, Line, LineStyle, PlotPoint, PlotPoints, PlotUi, Text};
use lightbox_core::forecast::Forecast;

use super::curves::{Axis, Curves, NOISE};
use crate::panels::decades::{self, dots};
use crate::panels::format::{count, percent, rate, seconds};
use crate::session::{History, Moment, Point};

/// Draws the curves into the space that is left, and a line about the moment under the pointer or
/// the newest. Returns the moment under the pointer; `last` is what that was before.
pub fn show(
    ui: &mut Ui,
    history: &History,
    forecast: Option<Forecast>,
    axis: Axis,
    last: Option<Moment>,
) -> Option<Moment> {
    let line = ui.spacing().interact_size.y + ui.spacing().item_spacing.y;
    let height = (ui.available_height() - line).max(60.0);
    let curves = Curves::new(history, forecast, axis);
    let plot = decades::plot("error chart", height, move |x| axis.text(x));
    let weak = ui.visuals().weak_text_color();
    let plot = plot.show(ui, |plot| curves.draw(plot, weak, last));
    plot.response
        .widget_info(|| WidgetInfo::labeled(Role::Image, true, "Error curves"));
    let pointer = plot.response.hover_pos();
    let nearest = pointer.and_then(|pointer| {
        let far = |at: &[f64; 2]| {
            let at = plot.transform.position_from_point(&PlotPoint::from(*at));
            at.distance_sq(pointer)
        };
        let places = curves.places().map(|(place, at)| (place, far(&at)));
        places.min_by(|a, b| a.1.total_cmp(&b.1)).map(|(p, _)| p)
    });
    let moment = nearest.map(|(moment, _)| moment);
    if moment != last {
        ui.ctx().request_repaint(); // Its ring is drawn next time.
    }
    let text = match (nearest, curves.newest) {
        (Some((_, point)), _) => words(&point),
        (None, Some(point)) => format!("now: {}", words(&point)),
        (None, None) => "The curve begins at two samples per pixel.".into(),
    };
    ui.add(egui::Label::new(text).truncate().selectable(false));
    moment
}

/// A moment in one line.
fn words(point: &Point) -> String {
    let mut text = format!(
        "{} spp, {}, {}rays",
        count(point.samples),
        seconds(point.seconds),
        rate(point.rays as f64)
    );
    for (name, value) in [
        ("noise", point.noise.map(|n| n.value)),
        ("error", point.error),
    ] {
        if let Some(value) = value {
            text += &format!(", {name} {}", percent(value));
        }
    }
    text
}

impl Curves {
    fn draw(&self, plot: &mut PlotUi<'_>, weak: Color32, moment: Option<Moment>) {
        let [left, right, bottom, top] = self.bounds;
        plot.set_plot_bounds_x(left..=right);
        plot.set_plot_bounds_y(bottom..=top);
        if let Some([x, y]) = self.now {
            let ends = [left, right].map(|at| [at, y - 0.5 * (at - x)]);
            let guide = Line::new("1/√N", PlotPoints::from(ends.to_vec()))
                .color(weak)
                .width(1.0)
                .style(LineStyle::dashed_dense())
                .allow_hover(false);
            plot.line(guide);
        }
        for curve in &self.curves {
            if !curve.band.is_empty() {
                let column = |k: usize| curve.band.iter().map(|p| p[k]).collect::<Vec<f64>>();
                let band = FilledArea::new("", &column(0), &column(1), &column(2))
                    .id((curve.run, "band"))
                    .fill_color(curve.color.gamma_multiply(0.25))
                    .allow_hover(false);
                plot.add(band);
            }
            let line = Line::new(&curve.name, PlotPoints::from(curve.points.clone()))
                .id((curve.run, &curve.name))
                .color(curve.color)
                .width(curve.width)
                .style(curve.style)
                .allow_hover(false);
            plot.line(line);
            let at: Vec<[f64; 2]> = curve.pictures.iter().map(|(_, at)| *at).collect();
            plot.points(
                dots(&curve.name, (curve.run, &curve.name, "kept"), at)
                    .color(curve.color)
                    .radius(1.0 + curve.width),
            );
        }
        if let Some(at) = self.now {
            plot.points(dots("", "now", vec![at]).color(NOISE).radius(4.5));
            let text = Text::new(
                "",
                PlotPoint::from([at[0] + 0.02 * (right - left), at[1]]),
                "now",
            );
            plot.text(text.anchor(Align2::LEFT_CENTER).color(weak));
        }
        if let (Some(now), Some([x, y])) = (self.now, self.end) {
            let at = [x.value, y.value];
            let way = [now, at];
            let across = [[x.low, y.value], [x.high, y.value]];
            let upright = [[x.value, y.low], [x.value, y.high]];
            for (name, ends, style) in [
                ("forecast", way, LineStyle::dotted_dense()),
                ("", across, LineStyle::Solid),
                ("", upright, LineStyle::Solid),
            ] {
                let line = Line::new(name, PlotPoints::from(ends.to_vec()))
                    .id(("forecast", ends.map(|e| e.map(f64::to_bits))))
                    .color(NOISE.gamma_multiply(0.7))
                    .width(1.5)
                    .style(style)
                    .allow_hover(false);
                plot.line(line);
            }
        }
        let chosen = self
            .places()
            .filter(|((m, _), _)| Some(*m) == moment)
            .map(|(_, at)| at);
        plot.points(
            dots("", "moment", chosen.collect())
                .color(weak)
                .filled(false)
                .radius(7.0),
        );
    }
}
