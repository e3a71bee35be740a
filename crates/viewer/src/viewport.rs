//! The live picture: its place in the window, its size and its texture.

use egui::{
    Color32, Pos2, Rect, Response, Sense, TextureHandle, TextureOptions, Ui, Vec2, WidgetInfo,
};
use lightbox_core::settings::MAX_SIZE;

use crate::aov::Scope;
use crate::gestures::Gestures;
use crate::legend;
use crate::model::{Model, PictureSize};
use crate::overlay;
use crate::panels::format;
use crate::session::{Session, Snapshot, Status};

/// Most pixels of a picture sized by the window: some hundred megabytes of film.
const MOST_PIXELS: f32 = (1 << 22) as f32;

/// How long the window's size must be still before the picture takes it over, seconds: a render
/// for each step of a drag would be a storm.
const SETTLE: f64 = 0.2;

/// The picture's place in the window.
#[derive(Default)]
pub struct Viewport {
    /// Camera moves.
    pub gestures: Gestures,
    texture: Option<Shown>,
    resize: Option<Resize>,
}

/// Where the picture is, and what the pointer does there.
pub struct Seen {
    /// All that is left for it.
    pub space: Rect,
    /// What it takes up.
    pub rect: Rect,
    /// The pointer.
    pub response: Response,
}

/// What is on the graphics card.
struct Shown {
    texture: TextureHandle,
    number: u64,
    options: TextureOptions,
}

/// A size that waits until it is settled.
struct Resize {
    size: [u32; 2],
    /// Seconds of the input's clock.
    since: f64,
}

impl Viewport {
    /// Shows the newest picture in the space that is left and applies gestures over it; where it is.
    pub fn ui(
        &mut self,
        ui: &mut Ui,
        model: &mut Model,
        session: &Session,
        status: &Status,
        snapshot: Option<&Snapshot>,
    ) -> Option<Seen> {
        let space = ui.max_rect();
        ui.painter()
            .rect_filled(space, 0.0, ui.visuals().extreme_bg_color);
        self.follow_window(ui, space, model);
        let response = ui.allocate_rect(space, Sense::click_and_drag());
        response.widget_info(|| WidgetInfo::labeled(egui::accesskit::Role::Image, true, "Picture"));
        if response.is_pointer_button_down_on() {
            // Keys go to the picture after a click on it.
            ui.memory_mut(|m| {
                if let Some(id) = m.focused() {
                    m.surrender_focus(id);
                }
            });
        }
        let (Some(scene), Some(snapshot)) = (&status.scene, snapshot) else {
            return None;
        };
        let rect = placed(ui, space, snapshot.picture.map(|n| n as f32).into());
        self.gestures.update(ui, &response, rect, scene, model);
        self.picture(ui, rect, snapshot);

        let painter = ui.painter().with_clip_rect(space);
        overlay::outline(&painter, rect, scene, model);
        if self.gestures.is_moving(&response) {
            overlay::pivot(&painter, rect.center());
        }
        if let Some(past) = &snapshot.past {
            let text = format!(
                "as it was at {} spp, after {}",
                format::count(past.samples),
                format::seconds(past.seconds)
            );
            overlay::tag(ui, &painter, space.left_top(), &text);
        } else if self.gestures.is_flying {
            let text = "flying: W A S D, Q E, drag to look, Shift fast, Alt slow; Esc ends it";
            overlay::tag(ui, &painter, space.left_top(), text);
        } else if let Some(scale) = snapshot.preview {
            let text = match status.loading {
                Some(_) => format!("preview 1/{scale}, building"),
                None => format!("preview 1/{scale}"),
            };
            overlay::tag(ui, &painter, space.left_top(), &text);
        } else if self.gestures.is_limited {
            overlay::tag(ui, &painter, space.left_top(), "as far as the camera goes");
        }
        if snapshot.past.is_none() {
            let (eye, settings) = (model.desc.camera.eye, &model.desc.render);
            let size = [settings.width, settings.height];
            let reference = status.reference.as_deref().filter(|r| r.size() == size);
            let scope = Scope::new(scene, eye, settings.samples, model.tone, reference);
            legend::show(ui, space, snapshot.aov, &scope);
        }
        let film = |pixel| snapshot.past.is_none().then(|| session.pixel(pixel))?;
        overlay::readout(ui, &painter, &response, rect, scene, model, film);
        Some(Seen {
            space,
            rect,
            response,
        })
    }

    /// Sets the picture's size, at once for a new file and otherwise when the window is at rest.
    fn follow_window(&mut self, ui: &Ui, space: Rect, model: &mut Model) {
        let size = match model.size {
            PictureSize::AsInFile => model.file_size,
            PictureSize::FitWindow => fitting(
                space.size() * ui.pixels_per_point(),
                ui.input(|i| i.max_texture_side),
            ),
        };
        let settings = &mut model.desc.render;
        if size == [settings.width, settings.height] {
            self.resize = None;
            return;
        }
        let now = ui.input(|i| i.time);
        let since = match &self.resize {
            Some(resize) if resize.size == size => resize.since,
            // Nothing is lost by a new file's first picture.
            None if [settings.width, settings.height] == model.file_size => f64::NEG_INFINITY,
            _ => now,
        };
        if now - since >= SETTLE {
            [settings.width, settings.height] = size;
            self.resize = None;
        } else {
            self.resize = Some(Resize { size, since });
            ui.ctx()
                .request_repaint_after(std::time::Duration::from_secs_f64(SETTLE - (now - since)));
        }
    }

    fn picture(&mut self, ui: &Ui, rect: Rect, snapshot: &Snapshot) {
        let pixels = rect.size() * ui.pixels_per_point();
        let one_to_one = (pixels.x - snapshot.size[0] as f32).abs() < 1.0;
        let options = if snapshot.size != snapshot.picture || one_to_one {
            TextureOptions::NEAREST
        } else {
            TextureOptions::LINEAR
        };
        let is_current = |t: &Shown| (t.number, t.options) == (snapshot.number, options);
        if !self.texture.as_ref().is_some_and(is_current) {
            let image = egui::ColorImage::from_rgb(snapshot.size, &snapshot.rgb);
            match &mut self.texture {
                Some(shown) => {
                    shown.texture.set(image, options);
                    (shown.number, shown.options) = (snapshot.number, options);
                }
                None => {
                    let texture = ui.ctx().load_texture("picture", image, options);
                    self.texture = Some(Shown {
                        texture,
                        number: snapshot.number,
                        options,
                    });
                }
            }
        }
        if let Some(shown) = &self.texture {
            let whole = Rect::from_min_max(Pos2::ZERO, Pos2::new(1.0, 1.0));
            ui.painter()
                .image(shown.texture.id(), rect, whole, Color32::WHITE);
        }
    }
}

/// The picture's rectangle: as large as fits with its aspect, centred, on whole screen pixels.
fn placed(ui: &Ui, space: Rect, size: Vec2) -> Rect {
    let scale = (space.width() / size.x).min(space.height() / size.y);
    let native = 1.0 / ui.pixels_per_point();
    // A pixel for a pixel where the window's size is followed.
    let scale = if (scale / native - 1.0).abs() * size.max_elem() < 1.0 {
        native
    } else {
        scale
    };
    let size = size * scale;
    let snap = |x: f32| (x / native).round() * native;
    let min = space.center() - size * 0.5;
    Rect::from_min_size(Pos2::new(snap(min.x), snap(min.y)), size)
}

/// Pixels for a picture that fills a space: at least one, at most what film and texture can hold.
fn fitting(pixels: Vec2, texture_limit: usize) -> [u32; 2] {
    let pixels = pixels.max(Vec2::splat(1.0));
    let limit = texture_limit.min(MAX_SIZE as usize) as f32;
    let scale = (MOST_PIXELS / (pixels.x * pixels.y))
        .sqrt()
        .min(limit / pixels.max_elem())
        .min(1.0);
    [pixels.x, pixels.y].map(|n| ((n * scale).floor() as u32).max(1))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pictures_stay_within_every_limit() {
        assert_eq!(fitting(Vec2::new(1000.7, 600.2), 8192), [1000, 600]);
        assert_eq!(fitting(Vec2::new(0.3, -5.0), 8192), [1, 1]);
        let [w, h] = fitting(Vec2::new(7680.0, 4320.0), 8192);
        assert!(
            w * h <= MOST_PIXELS as u32 && (f64::from(w) / f64::from(h) - 16.0 / 9.0).abs() < 0.01,
            "{w} x {h}"
        );
        assert_eq!(fitting(Vec2::new(4000.0, 100.0), 2048), [2048, 51]);
        assert_eq!(fitting(Vec2::new(1e6, 1.0), 1 << 20), [MAX_SIZE, 1]);
    }
}
