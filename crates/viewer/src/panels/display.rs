//! From light to screen: nothing here touches the samples.

use egui::{Context, Ui};
use lightbox_core::color::ToneCurve;

use super::widgets::{KEEPS, choice, labelled, row, section, slider};
use crate::aov::Aov;
use crate::keys::{self, Action};
use crate::model::Model;

/// Exposure, tone curve and what pixels show.
pub fn display_ui(ui: &mut Ui, model: &mut Model) {
    section(ui, "Display", true, |ui| {
        let tip =
            format!("Brightness in stops: one more is twice the light. E and Shift+E. {KEEPS}");
        row(ui, "Exposure", &tip, |ui| {
            slider(ui, &mut model.tone.exposure, 0.0, -10.0..=10.0, |s| {
                s.step_by(0.1).fixed_decimals(1)
            })
        });
        let tip = format!(
            "Added after exposure, in shares of white. O and Shift+O; N fits both to the picture, R takes both back. {KEEPS}"
        );
        row(ui, "Offset", &tip, |ui| {
            slider(ui, &mut model.tone.offset, 0.0, -1.0..=1.0, |s| {
                s.step_by(0.01).fixed_decimals(2)
            })
        });
        let tip = format!("Linear clips what is too bright; filmic bends it gently. {KEEPS}");
        choice(
            ui,
            "Tone curve",
            &tip,
            &mut model.tone.curve,
            &ToneCurve::ALL,
        );
        aov(ui, &mut model.aov);
    });
}

fn aov(ui: &mut Ui, chosen: &mut Aov) {
    let tip = format!("What pixels show: light, or something else about them. {KEEPS}");
    labelled(ui, "View", &tip, |ui| {
        let combo = egui::ComboBox::from_id_salt("view")
            .selected_text(chosen.name())
            .height(400.0)
            .width(ui.available_width());
        let response = combo.show_ui(ui, |ui| {
            for aov in Aov::all() {
                let label = egui::Button::selectable(*chosen == aov, aov.name())
                    .shortcut_text(key(ui.ctx(), aov));
                if ui.add(label).on_hover_text(aov.tip()).clicked() {
                    *chosen = aov;
                }
            }
        });
        let response = response.response.on_hover_text(&tip);
        response.accessible_name("View");
    });
}

fn key(ctx: &Context, aov: Aov) -> String {
    keys::text(ctx, &Action::Show(aov))
}
