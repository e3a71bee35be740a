//! The window that lists all keys and gestures.

use egui::{Align2, Context, KeyboardShortcut, Window};

use crate::keys::{self, GESTURES};

/// Shows the list while `open`.
pub fn help_ui(ctx: &Context, open: &mut bool) {
    let frame = egui::Frame::window(&ctx.global_style()).inner_margin(12);
    let window = Window::new("Keys")
        .open(open)
        .frame(frame)
        .collapsible(false)
        .resizable(false);
    window
        .pivot(Align2::CENTER_CENTER)
        .default_pos(ctx.content_rect().center())
        .show(ctx, |ui| {
            egui::Grid::new("keys")
                .num_columns(2)
                .spacing([24.0, 5.0])
                .show(ui, |ui| {
                    for (gesture, text) in GESTURES {
                        ui.strong(*gesture);
                        ui.label(*text);
                        ui.end_row();
                    }
                    for (_, _, action, text) in keys::all() {
                        if text.is_empty() {
                            continue;
                        }
                        // An action may have several keys; one line describes them.
                        let same = keys::all().filter(|(_, _, a, _)| *a == action);
                        let names: Vec<String> = same
                            .map(|(m, k, _, _)| ctx.format_shortcut(&KeyboardShortcut::new(m, k)))
                            .collect();
                        ui.strong(names.join(" or ").replace("Questionmark", "?"));
                        ui.label(text);
                        ui.end_row();
                    }
                });
        });
}
