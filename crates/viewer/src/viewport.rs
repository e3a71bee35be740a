//! The live picture: its place in the window, its texture and what is drawn over it.

use egui::{Color32, Painter, Pos2, Rect, Response, Sense, Stroke, TextureHandle, TextureOptions, Ui, Vec2, WidgetInfo};
use glam::Vec3;
use lightbox_core::math::Aabb;
use lightbox_core::settings::MAX_SIZE;
use lightbox_core::{Scene, scene::CameraDesc};

use crate::gestures::{Gestures, pick, share};
use crate::model::{Model, PictureSize, Selection};
use crate::panels::format;
use crate::session::{Snapshot, Status};

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
    outline: Option<Outline>,
    resize: Option<Resize>,
}

/// What is on the graphics card.
struct Shown {
    texture: TextureHandle,
    number: u64,
    options: TextureOptions,
}

/// Bounds of the selected object; kept, because finding them takes a look at every primitive.
struct Outline {
    selection: Selection,
    scene: *const Scene,
    bounds: Aabb,
}

/// A size that waits until it is settled.
struct Resize {
    size: [u32; 2],
    /// Seconds of the input's clock.
    since: f64,
}

impl Viewport {
    /// Shows the newest picture in the space that is left and applies gestures over it.
    pub fn ui(&mut self, ui: &mut Ui, model: &mut Model, status: &Status, snapshot: Option<&Snapshot>) {
        let space = ui.max_rect();
        ui.painter().rect_filled(space, 0.0, ui.visuals().extreme_bg_color);
        self.follow_window(ui, space, model);
        let response = ui.allocate_rect(space, Sense::click_and_drag());
        response.widget_info(|| WidgetInfo::labeled(egui::accesskit::Role::Image, true, "Picture"));
        if response.is_pointer_button_down_on() {
            // Keys go to the picture after a click on it.
            ui.memory_mut(|m| m.focused().inspect(|id| m.surrender_focus(*id)));
        }
        let (Some(scene), Some(snapshot)) = (&status.scene, snapshot) else {
            return;
        };
        let size = match snapshot.preview {
            // A preview's own size is rounded.
            Some(_) => [model.desc.render.width, model.desc.render.height].map(|n| n as f32),
            None => snapshot.size.map(|n| n as f32),
        };
        let rect = placed(ui, space, size.into());
        self.gestures.update(ui, &response, rect, scene, model);
        self.picture(ui, rect, snapshot);

        let painter = ui.painter().with_clip_rect(space);
        self.outline(&painter, rect, scene, model);
        if self.gestures.is_moving(&response) {
            pivot(&painter, rect.center());
        }
        if let Some(scale) = snapshot.preview {
            tag(ui, &painter, space.left_top(), &format!("preview 1/{scale}"));
        } else if self.gestures.is_limited {
            tag(ui, &painter, space.left_top(), "as far as the camera goes");
        }
        readout(ui, &painter, &response, rect, scene, model, snapshot);
    }

    /// Sets the picture's size, at once for a new file and otherwise when the window is at rest.
    fn follow_window(&mut self, ui: &Ui, space: Rect, model: &mut Model) {
        let size = match model.size {
            PictureSize::AsInFile => model.file_size,
            PictureSize::FitWindow => fitting(space.size() * ui.pixels_per_point(), ui.input(|i| i.max_texture_side)),
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
            ui.ctx().request_repaint_after(std::time::Duration::from_secs_f64(SETTLE - (now - since)));
        }
    }

    fn picture(&mut self, ui: &Ui, rect: Rect, snapshot: &Snapshot) {
        let pixels = rect.size() * ui.pixels_per_point();
        let one_to_one = (pixels.x - snapshot.size[0] as f32).abs() < 1.0;
        let options =
            if snapshot.preview.is_some() || one_to_one { TextureOptions::NEAREST } else { TextureOptions::LINEAR };
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
                    self.texture = Some(Shown { texture, number: snapshot.number, options });
                }
            }
        }
        if let Some(shown) = &self.texture {
            let whole = Rect::from_min_max(Pos2::ZERO, Pos2::new(1.0, 1.0));
            ui.painter().image(shown.texture.id(), rect, whole, Color32::WHITE);
        }
    }

    /// The box of the selected object.
    fn outline(&mut self, painter: &Painter, rect: Rect, scene: &std::sync::Arc<Scene>, model: &Model) {
        let Some(selection) = model.selection else { return };
        let id = std::sync::Arc::as_ptr(scene);
        if !self.outline.as_ref().is_some_and(|o| o.selection == selection && o.scene == id) {
            let Some(object) = selection.object(scene) else { return };
            self.outline = Some(Outline { selection, scene: id, bounds: scene.object_bounds(object) });
        }
        let Some(Outline { bounds, .. }) = &self.outline else { return };
        let stroke = Stroke::new(1.0, Color32::from_rgb(255, 190, 60).gamma_multiply(0.8));
        for [a, b] in edges(bounds) {
            if let (Some(a), Some(b)) = (on_screen(rect, &model.desc.camera, a), on_screen(rect, &model.desc.camera, b)) {
                painter.line_segment([a, b], stroke);
            }
        }
    }
}

/// The picture's rectangle: as large as fits with its aspect, centred, on whole screen pixels.
fn placed(ui: &Ui, space: Rect, size: Vec2) -> Rect {
    let scale = (space.width() / size.x).min(space.height() / size.y);
    let native = 1.0 / ui.pixels_per_point();
    // A pixel for a pixel where the window's size is followed.
    let scale = if (scale / native - 1.0).abs() * size.max_elem() < 1.0 { native } else { scale };
    let size = size * scale;
    let snap = |x: f32| (x / native).round() * native;
    let min = space.center() - size * 0.5;
    Rect::from_min_size(Pos2::new(snap(min.x), snap(min.y)), size)
}

/// Pixels for a picture that fills a space: at least one, at most what film and texture can hold.
fn fitting(pixels: Vec2, texture_limit: usize) -> [u32; 2] {
    let pixels = pixels.max(Vec2::splat(1.0));
    let limit = texture_limit.min(MAX_SIZE as usize) as f32;
    let scale = (MOST_PIXELS / (pixels.x * pixels.y)).sqrt().min(limit / pixels.max_elem()).min(1.0);
    [pixels.x, pixels.y].map(|n| ((n * scale).floor() as u32).max(1))
}

/// The twelve edges of a box.
fn edges(bounds: &Aabb) -> impl Iterator<Item = [Vec3; 2]> {
    let corner = |i: usize| {
        let pick = |bit: usize, lo: f32, hi: f32| if i >> bit & 1 == 1 { hi } else { lo };
        let (lo, hi) = (bounds.min, bounds.max);
        Vec3::new(pick(0, lo.x, hi.x), pick(1, lo.y, hi.y), pick(2, lo.z, hi.z))
    };
    (0..8).flat_map(move |i| (0..3).filter(move |bit| i >> bit & 1 == 0).map(move |bit| [corner(i), corner(i | 1 << bit)]))
}

fn on_screen(rect: Rect, camera: &CameraDesc, point: Vec3) -> Option<Pos2> {
    let ([x, y], _) = crate::orbit::projected(camera, point)?;
    Some(rect.center() + Vec2::new(x, y) * rect.height())
}

/// A small cross where the camera turns around.
fn pivot(painter: &Painter, at: Pos2) {
    for (width, color) in [(3.0, Color32::from_black_alpha(140)), (1.0, Color32::WHITE)] {
        painter.hline(at.x - 7.0..=at.x + 7.0, at.y, Stroke::new(width, color));
        painter.vline(at.x, at.y - 7.0..=at.y + 7.0, Stroke::new(width, color));
    }
}

/// A short text over the picture, at a corner of it.
fn tag(ui: &Ui, painter: &Painter, corner: Pos2, text: &str) -> Rect {
    let font = egui::TextStyle::Body.resolve(ui.style());
    let galley = painter.layout_no_wrap(text.to_owned(), font, Color32::from_gray(230));
    let pad = Vec2::new(6.0, 3.0);
    let size = galley.size() + 2.0 * pad;
    // Above a lower corner, below an upper one.
    let below = corner.y + size.y < painter.clip_rect().bottom();
    let min = if below { corner } else { Pos2::new(corner.x, painter.clip_rect().bottom() - size.y) };
    let rect = Rect::from_min_size(min + Vec2::new(6.0, if below { 6.0 } else { -6.0 }), size);
    painter.rect_filled(rect, 3.0, Color32::from_black_alpha(170));
    painter.galley(rect.min + pad, galley, Color32::WHITE);
    rect
}

/// What is under the cursor.
fn readout(ui: &Ui, painter: &Painter, response: &Response, rect: Rect, scene: &Scene, model: &Model, snapshot: &Snapshot) {
    let Some(pos) = response.hover_pos().filter(|p| rect.contains(*p) && !response.dragged()) else { return };
    let at = share(rect, pos);
    let pixel_of = |size: [usize; 2]| [0, 1].map(|i| ((at[i] * size[i] as f32) as usize).min(size[i] - 1));
    let size = [model.desc.render.width, model.desc.render.height];
    let [x, y] = pixel_of(size.map(|n| n as usize));
    let [sx, sy] = pixel_of(snapshot.size);
    let start = 3 * (sy * snapshot.size[0] + sx);
    let mut text = format!("{x}, {y}");
    if let Some([r, g, b]) = snapshot.rgb.get(start..start + 3) {
        text += &format!("    sRGB {r} {g} {b}");
    }
    match pick(scene, &model.desc.camera, size, at) {
        Some(pick) => {
            let depth = format::length(pick.hit.t);
            text += &format!("    {}    distance {depth}", scene.object(pick.hit.prim).label);
        }
        None => text += "    nothing",
    }
    tag(ui, painter, painter.clip_rect().left_bottom(), &text);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pictures_stay_within_every_limit() {
        assert_eq!(fitting(Vec2::new(1000.7, 600.2), 8192), [1000, 600]);
        assert_eq!(fitting(Vec2::new(0.3, -5.0), 8192), [1, 1]);
        let [w, h] = fitting(Vec2::new(7680.0, 4320.0), 8192);
        assert!(w * h <= MOST_PIXELS as u32 && (f64::from(w) / f64::from(h) - 16.0 / 9.0).abs() < 0.01, "{w} x {h}");
        assert_eq!(fitting(Vec2::new(4000.0, 100.0), 2048), [2048, 51]);
        assert_eq!(fitting(Vec2::new(1e6, 1.0), 1 << 20), [MAX_SIZE, 1]);
    }

    #[test]
    fn a_box_has_twelve_edges_along_the_axes() {
        let bounds = Aabb { min: Vec3::ZERO, max: Vec3::new(1.0, 2.0, 3.0) };
        let lengths: Vec<f32> = edges(&bounds).map(|[a, b]| a.distance(b)).collect();
        for length in [1.0, 2.0, 3.0] {
            assert_eq!(lengths.iter().filter(|l| **l == length).count(), 4);
        }
    }
}
