//! What the user edits: the description, the selection and how the picture is shown.

use std::path::Path;

use glam::Vec3;
use lightbox_core::color::ToneMap;
use lightbox_core::scene::{MaterialDesc, Object, ObjectKind};
use lightbox_core::{Scene, SceneDesc};

use crate::aov::Aov;
use crate::bookmarks::Bookmarks;
use crate::session::{Budget, Region};
use crate::workers;

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
#[derive(Clone, Debug, PartialEq)]
pub struct Model {
    /// The scene as edited.
    pub desc: SceneDesc,
    /// The scene as its file has it, to come back to.
    pub file: SceneDesc,
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
    /// What of the picture is rendered first.
    pub region: Option<Region>,
    /// Whether orbits go over the poles.
    pub free_orbit: bool,
    /// How many threads trace.
    pub threads: usize,
    /// Places of the camera to go back to.
    pub bookmarks: Bookmarks,
    /// Hue of an emission whose strength is zero: material name and colour.
    pub unlit: Option<(String, Vec3)>,
}

impl Default for Model {
    fn default() -> Self {
        Self {
            desc: SceneDesc::default(),
            file: SceneDesc::default(),
            size: PictureSize::default(),
            budget: Budget::default(),
            selection: None,
            tone: ToneMap::default(),
            aov: Aov::default(),
            region: None,
            free_orbit: false,
            threads: workers::usual(),
            bookmarks: Bookmarks::default(),
            unlit: None,
        }
    }
}

impl Model {
    /// Goes over to another file; how pictures are shown and when they are done stays, unless the file is a saved picture
    /// that comes back as it was.
    pub fn open(&mut self, desc: &SceneDesc, tone: Option<ToneMap>) {
        *self = Self {
            desc: desc.clone(),
            file: desc.clone(),
            size: tone.map_or(self.size, |_| PictureSize::AsInFile),
            budget: tone.map_or(self.budget, |_| Budget::Samples),
            tone: tone.unwrap_or(self.tone),
            aov: self.aov,
            free_orbit: self.free_orbit,
            threads: self.threads,
            ..Self::default()
        };
    }

    /// Selects a whole object.
    pub fn select(&mut self, kind: ObjectKind) {
        self.selection = Some(Selection { kind, part: 0 });
    }

    /// Orbits over the poles from now on, or with the horizon of the file.
    pub fn toggle_free_orbit(&mut self) {
        self.free_orbit = !self.free_orbit;
        if !self.free_orbit {
            self.desc.camera.up = self.file.camera.up;
        }
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

    /// A material as the file has it, or a new one.
    pub fn usual_material(&self, name: &str) -> MaterialDesc {
        let found = self.file.materials.iter().find(|m| m.name == name);
        found.cloned().unwrap_or_default()
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
}
