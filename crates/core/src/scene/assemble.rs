//! The parts of a scene from its description: primitives, materials and lights.

use std::collections::HashMap;
use std::path::Path;
use std::sync::Arc;

use glam::{Vec2, Vec3};
use rayon::prelude::*;

use super::desc::{MaterialDesc, SceneDesc};
use super::error::SceneError;
use super::{MeshCache, MirrorSphere, Object, ObjectKind, Scene, builtin, load};
use crate::bsdf::Bsdf;
use crate::color::luminance;
use crate::geometry::{Primitive, Primitives};
use crate::light::{Casters, Lights};
use crate::material::Material;
use crate::math::Aabb;
use crate::shape::{Quad, Sphere};
use crate::texture::Texture;

/// Name of the material of mesh faces that name none.
const DEFAULT_MATERIAL: &str = "default";

/// The primitives and which object and slot they belong to.
pub(super) fn primitives(desc: &SceneDesc, meshes: &MeshCache) -> (Primitives, Vec<Object>) {
    let mut primitives = Primitives::default();
    let mut objects: Vec<Object> = Vec::new();
    let mut next_slot = 0;
    let mut object = |kind, name: &str, slots: u32, bounds| {
        let first_slot = next_slot;
        next_slot += slots;
        let label = match (name, kind) {
            ("", ObjectKind::Sphere(i)) => format!("sphere {}", i + 1),
            ("", ObjectKind::Quad(i)) => format!("quad {}", i + 1),
            ("", ObjectKind::Mesh(i)) => format!("mesh {}", i + 1),
            (name, _) => name.to_owned(),
        };
        objects.push(Object {
            kind,
            label,
            first_slot,
            slots,
            bounds,
            placed: Aabb::EMPTY,
        });
        first_slot
    };
    // Slots of each kind are collected apart, then joined in the order of ids.
    let (mut triangle_slots, mut quad_slots, mut sphere_slots) =
        (Vec::new(), Vec::new(), Vec::new());

    for (i, sphere) in desc.spheres.iter().enumerate() {
        let (center, radius) = (sphere.center, sphere.radius);
        let bounds = Aabb {
            min: center - radius,
            max: center + radius,
        };
        sphere_slots.push(object(ObjectKind::Sphere(i), &sphere.name, 1, bounds));
        primitives.spheres.push(Sphere { center, radius });
    }
    for (i, quad) in desc.quads.iter().enumerate() {
        let bounds = Aabb::of_points(quad.corners);
        let slot = object(ObjectKind::Quad(i), &quad.name, 1, bounds);
        if Quad::is_parallelogram(&quad.corners) {
            quad_slots.push(slot);
            primitives.quads.push(Quad::new(quad.corners));
        } else {
            let [a, b, c, d] = quad.corners;
            triangle_slots.extend([slot, slot]);
            primitives.triangles.extend([[a, b, c], [a, c, d]]);
        }
    }
    let wants_uvs = desc
        .meshes
        .iter()
        .filter_map(|m| meshes.get(m))
        .any(|m| !m.uvs.is_empty());
    if wants_uvs {
        primitives.triangle_uvs = vec![[Vec2::ZERO; 3]; primitives.triangles.len()];
    }
    for (i, mesh_desc) in desc.meshes.iter().enumerate() {
        let Some(mesh) = meshes.get(mesh_desc) else {
            continue;
        };
        let own_materials = if mesh_desc.material.is_none() {
            mesh.materials.len() as u32
        } else {
            0
        };
        // The last slot is for faces without a material of their own.
        let kind = ObjectKind::Mesh(i);
        let first = object(kind, &mesh_desc.name, own_materials + 1, mesh.bounds());
        let position = mesh_desc.placement();
        let positions: Vec<_> = mesh.positions.iter().map(|p| position(*p)).collect();
        primitives.triangles.extend(
            mesh.triangles
                .iter()
                .map(|t| t.map(|v| positions[v as usize])),
        );
        triangle_slots.extend(
            mesh.triangle_materials
                .iter()
                .map(|m| first + (*m).min(own_materials)),
        );
        if wants_uvs {
            primitives
                .triangle_uvs
                .extend((0..mesh.triangles.len()).map(|t| {
                    let corners = mesh.uv_triangles.get(t).copied().unwrap_or([u32::MAX; 3]);
                    corners.map(|v| mesh.uvs.get(v as usize).copied().unwrap_or_default())
                }));
        }
    }
    primitives.slots = triangle_slots;
    primitives.slots.extend(quad_slots);
    primitives.slots.extend(sphere_slots);
    let mut placed = vec![Aabb::EMPTY; next_slot as usize];
    for (id, slot) in primitives.slots.iter().enumerate() {
        let all = &mut placed[*slot as usize];
        *all = all.union(primitives.bounds(id as u32));
    }
    for object in &mut objects {
        let slots = placed.drain(..object.slots as usize);
        object.placed = slots.fold(Aabb::EMPTY, Aabb::union);
    }
    (primitives, objects)
}

/// Name and material of each slot.
pub(super) fn materials(
    desc: &SceneDesc,
    path: &Path,
    meshes: &MeshCache,
    objects: &[Object],
    textures: &mut Textures,
) -> Result<(Vec<String>, Vec<Material>), SceneError> {
    let mut names = Vec::new();
    let mut materials = Vec::new();
    let mut add = |name: String, fallback: Option<&MaterialDesc>| -> Result<(), SceneError> {
        let from_scene = desc.materials.iter().position(|m| m.name == name);
        let unnamed = MaterialDesc::default();
        let material = from_scene
            .map(|i| &desc.materials[i])
            .or(fallback)
            .unwrap_or(&unnamed);
        let texture =
            match &material.texture {
                Some(file) => {
                    Some(textures.get(&builtin::beside(path, file)).map_err(
                        |e| match from_scene {
                            Some(i) => {
                                SceneError::at_place("material", i, "texture", e.to_string())
                            }
                            None => e,
                        },
                    )?)
                }
                None => None,
            };
        materials.push(Material {
            albedo: material.albedo,
            texture,
            mirror: material.mirror,
            mirror_color: material.mirror_color,
            glass: material.glass,
            emission: material.emission,
        });
        names.push(name);
        Ok(())
    };
    for object in objects {
        match object.kind {
            ObjectKind::Sphere(i) => add(desc.spheres[i].material.clone(), None)?,
            ObjectKind::Quad(i) => add(desc.quads[i].material.clone(), None)?,
            ObjectKind::Mesh(i) => {
                let mesh_desc = &desc.meshes[i];
                if let (None, Some(mesh)) = (&mesh_desc.material, meshes.get(mesh_desc)) {
                    for material in &mesh.materials {
                        add(
                            format!("{}/{}", object.label, material.name),
                            Some(material),
                        )?;
                    }
                }
                add(
                    mesh_desc
                        .material
                        .clone()
                        .unwrap_or_else(|| DEFAULT_MATERIAL.into()),
                    None,
                )?;
            }
        }
    }
    Ok((names, materials))
}

/// The spheres that light may reach a surface by way of.
pub(super) fn mirror_spheres(scene: &Scene) -> Vec<MirrorSphere> {
    let primitives = scene.primitives();
    let first = primitives.len() - primitives.spheres.len();
    let ids = (first..primitives.len()).map(|id| id as u32);
    ids.zip(&primitives.spheres)
        .filter_map(|(prim, sphere)| {
            // Spheres have no texture coordinates.
            let reflectance = scene.material(prim).bsdf(|| Vec2::ZERO).mirror();
            (reflectance != Vec3::ZERO).then_some(MirrorSphere {
                prim,
                sphere: *sphere,
                reflectance,
            })
        })
        .collect()
}

/// Spheres around what mirrors or refracts in each object. None if that is one mirror sphere
/// alone: all that it does to light but once is to reflect it.
pub(super) fn casters(scene: &Scene) -> Casters {
    let is_specular =
        |material: &Material| !matches!(material.bsdf(Default::default), Bsdf::Diffuse(_));
    let slots: Vec<bool> = scene.materials().iter().map(is_specular).collect();
    let primitives = scene.primitives();
    let mut spheres = Vec::new();
    let mut ids: Vec<u32> = (0..primitives.len() as u32)
        .filter(|id| slots[scene.slot(*id) as usize])
        .collect();
    ids.sort_by_key(|id| scene.slot(*id));
    for ids in ids.chunk_by(|a, b| scene.object(*a) == scene.object(*b)) {
        let boxes = ids.par_iter().map(|id| primitives.bounds(*id));
        let bounds = boxes.reduce(|| Aabb::EMPTY, Aabb::union);
        let center = bounds.center();
        let reach = |id: &u32| match primitives.get(*id) {
            Primitive::Triangle(corners) => farthest(center, corners),
            Primitive::Quad(quad) => farthest(center, quad.corners()),
            Primitive::Sphere(sphere) => center.distance(sphere.center) + sphere.radius,
        };
        // A little more, so that rounding leaves nothing out.
        let radius =
            ids.par_iter().map(reach).reduce(|| 0.0, f32::max) * (1.0 + 16.0 * f32::EPSILON);
        spheres.push(Sphere { center, radius });
    }
    if ids.len() == 1 && scene.mirror_spheres().len() == 1 {
        spheres.clear();
    }
    Casters::new(spheres)
}

fn farthest<const N: usize>(from: Vec3, corners: [Vec3; N]) -> f32 {
    corners
        .map(|p| p.distance(from))
        .into_iter()
        .fold(0.0, f32::max)
}

/// The emitting primitives, weighted by power.
pub(super) fn lights(primitives: &Primitives, materials: &[Material]) -> Lights {
    let radiances: Vec<f64> = materials
        .iter()
        .map(|m| f64::from(luminance(m.emission)))
        .collect();
    if radiances.iter().all(|r| *r == 0.0) {
        return Lights::default();
    }
    Lights::new(
        primitives,
        primitives
            .slots
            .iter()
            .enumerate()
            .filter_map(|(id, slot)| {
                let radiance = radiances[*slot as usize];
                (radiance > 0.0)
                    .then(|| (id as u32, radiance * f64::from(primitives.area(id as u32))))
            }),
    )
}

/// Decoded images by path: read once, shared between edits.
#[derive(Clone, Debug, Default)]
pub(super) struct Textures(HashMap<std::path::PathBuf, Arc<Texture>>);

impl Textures {
    fn get(&mut self, path: &Path) -> Result<Arc<Texture>, SceneError> {
        if let Some(texture) = self.0.get(path) {
            return Ok(texture.clone());
        }
        let texture =
            Texture::decode(&load::read(path)?).map_err(|e| SceneError::in_file(path, e))?;
        let texture = Arc::new(texture);
        self.0.insert(path.to_owned(), texture.clone());
        Ok(texture)
    }
}
