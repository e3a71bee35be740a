//! Lines over the picture: what failed, what was saved, what is missing.

use std::path::Path;

use egui::{Align2, Area, Color32, Frame, Id, Rect, Ui};
use lightbox_core::Scene;
use lightbox_core::scene::Phase;

use super::format::counted;
use crate::keys::Action;
use crate::model::{Model, scene_name};
use crate::session::{Notice, Status};
use crate::unsaved::Answer;

/// How long good news stay, seconds. Errors stay until they are dismissed.
const GOOD_NEWS: f64 = 6.0;

/// How long a file may take to open without a word, seconds.
const SOON: f64 = 0.3;

/// Most lines at a time; the oldest go first.
const MOST: usize = 4;

/// Room for the buttons of a line, points.
const BUTTONS: f32 = 250.0;

/// Least room for a text beside its buttons, points; else they stand under it.
const LEAST_TEXT: f32 = 160.0;

/// Answers to what becomes of edits before another file is opened: text, meaning, tip.
const LOSES: [(&str, Answer, &str); 3] = [
    (
        "Save first…",
        Answer::Save,
        "As a .toml file, then opens it.",
    ),
    ("Open anyway", Answer::Drop, "The edits are lost."),
    ("Stay", Answer::Stay, "Back to the edits."),
];

/// The same where none would be lost.
const KEPT: [(&str, Answer, &str); 2] = [
    ("Open", Answer::Drop, "Every edit is in a file."),
    ("Stay", Answer::Stay, "Back to the scene."),
];

/// Notices that are still shown.
#[derive(Default)]
pub struct Banners {
    lines: Vec<(Notice, f64)>,
    /// Since when a file is being opened, seconds of the input's clock.
    loading: Option<f64>,
    /// Name of a file that was changed on disk while the scene has edits.
    pub changed: Option<String>,
}

impl Banners {
    /// Adds a line at a time in seconds; the same line again takes the place of the old one.
    pub fn add(&mut self, notice: Notice, now: f64) {
        self.lines.retain(|(old, _)| *old != notice);
        self.lines.push((notice, now));
        let surplus = self.lines.len().saturating_sub(MOST);
        self.lines.drain(..surplus);
    }

    /// Draws them over the picture in `space`: an overlay, so that nothing moves. `leaving` is the
    /// file that is to be opened, and whether that is at the cost of edits.
    pub fn ui(
        &mut self,
        ui: &Ui,
        space: Rect,
        model: &mut Model,
        status: &Status,
        leaving: Option<(&Path, bool)>,
        actions: &mut Vec<Action>,
    ) {
        self.expire(ui);
        let dark = status.scene.as_ref().filter(|s| is_dark(s, model));
        let loading = self.slow_loading(ui, status);
        let none = loading.is_none() && dark.is_none() && self.changed.is_none();
        let none = none && leaving.is_none();
        if self.lines.is_empty() && none {
            return;
        }
        let top = space.center_top() + egui::vec2(0.0, 10.0);
        let area = Area::new(Id::unique("banners"))
            .fixed_pos(top)
            .pivot(Align2::CENTER_TOP)
            .constrain_to(space);
        area.show(ui.ctx(), |ui| {
            ui.set_max_width((space.width() - 40.0).min(720.0));
            if let Some(text) = loading {
                line(ui, false, &text, |ui| {
                    if ui.button("Cancel").clicked() {
                        actions.push(Action::CancelOpening);
                    }
                });
            }
            if let Some(scene) = dark {
                line(ui, false, "Nothing emits light.", |ui| {
                    if ui.button("Add a ceiling lamp").clicked() {
                        model.add_lamp(scene);
                    }
                });
            }
            if let Some(file) = &self.changed {
                let text = format!(
                    "{file} was changed on disk. To read it again drops your edits; Undo brings them back."
                );
                let mut keep = true;
                line(ui, false, &text, |ui| {
                    if ui.button("Read again").clicked() {
                        actions.push(Action::Reload);
                        keep = false;
                    }
                    keep &= !ui.button("Keep edits").clicked();
                });
                if !keep {
                    self.changed = None;
                }
            }
            if let Some((path, loses)) = leaving {
                let name = scene_name(path);
                // They may have been saved, or taken back, while the question stood.
                let (text, answers) = match loses {
                    true => ("The scene has edits that no file has.", &LOSES[..]),
                    false => ("No edit is lost now.", &KEPT[..]),
                };
                line(ui, false, &format!("{text} Open {name}?"), |ui| {
                    for (text, answer, tip) in answers {
                        if ui.button(*text).on_hover_text(*tip).clicked() {
                            actions.push(Action::Leave(*answer));
                        }
                    }
                });
            }
            self.lines.retain(|(notice, _)| {
                let mut keep = true;
                line(ui, notice.is_error, &notice.text, |ui| {
                    keep = !ui.button("Dismiss").clicked();
                });
                keep
            });
        });
    }

    /// What is being opened and how far that is, unless it is soon over.
    fn slow_loading(&mut self, ui: &Ui, status: &Status) -> Option<String> {
        let (what, phase) = status.opening.as_ref().or_else(|| {
            self.loading = None;
            None
        })?;
        let now = ui.input(|i| i.time);
        let wait = SOON - (now - *self.loading.get_or_insert(now));
        if wait > 0.0 {
            ui.ctx()
                .request_repaint_after(std::time::Duration::from_secs_f64(wait + 0.01));
            return None;
        }
        let name = scene_name(what.as_ref());
        Some(format!("Opening {name}: {}", phase_text(*phase)))
    }

    /// Takes good news away when they are old, and wakes up for that.
    fn expire(&mut self, ui: &Ui) {
        let now = ui.input(|i| i.time);
        self.lines
            .retain(|(notice, since)| notice.is_error || now - since < GOOD_NEWS);
        let good = self.lines.iter().filter(|(notice, _)| !notice.is_error);
        if let Some(first) = good
            .map(|(_, since)| since + GOOD_NEWS - now)
            .reduce(f64::min)
        {
            ui.ctx()
                .request_repaint_after(std::time::Duration::from_secs_f64(first.max(0.0) + 0.01));
        }
    }
}

fn phase_text(phase: Phase) -> String {
    match phase {
        Phase::Reading => "reading".into(),
        Phase::BuildingAccelerator {
            primitives,
            percent,
        } => format!(
            "building the accelerator, {}, {percent} %",
            counted(primitives as u64, "primitive")
        ),
        Phase::Ready => "ready".into(),
    }
}

/// Whether the scene is black, and no edit on the way changes that.
fn is_dark(scene: &Scene, model: &Model) -> bool {
    let lit = |m: &lightbox_core::scene::MaterialDesc| m.emission.max_element() > 0.0;
    scene.lights().is_empty()
        && model.desc.background.max_element() <= 0.0
        && !(model.desc.materials.iter().any(lit) && model.desc != *scene.desc())
}

fn line(ui: &mut Ui, is_error: bool, text: &str, buttons: impl FnOnce(&mut Ui)) {
    let fill = if is_error {
        Color32::from_rgb(110, 30, 30)
    } else {
        Color32::from_rgb(38, 52, 66)
    };
    Frame::new()
        .fill(fill)
        .corner_radius(4.0)
        .inner_margin(egui::Margin::symmetric(10, 6))
        .show(ui, |ui| {
            let text = egui::RichText::new(text).color(Color32::WHITE);
            let text = egui::Label::new(text).wrap();
            let room = ui.available_width() - BUTTONS;
            if room < LEAST_TEXT {
                ui.add(text);
                ui.horizontal(buttons);
                return;
            }
            ui.horizontal(|ui| {
                ui.scope(|ui| {
                    ui.set_max_width(room);
                    ui.add(text);
                });
                buttons(ui);
            });
        });
    ui.add_space(4.0);
}
