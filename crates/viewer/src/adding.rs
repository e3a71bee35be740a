//! New objects: lamps, spheres, squares, meshes, copies; placed where they are seen.

use std::path::PathBuf;

use glam::Vec3;
use lightbox_core::Scene;
use lightbox_core::math::{Aabb, Ray};
use lightbox_core::scene::{CameraDesc, MaterialDesc, MeshDesc, ObjectKind, QuadDesc, SphereDesc};

use crate::model::Model;
use crate::objects;

/// Radiance of an added lamp, W/(m²·sr).
const LAMP_RADIANCE: f32 = 15.0;

impl Model {
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
        let name = objects::free_name(&self.desc, "lamp");
        self.desc.materials.push(MaterialDesc {
            name: name.clone(),
            albedo: Vec3::ZERO,
            emission: Vec3::splat(LAMP_RADIANCE),
            ..MaterialDesc::default()
        });
        // Counter-clockwise from below, so that it shines down.
        let corners = [place - a - b, place - a + b, place + a + b, place + a - b];
        let lamp = QuadDesc {
            name: name.clone(),
            material: name,
            corners,
        };
        let kind = objects::add_quad(&mut self.desc, lamp);
        self.select(kind);
    }

    /// Adds a sphere in front of what is seen in the middle of the picture.
    pub fn add_sphere(&mut self, scene: &Scene) {
        let (center, size) = self.free_place(scene);
        let sphere = SphereDesc {
            name: objects::free_name(&self.desc, "sphere"),
            material: self.some_material(),
            center,
            radius: 0.5 * size,
        };
        let kind = objects::add_sphere(&mut self.desc, sphere);
        self.select(kind);
    }

    /// Adds a square that faces the camera, in front of what is seen in the middle of the picture.
    pub fn add_quad(&mut self, scene: &Scene) {
        let (center, size) = self.free_place(scene);
        let CameraDesc {
            eye, target, up, ..
        } = self.desc.camera;
        let back = (eye - target).normalize_or(Vec3::Z);
        let right = up
            .cross(back)
            .try_normalize()
            .unwrap_or_else(|| back.any_orthonormal_vector());
        let (a, b) = (right * (0.5 * size), back.cross(right) * (0.5 * size));
        let quad = QuadDesc {
            name: objects::free_name(&self.desc, "quad"),
            material: self.some_material(),
            corners: [
                center - a - b,
                center + a - b,
                center + a + b,
                center - a + b,
            ],
        };
        let kind = objects::add_quad(&mut self.desc, quad);
        self.select(kind);
    }

    /// Adds the mesh of a file, with this box around it, in front of what is seen in the middle of
    /// the picture.
    pub fn add_mesh(&mut self, scene: &Scene, file: PathBuf, bounds: &Aabb) {
        let (center, size) = self.free_place(scene);
        let mesh = objects::mesh_at(file, bounds, center, size);
        let name = objects::free_name(&self.desc, &mesh.name);
        let mesh = MeshDesc { name, ..mesh };
        let kind = objects::add_mesh(&mut self.desc, mesh);
        self.select(kind);
    }

    /// Takes the selected object out.
    pub fn delete(&mut self) {
        if let Some(selection) = self.selection.take() {
            objects::remove(&mut self.desc, selection.kind);
        }
    }

    /// Puts a copy of the selected object beside it, to the right in the picture.
    pub fn duplicate(&mut self, scene: &Scene) {
        let Some(selection) = self.selection else {
            return;
        };
        let Some(copy) = objects::duplicate(&mut self.desc, selection.kind) else {
            return;
        };
        let object = selection.object(scene);
        let size = object.map_or(0.0, |object| object.bounds.diagonal());
        let scale = match copy {
            ObjectKind::Mesh(i) => self.desc.meshes[i].scale,
            _ => 1.0,
        };
        let CameraDesc {
            eye, target, up, ..
        } = self.desc.camera;
        let right = (target - eye).cross(up).normalize_or(Vec3::X);
        objects::shift(&mut self.desc, copy, right * (0.5 * size * scale));
        self.select(copy);
    }

    /// A place before what is seen in the middle of the picture, and how large something may be
    /// there.
    fn free_place(&self, scene: &Scene) -> (Vec3, f32) {
        let CameraDesc { eye, target, .. } = self.desc.camera;
        let ray = Ray::new(eye, (target - eye).normalize_or(-Vec3::Z));
        let hit = scene.intersect(&ray);
        let distance = hit.map_or(eye.distance(target), |hit| hit.t);
        let diagonal = scene.geometry().bounds().diagonal();
        let most = if diagonal > 0.0 { diagonal } else { distance };
        let size = (0.15 * most).min(0.4 * distance);
        (ray.at(distance - 0.5 * size), size)
    }

    /// A material for something new: that of the selected object, or the first one that does not
    /// shine, or a new one.
    fn some_material(&mut self) -> String {
        let selected = self.selection.and_then(|s| {
            Some(
                objects::material(&mut self.desc, s.kind)?
                    .name()?
                    .to_owned(),
            )
        });
        let plain = |m: &&MaterialDesc| m.emission == Vec3::ZERO;
        let first = self.desc.materials.iter().find(plain);
        selected
            .or_else(|| first.map(|m| m.name.clone()))
            .unwrap_or_else(|| objects::add_material(&mut self.desc, None))
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn axes_keep_their_sign() {
        for axis in [Vec3::X, -Vec3::X, Vec3::Y, -Vec3::Y, Vec3::Z, -Vec3::Z] {
            assert_eq!(dominant_axis(axis * 2.0 + Vec3::splat(0.1)), axis);
        }
    }
}
