//! What the scene has that its file has not, and the other way round: edits that would be lost by
//! quitting, and files that another program has changed.

use std::path::PathBuf;
use std::sync::Arc;

use egui::{Context, ViewportCommand};
use lightbox_core::SceneDesc;

use crate::session::Status;
use crate::watch::Watch;

/// The scene as some file has it, and the files it was read from.
pub struct Unsaved {
    /// As opened, or as saved since.
    kept: Arc<SceneDesc>,
    watch: Watch,
    /// Whether camera and settings survive the next reading of the file.
    keeps_view: bool,
    quitting: Quitting,
}

/// How far it is with the end.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
enum Quitting {
    #[default]
    No,
    /// The user is asked what becomes of the edits.
    Asking,
    /// Once the scene is saved.
    WhenSaved,
    /// Whatever is lost.
    Now,
}

/// What the user answers to the question what becomes of the edits.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Answer {
    /// They are saved first.
    Save,
    /// They are lost.
    Drop,
    /// The window stays.
    Stay,
}

impl Unsaved {
    /// Nothing yet.
    pub fn new(ctx: &Context) -> Result<Self, String> {
        let ctx = ctx.clone();
        Ok(Self {
            kept: Arc::default(),
            watch: Watch::new(move || ctx.request_repaint())?,
            keeps_view: false,
            quitting: Quitting::default(),
        })
    }

    /// A file was opened. If it was `before` and has changed on disk, the camera and the settings
    /// that differed from it stay as they are: `desc` gets them.
    pub fn opened(&mut self, status: &Status, before: Option<&SceneDesc>, desc: &mut SceneDesc) {
        let keeps_view = std::mem::take(&mut self.keeps_view);
        if let Some(before) = before.filter(|_| keeps_view) {
            if before.camera != self.kept.camera {
                desc.camera = before.camera;
            }
            if before.render != self.kept.render {
                desc.render = before.render;
            }
        }
        self.kept = status.desc.clone();
        self.follow(status);
    }

    /// The scene was written to a file.
    pub fn saved(&mut self, desc: &Arc<SceneDesc>, status: &Status) {
        self.kept = desc.clone();
        // What was written just now is not another program's.
        self.follow(status);
        if self.quitting == Quitting::WhenSaved {
            self.quitting = Quitting::Now;
        }
    }

    fn follow(&self, status: &Status) {
        let Some(scene) = &status.scene else { return };
        let path = scene.path().to_owned();
        let desc = self.kept.detached(&path);
        let meshes = desc.meshes.into_iter().filter_map(|m| m.file);
        let textures = desc.materials.into_iter().filter_map(|m| m.texture);
        let files = [path].into_iter().chain(meshes).chain(textures);
        // What is built in does not change.
        self.watch.follow(files.filter(|f| f.exists()).collect());
    }

    /// A file that another program has changed.
    pub fn changed_on_disk(&self) -> Option<PathBuf> {
        self.watch.changed()
    }

    /// Whether there are edits, the camera and the settings aside, that no file has.
    pub fn is_any(&self, desc: &SceneDesc) -> bool {
        let kept = &*self.kept;
        (&desc.materials, desc.background) != (&kept.materials, kept.background)
            || (&desc.spheres, &desc.quads, &desc.meshes)
                != (&kept.spheres, &kept.quads, &kept.meshes)
    }

    /// The file is read again: what differs in camera and settings shall stay.
    pub fn keeps_view(&mut self) {
        self.keeps_view = true;
    }

    /// Keeps the window open where edits would be lost; says whether the user is to be asked.
    pub fn holds_back(&mut self, ctx: &Context, desc: &SceneDesc) -> bool {
        if self.quitting == Quitting::Now {
            ctx.send_viewport_cmd(ViewportCommand::Close);
        } else if ctx.input(|i| i.viewport().close_requested()) && self.is_any(desc) {
            ctx.send_viewport_cmd(ViewportCommand::CancelClose);
            self.quitting = Quitting::Asking;
        }
        self.quitting == Quitting::Asking
    }

    /// Saving failed, or the user thought better of it.
    pub fn not_saved(&mut self) {
        if self.quitting == Quitting::WhenSaved {
            self.quitting = Quitting::No;
        }
    }

    /// The user's answer.
    pub fn answered(&mut self, answer: Answer) {
        self.quitting = match answer {
            Answer::Save => Quitting::WhenSaved,
            Answer::Drop => Quitting::Now,
            Answer::Stay => Quitting::No,
        };
    }
}
