//! The material of the selected object.

use egui::Ui;
use glam::Vec3;
use lightbox_core::scene::MaterialDesc;

use super::color::color;
use super::widgets::{RESTARTS, row, section, slider};
use crate::model::Model;
use crate::session::Status;

/// Index of refraction of window glass.
const WINDOW_GLASS: f32 = 1.5;

/// Strongest emission the slider offers, W/(m²·sr); more can be typed.
const STRONGEST: f32 = 1000.0;

/// Albedo, mirror, glass and emission.
pub fn material_ui(ui: &mut Ui, model: &mut Model, status: &Status) {
    section(ui, "Material", true, |ui| {
        let selected = status.scene.as_ref().and_then(|scene| {
            let object = model.selection?.object(scene)?;
            Some((scene, object, model.selected_material(scene)?))
        });
        let Some((scene, object, material)) = selected else {
            ui.weak("Click an object in the picture to edit its material.");
            return;
        };
        let others = model.sharing(scene, &material.name);
        ui.horizontal_wrapped(|ui| {
            ui.strong(&object.label);
            ui.weak(&material.name);
        });
        if !others.is_empty() {
            ui.add(
                egui::Label::new(
                    egui::RichText::new(format!("also on {}", others.join(", "))).weak(),
                )
                .truncate(),
            );
        }
        let mut edited = material.clone();
        let usual = model.usual_material(&material.name);
        surface(ui, &mut edited, &usual);
        emission(ui, model, &mut edited, &usual);
        if edited != material {
            model.set_material(edited);
        }
    });
}

fn surface(ui: &mut Ui, material: &mut MaterialDesc, usual: &MaterialDesc) {
    ui.add_enabled_ui(material.glass.is_none(), |ui| {
        color(
            ui,
            "Albedo",
            &format!("Share of light that is scattered. {RESTARTS}"),
            &mut material.albedo,
            usual.albedo,
        );
        let tip = format!("From all diffuse (0) to all mirror (1). {RESTARTS}");
        row(ui, "Mirror", &tip, |ui| {
            slider(ui, &mut material.mirror, usual.mirror, 0.0..=1.0, |s| {
                s.fixed_decimals(2)
            })
        });
        ui.add_enabled_ui(material.mirror > 0.0, |ui| {
            color(
                ui,
                "Mirror tint",
                &format!("Share of light that is mirrored. {RESTARTS}"),
                &mut material.mirror_color,
                usual.mirror_color,
            );
        });
    });
    let mut is_glass = material.glass.is_some();
    let tip = format!("Clear glass, whatever stands above. {RESTARTS}");
    row(ui, "Glass", &tip, |ui| ui.checkbox(&mut is_glass, ""));
    if is_glass != material.glass.is_some() {
        material.glass = is_glass.then_some(WINDOW_GLASS);
    }
    if let Some(ior) = &mut material.glass {
        let tip =
            format!("Index of refraction: water 1.33, window glass 1.5, diamond 2.4. {RESTARTS}");
        row(ui, "Refraction", &tip, |ui| {
            let usual = usual.glass.unwrap_or(WINDOW_GLASS);
            slider(ui, ior, usual, 1.0..=3.0, |s| s.fixed_decimals(2))
        });
    }
}

/// Emission as a colour, whose largest part is 1, times a strength.
fn emission(ui: &mut Ui, model: &mut Model, material: &mut MaterialDesc, usual: &MaterialDesc) {
    let mut strength = material.emission.max_element();
    let mut hue = match &model.unlit {
        _ if strength > 0.0 => material.emission / strength,
        Some((name, hue)) if *name == material.name => *hue,
        _ => Vec3::ONE,
    };
    let before = strength;
    let tip = format!("Radiance that the front emits, W/(m²·sr). {RESTARTS}");
    row(ui, "Emission", &tip, |ui| {
        let usual = usual.emission.max_element();
        slider(ui, &mut strength, usual, 0.0..=STRONGEST, |s| {
            s.logarithmic(true)
                .smallest_positive(0.01)
                .max_decimals(2)
                .clamping(egui::SliderClamping::Never)
        })
    });
    let strength = if strength.is_finite() {
        strength.max(0.0)
    } else {
        before
    };
    let usual_hue = match usual.emission.max_element() {
        0.0 => Vec3::ONE,
        strength => usual.emission / strength,
    };
    let recolored = color(
        ui,
        "Light colour",
        &format!("Hue of the emission. {RESTARTS}"),
        &mut hue,
        usual_hue,
    );
    if strength != before || recolored {
        // Black has no hue; it would come back as white.
        let hue = if hue.max_element() > 0.0 {
            hue / hue.max_element()
        } else {
            Vec3::ONE
        };
        material.emission = hue * strength;
        model.unlit = Some((material.name.clone(), hue));
    }
}
