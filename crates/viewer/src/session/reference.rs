//! A picture that counts as right: with it, noise becomes true error.

use std::path::Path;
use std::sync::Arc;

use lightbox_core::{Image, SamplerKind, image_io};

use crate::saved;

/// A reference.
#[derive(Clone, Debug, PartialEq)]
pub struct Reference {
    /// Linear light.
    pub image: Arc<Image>,
    /// What to call it.
    pub name: String,
    /// The sampler and seed it was made with, where that is known. A picture made with the same has
    /// errors in common with it, and seems closer than it is.
    pub stream: Option<(SamplerKind, u64)>,
}

impl Reference {
    /// Reads a picture; the error is one line.
    pub(super) fn read(path: &Path) -> Result<Self, String> {
        if image_io::Format::of(path)? != image_io::Format::Exr {
            return Err(format!(
                "{}: a reference is linear light; choose an *.exr",
                path.display()
            ));
        }
        let image = image_io::read(path)?;
        // A picture of another program carries no scene.
        let made_by = saved::load(path).ok();
        Ok(Self {
            image: image.into(),
            name: path
                .file_name()
                .unwrap_or(path.as_os_str())
                .to_string_lossy()
                .into_owned(),
            stream: made_by.map(|(source, _)| {
                let render = source.desc.render;
                (render.sampler, render.seed)
            }),
        })
    }

    /// Pixels across and down.
    pub fn size(&self) -> [u32; 2] {
        [self.image.width, self.image.height]
    }
}
