//! The live picture: its place in the window, its size and its texture.

use egui::{Pos2, Rect, Response, Sense, Ui, Vec2, WidgetInfo};
use lightbox_core::settings::MAX_SIZE;

use crate::aov::Scope;
use crate::compare::Compare;
use crate::gestures::Gestures;
use crate::handles::Handles;
use crate::keys;
use crate::legend;
use crate::model::{Model, PictureSize};
use crate::overlay;
use crate::panels::format;
use crate::session::{Session, Snapshot, Status};
use crate::silhouette::Silhouette;
use crate::texture::Texture;
use crate::zoom::Zoom;

/// Most pixels of a picture sized by the window: some hundred megabytes of film.
const MOST_PIXELS: f32 = (1 << 22) as f32;

/// How long the window's size must be still before the picture takes it over, seconds: a render
/// for each step of a drag would be a storm.
const SETTLE: f64 = 0.2;

/// The picture's place in the window.
pub struct Viewport {
    /// Camera moves.
    pub gestures: Gestures,
    /// The other picture.
    pub compare: Compare,
    /// Which part of the picture is seen.
    pub zoom: Zoom,
    handles: Handles,
    silhouette: Silhouette,
    texture: Texture,
    resize: Option<Resize>,
}

impl Default for Viewport {
    fn default() -> Self {
        Self {
            gestures: Gestures::default(),
            compare: Compare::default(),
            zoom: Zoom::default(),
            handles: Handles::default(),
            silhouette: Silhouette::default(),
            texture: Texture::new("picture"),
            resize: None,
        }
    }
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
        self.compare.is_glancing = keys::is_glancing(ui.ctx());
        let other = session.other();
        let stage = self.compare.stage(space, other.as_deref());
        let whole = placed(ui, stage, snapshot.picture.map(|n| n as f32).into());
        let rect = self.zoom.applied(whole);
        self.zoom.follow(&response, whole, rect);
        let zoom = &mut self.zoom;
        self.gestures
            .update(ui, &response, rect, scene, model, zoom);
        let painter = ui.painter().with_clip_rect(stage);
        self.texture.draw(&painter, rect, snapshot);
        let reference = status.reference.as_ref();
        self.compare
            .draw(ui, space, rect, other.as_deref(), reference);

        if let Some(object) = model.selection.and_then(|s| s.object(scene)) {
            let is_still = snapshot.preview.is_none();
            let seen = self.silhouette.of(ui.ctx(), scene, object, model, is_still);
            overlay::outline(&painter, rect, object, seen, model);
        }
        if let Some(region) = model.region {
            overlay::region(&painter, rect, region);
        }
        if self.gestures.is_moving(&response) {
            overlay::pivot(&painter, rect.center());
        }
        let edit = match snapshot.past {
            None => self.handles.ui(ui, &painter, rect, scene, model),
            Some(_) => None, // The object may have stood elsewhere.
        };
        // Not cut off where the other picture begins.
        let painter = ui.painter().with_clip_rect(space);
        if let Some(text) = edit {
            overlay::tag(ui, &painter, space.left_top(), &text);
        } else if let Some(past) = &snapshot.past {
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
            let text = match (scale, &status.loading) {
                (1, _) => format!("drawing {}", snapshot.aov.name()),
                (_, Some(_)) => format!("preview 1/{scale}, building"),
                (_, None) => format!("preview 1/{scale}"),
            };
            overlay::tag(ui, &painter, space.left_top(), &text);
        } else if !self.gestures.is_known {
            let text = "Drag to orbit, turn the wheel to come closer, click an object to change it. F1 lists all keys.";
            overlay::tag(ui, &painter, space.left_top(), text);
        } else if self.gestures.is_limited {
            overlay::tag(ui, &painter, space.left_top(), "as far as the camera goes");
        }
        let told = |pixel| match snapshot.past {
            None => {
                let view = || Some(session.making()?.0);
                (session.pixel(pixel), snapshot.aov.reading(view, pixel))
            }
            Some(_) => (None, None),
        };
        let taken = overlay::readout(ui, &painter, &response, rect, scene, model, told);
        if snapshot.past.is_none() {
            let (eye, settings) = (model.desc.camera.eye, &model.desc.render);
            let size = [settings.width, settings.height];
            let reference = status.reference.as_deref().filter(|r| r.size() == size);
            let scope = Scope::new(scene, eye, settings, model.tone, reference);
            legend::show(ui, space, taken, snapshot.aov, &scope);
        }
        Some(Seen {
            space: stage,
            rect,
            response,
        })
    }

    /// Sets the picture's size, at once for a new file and otherwise when the window is at rest.
    fn follow_window(&mut self, ui: &Ui, space: Rect, model: &mut Model) {
        let file = [model.file.render.width, model.file.render.height];
        let size = match model.size {
            PictureSize::AsInFile => file,
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
            None if [settings.width, settings.height] == file => f64::NEG_INFINITY,
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
