//! The window that lists all keys and gestures.

use egui::{Align2, Context, KeyboardShortcut, ScrollArea, Window};

use crate::keys::{self, GESTURES};

/// Room for the window's title and edges, points.
const AROUND: egui::Vec2 = egui::Vec2::new(60.0, 90.0);

/// Room that two columns take, points.
const TWO: f32 = 1150.0;

/// Shows the list while `open`.
pub fn help_ui(ctx: &Context, open: &mut bool) {
    let frame = egui::Frame::window(&ctx.global_style()).inner_margin(12);
    let window = Window::new("Keys")
        .open(open)
        .frame(frame)
        .collapsible(false)
        .resizable(false);
    let most = ctx.content_rect().size() - AROUND;
    window
        .pivot(Align2::CENTER_CENTER)
        .default_pos(ctx.content_rect().center())
        .show(ctx, |ui| {
            let room = ScrollArea::both().max_width(most.x).max_height(most.y);
            // Not the usual size of windows, but what it takes.
            let room = room.min_scrolled_width(most.x).min_scrolled_height(most.y);
            room.show(ui, |ui| {
                let lines = lines(ctx);
                ui.horizontal_top(|ui| {
                    let columns = if most.x < TWO { 1 } else { 2 };
                    let columns = lines.chunks(lines.len().div_ceil(columns));
                    for (i, column) in columns.enumerate() {
                        let grid = egui::Grid::new(("keys", i)).num_columns(2);
                        grid.spacing([16.0, 1.0]).show(ui, |ui| {
                            for (names, text) in column {
                                ui.strong(names);
                                ui.label(*text);
                                ui.end_row();
                            }
                        });
                        ui.add_space(12.0);
                    }
                });
            });
        });
}

/// Gestures and keys, and what they do.
fn lines(ctx: &Context) -> Vec<(String, &'static str)> {
    let gestures = GESTURES
        .iter()
        .map(|(name, text)| ((*name).to_owned(), *text));
    let described = keys::all().filter(|(_, _, _, text)| !text.is_empty());
    let keys = described.map(|(_, _, action, text)| {
        // An action may have several keys; one line describes them.
        let same = keys::all().filter(|(_, _, a, _)| *a == action);
        let names: Vec<String> = same
            .map(|(m, k, _, _)| ctx.format_shortcut(&KeyboardShortcut::new(m, k)))
            .collect();
        let names = names.join(" or ");
        (
            names.replace("Questionmark", "?").replace("Equals", "="),
            text,
        )
    });
    gestures.chain(keys).collect()
}
