//! How the window itself looks.

use egui::gui_zoom::kb_shortcuts::ZOOM_OUT;
use egui::{Context, ThemePreference, Ui};

use super::widgets::{KEEPS, labelled, row, section, slider};
use crate::model::Model;
use crate::workers;

/// Sizes of everything, per cent of the usual one.
const SCALES: [u16; 5] = [100, 125, 150, 175, 200];

/// Least size of everything that can still be read.
const LEAST: f32 = 0.8;

/// Theme, scale and threads.
pub fn window_ui(ui: &mut Ui, model: &mut Model) {
    keep_readable(ui.ctx());
    section(ui, "Window", false, |ui| {
        let tip = "Dark, light, or what the desktop is set to.";
        let before = ui.ctx().options(|o| o.theme_preference);
        let mut theme = before;
        labelled(ui, "Theme", tip, |ui| {
            ui.spacing_mut().item_spacing.x = 2.0;
            for (name, preference) in [
                ("dark", ThemePreference::Dark),
                ("light", ThemePreference::Light),
                ("system", ThemePreference::System),
            ] {
                ui.selectable_value(&mut theme, preference, name)
                    .on_hover_text(tip);
            }
        });
        if theme != before {
            ui.ctx().set_theme(theme);
        }
        let tip = "Size of text and controls. Ctrl++ and Ctrl+- change it too.";
        let before = ui.ctx().zoom_factor();
        let mut scale = before;
        labelled(ui, "Scale, %", tip, |ui| {
            ui.spacing_mut().item_spacing.x = 0.0;
            ui.spacing_mut().button_padding.x = 4.0;
            for percent in SCALES {
                let share = f32::from(percent) / 100.0;
                ui.selectable_value(&mut scale, share, percent.to_string())
                    .on_hover_text(tip)
                    .accessible_name(format!("{percent} %"));
            }
        });
        if scale != before {
            ui.ctx().set_zoom_factor(scale);
        }
        let tip = format!(
            "How many threads trace: fewer leave room for other programs; the picture is the same. {KEEPS}"
        );
        row(ui, "Threads", &tip, |ui| {
            let cores = workers::cores();
            slider(ui, &mut model.threads, workers::usual(), 1..=cores, |s| s)
        });
    });
}

/// egui's own key would go on making everything smaller.
fn keep_readable(ctx: &Context) {
    if ctx.zoom_factor() <= LEAST {
        ctx.input_mut(|i| i.consume_shortcut(&ZOOM_OUT));
        ctx.set_zoom_factor(LEAST);
    }
}
