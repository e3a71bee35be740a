//! Materials as the integrator sees them.

use std::sync::Arc;

use glam::{Vec2, Vec3};

use crate::bsdf::Bsdf;
use crate::texture::Texture;

/// A surface's scattering and emission.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Material {
    /// Diffuse reflectance, before the texture.
    pub albedo: Vec3,
    /// Multiplies `albedo`.
    pub texture: Option<Arc<Texture>>,
    /// Share of mirror in the blend, 0 to 1.
    pub mirror: f32,
    /// Reflectance of the mirror part.
    pub mirror_color: Vec3,
    /// Index of refraction of clear glass; overrides the above.
    pub glass: Option<f32>,
    /// Radiance emitted from the front, W/(m²·sr).
    pub emission: Vec3,
}

impl Material {
    /// Scattering at texture coordinates `uv` (asked for only if there is a texture).
    pub(crate) fn bsdf(&self, uv: impl FnOnce() -> Vec2) -> Bsdf {
        if let Some(ior) = self.glass {
            return Bsdf::Glass(ior);
        }
        if self.mirror >= 1.0 {
            return Bsdf::Mirror(self.mirror_color);
        }
        let albedo = match &self.texture {
            Some(texture) => self.albedo * texture.lookup(uv()),
            None => self.albedo,
        };
        if self.mirror <= 0.0 {
            return Bsdf::Diffuse(albedo);
        }
        Bsdf::Blend {
            diffuse: (1.0 - self.mirror) * albedo,
            mirror: self.mirror * self.mirror_color,
        }
    }

    /// Whether any light leaves the surface by itself.
    pub(crate) fn emits(&self) -> bool {
        self.emission != Vec3::ZERO
    }
}
