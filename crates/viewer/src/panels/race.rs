//! The race: ways to make the present picture against each other.

use egui::accesskit::Role;
use egui::{
    Color32, Context, DragValue, Grid, ProgressBar, RichText, ScrollArea, TextureHandle, Ui,
    WidgetInfo, Window,
};
use egui_plot::{FilledArea, Line, LineStyle, PlotPoints};
use lightbox_core::agreement::{Agreement, TileDifference};
use lightbox_core::color::ToneMap;
use lightbox_core::film::TILE;
use lightbox_core::filter::FilterKind;
use lightbox_core::race::{Curve, Rules};
use lightbox_core::{AccelKind, Filter, Method, SamplerKind};

use super::decades::{self, dots};
use super::format::{clock, percent};
use super::widgets::labelled;
use crate::keys::Action;
use crate::race::{Choice, Contest, Live, Race, Standing, report};
use crate::session::Status;

const BAD: Color32 = Color32::from_rgb(230, 90, 80);

/// The race's window.
pub struct RacePanel {
    /// Whether it is shown.
    pub is_open: bool,
    methods: Vec<Method>,
    /// Beside what the picture has.
    accels: Vec<AccelKind>,
    samplers: Vec<SamplerKind>,
    filters: Vec<FilterKind>,
    rules: Rules,
    live: Option<Live>,
    /// Why it could not begin.
    problem: Option<String>,
    /// The comparison whose map is shown, and the map.
    map: Option<(usize, TextureHandle)>,
}

impl Default for RacePanel {
    fn default() -> Self {
        Self {
            is_open: false,
            methods: Method::ALL.to_vec(),
            accels: Vec::new(),
            samplers: Vec::new(),
            filters: Vec::new(),
            rules: Rules {
                seconds: 2.0,
                seeds: 2,
            },
            live: None,
            problem: None,
            map: None,
        }
    }
}

impl RacePanel {
    /// Whether a race needs the processor.
    pub fn is_running(&self) -> bool {
        self.live.as_ref().is_some_and(Live::is_running)
    }

    /// Whether there is a race whose files could be written.
    pub fn is_over(&self) -> bool {
        let over = |live: &Live| matches!(live.standing().end, Some(Ok(_)));
        self.live.as_ref().is_some_and(over)
    }

    /// Writes its files, in the background.
    pub fn save(&self, ctx: &Context, folder: std::path::PathBuf) {
        if let Some(live) = &self.live {
            let ctx = ctx.clone();
            live.save(folder, move || ctx.request_repaint());
        }
    }

    /// Shows the window while it is open.
    pub fn ui(&mut self, ctx: &Context, status: &Status, actions: &mut Vec<Action>) {
        let mut is_open = self.is_open;
        Window::new("Race")
            .open(&mut is_open)
            .default_size([560.0, 560.0])
            .min_size([420.0, 300.0])
            .show(ctx, |ui| {
                let is_running = self.is_running();
                ui.add_enabled_ui(!is_running, |ui| self.choices(ui, status));
                self.controls(ui, status, is_running, actions);
                ScrollArea::vertical()
                    .auto_shrink(false)
                    .show(ui, |ui| self.results(ui));
            });
        self.is_open = is_open;
    }

    fn choices(&mut self, ui: &mut Ui, status: &Status) {
        let own = &status.desc.render;
        let tip = "Every combination of what is ticked races.";
        labelled(ui, "Method", tip, |ui| {
            ticks(ui, &mut self.methods, Method::ALL, None, Method::name);
        });
        labelled(ui, "Accelerator", tip, |ui| {
            ticks(
                ui,
                &mut self.accels,
                AccelKind::ALL,
                Some(own.accel),
                AccelKind::name,
            );
        });
        labelled(ui, "Sampler", tip, |ui| {
            ticks(
                ui,
                &mut self.samplers,
                SamplerKind::ALL,
                Some(own.sampler),
                SamplerKind::name,
            );
        });
        labelled(ui, "Filter", tip, |ui| {
            ui.horizontal_wrapped(|ui| {
                ticks(
                    ui,
                    &mut self.filters,
                    &FilterKind::ALL,
                    Some(own.filter.kind),
                    FilterKind::name,
                );
            });
        });
    }

    /// What is to race: what is ticked, and of each kind at least what the picture has.
    fn choice(&self, status: &Status) -> Choice {
        let own = &status.desc.render;
        Choice {
            methods: self.methods.clone(),
            accels: with(&self.accels, own.accel),
            samplers: with(&self.samplers, own.sampler),
            filters: with(&self.filters, own.filter.kind)
                .into_iter()
                .map(|kind| {
                    if kind == own.filter.kind {
                        own.filter
                    } else {
                        Filter::new(kind)
                    }
                })
                .collect(),
        }
    }

    fn controls(
        &mut self,
        ui: &mut Ui,
        status: &Status,
        is_running: bool,
        actions: &mut Vec<Action>,
    ) {
        let choice = self.choice(status);
        let entries = choice.entries().len();
        ui.horizontal(|ui| {
            ui.add_enabled_ui(!is_running, |ui| {
                let seconds = DragValue::new(&mut self.rules.seconds)
                    .range(0.05..=3600.0)
                    .speed(0.1)
                    .suffix(" s each");
                ui.add(seconds)
                    .on_hover_text("Seconds of tracing for each contestant and seed.")
                    .accessible_name("Seconds each");
                let seeds = DragValue::new(&mut self.rules.seeds)
                    .range(1..=100)
                    .speed(0.05)
                    .suffix(" seeds");
                ui.add(seeds)
                    .on_hover_text("Runs of each contestant, with different random numbers.")
                    .accessible_name("Seeds");
            });
            if is_running {
                self.running(ui);
                return;
            }
            let start = egui::Button::new("Start");
            let can = entries > 0 && status.scene.is_some();
            if ui
                .add_enabled(can, start)
                .on_hover_text("The picture rests meanwhile.")
                .on_disabled_hover_text("Tick a method first.")
                .clicked()
            {
                self.start(ui.ctx(), status, &choice);
            }
            let reference = if fitting(status, &choice).is_some() {
                1.0
            } else {
                2.0
            };
            let time = self.rules.seconds * self.rules.seeds as f64 * entries as f64 * reference;
            ui.weak(format!("{entries} contestants, {}", clock(time.ceil())))
                .on_hover_text(
                    "Without a reference in the error chart, half of it goes to rendering one.",
                );
            if self.is_over() && ui.button("Save…").clicked() {
                actions.push(Action::SaveRace);
            }
        });
        if let Some(problem) = &self.problem {
            ui.colored_label(BAD, problem);
        }
    }

    fn running(&self, ui: &mut Ui) {
        let Some(live) = &self.live else { return };
        if ui
            .button("Stop")
            .on_hover_text("Keeps what there is.")
            .clicked()
        {
            live.stop();
        }
        let standing = live.standing();
        let what = if standing.is_preparing {
            "reference"
        } else {
            "race"
        };
        let left = live.seconds_left(standing.share);
        ui.add(ProgressBar::new(standing.share as f32).desired_width(120.0))
            .accessible_name("Race progress");
        ui.weak(format!("{what}, {} left", clock(left)));
    }

    fn start(&mut self, ctx: &Context, status: &Status, choice: &Choice) {
        let Some(scene) = status.scene.clone() else {
            return;
        };
        let desc = &status.desc;
        let wake = ctx.clone();
        let live = Contest::new(scene, desc.camera, desc.render, choice).and_then(|contest| {
            let reference = fitting(status, choice);
            Live::start(contest, self.rules, reference, status.threads, move || {
                wake.request_repaint();
            })
        });
        self.map = None;
        (self.live, self.problem) = match live {
            Ok(live) => (Some(live), None),
            Err(problem) => (None, Some(problem)),
        };
    }

    fn results(&mut self, ui: &mut Ui) {
        let Some(live) = &self.live else {
            ui.weak(
                "Each gets the same seconds, in turns. The chart shows whose error is smallest, \
                 the table what it cost.",
            );
            return;
        };
        let standing = live.standing();
        chart(ui, &standing);
        table(ui, &standing);
        match &standing.end {
            Some(Ok(race)) => agreements(ui, race, &mut self.map),
            Some(Err(problem)) => {
                ui.colored_label(BAD, problem);
            }
            None => {}
        }
        match &standing.saved {
            Some(Ok(line)) => ui.label(line),
            Some(Err(problem)) => ui.colored_label(BAD, problem),
            None => return,
        };
    }
}

/// Boxes to tick; what the picture has races in any case.
fn ticks<T: Copy + PartialEq>(
    ui: &mut Ui,
    chosen: &mut Vec<T>,
    all: &[T],
    own: Option<T>,
    name: impl Fn(T) -> &'static str,
) {
    for value in all {
        let is_own = own == Some(*value);
        let mut is_chosen = is_own || chosen.contains(value);
        let tick = egui::Checkbox::new(&mut is_chosen, name(*value));
        let response = ui.add_enabled(!is_own, tick);
        let response = response.on_disabled_hover_text("What the picture has.");
        if response.changed() {
            chosen.retain(|v| v != value);
            if is_chosen {
                chosen.push(*value);
            }
        }
    }
}

fn with<T: Copy + PartialEq>(chosen: &[T], own: T) -> Vec<T> {
    let others = chosen.iter().copied().filter(|value| *value != own);
    std::iter::once(own).chain(others).collect()
}

/// The error chart's reference, if all contestants can be measured against it.
fn fitting(
    status: &Status,
    choice: &Choice,
) -> Option<(String, std::sync::Arc<lightbox_core::Image>)> {
    let reference = status.reference.as_ref()?;
    let settings = &status.desc.render;
    let fits = reference.size() == [settings.width, settings.height] && choice.filters.len() == 1;
    fits.then(|| (reference.name.clone(), reference.image.clone()))
}

/// A contestant's colour: hues a golden angle apart.
fn color(i: usize) -> Color32 {
    let hue = (0.58 + i as f32 * 0.618_034).fract();
    egui::ecolor::Hsva::new(hue, 0.65, 0.9, 1.0).into()
}

/// Seconds, error, least and most in decades; what has no logarithm is left out.
fn places(curve: &Curve) -> Vec<[f64; 4]> {
    let place = |p: &[f64; 4]| {
        [
            p[0].log10(),
            p[1].log10() / 2.0,
            p[2].log10() / 2.0,
            p[3].log10() / 2.0,
        ]
    };
    let is_drawn = |p: &[f64; 4]| p.iter().all(|x| x.is_finite());
    curve.points.iter().map(place).filter(is_drawn).collect()
}

fn chart(ui: &mut Ui, standing: &Standing) {
    let curves: Vec<Vec<[f64; 4]>> = standing.curves.iter().map(places).collect();
    let corners: Vec<[f64; 2]> = curves
        .iter()
        .flatten()
        .flat_map(|p| [[p[0], p[2]], [p[0], p[3]]])
        .collect();
    let [left, right, bottom, top] = decades::bounds(corners.iter());
    let weak = ui.visuals().weak_text_color();
    let plot = decades::plot("race chart", 230.0, |x| format!("{x} s")).show(ui, |plot| {
        plot.set_plot_bounds_x(left..=right);
        plot.set_plot_bounds_y(bottom..=top);
        let best = curves.iter().filter_map(|c| c.first());
        if let Some(p) = best.min_by(|a, b| a[1].total_cmp(&b[1])) {
            let ends = [p[0], right].map(|x| [x, p[1] - 0.5 * (x - p[0])]);
            let guide = Line::new("1/√N", PlotPoints::from(ends.to_vec()));
            let style = LineStyle::dashed_dense();
            plot.line(guide.color(weak).width(1.0).style(style).allow_hover(false));
        }
        for (i, (curve, label)) in curves.iter().zip(&standing.labels).enumerate() {
            let column = |k: usize| curve.iter().map(|p| p[k]).collect::<Vec<f64>>();
            let band = FilledArea::new("", &column(0), &column(2), &column(3)).id((i, "band"));
            plot.add(
                band.fill_color(color(i).gamma_multiply(0.2))
                    .allow_hover(false),
            );
            let line: Vec<[f64; 2]> = curve.iter().map(|p| [p[0], p[1]]).collect();
            let line = Line::new(label, PlotPoints::from(line)).color(color(i));
            plot.line(line.width(2.0).allow_hover(false));
            let front = curve
                .iter()
                .zip(&standing.curves[i].front)
                .filter(|(_, f)| **f);
            let front = front.map(|(p, _)| [p[0], p[1]]).collect();
            plot.points(dots(label, (i, "front"), front).color(color(i)).radius(3.0));
        }
    });
    plot.response
        .widget_info(|| WidgetInfo::labeled(Role::Image, true, "Race curves"));
    plot.response.on_hover_text(
        "Relative error against seconds of tracing. The band spans the seeds; a dot marks where \
         nobody else was as good in as little time.",
    );
}

fn table(ui: &mut Ui, standing: &Standing) {
    Grid::new("race table").num_columns(5).striped(true).spacing([16.0, 4.0]).show(ui, |ui| {
        let tips = ["", "At the end, against the reference.", "", "1/(relMSE × seconds): twice as much is the same picture in half the time.", "Power of the samples with which relMSE falls: −1 for independent ones, steeper for Sobol points."];
        for (title, tip) in ["contestant", "error", "seconds", "efficiency", "slope"].iter().zip(tips) {
            let label = ui.strong(*title);
            if !tip.is_empty() {
                label.on_hover_text(tip);
            }
        }
        ui.end_row();
        for (i, (curve, label)) in standing.curves.iter().zip(&standing.labels).enumerate() {
            let Some(end) = curve.points.last() else { continue };
            ui.label(RichText::new(label).color(color(i)));
            ui.label(percent(end[1].sqrt()));
            ui.label(format!("{:.2}", end[0]));
            ui.label(format!("{:.3e}", curve.efficiency));
            match &curve.slope {
                Some(slope) if slope.trouble => ui
                    .colored_label(BAD, format!("{:.2} trouble", slope.value))
                    .on_hover_text("The error does not fall as it should: rare bright samples, or a bias."),
                Some(slope) => ui.label(slope.to_string()),
                None => ui.label("–"),
            };
            ui.end_row();
        }
    });
}

/// Whether methods make the same picture; the map of the comparison that is clicked.
fn agreements(ui: &mut Ui, race: &Race, map: &mut Option<(usize, TextureHandle)>) {
    let mut clicked = None;
    for (k, (i, j, agreement)) in race.agreements.iter().enumerate() {
        let text = agreement.headline(&race.labels[*i], &race.labels[*j]);
        let text = if agreement.holds() {
            RichText::new(text)
        } else {
            RichText::new(text).color(BAD)
        };
        let is_shown = map.as_ref().is_some_and(|(shown, _)| *shown == k);
        let tip = "Shows where: red where the first is brighter than noise explains, blue where \
                   it is darker.";
        if ui
            .selectable_label(is_shown, text)
            .on_hover_text(tip)
            .clicked()
        {
            clicked = Some(k);
            *map = (!is_shown).then(|| {
                let image = tiles(agreement);
                let nearest = egui::TextureOptions::NEAREST;
                let texture = ui.ctx().load_texture("agreement", image, nearest);
                (k, texture)
            });
        }
    }
    if let Some((shown, texture)) = map {
        // Tiles at the right and lower border are cut off where the picture ends.
        let size = egui::vec2(race.settings.width as f32, race.settings.height as f32);
        let seen =
            egui::Rect::from_min_size(egui::Pos2::ZERO, size / TILE as f32 / texture.size_vec2());
        let image = egui::Image::from_texture((texture.id(), size * (240.0 / size.y))).uv(seen);
        let image = ui.add(image.alt_text("Agreement map"));
        if clicked == Some(*shown) {
            image.scroll_to_me(None);
        }
    }
}

/// A map with one texel for each tile.
fn tiles(agreement: &Agreement) -> egui::ColorImage {
    let place =
        |tile: &TileDifference| [tile.rect.x / TILE, tile.rect.y / TILE].map(|n| n as usize);
    let size = agreement.tiles.iter().map(place).fold([0; 2], |size, at| {
        [size[0].max(at[0] + 1), size[1].max(at[1] + 1)]
    });
    let mut image = egui::ColorImage::filled(size, Color32::WHITE);
    for tile in &agreement.tiles {
        let [x, y] = place(tile);
        let [r, g, b] = ToneMap::default().apply(report::color(tile.t));
        image[(x, y)] = Color32::from_rgb(r, g, b);
    }
    image
}
