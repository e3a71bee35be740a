//! What a scene uses: counted once, when it is built.

use std::collections::{HashMap, HashSet};
use std::sync::Arc;

use glam::Vec3;
use serde::Serialize;

use super::Scene;
use crate::bsdf::Bsdf;
use crate::light::LightKinds;

/// Counts of what a scene uses. What no primitive uses is not counted.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize)]
#[non_exhaustive]
pub struct Census {
    /// Triangles; a quad that is no parallelogram is two.
    pub triangles: usize,
    /// Parallelograms.
    pub quads: usize,
    /// Spheres.
    pub spheres: usize,
    /// By how they scatter.
    pub materials: MaterialKinds,
    /// Primitives that can be aimed at, by how they are sampled.
    pub lights: LightKinds,
    /// Distinct images.
    pub textures: usize,
    /// Bytes that they take.
    #[serde(skip)]
    pub texture_bytes: usize,
    /// Whether a ray that leaves the scene finds light. If not, it makes no difference to the
    /// picture whether the scene is closed.
    pub background: bool,
}

/// Counts of materials by how they scatter.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct MaterialKinds {
    /// Perfectly diffuse.
    pub diffuse: usize,
    /// Between diffuse and mirror.
    pub blend: usize,
    /// Perfect mirror.
    pub mirror: usize,
    /// Clear glass.
    pub glass: usize,
    /// Of the above, those that emit.
    pub emitting: usize,
}

impl MaterialKinds {
    /// Those that reflect or refract rays in one direction only.
    pub fn specular(&self) -> usize {
        self.blend + self.mirror + self.glass
    }
}

impl Census {
    pub(super) fn of(scene: &Scene) -> Self {
        let primitives = scene.primitives();
        let mut is_used = vec![false; scene.materials.len()];
        for slot in &primitives.slots {
            is_used[*slot as usize] = true;
        }
        let mut kinds = MaterialKinds::default();
        let mut textures = HashMap::new();
        // Slots can share a material, materials a texture; each counts once.
        let mut names = HashSet::new();
        let slots = scene.materials.iter().zip(&scene.material_names);
        for ((material, name), _) in slots.zip(&is_used).filter(|(_, used)| **used) {
            if let Some(texture) = &material.texture {
                textures.insert(Arc::as_ptr(texture), texture.bytes());
            }
            if !names.insert(name) {
                continue;
            }
            let kind = match material.bsdf(Default::default) {
                Bsdf::Diffuse(_) => &mut kinds.diffuse,
                Bsdf::Blend { .. } => &mut kinds.blend,
                Bsdf::Mirror(_) => &mut kinds.mirror,
                Bsdf::Glass(_) => &mut kinds.glass,
            };
            *kind += 1;
            kinds.emitting += usize::from(material.emits());
        }
        Self {
            triangles: primitives.triangles.len(),
            quads: primitives.quads.len(),
            spheres: primitives.spheres.len(),
            materials: kinds,
            lights: scene.lights.kinds(),
            textures: textures.len(),
            texture_bytes: textures.values().sum(),
            background: scene.background() != Vec3::ZERO,
        }
    }

    /// Number of primitives.
    pub fn primitives(&self) -> usize {
        self.triangles + self.quads + self.spheres
    }
}
