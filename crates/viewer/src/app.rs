//! The window: a session behind, a model in hand, panels around the picture.

mod habits;

use std::path::PathBuf;

use egui::{CentralPanel, Color32, Context, Frame, Margin, Panel, ScrollArea, Ui, ViewportCommand};
use glam::Vec3;
use lightbox_core::SceneDesc;
use lightbox_core::scene::{BUILTIN, CameraDesc};

use crate::aov::Aov;
use crate::autopsy::AutopsyPanel;
use crate::bookmarks;
use crate::commands::INTERRUPTED;
use crate::dialogs::{Answer, Dialogs, OPENS};
use crate::flight;
use crate::keys::{self, Action};
use crate::model::{Model, scene_name};
use crate::orbit;
use crate::panels::{self, Banners, ChartPanel, LabPanel, RacePanel};
use crate::session::{Activity, Budget, Look, Moment, Notice, Region, Session, Status};
use crate::settings::Settings;
use crate::undo::Undo;
use crate::unsaved::Unsaved;
use crate::viewport::Viewport;

/// Stops by which a key changes the exposure.
const EXPOSURE_STEP: f32 = 0.5;

/// Share of white by which a key changes the offset.
const OFFSET_STEP: f32 = 0.1;

/// The window's icon: `dist/lightbox.svg` at 128×128 (`rsvg-convert -w 128`).
const ICON: &[u8] = include_bytes!("icon.png");

/// What to do where no window can be opened.
const WITHOUT_WINDOW: &str = "use `lightbox render SCENE -o OUT.png` instead";

/// Opens the window on a scene or mesh, or on the first built-in scene, until the user closes it.
/// The error is one line that names what to use where there is no display.
pub fn run(path: Option<PathBuf>) -> Result<(), String> {
    if !has_display() {
        return Err(format!(
            "there is no display to open a window on; {WITHOUT_WINDOW}"
        ));
    }
    let icon = eframe::icon_data::from_png_bytes(ICON).expect("the icon is a PNG");
    let viewport = egui::ViewportBuilder::default()
        .with_title("lightbox")
        .with_app_id("lightbox")
        .with_icon(icon)
        .with_inner_size([1280.0, 720.0])
        .with_min_inner_size([640.0, 400.0])
        .with_drag_and_drop(true);
    let options = eframe::NativeOptions {
        viewport,
        ..Default::default()
    };
    let create: eframe::AppCreator<'_> = Box::new(|context| {
        let settings = Settings::load(context.storage);
        let app = App::new(&context.egui_ctx, path)?.remembering(settings);
        let end = app.session.ender();
        ctrlc::set_handler(move || {
            end();
            #[expect(
                clippy::disallowed_methods,
                reason = "a window out of sight draws nothing, and never comes back to main"
            )]
            std::process::exit(INTERRUPTED.into());
        })?;
        Ok(Box::new(app))
    });
    eframe::run_native("lightbox", options, create).map_err(|e| {
        // What comes before the last colon names places in somebody's source code.
        let text = e.to_string();
        let reason = text.lines().last().unwrap_or_default();
        let reason = reason
            .rsplit(": ")
            .next()
            .unwrap_or_default()
            .trim_end_matches(')');
        format!("cannot open a window ({reason}); {WITHOUT_WINDOW}")
    })
}

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

/// Whether a display server is named; only where there may be none.
fn has_display() -> bool {
    let named = |name| std::env::var_os(name).is_some_and(|v| !v.is_empty());
    cfg!(not(all(unix, not(target_vendor = "apple"))))
        || named("DISPLAY")
        || named("WAYLAND_DISPLAY")
}

/// The viewer.
pub struct App {
    session: Session,
    model: Model,
    /// What the engine was told last.
    sent: (SceneDesc, Look, Budget, Option<Region>),
    /// Whether it was told to rest.
    rests: bool,
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
        // On a large machine, one thread in eight stays free for the window and the desktop.
        let threads = std::thread::available_parallelism().map_or(1, |n| n.get() - n.get() / 8);
        let session = Session::new(threads, move || wake.request_repaint())?;
        session.open(&path.unwrap_or_else(|| PathBuf::from(BUILTIN[0])));
        Ok(Self {
            session,
            model: Model::default(),
            sent: Default::default(),
            rests: false,
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

    fn act(&mut self, ctx: &Context, action: Action, status: &Status) {
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
            Action::Frame => self.frame(ctx, status),
            Action::Home => self
                .viewport
                .gestures
                .glide(ctx, &self.model, self.model.file_camera),
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
            Action::Compare(_)
                if status.reference.is_none() && !self.viewport.compare.is_keeping() =>
            {
                let text = "nothing to compare with yet: K keeps this picture";
                self.complain(ctx, text.into());
            }
            Action::Compare(mode) => self.viewport.compare.toggle(mode),
            Action::Zoom(closer) => {
                self.viewport.zoom.by(if closer { 2.0 } else { 0.5 });
                ctx.request_repaint(); // The picture is drawn already.
            }
            Action::ZoomAll => {
                self.viewport.zoom.reset();
                ctx.request_repaint();
            }
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
        let bounds = selected.map_or_else(
            || scene.geometry().bounds(),
            |object| scene.object_bounds(object),
        );
        let settings = &self.model.desc.render;
        let aspect = settings.width as f32 / settings.height as f32;
        let to = orbit::framed(
            &self.viewport.gestures.destination(&self.model),
            &bounds,
            aspect,
        );
        self.viewport.gestures.glide(ctx, &self.model, to);
    }

    fn ask_where_to_save(&mut self, ctx: &Context, extension: &'static str, status: &Status) {
        if let Some(scene) = status.scene.as_ref().filter(|_| status.samples > 0) {
            let name = scene_name(scene.path());
            // More samples come while the dialog is open.
            let name = match status.activity {
                Activity::Rendering => format!("{name}.{extension}"),
                _ => format!("{name}-{}spp.{extension}", status.samples),
            };
            self.dialogs.save(ctx, &name, extension);
        } else {
            self.complain(ctx, "there is no picture to save yet".into());
        }
    }

    fn ask_where_to_save_scene(&mut self, ctx: &Context, status: &Status) {
        if let Some(scene) = &status.scene {
            let name = format!("{}.toml", scene_name(scene.path()));
            self.dialogs.save(ctx, &name, "toml");
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

    fn take_answers(&mut self, ctx: &Context) {
        match self.dialogs.answer() {
            Some(Answer::Open(path)) => self.open(path),
            Some(Answer::Save(path)) => self.save(path),
            Some(Answer::Reference(path)) => self.session.load_reference(path),
            Some(Answer::Race(folder)) => self.race.save(ctx, folder),
            Some(Answer::Mesh(file, bounds)) => {
                if let Some(scene) = self.session.status().scene {
                    self.model.add_mesh(&scene, file, &bounds);
                }
            }
            Some(Answer::Unavailable(text)) => self.complain(ctx, text),
            Some(Answer::Cancelled) => self.unsaved.not_saved(),
            None => {}
        }
    }

    fn take_drops(&mut self, ctx: &Context) {
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
            || ctx.input(|i| i.pointer.any_down())
            || ctx.text_edit_focused();
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
                        panels::window_ui(ui);
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
            let leaving = self.unsaved.asks_to_leave();
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
        hovered_files(&ctx);

        for action in actions {
            self.act(&ctx, action, &status);
        }
        self.quit(&ctx, &status);
        self.send();
    }
}

/// Says what will happen to a file held over the window.
fn hovered_files(ctx: &Context) {
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
