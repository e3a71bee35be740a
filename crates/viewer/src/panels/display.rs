//! From light to screen: nothing here touches the samples.

use egui::Ui;
use lightbox_core::color::ToneCurve;

use super::widgets::{KEEPS, choice, row, section, slider};
use crate::model::Model;

/// Exposure and tone curve.
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
    });
}
