//! The only question that the window insists on: what becomes of edits when it closes.

use egui::{Context, Id, Modal};

use crate::unsaved::Answer;

/// Asks; the answer, once there is one.
pub fn quit_ui(ctx: &Context) -> Option<Answer> {
    let modal = Modal::new(Id::unique("quit")).show(ctx, |ui| {
        ui.set_max_width(340.0);
        ui.strong("The scene has edits that no file has.");
        ui.add_space(10.0);
        let mut answer = None;
        ui.horizontal(|ui| {
            for (text, meaning, tip) in [
                ("Save scene…", Answer::Save, "As a .toml file, then quits."),
                ("Quit without saving", Answer::Drop, "The edits are lost."),
                ("Stay", Answer::Stay, "Back to the window. (Escape)"),
            ] {
                if ui.button(text).on_hover_text(tip).clicked() {
                    answer = Some(meaning);
                }
            }
        });
        answer
    });
    let stays = modal.should_close().then_some(Answer::Stay);
    modal.inner.or(stays)
}
