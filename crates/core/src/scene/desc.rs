//! The editable scene: what a scene file holds and what the viewer edits. Plain data; nothing in
//! it is checked until it is read from a file or built into a [`super::Scene`].

use std::path::{Path, PathBuf};

use glam::{Quat, Vec3};
use serde::{Deserialize, Serialize};

use super::builtin;
use crate::settings::RenderSettings;

/// A whole scene as plain data.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct SceneDesc {
    /// Where the picture is taken from.
    pub camera: CameraDesc,
    /// How the scene wants to be rendered; the command line and the viewer override it.
    pub render: RenderSettings,
    /// Radiance that arrives from where no surface is, W/(m²·sr).
    pub background: Vec3,
    /// Named materials.
    #[serde(rename = "material", skip_serializing_if = "Vec::is_empty")]
    pub materials: Vec<MaterialDesc>,
    /// Spheres.
    #[serde(rename = "sphere", skip_serializing_if = "Vec::is_empty")]
    pub spheres: Vec<SphereDesc>,
    /// Planar quadrilaterals.
    #[serde(rename = "quad", skip_serializing_if = "Vec::is_empty")]
    pub quads: Vec<QuadDesc>,
    /// Triangle meshes.
    #[serde(rename = "mesh", skip_serializing_if = "Vec::is_empty")]
    pub meshes: Vec<MeshDesc>,
}

impl SceneDesc {
    /// Whether both have the same shapes in the same places under the same accelerator.
    pub fn same_shapes(&self, other: &Self) -> bool {
        let spheres = |d: &Self| {
            d.spheres
                .iter()
                .map(|s| (s.center, s.radius))
                .collect::<Vec<_>>()
        };
        let quads = |d: &Self| d.quads.iter().map(|q| q.corners).collect::<Vec<_>>();
        self.render.built_accel() == other.render.built_accel()
            && spheres(self) == spheres(other)
            && quads(self) == quads(other)
            && self.meshes.len() == other.meshes.len()
            && self
                .meshes
                .iter()
                .zip(&other.meshes)
                .all(|(a, b)| a.same_shape(b))
    }

    /// The same scene for a reader in any folder: files that it names are relative to that of
    /// `path` so far, and absolute then.
    pub fn detached(&self, path: &Path) -> Self {
        let mut desc = self.clone();
        let meshes = desc.meshes.iter_mut().filter_map(|m| m.file.as_mut());
        let textures = desc.materials.iter_mut().filter_map(|m| m.texture.as_mut());
        for file in meshes.chain(textures) {
            *file = builtin::absolute(builtin::beside(path, file));
        }
        desc
    }

    /// Whether each shape refers to a material of the same name as in `other`.
    pub fn same_assignments(&self, other: &Self) -> bool {
        self.spheres
            .iter()
            .map(|s| &s.material)
            .eq(other.spheres.iter().map(|s| &s.material))
            && self
                .quads
                .iter()
                .map(|q| &q.material)
                .eq(other.quads.iter().map(|q| &q.material))
            && self
                .meshes
                .iter()
                .map(|m| &m.material)
                .eq(other.meshes.iter().map(|m| &m.material))
    }
}

/// A pinhole camera that looks from `eye` to `target`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct CameraDesc {
    /// Pinhole, scene units.
    pub eye: Vec3,
    /// A point on the optical axis, and the pivot of the viewer's orbit.
    pub target: Vec3,
    /// Direction that is up in the picture; need not be perpendicular to the axis.
    pub up: Vec3,
    /// Vertical field of view, degrees, in (0, 180).
    pub fov: f32,
}

impl Default for CameraDesc {
    fn default() -> Self {
        Self {
            eye: Vec3::new(0.0, 0.0, 3.9),
            target: Vec3::ZERO,
            up: Vec3::Y,
            fov: 39.3,
        }
    }
}

/// A surface: perfect diffuse, perfect mirror or a blend of the two, or glass; and its emission.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct MaterialDesc {
    /// What the shapes refer to.
    pub name: String,
    /// Diffuse reflectance per channel, in [0, 1].
    pub albedo: Vec3,
    /// Image that multiplies `albedo`, sRGB, repeated over the mesh's texture coordinates;
    /// relative to the file that names it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub texture: Option<PathBuf>,
    /// Share of mirror in the blend: 0 is all diffuse, 1 is all mirror.
    pub mirror: f32,
    /// Reflectance of the mirror part per channel, in [0, 1].
    pub mirror_color: Vec3,
    /// Index of refraction: makes the surface clear glass, whatever the fields above say.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub glass: Option<f32>,
    /// Radiance emitted from the front, W/(m²·sr).
    pub emission: Vec3,
}

impl Default for MaterialDesc {
    fn default() -> Self {
        Self {
            name: String::new(),
            albedo: Vec3::splat(0.7),
            texture: None,
            mirror: 0.0,
            mirror_color: Vec3::ONE,
            glass: None,
            emission: Vec3::ZERO,
        }
    }
}

/// A sphere; its front is the outside.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SphereDesc {
    /// Label in the viewer.
    #[serde(default)]
    pub name: String,
    /// Name of a material.
    pub material: String,
    /// Centre.
    pub center: Vec3,
    /// Radius, positive.
    pub radius: f32,
}

/// A planar quadrilateral; its front is the side from which the corners run counter-clockwise.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct QuadDesc {
    /// Label in the viewer.
    #[serde(default)]
    pub name: String,
    /// Name of a material.
    pub material: String,
    /// Corners in order around the edge. A parallelogram is kept as one shape; any other convex
    /// quadrilateral becomes two triangles.
    pub corners: [Vec3; 4],
}

/// A triangle mesh, scaled, then rotated, then moved.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MeshDesc {
    /// Label in the viewer.
    #[serde(default)]
    pub name: String,
    /// Name of the material of every face; absent: the mesh file's own, else the default.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub material: Option<String>,
    /// OBJ file, relative to the scene file.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub file: Option<PathBuf>,
    /// Instead of a file: generate a closed rock-like mesh of about this many triangles.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub boulder: Option<u32>,
    /// Uniform scale, positive.
    #[serde(default = "one")]
    pub scale: f32,
    /// Rotation about x, then y, then z, degrees.
    #[serde(default)]
    pub rotate: Vec3,
    /// Translation, scene units.
    #[serde(default)]
    pub translate: Vec3,
}

impl MeshDesc {
    /// Where the points of its file stand in the scene.
    pub fn placement(&self) -> impl Fn(Vec3) -> Vec3 + use<> {
        let Self {
            scale,
            rotate,
            translate,
            ..
        } = *self;
        let [x, y, z] = rotate.to_array().map(f32::to_radians);
        let turn = (rotate != Vec3::ZERO).then(|| {
            Quat::from_rotation_z(z) * Quat::from_rotation_y(y) * Quat::from_rotation_x(x)
        });
        move |p| {
            let p = p * scale;
            turn.map_or(p, |turn| turn * p) + translate
        }
    }

    fn same_shape(&self, other: &Self) -> bool {
        // The number of slots depends on whether the mesh has one material or its file's own.
        let source = |m: &Self| (m.file.clone(), m.boulder, m.material.is_some());
        source(self) == source(other)
            && (self.scale, self.rotate, self.translate)
                == (other.scale, other.rotate, other.translate)
    }
}

fn one() -> f32 {
    1.0
}
