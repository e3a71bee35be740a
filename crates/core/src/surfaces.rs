//! What the camera sees first, whatever light falls on it.

use glam::Vec3;

use crate::bsdf::Bsdf;
use crate::film::TileRect;
use crate::geometry::{Hit, Traversal};
use crate::math::Ray;
use crate::render::View;
use crate::scene::Scene;

/// A surface that a ray meets.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct Surface {
    /// From the start of the ray, scene units.
    pub distance: f32,
    /// Primitive id.
    pub prim: u32,
    /// Whether the ray comes from the front.
    pub is_front: bool,
    /// Unit normal of the front.
    pub normal: Vec3,
    /// Share of light that is scattered or mirrored; all of it by clear glass.
    pub albedo: Vec3,
}

impl Surface {
    /// The surface at a hit of a ray.
    pub(crate) fn at(scene: &Scene, ray: &Ray, hit: &Hit) -> Self {
        let normal = scene.primitives().surface_point(ray, hit).n;
        let material = scene.material(hit.prim);
        let albedo = match material.bsdf(|| scene.primitives().uv(hit)) {
            Bsdf::Diffuse(albedo) | Bsdf::Mirror(albedo) => albedo,
            Bsdf::Blend { diffuse, mirror } => diffuse + mirror,
            Bsdf::Glass(_) => Vec3::ONE,
        };
        Self {
            distance: hit.t,
            prim: hit.prim,
            is_front: ray.dir.dot(normal) < 0.0,
            normal,
            albedo,
        }
    }
}

impl View {
    /// The surfaces seen through the centres of some pixels, row by row.
    pub fn surfaces(&self, rect: TileRect) -> Vec<Option<Surface>> {
        let rays: Vec<Ray> = self.centres(rect).collect();
        let mut hits = Vec::new();
        self.scene.intersect_all(&rays, &mut hits);
        let seen = rays.iter().zip(&hits);
        seen.map(|(ray, hit)| Some(Surface::at(&self.scene, ray, hit.as_ref()?)))
            .collect()
    }

    /// What it takes to find the surfaces seen through the centres of some pixels, row by row.
    pub fn traversals(&self, rect: TileRect) -> Vec<Traversal> {
        let rays = self.centres(rect);
        rays.map(|ray| self.scene.traversal(&ray)).collect()
    }

    /// The rays through the centres of some pixels, row by row.
    pub(crate) fn centres(&self, rect: TileRect) -> impl Iterator<Item = Ray> {
        rect.pixels().map(|pixel| self.camera.ray(pixel, [0.0; 2]))
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;
    use std::sync::Arc;

    use super::*;
    use crate::scene;

    #[test]
    fn surfaces_are_those_that_rays_meet() {
        let source = scene::load(Path::new("builtin:sphere-mirror.toml")).expect("a scene");
        let scene = Arc::new(source.build(&scene::unwatched).expect("a scene"));
        let settings = crate::RenderSettings {
            width: 40,
            height: 30,
            ..source.desc.render
        };
        let view = View::new(scene, &source.desc.camera, settings).expect("a view");
        let rect = TileRect {
            x: 3,
            y: 2,
            width: 30,
            height: 25,
        };
        let surfaces = view.surfaces(rect);
        assert_eq!(surfaces.len(), 30 * 25);
        let mut seen = std::collections::BTreeSet::new();
        for (i, surface) in surfaces.iter().enumerate() {
            let pixel = [3 + i as u32 % 30, 2 + i as u32 / 30];
            let ray = view.camera.ray(pixel, [0.0; 2]);
            let hit = view.scene.intersect(&ray);
            assert_eq!(
                surface.map(|s| (s.prim, s.distance)),
                hit.map(|h| (h.prim, h.t))
            );
            if let Some(surface) = surface {
                assert_eq!(surface.is_front, surface.normal.dot(ray.dir) < 0.0);
                seen.insert(view.scene.object(surface.prim).label.clone());
                let material = view.scene.material(surface.prim);
                let albedo = match material.mirror {
                    m if m >= 1.0 => material.mirror_color,
                    _ => material.albedo,
                };
                assert_eq!(surface.albedo, albedo);
            }
        }
        assert!(seen.len() > 3, "{seen:?}");
        let rays = rect.pixels().map(|pixel| view.camera.ray(pixel, [0.0; 2]));
        let traversals: Vec<_> = rays.map(|ray| view.scene.traversal(&ray)).collect();
        assert_eq!(view.traversals(rect), traversals);
    }
}
