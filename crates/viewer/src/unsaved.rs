//! What the scene has that its file has not, and the other way round: edits that would be lost by
//! quitting or by going over to another file, and files that another program has changed.

use std::path::{Path, PathBuf};
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
    leaving: Leaving,
}

/// How far it is with going over to another file.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
enum Leaving {
    #[default]
    No,
    /// It is being opened; there were no edits when that began.
    Opening(PathBuf),
    /// The user is asked what becomes of the edits.
    Asking(PathBuf),
    /// Once the scene is saved.
    WhenSaved(PathBuf),
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
            leaving: Leaving::default(),
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
        self.leaving = Leaving::No;
        self.follow(status);
    }

    /// The scene was written to a file; which file was to be opened once it is.
    pub fn saved(&mut self, desc: &Arc<SceneDesc>, status: &Status) -> Option<PathBuf> {
        self.kept = desc.clone();
        // What was written just now is not another program's.
        self.follow(status);
        if self.quitting == Quitting::WhenSaved {
            self.quitting = Quitting::Now;
        }
        match std::mem::take(&mut self.leaving) {
            Leaving::WhenSaved(path) => Some(path),
            other => {
                self.leaving = other;
                None
            }
        }
    }

    /// Another file is asked for: whether that can be opened, or whether the user is to be asked
    /// first what becomes of the edits.
    pub fn may_leave(&mut self, desc: &SceneDesc, path: &Path) -> bool {
        let may = !self.is_any(desc);
        let path = path.to_owned();
        self.leaving = if may {
            Leaving::Opening(path)
        } else {
            Leaving::Asking(path)
        };
        may
    }

    /// Whether edits have come while another file is being opened: then the user is to be asked.
    pub fn is_in_two_minds(&mut self, desc: &SceneDesc, status: &Status) -> bool {
        let Leaving::Opening(path) = &self.leaving else {
            return false;
        };
        let is_opening = status.opening.is_some();
        let asks = is_opening && self.is_any(desc);
        if asks {
            self.leaving = Leaving::Asking(path.clone());
        } else if !is_opening {
            self.leaving = Leaving::No; // It was refused, or cancelled.
        }
        asks
    }

    /// The file of which the user is asked whether it is opened at the cost of the edits.
    pub fn asks_to_leave(&self) -> Option<&Path> {
        match &self.leaving {
            Leaving::Asking(path) => Some(path),
            _ => None,
        }
    }

    /// The user's answer to that; the file, if it is to be opened at once.
    pub fn leave(&mut self, answer: Answer) -> Option<PathBuf> {
        let Leaving::Asking(path) = std::mem::take(&mut self.leaving) else {
            return None;
        };
        match answer {
            Answer::Save => self.leaving = Leaving::WhenSaved(path),
            Answer::Drop => return Some(path),
            Answer::Stay => {}
        }
        None
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
        // The question stands again, as it did.
        if let Leaving::WhenSaved(path) = &self.leaving {
            self.leaving = Leaving::Asking(path.clone());
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn another_file_waits_until_the_scene_is_saved() {
        let mut unsaved = Unsaved::new(&Context::default()).unwrap();
        let (kept, other) = (SceneDesc::default(), Path::new("other.toml"));
        assert!(unsaved.may_leave(&kept, other));
        let mut edited = kept;
        edited.background.x += 1.0;
        assert!(!unsaved.may_leave(&edited, other));
        assert_eq!(unsaved.asks_to_leave(), Some(other));
        assert_eq!(unsaved.leave(Answer::Save), None);
        assert_eq!(unsaved.asks_to_leave(), None);
        unsaved.not_saved();
        assert_eq!(
            unsaved.asks_to_leave(),
            Some(other),
            "the dialog was cancelled"
        );
        assert_eq!(unsaved.leave(Answer::Save), None);
        let status = Status::default();
        let opens = unsaved.saved(&Arc::new(edited.clone()), &status);
        assert_eq!(opens.as_deref(), Some(other));
        assert!(unsaved.may_leave(&edited, other));
        let again = unsaved.saved(&Arc::new(edited), &status);
        assert_eq!(again, None, "to save is not to leave");
    }
}
