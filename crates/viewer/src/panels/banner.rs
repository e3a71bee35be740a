//! Lines over the picture: what failed, what was saved, what is missing.

use std::sync::Arc;

use egui::{Align2, Area, Color32, Frame, Id, Rect, Ui};
use lightbox_core::Scene;

use crate::model::Model;
use crate::session::Notice;

/// How long good news stay, seconds. Errors stay until they are dismissed.
const GOOD_NEWS: f64 = 6.0;

/// Most lines at a time; the oldest go first.
const MOST: usize = 4;

/// Notices that are still shown.
#[derive(Default)]
pub struct Banners {
    lines: Vec<(Notice, f64)>,
}

impl Banners {
    /// Adds a line at a time in seconds; the same line again takes the place of the old one.
    pub fn add(&mut self, notice: Notice, now: f64) {
        self.lines.retain(|(old, _)| *old != notice);
        self.lines.push((notice, now));
        let surplus = self.lines.len().saturating_sub(MOST);
        self.lines.drain(..surplus);
    }

    /// Draws them over the picture in `space`: an overlay, so that nothing moves.
    pub fn ui(&mut self, ui: &Ui, space: Rect, model: &mut Model, scene: Option<&Arc<Scene>>) {
        self.expire(ui);
        let dark = scene.filter(|s| is_dark(s, model));
        if self.lines.is_empty() && dark.is_none() {
            return;
        }
        let top = space.center_top() + egui::vec2(0.0, 10.0);
        let area = Area::new(Id::unique("banners"))
            .fixed_pos(top)
            .pivot(Align2::CENTER_TOP)
            .constrain_to(space);
        area.show(ui.ctx(), |ui| {
            ui.set_max_width((space.width() - 40.0).min(720.0));
            if let Some(scene) = dark {
                line(ui, false, "Nothing emits light.", |ui| {
                    if ui.button("Add a ceiling lamp").clicked() {
                        model.add_lamp(scene);
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
            ui.horizontal(|ui| {
                let room = ui.available_width() - 140.0;
                ui.scope(|ui| {
                    ui.set_max_width(room.max(120.0));
                    ui.add(
                        egui::Label::new(egui::RichText::new(text).color(Color32::WHITE)).wrap(),
                    );
                });
                buttons(ui);
            });
        });
    ui.add_space(4.0);
}
