//! Saving the picture in the making.

use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use lightbox_core::color::ToneMap;
use lightbox_core::image_io::{self, check_writable};
use lightbox_core::scene::CameraDesc;
use lightbox_core::{Film, SceneDesc, View};

use crate::saved;

/// The picture being made, for saving.
#[derive(Clone)]
pub(super) struct Shown {
    pub view: View,
    /// What `view` was made from.
    pub camera: CameraDesc,
    pub film: Arc<Film>,
    pub is_edited: bool,
}

impl Shown {
    /// Writes the picture as it is now, tiles that lag behind brought up to the others.
    pub fn write(&self, path: &Path, tone: ToneMap) -> Result<(), String> {
        check_writable(path)?;
        let film = (*self.film).clone();
        let samples = film.most_samples().max(1);
        self.view.render(&film, samples, &AtomicBool::new(false));
        let scene = &self.view.scene;
        let desc = SceneDesc {
            camera: self.camera,
            render: self.view.settings,
            ..scene.desc().clone()
        };
        // Of edits, only the picture itself knows.
        let named = if self.is_edited { path } else { scene.path() };
        let mut line = crate::replay::line(named, &desc, samples);
        line.push_str(&crate::replay::tone_options(tone));
        let text = saved::text(&line, desc, samples, scene.path(), tone);
        image_io::write(path, &film.develop(), tone, &text)
    }
}
