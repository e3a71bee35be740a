//! Files that are opened, dropped, asked for and saved.

use std::path::PathBuf;

use egui::{Color32, Context};

use super::App;
use crate::dialogs::{self, OPENS};
use crate::model::scene_name;
use crate::session::{Activity, Status};
use crate::unsaved::Answer;

impl App {
    /// Opens a file, once it is clear what becomes of edits. To read the same file again is an edit
    /// that can be undone.
    pub(super) fn open(&mut self, path: PathBuf) {
        if path == self.title {
            self.unsaved.leave(Answer::Stay);
        } else if !self.unsaved.may_leave(&self.model.desc, &path) {
            return;
        }
        self.session.open(&path);
    }

    /// Goes on as the user wants edits to be treated.
    pub(super) fn leave(&mut self, ctx: &Context, answer: Answer, status: &Status) {
        match self.unsaved.leave(answer) {
            // Edits there are go, as was said.
            Some(path) if self.unsaved.is_any(&self.model.desc) => self.session.open(&path),
            Some(path) => self.open(path),
            None => {}
        }
        if answer == Answer::Save {
            self.ask_where_to_save_scene(ctx, status);
        }
    }

    pub(super) fn ask_where_to_save(
        &mut self,
        ctx: &Context,
        extension: &'static str,
        status: &Status,
    ) {
        if let Some(scene) = status.scene.as_ref().filter(|_| status.samples > 0) {
            let name = scene_name(scene.path());
            // More samples come while the dialog is open.
            let name = match status.activity {
                Activity::Rendering => format!("{name}.{extension}"),
                _ => format!("{name}-{}spp.{extension}", self.session.samples_to_save()),
            };
            self.dialogs.save(ctx, &name, extension);
        } else {
            self.complain(ctx, "there is no picture to save yet".into());
        }
    }

    pub(super) fn ask_where_to_save_scene(&mut self, ctx: &Context, status: &Status) {
        if self.dialogs.is_open() {
            // What is to follow would wait for that one, whatever it is about.
            self.unsaved.not_saved();
            let text = "a file dialog is open already; answer that first";
            return self.complain(ctx, text.into());
        }
        if let Some(scene) = &status.scene {
            let name = format!("{}.toml", scene_name(scene.path()));
            self.dialogs.save(ctx, &name, "toml");
        }
    }

    pub(super) fn take_answers(&mut self, ctx: &Context) {
        match self.dialogs.answer() {
            Some(dialogs::Answer::Open(path)) => self.open(path),
            Some(dialogs::Answer::Save(path)) => self.save(path),
            Some(dialogs::Answer::Reference(path)) => self.session.load_reference(path),
            Some(dialogs::Answer::Race(folder)) => self.race.save(ctx, folder),
            Some(dialogs::Answer::Mesh(file, bounds)) => {
                if let Some(scene) = self.session.status().scene {
                    self.model.add_mesh(&scene, file, &bounds);
                }
            }
            Some(dialogs::Answer::Unavailable(text)) => self.complain(ctx, text),
            Some(dialogs::Answer::Cancelled) => self.unsaved.not_saved(),
            None => {}
        }
    }

    pub(super) fn take_drops(&mut self, ctx: &Context) {
        let dropped = ctx.input_mut(|i| std::mem::take(&mut i.raw.dropped_files));
        // One window shows one scene.
        let Some(file) = dropped.last() else { return };
        let path = file.path();
        let known = OPENS
            .iter()
            .any(|e| path.extension().is_some_and(|x| x.eq_ignore_ascii_case(e)));
        if known {
            self.open(path.to_owned());
        } else {
            self.complain(
                ctx,
                format!(
                    "{}: not a scene; drop a .toml scene, an .obj mesh or a saved picture",
                    path.display()
                ),
            );
        }
    }
}

/// Says what will happen to a file held over the window.
pub(super) fn hovered_files(ctx: &Context) {
    let name = ctx.input(|i| {
        let file = i.raw.hovered_files.last()?;
        Some(
            file.path
                .as_ref()
                .and_then(|p| p.file_name())
                .map(|n| n.to_string_lossy().into_owned()),
        )
    });
    let Some(name) = name else { return };
    let layer = egui::LayerId::new(egui::Order::Foreground, egui::Id::unique("hovered files"));
    let (painter, window) = (ctx.layer_painter(layer), ctx.content_rect());
    painter.rect_filled(window, 0.0, Color32::from_black_alpha(190));
    let text = match name {
        Some(name) => format!("Drop to open {name}"),
        None => "Drop a scene, a mesh or a saved picture to open it".into(),
    };
    let font = egui::FontId::proportional(24.0);
    painter.text(
        window.center(),
        egui::Align2::CENTER_CENTER,
        text,
        font,
        Color32::WHITE,
    );
}
