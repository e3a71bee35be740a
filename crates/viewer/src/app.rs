//! The window: a session behind, a model in hand, panels around the picture.

mod actions;
mod files;
mod habits;
mod start;

use std::path::PathBuf;

use egui::{CentralPanel, Context, Frame, Margin, Panel, ScrollArea, Ui, ViewportCommand};
use lightbox_core::SceneDesc;
use lightbox_core::scene::{BUILTIN, CameraDesc};

use crate::autopsy::AutopsyPanel;
use crate::dialogs::Dialogs;
use crate::keys::{self, Action};
use crate::model::{Model, scene_name};
use crate::panels::{self, Banners, ChartPanel, LabPanel, RacePanel};
use crate::session::{Budget, Look, Moment, Notice, Region, Session, Status};
use crate::settings::Settings;
use crate::undo::Undo;
use crate::unsaved::Unsaved;
use crate::viewport::Viewport;

pub use start::run;

/// What the whole window looks like, where that is not egui's own taste.
fn restyle(ctx: &Context) {
    // Dim, but to be read.
    ctx.all_styles_mut(|style| style.visuals.weak_text_alpha = 0.8);
    // The monospaced font has arrows and superscripts that the other lacks.
    let mut fonts = egui::FontDefinitions::default();
    let families = &mut fonts.families;
    let spare = families.get(&egui::FontFamily::Monospace).cloned();
    if let Some(family) = families.get_mut(&egui::FontFamily::Proportional) {
        family.extend(spare.unwrap_or_default());
    }
    ctx.set_fonts(fonts);
}

/// The viewer.
pub struct App {
    session: Session,
    model: Model,
    /// What the engine was told last.
    sent: (SceneDesc, Look, Budget, Option<Region>, usize),
    /// Whether it was told to rest.
    rests: bool,
    /// Whether it is to make one more pass first.
    asks_for_pass: bool,
    /// The `opened` count that the model belongs to.
    opened: u64,
    /// The file named in the window's title.
    title: PathBuf,
    is_paused: bool,
    undo: Undo<SceneDesc>,
    camera_undo: Undo<CameraDesc>,
    unsaved: Unsaved,
    viewport: Viewport,
    banners: Banners,
    dialogs: Dialogs,
    is_help_open: bool,
    is_plan_open: bool,
    lab: LabPanel,
    chart: ChartPanel,
    race: RacePanel,
    autopsy: AutopsyPanel,
    /// What the engine was asked to look back to.
    past: Option<Moment>,
    /// As of the last start; [`App::settings`] has them up to date.
    settings: Settings,
}

impl App {
    /// Starts an engine and opens a scene or mesh, or the first built-in scene. Works without a
    /// window, for tests.
    pub fn new(ctx: &Context, path: Option<PathBuf>) -> Result<Self, String> {
        let wake = ctx.clone();
        restyle(ctx);
        let model = Model::default();
        let session = Session::new(model.threads, move || wake.request_repaint())?;
        session.open(&path.unwrap_or_else(|| PathBuf::from(BUILTIN[0])));
        Ok(Self {
            session,
            sent: (
                SceneDesc::default(),
                Look::default(),
                Budget::default(),
                None,
                model.threads,
            ),
            model,
            rests: false,
            asks_for_pass: false,
            opened: 0,
            title: PathBuf::new(),
            is_paused: false,
            undo: Undo::default(),
            camera_undo: Undo::default(),
            unsaved: Unsaved::new(ctx)?,
            viewport: Viewport::default(),
            banners: Banners::default(),
            dialogs: Dialogs::default(),
            is_help_open: false,
            is_plan_open: false,
            lab: LabPanel::new(ctx),
            chart: ChartPanel::default(),
            race: RacePanel::default(),
            autopsy: AutopsyPanel::default(),
            past: None,
            settings: Settings::default(),
        })
    }

    /// The engine.
    pub fn session(&self) -> &Session {
        &self.session
    }

    /// What the user edits.
    pub fn model(&self) -> &Model {
        &self.model
    }

    /// Writes the picture, the scene as a *.toml, or the samples as a *.part, in the background.
    pub fn save(&self, path: PathBuf) {
        self.session.save(path);
    }

    /// Adds the mesh of a file to the scene, once it is read in the background.
    pub fn add_mesh(&mut self, ctx: &Context, path: PathBuf) {
        self.dialogs.measure(ctx, path);
    }

    /// Goes over to a file that was opened since.
    fn follow(&mut self, ctx: &Context, status: &Status) {
        if status.opened == self.opened {
            return;
        }
        self.opened = status.opened;
        self.is_paused = false;
        let is_same_file = status
            .scene
            .as_ref()
            .is_some_and(|s| s.path() == self.title);
        let before = self.model.desc.clone();
        if is_same_file && self.unsaved.is_any(&before) {
            let key = keys::text(ctx, &Action::Undo);
            self.say(
                ctx,
                &format!("read again without the edits; {key} brings them back"),
            );
        }
        self.model.open(&status.desc, status.tone);
        if let Some(scene) = &status.scene {
            self.model.bookmarks = self.settings.opened(scene.path());
        }
        // To read a file again is an edit that can be undone.
        if !is_same_file {
            self.undo.open(&self.model.desc);
            self.camera_undo.open(&self.model.desc.camera);
            self.viewport.gestures.is_flying = false;
        }
        self.sent.0 = (*status.desc).clone();
        self.banners.changed = None;
        self.unsaved.opened(
            status,
            is_same_file.then_some(&before),
            &mut self.model.desc,
        );
    }

    /// Names the scene in the window's title.
    fn entitle(&mut self, ctx: &Context, status: &Status) {
        let Some(scene) = &status.scene else { return };
        if self.title != scene.path() {
            self.title = scene.path().to_owned();
            let title = format!("{} - lightbox", scene_name(&self.title));
            ctx.send_viewport_cmd(ViewportCommand::Title(title));
        }
    }

    /// Shows a picture as it was, or as it is.
    fn look_back(&mut self, ctx: &Context, past: Option<Moment>) {
        if past != self.past {
            self.past = past;
            self.session.look_back(past);
            ctx.request_repaint(); // The picture is drawn already.
        }
    }

    fn complain(&mut self, ctx: &Context, text: String) {
        let is_error = true;
        self.banners
            .add(Notice { text, is_error }, ctx.input(|i| i.time));
    }

    fn say(&mut self, ctx: &Context, text: &str) {
        let (text, is_error) = (text.to_owned(), false);
        self.banners
            .add(Notice { text, is_error }, ctx.input(|i| i.time));
    }

    /// Sends the engine what this frame has changed.
    fn send(&mut self) {
        // A race needs the whole processor.
        let rests = self.is_paused || self.race.is_running();
        if rests != self.rests {
            self.rests = rests;
            self.session.set_paused(rests);
        }
        if std::mem::take(&mut self.asks_for_pass) {
            self.session.add_pass();
        }
        let look = Look {
            tone: self.model.tone,
            aov: self.model.aov,
        };
        if look != self.sent.1 {
            self.sent.1 = look;
            self.session.set_look(look);
        }
        if self.model.budget != self.sent.2 {
            self.sent.2 = self.model.budget;
            self.session.set_budget(self.model.budget);
        }
        if self.model.region != self.sent.3 {
            self.sent.3 = self.model.region;
            self.session.prefer(self.model.region);
        }
        if self.model.threads != self.sent.4 {
            self.sent.4 = self.model.threads;
            self.session.set_threads(self.model.threads);
        }
        if self.model.desc != self.sent.0 {
            self.sent.0 = self.model.desc.clone();
            self.session.edit(self.opened, self.model.desc.clone());
        }
    }
}

impl eframe::App for App {
    fn save(&mut self, storage: &mut dyn eframe::Storage) {
        self.settings().store(storage);
    }

    fn ui(&mut self, ui: &mut Ui, _frame: &mut eframe::Frame) {
        let ctx = ui.ctx().clone();
        let status = self.session.status();
        self.follow(&ctx, &status);
        self.entitle(&ctx, &status);
        // Before anything is opened that the status does not know of.
        self.notice_changes(&ctx, &status);
        let now = ui.input(|i| i.time);
        for notice in self.session.take_notices() {
            if notice.is_error {
                self.unsaved.not_saved();
            }
            self.banners.add(notice, now);
        }
        if let Some(tone) = self.session.take_fitted_tone() {
            self.model.tone = tone;
        }
        self.take_answers(&ctx);
        self.take_drops(&ctx);

        // A number that is typed is one edit, not one for each digit.
        let is_held = self.viewport.gestures.is_gliding()
            || self.viewport.gestures.flies()
            || ctx.input(|i| i.pointer.any_down() || i.pointer.any_released())
            || ctx.text_edit_focused()
            || panels::may_be_reset(&ctx);
        self.undo.watch(&self.model.desc, is_held);
        self.camera_undo.watch(&self.model.desc.camera, is_held);
        let mut actions = keys::pressed(&ctx, self.viewport.gestures.flies());
        self.go_places(&ctx);
        Panel::bottom("status").exact_size(32.0).show(ui, |ui| {
            panels::status_bar_ui(ui, &status, self.race.is_running(), &mut actions)
        });
        Panel::right("controls")
            .default_size(310.0)
            .size_range(270.0..=480.0)
            .show(ui, |ui| {
                ScrollArea::vertical().auto_shrink(false).show(ui, |ui| {
                    // Always room for the bar: if the panel grew with it, the picture would
                    // shrink and start anew.
                    let margin = Margin {
                        right: 8,
                        ..Margin::ZERO
                    };
                    Frame::new().inner_margin(margin).show(ui, |ui| {
                        let model = &mut self.model;
                        let (can, settings) = (self.undo.can(), &self.settings);
                        panels::scene_ui(ui, model, &status, can, settings, &mut actions);
                        panels::budget_ui(ui, model, &status);
                        panels::render_ui(ui, model);
                        panels::display_ui(ui, model);
                        panels::material_ui(ui, model, &status);
                        panels::object_ui(ui, model, &status, &mut actions);
                        panels::camera_ui(ui, model, &status, &mut actions);
                        panels::window_ui(ui, model);
                        panels::follow_focus(ui);
                    });
                });
            });
        CentralPanel::default().frame(Frame::NONE).show(ui, |ui| {
            let space = ui.max_rect();
            let past = self.past.and_then(|_| self.session.past());
            let snapshot = past.or_else(|| self.session.snapshot());
            let (model, session) = (&mut self.model, &self.session);
            let seen = self
                .viewport
                .ui(ui, model, session, &status, snapshot.as_deref());
            if let Some(seen) = &seen {
                self.autopsy.follow(ui, seen, session, model);
            }
            self.autopsy.ui(ui, seen.as_ref(), session, model);
            let (compare, reference) = (&mut self.viewport.compare, status.reference.as_ref());
            compare.ui(&ctx, space, session, reference, model.tone);
            let loses = self.unsaved.is_any(&self.model.desc);
            let leaving = self.unsaved.asks_to_leave().map(|path| (path, loses));
            self.banners
                .ui(ui, space, &mut self.model, &status, leaving, &mut actions);
            let past = self
                .chart
                .ui(&ctx, space, &self.session, &status, &mut actions);
            self.look_back(&ctx, past);
        });
        self.lab.ui(&ctx, &mut actions);
        self.race.ui(&ctx, &status, &mut actions);
        if panels::plan_ui(&ctx, &mut self.is_plan_open, &mut self.model, &status) {
            self.session.measure_plan();
        }
        panels::help_ui(&ctx, &mut self.is_help_open);
        files::hovered_files(&ctx);

        for action in actions {
            self.act(&ctx, action, &status);
        }
        self.quit(&ctx, &status);
        self.send();
    }
}
