//! The scene: which one, what is in it, what is odd about it.

use std::path::PathBuf;

use egui::Ui;
use lightbox_core::Scene;
use lightbox_core::scene::BUILTIN;

use super::format::{count, counted, length};
use super::widgets::{labelled, section};
use crate::keys::{self, Action};
use crate::model::{Model, Selection, scene_name};
use crate::session::Status;
use crate::settings::Settings;

/// Built-in scenes, opening, saving, objects and warnings.
/// `can` says whether there is something to undo, and to redo.
pub fn scene_ui(
    ui: &mut Ui,
    model: &mut Model,
    status: &Status,
    can: [bool; 2],
    settings: &Settings,
    actions: &mut Vec<Action>,
) {
    section(ui, "Scene", true, |ui| {
        chooser(ui, status, settings, actions);
        let has_samples = status.samples > 0;
        let open = "A .toml scene, an .obj mesh or a saved picture; or drop one on the window.";
        buttons(
            ui,
            [
                ("Open…", Action::Open, open, true),
                (
                    "Save PNG…",
                    Action::SavePng,
                    "The picture as shown.",
                    has_samples,
                ),
                (
                    "Save EXR…",
                    Action::SaveExr,
                    "Linear light in 32-bit floats.",
                    has_samples,
                ),
            ],
            actions,
        );
        let save = "The scene with every edit, camera and settings, as a .toml file.";
        buttons(
            ui,
            [
                ("Undo", Action::Undo, "Takes the last edit back.", can[0]),
                (
                    "Redo",
                    Action::Redo,
                    "Does again what was taken back.",
                    can[1],
                ),
                (
                    "Copy",
                    Action::CopyPicture,
                    "The picture as shown, to the clipboard.",
                    has_samples,
                ),
                (
                    "Save scene…",
                    Action::SaveScene,
                    save,
                    status.scene.is_some(),
                ),
            ],
            actions,
        );
        let Some(scene) = &status.scene else { return };
        ui.add(egui::Label::new(census(scene)).wrap());
        warnings(ui, scene);
        objects(ui, model, scene);
    });
}

fn chooser(ui: &mut Ui, status: &Status, settings: &Settings, actions: &mut Vec<Action>) {
    let path = status
        .scene
        .as_ref()
        .map(|s| s.path().to_owned())
        .unwrap_or_default();
    labelled(
        ui,
        "Scene",
        "Scenes that come with lightbox, and files that were open before.",
        |ui| {
            let combo = egui::ComboBox::from_id_salt("scenes")
                .selected_text(scene_name(&path))
                .width(ui.available_width())
                .truncate();
            let response = combo.show_ui(ui, |ui| {
                for name in BUILTIN {
                    let choice = PathBuf::from(name);
                    if ui
                        .selectable_label(choice == path, scene_name(&choice))
                        .clicked()
                    {
                        actions.push(Action::OpenPath(choice));
                    }
                }
                recent(ui, settings, actions);
            });
            response.response.accessible_name("Scene");
        },
    );
}

/// Files that were open before, by their names.
fn recent(ui: &mut Ui, settings: &Settings, actions: &mut Vec<Action>) {
    let mut files = settings.recent().peekable();
    if files.peek().is_some() {
        ui.separator();
    }
    for path in files {
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        let choice = ui.selectable_label(false, name);
        if choice.on_hover_text(path.display().to_string()).clicked() {
            actions.push(Action::OpenPath(path.to_owned()));
        }
    }
}

/// A row of buttons: text, what it does, tip, and whether it can.
fn buttons<const N: usize>(
    ui: &mut Ui,
    row: [(&str, Action, &str, bool); N],
    actions: &mut Vec<Action>,
) {
    ui.horizontal(|ui| {
        for (text, action, tip, can) in row {
            let button = ui.add_enabled(can, egui::Button::new(text));
            let tip = format!("{tip} ({})", keys::text(ui.ctx(), &action));
            if button.on_hover_text(tip).clicked() {
                actions.push(action);
            }
        }
    });
}

/// One line on what the scene holds.
fn census(scene: &Scene) -> String {
    let primitives = scene.primitives();
    let kinds = [
        (primitives.triangles.len(), "triangle"),
        (primitives.quads.len(), "quad"),
        (primitives.spheres.len(), "sphere"),
    ];
    let mut parts: Vec<String> = kinds
        .iter()
        .filter(|(n, _)| *n > 0)
        .map(|(n, noun)| counted(*n as u64, noun))
        .collect();
    if parts.is_empty() {
        parts.push("empty".into());
    }
    parts.push(counted(scene.lights().len() as u64, "light"));
    parts.push(format!(
        "size {}",
        length(scene.geometry().bounds().diagonal())
    ));
    parts.join(", ")
}

fn warnings(ui: &mut Ui, scene: &Scene) {
    for warning in scene.warnings() {
        let text =
            egui::RichText::new(format!("Warning: {warning}")).color(ui.visuals().warn_fg_color);
        ui.add(egui::Label::new(text).wrap());
    }
}

fn objects(ui: &mut Ui, model: &mut Model, scene: &Scene) {
    let objects = scene.objects();
    let title = format!("Objects ({})", count(objects.len() as u64));
    egui::CollapsingHeader::new(title)
        .id_salt("objects")
        .show(ui, |ui| {
            let height = ui.text_style_height(&egui::TextStyle::Button)
                + 2.0 * ui.spacing().button_padding.y;
            let list = egui::ScrollArea::vertical()
                .id_salt("object list")
                .max_height(160.0)
                .auto_shrink([false, true]);
            // Only rows in view are made: a scene may have very many objects.
            list.show_rows(ui, height, objects.len(), |ui, rows| {
                for object in &objects[rows] {
                    let is_selected = model.selection.is_some_and(|s| s.kind == object.kind);
                    if ui.selectable_label(is_selected, &object.label).clicked() {
                        model.selection = Some(Selection {
                            kind: object.kind,
                            part: 0,
                        });
                    }
                }
            });
        });
}
