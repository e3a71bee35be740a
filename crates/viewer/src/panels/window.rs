//! How the window itself looks.

use egui::{ThemePreference, Ui};

use super::widgets::{labelled, section};

/// Sizes of everything, by themselves and as shares of the usual one.
const SCALES: [(&str, f32); 5] = [
    ("100 %", 1.0),
    ("125 %", 1.25),
    ("150 %", 1.5),
    ("175 %", 1.75),
    ("200 %", 2.0),
];

/// Theme and scale.
pub fn window_ui(ui: &mut Ui) {
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
        labelled(ui, "Scale", tip, |ui| {
            ui.spacing_mut().item_spacing.x = 0.0;
            ui.spacing_mut().button_padding.x = 3.0;
            for (name, share) in SCALES {
                ui.selectable_value(&mut scale, share, name)
                    .on_hover_text(tip);
            }
        });
        if scale != before {
            ui.ctx().set_zoom_factor(scale);
        }
    });
}
