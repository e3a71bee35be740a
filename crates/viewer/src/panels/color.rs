//! A colour of linear light in one row: a swatch that opens hue, saturation and brightness, and
//! the three numbers as a scene file has them.

use egui::ecolor::{Hsva, HsvaGamma};
use egui::{Color32, DragValue, Popup, PopupCloseBehavior, Response, Rgba, Sense, Ui, WidgetInfo};
use glam::Vec3;

use super::widgets::{labelled, number, row, slider, thirds};

/// Edits a colour with parts in [0, 1]; says whether it was touched.
pub fn color(ui: &mut Ui, name: &str, tip: &str, value: &mut Vec3, usual: Vec3) -> bool {
    let before = *value;
    labelled(ui, name, tip, |ui| {
        ui.spacing_mut().item_spacing.x = 3.0;
        let swatch = swatch(ui, name, *value).on_hover_text(tip);
        Popup::menu(&swatch)
            .close_behavior(PopupCloseBehavior::CloseOnClickOutside)
            .show(|ui| {
                ui.set_width(290.0);
                hue_saturation_brightness(ui, value, usual);
            });
        let width = thirds(ui);
        for (part, x) in ["red", "green", "blue"].into_iter().zip(value.as_mut()) {
            let drag = DragValue::new(x)
                .custom_parser(number)
                .range(0.0..=1.0)
                .speed(0.005)
                .max_decimals(3);
            let response = ui.add_sized([width, ui.spacing().interact_size.y], drag);
            response
                .on_hover_text(format!("{part}, linear: drag, or click to type"))
                .accessible_name(format!("{name} {part}"));
        }
    });
    *value != before
}

fn swatch(ui: &mut Ui, name: &str, value: Vec3) -> Response {
    let size = egui::vec2(26.0, ui.spacing().interact_size.y);
    let (rect, response) = ui.allocate_exact_size(size, Sense::click());
    let [r, g, b] = value.to_array();
    let visuals = ui.style().interact(&response);
    ui.painter().rect(
        rect,
        3.0,
        Color32::from(Rgba::from_rgb(r, g, b)),
        visuals.fg_stroke,
        egui::StrokeKind::Inside,
    );
    response.widget_info(|| {
        WidgetInfo::labeled(egui::accesskit::Role::ColorWell, ui.is_enabled(), name)
    });
    response
}

/// Three sliders over the same colour, in steps that look even.
fn hue_saturation_brightness(ui: &mut Ui, value: &mut Vec3, usual: Vec3) {
    // Grey has no hue and black no saturation: they are remembered while the colour is this one.
    let id = ui.scope_id().with("hsv");
    let known: Option<(Vec3, HsvaGamma)> = ui.data(|d| d.get_temp(id));
    let mut hsv = match known {
        Some((rgb, hsv)) if rgb == *value => hsv,
        _ => HsvaGamma::from(Hsva::from_rgb(value.to_array())),
    };
    let before = hsv;
    let usual = HsvaGamma::from(Hsva::from_rgb(usual.to_array()));
    for (name, part, usual) in [
        ("Hue", &mut hsv.h, usual.h),
        ("Saturation", &mut hsv.s, usual.s),
        ("Brightness", &mut hsv.v, usual.v),
    ] {
        row(ui, name, "", |ui| {
            slider(ui, part, usual, 0.0..=1.0, |s| s.fixed_decimals(2))
        });
    }
    if hsv != before {
        *value = Vec3::from(Hsva::from(hsv).to_rgb()).clamp(Vec3::ZERO, Vec3::ONE);
    }
    ui.data_mut(|d| d.insert_temp(id, (*value, hsv)));
}
