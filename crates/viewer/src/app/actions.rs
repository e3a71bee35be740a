//! What keys and buttons do.

use egui::{Context, ViewportCommand};
use glam::Vec3;

use super::App;
use crate::aov::Aov;
use crate::keys::Action;
use crate::session::{Activity, Status};
use crate::{bookmarks, flight, orbit};

/// Stops by which a key changes the exposure.
const EXPOSURE_STEP: f32 = 0.5;

/// Share of white by which a key changes the offset.
const OFFSET_STEP: f32 = 0.1;

impl App {
    pub(super) fn act(&mut self, ctx: &Context, action: Action, status: &Status) {
        match action {
            Action::Open => self.dialogs.open(ctx),
            Action::OpenPath(path) => self.open(path),
            Action::Leave(answer) => self.leave(ctx, answer, status),
            Action::CancelOpening => self.session.cancel_opening(),
            Action::Reload => {
                if let Some(scene) = &status.scene {
                    self.open(scene.path().to_owned());
                }
            }
            Action::SavePng => self.ask_where_to_save(ctx, "png", status),
            Action::SaveExr => self.ask_where_to_save(ctx, "exr", status),
            Action::SaveSamples => self.ask_where_to_save(ctx, "part", status),
            Action::Pause
                if !self.race.is_running()
                    && matches!(status.activity, Activity::Rendering | Activity::Paused) =>
            {
                self.is_paused = !self.is_paused;
            }
            Action::Pause => {}
            Action::Pass if self.race.is_running() => {}
            Action::Pass if status.activity == Activity::Done => {
                self.say(ctx, "the picture is done; Budget asks for more of it");
            }
            Action::Pass => {
                self.is_paused = true;
                self.asks_for_pass = true;
            }
            Action::Frame => self.frame(ctx, status),
            Action::Home => self
                .viewport
                .gestures
                .glide(ctx, &self.model, self.model.file.camera),
            Action::CameraBack => {
                self.viewport.gestures.halt();
                self.camera_undo.undo(&mut self.model.desc.camera);
            }
            Action::CameraOn => {
                self.viewport.gestures.halt();
                self.camera_undo.redo(&mut self.model.desc.camera);
            }
            Action::ViewFrom(axis) => {
                let direction = Vec3::from(axis.map(f32::from));
                let from = self.viewport.gestures.destination(&self.model);
                let to = flight::seen_from(&from, direction);
                self.viewport.gestures.glide(ctx, &self.model, to);
            }
            Action::Fly => {
                let is_flying = &mut self.viewport.gestures.is_flying;
                *is_flying = !*is_flying;
            }
            Action::FreeOrbit => self.model.toggle_free_orbit(),
            Action::CopyCamera => {
                ctx.copy_text(bookmarks::text(&self.model.desc.camera));
                self.say(
                    ctx,
                    "the camera is in the clipboard as text; Ctrl+V takes it up",
                );
            }
            Action::CopyPicture => self.copy_picture(ctx),
            Action::Brighter => self.expose(EXPOSURE_STEP),
            Action::Darker => self.expose(-EXPOSURE_STEP),
            Action::Raise => self.offset(OFFSET_STEP),
            Action::Lower => self.offset(-OFFSET_STEP),
            Action::FitTone => self.session.fit_tone(),
            Action::ResetTone => {
                let tone = &mut self.model.tone;
                (tone.exposure, tone.offset) = (0.0, 0.0);
            }
            Action::SaveScene => self.ask_where_to_save_scene(ctx, status),
            Action::Undo => {
                self.viewport.gestures.halt();
                self.undo.undo(&mut self.model.desc);
            }
            Action::Redo => {
                self.viewport.gestures.halt();
                self.undo.redo(&mut self.model.desc);
            }
            // Once more, it goes back to the light.
            Action::Show(aov) if self.model.aov == aov => self.model.aov = Aov::COLOR,
            Action::Show(aov) => self.model.aov = aov,
            Action::Duplicate => {
                if let Some(scene) = &status.scene {
                    self.model.duplicate(scene);
                }
            }
            Action::Delete => self.model.delete(),
            Action::AddMesh => self.dialogs.mesh(ctx),
            Action::Help => self.is_help_open = !self.is_help_open,
            Action::Lab => self.lab.is_open = !self.lab.is_open,
            Action::Chart => self.chart.is_open = !self.chart.is_open,
            Action::Race => self.race.is_open = !self.race.is_open,
            Action::SaveRace => self.dialogs.race(ctx),
            Action::Reference => self.dialogs.reference(ctx),
            Action::Keep if status.samples > 0 => self.viewport.compare.keep(&self.session),
            Action::Keep => self.complain(ctx, "there is no picture to keep yet".into()),
            Action::Strip => self.viewport.compare.toggle_strip(),
            Action::Compare(_) | Action::Glance
                if status.reference.is_none() && !self.viewport.compare.is_keeping() =>
            {
                let text = "nothing to compare with yet: K keeps this picture";
                self.complain(ctx, text.into());
            }
            Action::Compare(mode) => self.viewport.compare.toggle(mode),
            Action::Glance => {} // As long as the key is held.
            Action::Zoom(closer) => {
                self.viewport.zoom.by(if closer { 2.0 } else { 0.5 });
                ctx.request_repaint(); // The picture is drawn already.
            }
            Action::ZoomAll => {
                self.viewport.zoom.reset();
                ctx.request_repaint();
            }
            Action::Invalid => self.show_invalid(ctx),
            Action::Autopsy => {
                self.autopsy.ask();
                ctx.request_repaint(); // It is followed up with the picture.
            }
            Action::Escape if self.is_help_open => self.is_help_open = false,
            Action::Escape if self.lab.is_open => self.lab.is_open = false,
            Action::Escape if self.race.is_open => self.race.is_open = false,
            Action::Plan => self.is_plan_open = !self.is_plan_open,
            Action::Escape if self.is_plan_open => self.is_plan_open = false,
            Action::Escape if self.chart.is_open => self.chart.is_open = false,
            Action::Escape if self.autopsy.is_open => self.autopsy.is_open = false,
            Action::Escape if self.viewport.gestures.is_flying => {
                self.viewport.gestures.is_flying = false;
            }
            Action::Escape => self.model.selection = None,
            Action::Quit => ctx.send_viewport_cmd(ViewportCommand::Close),
        }
    }

    /// As it is shown, without what is drawn over it.
    fn copy_picture(&mut self, ctx: &Context) {
        let past = self.past.and_then(|_| self.session.past());
        match past.or_else(|| self.session.snapshot()) {
            Some(shown) if shown.size == shown.picture => {
                let [width, height] = shown.size;
                ctx.copy_image(shown.patches.whole());
                let text = format!("the picture, {width} × {height} px, is in the clipboard");
                self.say(ctx, &text);
            }
            _ => self.complain(ctx, "there is no picture to copy yet".into()),
        }
    }

    /// Where the first sample was that is no number.
    fn show_invalid(&mut self, ctx: &Context) {
        let film = self.session.film();
        let Some((film, first)) = film.and_then(|f| Some((f.size(), *f.invalid().1.first()?)))
        else {
            return;
        };
        self.model.aov = Aov::INVALID;
        let share = |i: usize| (first.pixel[i] as f32 + 0.5) / film[i] as f32;
        self.viewport.zoom.show([share(0), share(1)].into());
        let [x, y] = first.pixel;
        let text = format!(
            "the first is sample {} of pixel {x}, {y}; 0 shows all of the picture",
            first.sample
        );
        self.say(ctx, &text);
    }

    fn expose(&mut self, stops: f32) {
        self.model.tone.exposure = (self.model.tone.exposure + stops).clamp(-10.0, 10.0);
    }

    fn offset(&mut self, by: f32) {
        // Tenths, so that as many steps back lead to zero.
        let offset = ((self.model.tone.offset + by) * 10.0).round() / 10.0;
        self.model.tone.offset = offset.clamp(-1.0, 1.0);
    }

    fn frame(&mut self, ctx: &Context, status: &Status) {
        let Some(scene) = &status.scene else { return };
        let selected = self.model.selection.and_then(|s| s.object(scene));
        let bounds = selected.map_or_else(|| scene.geometry().bounds(), |object| object.placed);
        let settings = &self.model.desc.render;
        let aspect = settings.width as f32 / settings.height as f32;
        let to = orbit::framed(
            &self.viewport.gestures.destination(&self.model),
            &bounds,
            aspect,
        );
        self.viewport.gestures.glide(ctx, &self.model, to);
    }
}
