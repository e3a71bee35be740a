//! The pixel autopsy: what the samples of one pixel have found, their paths drawn into the picture,
//! and any of them step by step.

mod charts;
mod draw;
mod findings;
mod replay;
mod trace;

use std::sync::{Arc, Weak};

use egui::{Context, DragValue, Pos2, RichText, ScrollArea, Ui, Window};
use lightbox_core::film::Pixel;
use lightbox_core::{Film, Method, Scene};

use crate::gestures::share;
use crate::model::Model;
use crate::panels::follow_focus;
use crate::panels::format::{count, percent, short};
use crate::session::Session;
use crate::viewport::Seen;
use replay::Replay;
use trace::{Found, Trace};

/// Width at first, and the most height, points.
const SIZE: [f32; 2] = [400.0, 680.0];

/// The window, and what it is about.
#[derive(Default)]
pub struct AutopsyPanel {
    /// Whether it is shown.
    pub is_open: bool,
    pixel: [u32; 2],
    of: Option<Subject>,
    replay: Replay,
    /// Whether the pixel under the pointer is asked for.
    is_asked: bool,
}

/// A pixel of a picture, and what becomes of it.
struct Subject {
    film: Weak<Film>,
    scene: Arc<Scene>,
    trace: Trace,
    /// What the film knew of it.
    pixel: Pixel,
    /// Whether it shares light with others.
    shares: bool,
}

impl AutopsyPanel {
    /// Looks into the pixel under the pointer, the one looked into last, or that in the middle.
    pub fn ask(&mut self) {
        self.is_asked = true;
    }

    /// Looks into a pixel that was clicked with Ctrl, or asked for.
    pub fn follow(&mut self, ui: &Ui, seen: &Seen, session: &Session, model: &Model) {
        let clicked = seen.response.clicked() && ui.input(|i| i.modifiers.command);
        let asked = std::mem::take(&mut self.is_asked);
        if !(clicked || asked) {
            return;
        }
        let (width, height) = (model.desc.render.width, model.desc.render.height);
        let pointer = seen.response.interact_pointer_pos();
        let pointer = pointer.or_else(|| seen.response.hover_pos());
        let pixel = match pointer.filter(|pos| seen.rect.contains(*pos)) {
            Some(pos) => {
                let [x, y] = share(seen.rect, pos);
                [(x * width as f32) as u32, (y * height as f32) as u32]
            }
            None if self.of.is_some() => self.pixel,
            None => [width / 2, height / 2],
        };
        self.pixel = [pixel[0].min(width - 1), pixel[1].min(height - 1)];
        self.start(ui.ctx(), session);
        self.is_open = true;
    }

    /// Traces the samples of the pixel, if the picture has any.
    fn start(&mut self, ctx: &Context, session: &Session) {
        self.of = None;
        let Some((view, film)) = session.making() else {
            return;
        };
        let [x, y] = self.pixel;
        self.pixel = [
            x.min(view.settings.width - 1),
            y.min(view.settings.height - 1),
        ];
        let Some(pixel) = film.pixel(self.pixel) else {
            return;
        };
        let (ctx, scene) = (ctx.clone(), view.scene.clone());
        let shares = view.settings.method == Method::Reuse;
        let wake = move || ctx.request_repaint();
        let trace = Trace::start(view, self.pixel, pixel.samples, wake);
        // Where no thread can be started, there is nothing to show.
        self.of = trace.ok().map(|trace| Subject {
            film: Arc::downgrade(&film),
            scene,
            trace,
            pixel,
            shares,
        });
    }

    /// Shows the window while it is open, and draws the paths into the picture.
    pub fn ui(&mut self, ui: &Ui, seen: Option<&Seen>, session: &Session, model: &Model) {
        if !self.is_open {
            self.of = None; // Nothing is traced for nobody.
            return;
        }
        let found = self
            .of
            .as_ref()
            .map(|of| of.trace.found())
            .unwrap_or_default();
        if let (Some(seen), Some(of)) = (seen, &self.of) {
            let painter = ui.painter().with_clip_rect(seen.space);
            let canvas = draw::Canvas::new(painter, seen.rect, &model.desc.camera, &of.scene);
            if self.is_of(session) {
                let size = [model.desc.render.width, model.desc.render.height];
                canvas.pixel(self.pixel, size);
            }
            self.replay.draw(&canvas, &found.paths);
        }
        let mut is_open = self.is_open;
        let corner = seen.map_or(Pos2::ZERO, |seen| seen.space.left_top());
        let room = seen.map_or(SIZE[1], |seen| seen.space.height() - 64.0);
        Window::new("Pixel autopsy")
            .open(&mut is_open)
            .default_size([SIZE[0], SIZE[1].min(room)])
            .default_pos(corner + egui::vec2(8.0, 8.0))
            .min_size([320.0, 200.0])
            .show(ui.ctx(), |ui| {
                self.head(ui, session, model, &found);
                ScrollArea::vertical()
                    .auto_shrink([false, true])
                    .show(ui, |ui| {
                        let Some(of) = self.of.as_ref().filter(|_| found.findings.samples > 0)
                        else {
                            return;
                        };
                        charts::show(ui, &found.findings, &of.pixel);
                        self.replay.ui(ui, &of.scene, &found);
                        follow_focus(ui);
                    });
            });
        self.is_open = is_open;
    }

    /// Whether the picture in the making is still the one that was looked into.
    fn is_of(&self, session: &Session) -> bool {
        let Some(of) = &self.of else { return false };
        let making = session.film();
        making.is_some_and(|film| of.film.as_ptr() == Arc::as_ptr(&film))
    }

    /// Which pixel, and its samples in a line.
    fn head(&mut self, ui: &mut Ui, session: &Session, model: &Model, found: &Found) {
        let size = [model.desc.render.width, model.desc.render.height];
        let is_current = self.is_of(session);
        ui.horizontal(|ui| {
            let mut changed = false;
            for (i, name) in ["Pixel x", "Pixel y"].into_iter().enumerate() {
                let field = DragValue::new(&mut self.pixel[i]).range(0..=size[i] - 1);
                let field = ui.add(field.prefix(["x ", "y "][i]));
                changed |= field.changed();
                field
                    .on_hover_text("The pixel that is looked into; Ctrl+click one in the picture.")
                    .accessible_name(name);
            }
            let again = egui::Button::new("Again");
            let again = ui.add_enabled(!is_current, again);
            let tip = "Looks into this pixel of the present picture.";
            if again.on_hover_text(tip).clicked() || changed {
                self.start(ui.ctx(), session);
            }
        });
        let Some(of) = &self.of else {
            ui.weak("The picture has no sample here yet; try again in a moment.");
            return;
        };
        let findings = &found.findings;
        let text = match findings.samples {
            0 => "tracing…".to_owned(),
            n => format!(
                "{} samples, {} of them in the picture",
                count(n as u64),
                count(of.pixel.samples.min(n as u64))
            ),
        };
        let dots = if found.is_done || findings.samples == 0 {
            ""
        } else {
            "…"
        };
        ui.label(format!("{text}{dots}"));
        if of.shares {
            ui.weak("The pixel's own paths, before it shares with others.");
        }
        if !is_current {
            let text = "The picture has changed since: these are the paths of before.";
            ui.label(RichText::new(text).color(ui.visuals().warn_fg_color));
        }
        if let [Some(light), Some(variance)] = findings.tail {
            let shares = format!(
                "the brightest 1 % of samples bring {} of the light and {} of the variance.",
                percent(light),
                percent(variance)
            );
            if findings.is_heavy() {
                let text = RichText::new(format!("Heavy tail: {shares}"));
                ui.label(text.color(ui.visuals().warn_fg_color));
            } else {
                ui.weak(format!("No heavy tail: {shares}"));
            }
        }
        if findings.invalid > 0 {
            let text = format!("{} samples were no numbers", count(findings.invalid as u64));
            ui.label(RichText::new(text).color(ui.visuals().error_fg_color));
        }
    }
}

/// A luminance of a mean and its error: `0.123 ± 0.004`.
fn within(mean: f64, error: f64) -> String {
    format!("{} ± {}", short(mean as f32), short(error as f32))
}
