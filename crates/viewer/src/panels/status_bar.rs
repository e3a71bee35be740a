//! The line at the bottom: what is going on, how far, how fast, how good.

use egui::{Align, Layout, ProgressBar, Ui};

use super::format::{clock, count, eta, percent, rate};
use crate::keys::{self, Action};
use crate::session::{Activity, Budget, Status};

/// Room of a line between figures, points.
const SEPARATOR: f32 = 6.0;

/// Pause, progress and figures; the picture rests while methods race.
pub fn status_bar_ui(ui: &mut Ui, status: &Status, is_racing: bool, actions: &mut Vec<Action>) {
    // From the right, so that a narrow window leaves out figures and not the way to help.
    ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
        let tip = format!(
            "All keys and gestures ({})",
            keys::text(ui.ctx(), &Action::Help)
        );
        if ui
            .button("?")
            .on_hover_text(tip)
            .accessible_name("Keys")
            .clicked()
        {
            actions.push(Action::Help);
        }
        let tip = format!(
            "Where methods fail, and what lightbox does there ({})",
            keys::text(ui.ctx(), &Action::Lab)
        );
        if ui.button("Lab").on_hover_text(tip).clicked() {
            actions.push(Action::Lab);
        }
        let tip = format!(
            "Error against time ({})",
            keys::text(ui.ctx(), &Action::Chart)
        );
        if ui.button("Chart").on_hover_text(tip).clicked() {
            actions.push(Action::Chart);
        }
        let tip = format!(
            "Methods against each other ({})",
            keys::text(ui.ctx(), &Action::Race)
        );
        if ui.button("Race").on_hover_text(tip).clicked() {
            actions.push(Action::Race);
        }
        let tip = format!(
            "What the scene needs, what is left out, and where the time goes ({})",
            keys::text(ui.ctx(), &Action::Plan)
        );
        if ui.button("Plan").on_hover_text(tip).clicked() {
            actions.push(Action::Plan);
        }
        ui.with_layout(Layout::left_to_right(Align::Center), |ui| {
            ui.shrink_clip_rect(ui.max_rect());
            pause(ui, status.activity, is_racing, actions);
            progress(ui, status);
            figures(ui, status, actions);
        });
    });
}

fn pause(ui: &mut Ui, activity: Activity, is_racing: bool, actions: &mut Vec<Action>) {
    let text = if activity == Activity::Paused && !is_racing {
        "Resume"
    } else {
        "Pause"
    };
    let can = !is_racing && matches!(activity, Activity::Rendering | Activity::Paused);
    // Wide enough for either word: what follows must not jump.
    let button = egui::Button::new(text).min_size(egui::vec2(64.0, 0.0));
    if ui
        .add_enabled(can, button)
        .on_hover_text("Samples are kept. (Space)")
        .on_disabled_hover_text(if is_racing {
            "The picture rests while methods race."
        } else {
            "The picture is done."
        })
        .clicked()
    {
        actions.push(Action::Pause);
    }
    let state = match activity {
        Activity::Empty => "",
        Activity::Rendering => "RENDERING",
        Activity::Paused if is_racing => "RACING",
        Activity::Paused => "PAUSED",
        Activity::Done => "DONE",
    };
    ui.add_sized(
        [84.0, ui.spacing().interact_size.y],
        egui::Label::new(egui::RichText::new(state).strong()),
    );
}

fn progress(ui: &mut Ui, status: &Status) {
    ui.add(
        ProgressBar::new(status.share as f32)
            .desired_width(100.0)
            .desired_height(8.0),
    )
    .accessible_name("Progress");
}

/// A text and what it means.
type Figure = (String, String);

/// As many as there is room for, whole ones: what matters most comes first.
fn figures(ui: &mut Ui, status: &Status, actions: &mut Vec<Action>) {
    let invalid = invalid(status).map(|figure| (figure, Some(Action::Invalid)));
    let plain = |figure| (figure, None);
    let figures = [plain(samples(status)), plain(noise(status))].into_iter();
    let figures = figures.chain(invalid);
    let figures: Vec<_> = figures
        .chain(others(status).into_iter().map(plain))
        .collect();
    for ((text, tip), action) in figures {
        let color = match action {
            Some(_) => ui.visuals().error_fg_color,
            None => ui.visuals().text_color(),
        };
        let text = egui::RichText::new(text).color(color);
        let text = egui::WidgetText::from(text).into_galley(
            ui,
            Some(egui::TextWrapMode::Extend),
            f32::INFINITY,
            egui::TextStyle::Body,
        );
        if SEPARATOR + text.size().x + 2.0 * ui.spacing().item_spacing.x > ui.available_width() {
            return;
        }
        ui.add(egui::Separator::default().spacing(SEPARATOR));
        let Some(action) = action else {
            ui.add(egui::Label::new(text).selectable(false))
                .on_hover_text(tip);
            continue;
        };
        let button = ui.add(egui::Button::new(text).frame(false));
        if button.on_hover_text(tip).clicked() {
            actions.push(action);
        }
    }
}

fn samples(status: &Status) -> Figure {
    let wanted = match status.budget {
        Budget::Samples => format!(" / {}", count(status.desc.render.samples.max(1))),
        _ => String::new(),
    };
    (
        format!("{}{wanted} spp", count(status.samples)),
        "Samples per pixel: taken / wanted.".into(),
    )
}

fn noise(status: &Status) -> Figure {
    let mut noise = status.noise.map_or_else(|| "-".into(), percent);
    if let Budget::Noise(wanted) = status.budget {
        noise += &format!(" / {}", percent(wanted));
    }
    let tip = "Estimated relative error of the picture, from two independent halves of its samples: noise, not bias. \
               What no path has found yet, or what a low depth leaves out, is not in it.";
    (format!("noise {noise}"), tip.into())
}

fn invalid(status: &Status) -> Option<Figure> {
    let tip = "Samples that were not numbers. They are left out of the picture. A click shows where, and goes to the first.";
    let text = format!("{} invalid", count(status.invalid));
    (status.invalid > 0).then(|| (text, tip.into()))
}

fn others(status: &Status) -> Vec<Figure> {
    let left = match status.activity {
        Activity::Done => String::new(),
        _ => format!("  {} left", eta(status.eta())),
    };
    let wanted = match status.budget {
        Budget::Seconds(seconds) => format!(" / {}", clock(seconds)),
        _ => String::new(),
    };
    let mut figures = vec![(
        format!("{}{wanted}{left}", clock(status.seconds)),
        "Time spent tracing, and time left at the speed so far.".into(),
    )];
    if let Some(error) = status.true_error {
        figures.push((
            format!("error {}", percent(error)),
            "Relative error of the picture against the reference: the square root of relMSE."
                .into(),
        ));
    }
    if status.seconds > 0.0 {
        figures.push((
            format!("{}ray/s", rate(status.rays as f64 / status.seconds)),
            format!("Rays per second of tracing, on {} threads.", status.threads),
        ));
    }
    let lost = status
        .lost
        .map_or_else(|| "-".into(), |lost| percent(lost.share));
    let tip = "Share of all light that the depth leaves out, from a few paths that are followed to their ends. Roulette loses nothing.";
    figures.push((format!("lost {lost}"), tip.into()));
    let size = &status.desc.render;
    figures.push((
        format!("{} × {} px", size.width, size.height),
        "Pixels of the picture.".into(),
    ));
    figures
}
