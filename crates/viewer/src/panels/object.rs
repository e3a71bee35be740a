//! The selected object in numbers: where it stands, how it is turned, how large it is; its
//! material, copies of it, and new ones.

use egui::{Align, DragValue, Layout, Ui};
use glam::Vec3;
use lightbox_core::scene::{MeshDesc, Object, ObjectKind, QuadDesc, SphereDesc};
use lightbox_core::{Scene, SceneDesc};

use super::widgets::{LARGEST, RESTARTS, figure, labelled, number, point, section};
use crate::keys::{self, Action};
use crate::model::Model;
use crate::objects;
use crate::session::Status;

/// Least length that can be set, scene units: zero is no shape.
const LEAST: f32 = 1e-6;

/// Place, turn, size and material of the selected object.
pub fn object_ui(ui: &mut Ui, model: &mut Model, status: &Status, actions: &mut Vec<Action>) {
    section(ui, "Object", true, |ui| {
        let Some(scene) = &status.scene else { return };
        let selected = model.selection.and_then(|s| s.object(scene));
        match selected {
            Some(object) => {
                ui.strong(&object.label);
                placement(ui, &mut model.desc, object, scene);
                material(ui, model, object.kind);
                change(ui, actions);
            }
            None => {
                ui.weak("Click an object to move, turn or scale it.");
            }
        }
        add(ui, model, scene, actions);
    });
}

fn placement(ui: &mut Ui, desc: &mut SceneDesc, object: &Object, scene: &Scene) {
    let Some(center) = objects::center(desc, object.kind, &object.bounds) else {
        return;
    };
    let speed = f64::from(scene.geometry().bounds().diagonal()).max(1e-9) * 2e-3;
    let mut moved = center;
    let tip = format!("x, y and z of its middle, scene units: drag, or click to type. {RESTARTS}");
    point(ui, "Position", &tip, &mut moved, speed, "");
    if moved != center {
        objects::shift(desc, object.kind, moved - center);
    }
    match object.kind {
        ObjectKind::Sphere(i) => {
            if let Some(sphere) = desc.spheres.get_mut(i) {
                sphere_ui(ui, sphere);
            }
        }
        ObjectKind::Quad(i) => {
            if let Some(quad) = desc.quads.get_mut(i) {
                quad_ui(ui, quad);
            }
        }
        ObjectKind::Mesh(i) => {
            if let Some(mesh) = desc.meshes.get_mut(i) {
                mesh_ui(ui, mesh, object);
            }
        }
    }
}

fn sphere_ui(ui: &mut Ui, sphere: &mut SphereDesc) {
    let tip = format!("Scene units. {RESTARTS}");
    length(ui, "Radius of sphere", "Radius", &tip, &mut sphere.radius);
}

fn quad_ui(ui: &mut Ui, quad: &mut QuadDesc) {
    // Of a turn there are several triples of angles: those that were set are shown.
    let id = ui.scope_id().with("angles");
    let known: Option<Vec3> = ui.data(|d| d.get_temp(id));
    let known = known.filter(|angles| objects::is_turned_to(&quad.corners, *angles));
    let mut angles = known.unwrap_or_else(|| objects::angles(&quad.corners));
    if rotation(ui, &mut angles) {
        quad.corners = objects::turned(&quad.corners, angles);
        ui.data_mut(|d| d.insert_temp(id, angles));
    }
    let before = objects::edges(&quad.corners);
    let mut edges = before;
    let tips = [
        format!("Length of its first edge, scene units. {RESTARTS}"),
        format!("Length of its last edge, scene units. {RESTARTS}"),
    ];
    for ((edge, tip), name) in edges.iter_mut().zip(&tips).zip(["Width", "Height"]) {
        length(ui, name, name, tip, edge);
    }
    if edges != before {
        quad.corners = objects::stretched(&quad.corners, edges);
    }
}

fn mesh_ui(ui: &mut Ui, mesh: &mut MeshDesc, object: &Object) {
    let (mut rotate, mut scale) = (mesh.rotate, mesh.scale);
    rotation(ui, &mut rotate);
    let tip = format!("Times the size in its file. {RESTARTS}");
    length(ui, "Scale", "Scale", &tip, &mut scale);
    if (rotate, scale) != (mesh.rotate, mesh.scale) {
        objects::pose(mesh, &object.bounds, rotate, scale);
    }
}

/// Whether it was touched.
fn rotation(ui: &mut Ui, angles: &mut Vec3) -> bool {
    let before = *angles;
    let tip = format!("About x, then y, then z, around its middle. {RESTARTS}");
    point(ui, "Rotation", &tip, angles, 0.5, "°");
    *angles != before
}

/// A positive number, which a drag changes by shares of itself.
fn length(ui: &mut Ui, name: &str, label: &str, tip: &str, value: &mut f32) {
    let before = *value;
    labelled(ui, label, tip, |ui| {
        let drag = DragValue::new(value)
            .custom_parser(number)
            .custom_formatter(figure)
            .speed(f64::from(before) * 5e-3)
            .max_decimals(4);
        ui.add(drag).on_hover_text(tip).accessible_name(name);
    });
    // Not a range of the field: small ones in a file would be changed by looking at them.
    if *value != before {
        *value = value.clamp(LEAST.min(before), LARGEST.max(before));
    }
}

fn material(ui: &mut Ui, model: &mut Model, kind: ObjectKind) {
    let Some(place) = objects::material(&mut model.desc, kind) else {
        return;
    };
    let before = place.name().map(str::to_owned);
    let mut chosen = before.clone();
    let tip = format!("What it is made of; edited above. {RESTARTS}");
    let row = |ui: &mut Ui| {
        let own = format!("Gives it a copy of this material for itself. {RESTARTS}");
        let button = ui.button("New").on_hover_text(own);
        if button.accessible_name("New material").clicked() {
            let mut all = model.desc.materials.iter();
            let like = all.find(|m| Some(&m.name) == before.as_ref()).cloned();
            chosen = Some(objects::add_material(&mut model.desc, like.as_ref()));
        }
        let combo = egui::ComboBox::from_id_salt("made of")
            .selected_text(before.as_deref().unwrap_or("what its file says"))
            .width(ui.available_width())
            .truncate();
        let combo = combo.show_ui(ui, |ui| {
            for material in &model.desc.materials {
                let name = Some(material.name.clone());
                ui.selectable_value(&mut chosen, name, &material.name);
            }
        });
        let response = combo.response.on_hover_text(&tip);
        response.accessible_name("Made of");
    };
    // From the right: what is wider than the panel would push the picture.
    labelled(ui, "Made of", &tip, |ui| {
        ui.with_layout(Layout::right_to_left(Align::Center), row)
    });
    if let Some(name) = chosen.filter(|name| Some(name) != before.as_ref())
        && let Some(place) = objects::material(&mut model.desc, kind)
    {
        place.set(name);
        model.select(kind);
    }
}

fn change(ui: &mut Ui, actions: &mut Vec<Action>) {
    ui.horizontal(|ui| {
        for (text, action, tip) in [
            ("Duplicate", Action::Duplicate, "A copy beside it."),
            ("Delete", Action::Delete, "Takes it out of the scene."),
        ] {
            let tip = format!("{tip} {RESTARTS} ({})", keys::text(ui.ctx(), &action));
            if ui.button(text).on_hover_text(tip).clicked() {
                actions.push(action);
            }
        }
    });
}

/// New objects, in front of what is seen in the middle of the picture.
fn add(ui: &mut Ui, model: &mut Model, scene: &Scene, actions: &mut Vec<Action>) {
    ui.horizontal(|ui| {
        ui.spacing_mut().item_spacing.x = 3.0;
        ui.weak("Add");
        let clicked = |ui: &mut Ui, text: &str, name: &str, tip: &str| {
            let response = ui.button(text).on_hover_text(format!("{tip} {RESTARTS}"));
            response.accessible_name(name).clicked()
        };
        if clicked(ui, "Sphere", "Add sphere", "A ball before what is seen.") {
            model.add_sphere(scene);
        }
        if clicked(ui, "Quad", "Add quad", "A square that faces you.") {
            model.add_quad(scene);
        }
        if clicked(ui, "Mesh…", "Add mesh", "From an .obj file.") {
            actions.push(Action::AddMesh);
        }
        if clicked(ui, "Lamp", "Add lamp", "A square lamp under the ceiling.") {
            model.add_lamp(scene);
        }
    });
}
