//! One number for all that decides a picture: views of the same fingerprint take the same
//! samples. It is of contents, not of names and files: the same scene from another folder, with
//! materials renamed, or under another accelerator has the same.

use std::collections::HashMap;
use std::sync::Arc;

use glam::{Vec2, Vec3};
use twox_hash::XxHash3_128;

use crate::geometry::Primitives;
use crate::material::Material;
use crate::render::View;
use crate::settings::RenderSettings;

/// Of a view: scene, camera and settings.
pub(crate) fn of(view: &View) -> u128 {
    let mut digest = Digest(XxHash3_128::new());
    // Whoever adds a field has to say here whether it decides the picture.
    let RenderSettings {
        width,
        height,
        samples: _,
        depth,
        filter,
        method,
        accel: _,
        sampler,
        seed,
        full_model: _,
    } = view.settings;
    digest.integers([width, height, depth]);
    for name in [filter.kind.name(), method.name(), sampler.name()] {
        digest.bytes(name.as_bytes());
    }
    digest.integers([filter.radius.to_bits(), seed as u32, (seed >> 32) as u32]);
    digest.floats(view.camera.numbers());

    let Primitives {
        triangles,
        triangle_uvs,
        quads,
        spheres,
        slots,
    } = view.scene.primitives();
    digest.list(triangles.iter(), |digest, t| digest.vectors(t));
    digest.list(triangle_uvs, |digest, uvs| {
        digest.floats(uvs.iter().flat_map(Vec2::to_array));
    });
    digest.list(quads, |digest, q| digest.vectors(q.corners()));
    digest.list(spheres, |digest, s| {
        digest.vectors([s.center]);
        digest.floats([s.radius]);
    });
    digest.list(slots, |digest, slot| digest.integers([*slot]));
    let mut textures = HashMap::new();
    digest.list(view.scene.materials(), |digest, material| {
        let Material {
            albedo,
            texture,
            mirror,
            mirror_color,
            glass,
            emission,
        } = material;
        digest.vectors([*albedo, *mirror_color, *emission]);
        digest.floats([*mirror]);
        digest.list(glass.as_slice(), |digest, ior| digest.floats([*ior]));
        digest.list(texture.as_slice(), |digest, texture| {
            let hash = textures.entry(Arc::as_ptr(texture)).or_insert_with(|| {
                let (size, texels) = texture.content();
                (size, XxHash3_128::oneshot(texels.as_flattened()))
            });
            digest.integers(hash.0);
            digest.0.write(&hash.1.to_le_bytes());
        });
    });
    digest.vectors([view.scene.background()]);
    digest.0.finish_128()
}

/// A hash of numbers, the same on every machine.
struct Digest(XxHash3_128);

impl Digest {
    fn integers<const N: usize>(&mut self, values: [u32; N]) {
        for value in values {
            self.0.write(&value.to_le_bytes());
        }
    }

    fn floats(&mut self, values: impl IntoIterator<Item = f32>) {
        for value in values {
            self.integers([value.to_bits()]);
        }
    }

    fn vectors<const N: usize>(&mut self, values: [Vec3; N]) {
        self.floats(values.iter().flat_map(Vec3::to_array));
    }

    /// With its length, so that no two lists in a row look like two others.
    fn list<T>(
        &mut self,
        items: impl IntoIterator<Item = T, IntoIter: ExactSizeIterator>,
        mut item: impl FnMut(&mut Self, T),
    ) {
        let items = items.into_iter();
        self.0.write(&(items.len() as u64).to_le_bytes());
        for x in items {
            item(self, x);
        }
    }

    fn bytes(&mut self, bytes: &[u8]) {
        self.list(bytes, |digest, byte| digest.0.write(&[*byte]));
    }
}
