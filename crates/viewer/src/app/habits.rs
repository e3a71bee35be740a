//! What the window remembers, watches and asks: settings, bookmarks, files that change on disk, edits
//! that would be lost.

use egui::Context;

use super::App;
use crate::bookmarks::{self, Wish};
use crate::panels;
use crate::session::Status;
use crate::settings::Settings;
use crate::unsaved::Answer;
use crate::workers;

impl App {
    /// Goes on as it was left the last time.
    pub fn remembering(mut self, settings: Settings) -> Self {
        self.chart.is_open = settings.is_chart_open;
        self.is_plan_open = settings.is_plan_open;
        self.model.free_orbit = settings.free_orbit;
        if settings.threads > 0 {
            self.model.threads = settings.threads.min(workers::cores());
        }
        self.viewport.gestures.is_known = settings.is_acquainted;
        self.settings = settings;
        self
    }

    /// What is to be remembered.
    pub fn settings(&self) -> Settings {
        Settings {
            is_acquainted: self.viewport.gestures.is_known,
            is_chart_open: self.chart.is_open,
            is_plan_open: self.is_plan_open,
            free_orbit: self.model.free_orbit,
            threads: match self.model.threads {
                n if n == workers::usual() => 0,
                n => n,
            },
            ..self.settings.clone()
        }
    }

    /// Goes to a bookmark or to a pasted camera, or sets a bookmark.
    pub(super) fn go_places(&mut self, ctx: &Context) {
        let place = self.viewport.gestures.destination(&self.model);
        match self.model.bookmarks.pressed(ctx, &place) {
            Some(Wish::Go(to)) => self.viewport.gestures.glide(ctx, &self.model, to),
            Some(Wish::Set(digit)) => {
                self.settings.keep(self.model.bookmarks);
                self.say(ctx, &format!("{digit} brings the camera back here"));
            }
            Some(Wish::Missing(digit)) => {
                let text = format!("bookmark {digit} is empty; Ctrl+{digit} sets it");
                self.say(ctx, &text);
            }
            None => {}
        }
        match bookmarks::pasted(ctx) {
            Some(Ok(to)) => self.viewport.gestures.glide(ctx, &self.model, to),
            Some(Err(text)) => self.complain(ctx, text),
            None => {}
        }
    }

    /// Reads a file again that was changed on disk, or offers to where edits would be lost.
    pub(super) fn notice_changes(&mut self, ctx: &Context, status: &Status) {
        if self.unsaved.is_in_two_minds(&self.model.desc, status) {
            self.session.cancel_opening();
        }
        if let Some(saved) = self.session.take_saved()
            && let Some(path) = self.unsaved.saved(&saved, status)
        {
            self.open(path);
        }
        let Some(path) = self.unsaved.changed_on_disk() else {
            return;
        };
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        if self.unsaved.is_any(&self.model.desc) {
            self.banners.changed = Some(name.into_owned());
        } else if let Some(scene) = &status.scene {
            self.say(ctx, &format!("{name} was changed on disk and read again"));
            self.unsaved.keeps_view();
            self.session.open(scene.path());
        }
    }

    /// Asks what becomes of edits where the window is to close.
    pub(super) fn quit(&mut self, ctx: &Context, status: &Status) {
        if !self.unsaved.holds_back(ctx, &self.model.desc) {
            return;
        }
        if let Some(answer) = panels::quit_ui(ctx) {
            self.unsaved.answered(answer);
            if answer == Answer::Save {
                self.ask_where_to_save_scene(ctx, status);
            }
            ctx.request_repaint();
        }
    }
}
