//! From light to screen: nothing here touches the samples.

use egui::Ui;
use lightbox_core::color::ToneCurve;

use super::format::percent;
use super::widgets::{KEEPS, choice, labelled, row, section, slider};
use crate::model::Model;
use crate::session::{ERRORS, error_color};

/// Exposure, tone curve and error map.
pub fn display_ui(ui: &mut Ui, model: &mut Model) {
    section(ui, "Display", true, |ui| {
        let tip =
            format!("Brightness in stops: one more is twice the light. E and Shift+E. {KEEPS}");
        row(ui, "Exposure", &tip, |ui| {
            ui.add(
                slider(&mut model.tone.exposure, -10.0..=10.0)
                    .step_by(0.1)
                    .fixed_decimals(1),
            )
        });
        let tip = format!("Linear clips what is too bright; filmic bends it gently. {KEEPS}");
        choice(
            ui,
            "Tone curve",
            &tip,
            &mut model.tone.curve,
            &ToneCurve::ALL,
        );
        let tip = format!(
            "Estimated relative error (noise, not bias) of each pixel, pooled with its neighbours, instead of its light. F6. {KEEPS}"
        );
        labelled(ui, "Error map", &tip, |ui| {
            ui.checkbox(&mut model.shows_error, "")
                .on_hover_text(&tip)
                .accessible_name("Error map");
            if model.shows_error {
                scale(ui);
            }
        });
    });
}

/// The colours of errors, with numbers at both ends.
fn scale(ui: &mut Ui) {
    let [low, high] = ERRORS;
    ui.weak(percent(f64::from(low)));
    let room = egui::vec2(56.0, ui.spacing().interact_size.y * 0.6);
    let (rect, _) = ui.allocate_exact_size(room, egui::Sense::hover());
    let steps = room.x as u16;
    for i in 0..steps {
        let along = f32::from(i) / f32::from(steps - 1);
        let [r, g, b] = error_color(low * (high / low).powf(along));
        let left = rect.left() + f32::from(i);
        let x = egui::Rangef::new(left, left + 1.0);
        let strip = egui::Rect::from_x_y_ranges(x, rect.y_range());
        ui.painter()
            .rect_filled(strip, 0.0, egui::Color32::from_rgb(r, g, b));
    }
    ui.weak(percent(f64::from(high)));
}
