//! Images on surfaces: decoded once to linear light, looked up bilinearly, repeated.

use glam::{Vec2, Vec3};

use crate::color::linear_from_srgb;

/// An image in linear sRGB.
#[derive(Debug)]
pub struct Texture {
    width: u32,
    height: u32,
    /// Row by row from the top, as stored in the file: 8 bits, sRGB.
    texels: Vec<[u8; 3]>,
}

impl Texture {
    /// Decodes an image file; the error says what to use instead.
    pub(crate) fn decode(bytes: &[u8]) -> Result<Self, String> {
        let image = image::load_from_memory(bytes)
            .map_err(|e| format!("cannot be decoded as an image ({e}); use PNG, JPEG, TGA or BMP"))?
            .into_rgb8();
        let (width, height) = image.dimensions();
        if width == 0 || height == 0 {
            return Err("is an image without pixels".into());
        }
        Ok(Self {
            width,
            height,
            texels: image.pixels().map(|p| p.0).collect(),
        })
    }

    /// Reflectance at texture coordinates `uv`, whose origin is the image's lower left corner.
    pub(crate) fn lookup(&self, uv: Vec2) -> Vec3 {
        // Wrapped first, so that far-out coordinates keep what precision they have.
        let wrap = |x: f32| if x.is_finite() { x - x.floor() } else { 0.0 };
        let x = wrap(uv.x) * self.width as f32 - 0.5;
        let y = (1.0 - wrap(uv.y)) * self.height as f32 - 0.5;
        let (x0, y0) = (x.floor(), y.floor());
        let (fx, fy) = (x - x0, y - y0);
        let texel = |dx: i64, dy: i64| {
            let i = (x0 as i64 + dx).rem_euclid(i64::from(self.width)) as usize;
            let j = (y0 as i64 + dy).rem_euclid(i64::from(self.height)) as usize;
            let [r, g, b] = self.texels[j * self.width as usize + i];
            Vec3::new(
                linear_from_srgb(r),
                linear_from_srgb(g),
                linear_from_srgb(b),
            )
        };
        let top = texel(0, 0).lerp(texel(1, 0), fx);
        let bottom = texel(0, 1).lerp(texel(1, 1), fx);
        top.lerp(bottom, fy)
    }

    /// All that decides its look: size and texels.
    pub(crate) fn content(&self) -> ([u32; 2], &[[u8; 3]]) {
        ([self.width, self.height], &self.texels)
    }

    /// Bytes held.
    pub(crate) fn bytes(&self) -> usize {
        self.texels.len() * 3
    }
}
