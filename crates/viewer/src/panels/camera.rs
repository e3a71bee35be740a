//! The camera in numbers.

use egui::Ui;

use super::widgets::{KEEPS, RESTARTS, point, row, section, slider};
use crate::keys::{self, Action};
use crate::model::Model;
use crate::session::Status;

/// Field of view, eye and target.
pub fn camera_ui(ui: &mut Ui, model: &mut Model, status: &Status, actions: &mut Vec<Action>) {
    section(ui, "Camera", false, |ui| {
        let (camera, usual) = (&mut model.desc.camera, model.file.camera.fov);
        let tip = format!("Vertical field of view. {RESTARTS}");
        row(ui, "Field of view", &tip, |ui| {
            slider(ui, &mut camera.fov, usual, 5.0..=120.0, |s| {
                s.suffix("°").max_decimals(1)
            })
        });
        // Fine enough to aim, quick enough to cross the room.
        let speed = f64::from(camera.eye.distance(camera.target)) * 2e-3;
        let tip = format!("x, y and z in scene units: drag, or click to type. {RESTARTS}");
        point(ui, "Eye", &tip, &mut camera.eye, speed, "");
        point(ui, "Target", &tip, &mut camera.target, speed, "");
        let tip =
            format!("Orbits over the poles instead of keeping the horizon level (T). {KEEPS}");
        let mut is_free = model.free_orbit;
        if row(ui, "Free orbit", &tip, |ui| ui.checkbox(&mut is_free, "")).changed() {
            actions.push(Action::FreeOrbit);
        }
        ui.horizontal(|ui| {
            for (text, action, tip) in [
                (
                    "Frame",
                    Action::Frame,
                    "See all of the selected object, or of the scene.",
                ),
                ("Home", Action::Home, "Back to the file's camera."),
            ] {
                let tip = format!("{tip} ({})", keys::text(ui.ctx(), &action));
                if ui.button(text).on_hover_text(tip).clicked() {
                    actions.push(action);
                }
            }
            copy(ui, model, status);
        });
    });
}

/// The command that makes this very picture again.
fn copy(ui: &mut Ui, model: &Model, status: &Status) {
    let Some(scene) = &status.scene else { return };
    let tip = "Copies the command that renders this picture again, camera and settings included.";
    let button = egui::Button::new("Copy command");
    let button = ui
        .add_enabled(!status.is_edited, button)
        .on_hover_text(tip)
        .on_disabled_hover_text(
            "The file does not have your edits. Save the picture: it has them, and renders again.",
        );
    if button.clicked() {
        let line = crate::replay::command(scene.path(), &model.desc, model.desc.render.samples);
        ui.ctx().copy_text(line);
    }
}
