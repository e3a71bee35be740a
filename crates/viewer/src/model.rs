//! What the user edits: the description, the selection and how the picture is shown.

use std::path::Path;

use glam::Vec3;
use lightbox_core::color::ToneMap;
use lightbox_core::math::Ray;
use lightbox_core::scene::{CameraDesc, MaterialDesc, Object, ObjectKind, QuadDesc};
use lightbox_core::{Scene, SceneDesc};

use crate::aov::Aov;
use crate::session::Budget;

/// Radiance of an added lamp, W/(m²·sr).
const LAMP_RADIANCE: f32 = 15.0;

/// Which size the picture is rendered at.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum PictureSize {
    /// That of the picture's place in the window, pixel for pixel.
    #[default]
    FitWindow,
    /// That of the scene file.
    AsInFile,
}

/// A selected object, and which of its material slots.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Selection {
    /// The object; keeps its meaning when objects are added.
    pub kind: ObjectKind,
    /// Counted from the object's first slot.
    pub part: u32,
}

impl Selection {
    /// What a primitive belongs to.
    pub fn of(scene: &Scene, prim: u32) -> Self {
        let object = scene.object(prim);
        Self {
            kind: object.kind,
            part: scene.slot(prim) - object.first_slot,
        }
    }

    /// The object, if the scene still has it.
    pub fn object<'a>(&self, scene: &'a Scene) -> Option<&'a Object> {
        scene.objects().iter().find(|o| o.kind == self.kind)
    }
}

/// The edited state; the engine is sent a copy after each frame that changed it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Model {
    /// The scene as edited.
    pub desc: SceneDesc,
    /// The file's camera and picture size, to come back to.
    pub file_camera: CameraDesc,
    /// Pixels across and down.
    pub file_size: [u32; 2],
    /// Which size is rendered.
    pub size: PictureSize,
    /// When a picture is done.
    pub budget: Budget,
    /// What the material panel shows.
    pub selection: Option<Selection>,
    /// From light to screen.
    pub tone: ToneMap,
    /// What pixels show.
    pub aov: Aov,
    /// Hue of an emission whose strength is zero: material name and colour.
    pub unlit: Option<(String, Vec3)>,
}

impl Model {
    /// Goes over to another file; how pictures are shown and when they are done stays, unless the file is a saved picture
    /// that comes back as it was.
    pub fn open(&mut self, desc: &SceneDesc, tone: Option<ToneMap>) {
        *self = Self {
            desc: desc.clone(),
            file_camera: desc.camera,
            file_size: [desc.render.width, desc.render.height],
            size: tone.map_or(self.size, |_| PictureSize::AsInFile),
            budget: tone.map_or(self.budget, |_| Budget::Samples),
            tone: tone.unwrap_or(self.tone),
            aov: self.aov,
            ..Self::default()
        };
    }

    /// The selected material with the newest edits.
    pub fn selected_material(&self, scene: &Scene) -> Option<MaterialDesc> {
        let selection = self.selection?;
        let object = selection.object(scene)?;
        if selection.part >= object.slots {
            return None;
        }
        // The scene may lag behind the edits, but not in names.
        let material = scene.slot_material(object.first_slot + selection.part);
        Some(
            self.desc
                .materials
                .iter()
                .find(|m| m.name == material.name)
                .cloned()
                .unwrap_or(material),
        )
    }

    /// Puts an edited material in its place.
    pub fn set_material(&mut self, material: MaterialDesc) {
        match self
            .desc
            .materials
            .iter_mut()
            .find(|m| m.name == material.name)
        {
            Some(place) => *place = material,
            None => self.desc.materials.push(material),
        }
    }

    /// Labels of the other objects that an edit of the selected material changes too.
    pub fn sharing<'a>(&self, scene: &'a Scene, material: &str) -> Vec<&'a str> {
        let uses = |kind| match kind {
            ObjectKind::Sphere(i) => self
                .desc
                .spheres
                .get(i)
                .is_some_and(|s| s.material == material),
            ObjectKind::Quad(i) => self
                .desc
                .quads
                .get(i)
                .is_some_and(|q| q.material == material),
            ObjectKind::Mesh(i) => self
                .desc
                .meshes
                .get(i)
                .is_some_and(|m| m.material.as_deref() == Some(material)),
        };
        let selected = self.selection.map(|s| s.kind);
        let others = scene
            .objects()
            .iter()
            .filter(|o| Some(o.kind) != selected && uses(o.kind));
        others.map(|o| o.label.as_str()).collect()
    }

    /// Hangs a lamp under the top of the scene, or above it if that is where it would be seen.
    pub fn add_lamp(&mut self, scene: &Scene) {
        let bounds = scene.geometry().bounds();
        if bounds.is_empty() {
            return;
        }
        let up = dominant_axis(self.desc.camera.up);
        // Right-handed: across × along = up.
        let (across, along) = (
            Vec3::new(up.z, up.x, up.y),
            Vec3::new(up.y, up.z, up.x).abs(),
        );
        let half = bounds.extent() * 0.5;
        let size = bounds.diagonal();
        let side = |axis: Vec3| axis * (half.dot(axis.abs()) * 0.3).max(size * 0.05);
        let height = |share: f32| bounds.center() + up * (half.dot(up.abs()) + share * size);
        // The camera sees a place in a room; inside a solid body it does not.
        let eye = self.desc.camera.eye;
        let seen = |place: &Vec3| {
            let way = *place - eye;
            let ray = Ray {
                t_max: way.length() * 0.999,
                ..Ray::new(eye, way.normalize_or_zero())
            };
            !scene.occluded(&ray, u32::MAX)
        };
        let below = height(-0.01);
        let place = [below, height(0.25)]
            .into_iter()
            .find(seen)
            .unwrap_or(below);
        let (a, b) = (side(across), side(along));
        let name = free_name("lamp", |name| {
            self.desc.materials.iter().any(|m| m.name == name)
        });
        self.desc.materials.push(MaterialDesc {
            name: name.clone(),
            albedo: Vec3::ZERO,
            emission: Vec3::splat(LAMP_RADIANCE),
            ..MaterialDesc::default()
        });
        // Counter-clockwise from below, so that it shines down.
        let corners = [place - a - b, place - a + b, place + a + b, place + a - b];
        self.desc.quads.push(QuadDesc {
            name: name.clone(),
            material: name,
            corners,
        });
    }
}

/// The signed coordinate axis closest to a direction.
fn dominant_axis(v: Vec3) -> Vec3 {
    let a = v.abs();
    if a.x > a.y && a.x > a.z {
        Vec3::X * v.x.signum()
    } else if a.z > a.y {
        Vec3::Z * v.z.signum()
    } else {
        Vec3::Y * v.y.signum()
    }
}

fn free_name(wanted: &str, taken: impl Fn(&str) -> bool) -> String {
    let numbered = (2..).map(|i| format!("{wanted} {i}"));
    std::iter::once(wanted.to_owned())
        .chain(numbered)
        .find(|name| !taken(name))
        .unwrap_or_default()
}

/// A file or built-in scene without folder and extension.
pub fn scene_name(path: &Path) -> String {
    let stem = path
        .file_stem()
        .unwrap_or(path.as_os_str())
        .to_string_lossy();
    stem.strip_prefix("builtin:").unwrap_or(&stem).to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn scene_names_are_short() {
        assert_eq!(
            scene_name(Path::new("builtin:teddy-diffuse.toml")),
            "teddy-diffuse"
        );
        assert_eq!(scene_name(Path::new("some/folder/a.b.obj")), "a.b");
    }

    #[test]
    fn lamps_get_free_names() {
        assert_eq!(
            free_name("lamp", |n| n == "lamp" || n == "lamp 2"),
            "lamp 3"
        );
    }

    #[test]
    fn axes_keep_their_sign() {
        for axis in [Vec3::X, -Vec3::X, Vec3::Y, -Vec3::Y, Vec3::Z, -Vec3::Z] {
            assert_eq!(dominant_axis(axis * 2.0 + Vec3::splat(0.1)), axis);
        }
    }
}
