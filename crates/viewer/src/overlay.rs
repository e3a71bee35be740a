//! What is drawn over the picture: the box of the selection, the pivot, small texts.

use std::sync::{Arc, Weak};

use egui::accesskit::Role;
use egui::{Color32, Painter, Pos2, Rect, Response, Sense, Stroke, Ui, Vec2, WidgetInfo};
use glam::Vec3;
use lightbox_core::Scene;
use lightbox_core::film::Pixel;
use lightbox_core::math::Aabb;
use lightbox_core::scene::CameraDesc;

use crate::gestures::{pick, share};
use crate::model::{Model, Selection};
use crate::panels::format;

/// Color of the selection's box.
const SELECTED: Color32 = Color32::from_rgb(255, 190, 60);

/// Bounds of the selected object; kept, because finding them takes a look at every primitive.
#[derive(Default)]
pub struct Overlay {
    outline: Option<(Selection, Weak<Scene>, Aabb)>,
}

impl Overlay {
    /// Draws the box of the selected object.
    pub fn outline(&mut self, painter: &Painter, rect: Rect, scene: &Arc<Scene>, model: &Model) {
        let Some(bounds) = self.bounds(scene, model) else {
            return;
        };
        let stroke = Stroke::new(1.0, SELECTED.gamma_multiply(0.8));
        let camera = &model.desc.camera;
        for [a, b] in edges(&bounds) {
            if let (Some(a), Some(b)) = (on_screen(rect, camera, a), on_screen(rect, camera, b)) {
                painter.line_segment([a, b], stroke);
            }
        }
    }

    fn bounds(&mut self, scene: &Arc<Scene>, model: &Model) -> Option<Aabb> {
        let selection = model.selection?;
        match &self.outline {
            Some((of, within, bounds))
                if *of == selection && within.as_ptr() == Arc::as_ptr(scene) =>
            {
                Some(*bounds)
            }
            _ => {
                let bounds = scene.object_bounds(selection.object(scene)?);
                self.outline = Some((selection, Arc::downgrade(scene), bounds));
                Some(bounds)
            }
        }
    }
}

/// The twelve edges of a box.
fn edges(bounds: &Aabb) -> impl Iterator<Item = [Vec3; 2]> {
    let corner = |i: usize| {
        let pick = |bit: usize, lo: f32, hi: f32| if i >> bit & 1 == 1 { hi } else { lo };
        let (lo, hi) = (bounds.min, bounds.max);
        Vec3::new(
            pick(0, lo.x, hi.x),
            pick(1, lo.y, hi.y),
            pick(2, lo.z, hi.z),
        )
    };
    (0..8).flat_map(move |i| {
        (0..3)
            .filter(move |bit| i >> bit & 1 == 0)
            .map(move |bit| [corner(i), corner(i | 1 << bit)])
    })
}

fn on_screen(rect: Rect, camera: &CameraDesc, point: Vec3) -> Option<Pos2> {
    let ([x, y], _) = crate::orbit::projected(camera, point)?;
    Some(rect.center() + Vec2::new(x, y) * rect.height())
}

/// A small cross where the camera turns around.
pub fn pivot(painter: &Painter, at: Pos2) {
    for (width, color) in [(3.0, Color32::from_black_alpha(140)), (1.0, Color32::WHITE)] {
        painter.hline(at.x - 7.0..=at.x + 7.0, at.y, Stroke::new(width, color));
        painter.vline(at.x, at.y - 7.0..=at.y + 7.0, Stroke::new(width, color));
    }
}

/// A short text over the picture, at a corner of it.
pub fn tag(ui: &Ui, painter: &Painter, corner: Pos2, text: &str) -> Rect {
    let font = egui::TextStyle::Body.resolve(ui.style());
    let galley = painter.layout_no_wrap(text.to_owned(), font, Color32::from_gray(230));
    let pad = Vec2::new(6.0, 3.0);
    let size = galley.size() + 2.0 * pad;
    // Above a lower corner, below an upper one.
    let below = corner.y + size.y < painter.clip_rect().bottom();
    let min = if below {
        corner
    } else {
        Pos2::new(corner.x, painter.clip_rect().bottom() - size.y)
    };
    let rect = Rect::from_min_size(min + Vec2::new(6.0, if below { 6.0 } else { -6.0 }), size);
    painter.rect_filled(rect, 3.0, Color32::from_black_alpha(170));
    painter.galley(rect.min + pad, galley, Color32::WHITE);
    rect
}

/// What is under the cursor; `film` tells what is known of a pixel.
pub fn readout(
    ui: &Ui,
    painter: &Painter,
    response: &Response,
    rect: Rect,
    scene: &Scene,
    model: &Model,
    film: impl FnOnce([u32; 2]) -> Option<Pixel>,
) {
    let Some(pos) = response
        .hover_pos()
        .filter(|p| rect.contains(*p) && !response.dragged())
    else {
        return;
    };
    let at = share(rect, pos);
    let size = [model.desc.render.width, model.desc.render.height];
    let pixel = [0, 1].map(|i| ((at[i] * size[i] as f32) as u32).min(size[i] - 1));
    let mut text = format!("{}, {}", pixel[0], pixel[1]);
    if let Some(pixel) = film(pixel) {
        text += &format!("    {}", radiance(&pixel));
    }
    match pick(scene, &model.desc.camera, size, at) {
        Some(pick) => {
            let prim = pick.hit.prim;
            text += &format!(
                "    {}, {}    distance {}",
                scene.object(prim).label,
                scene.material_names()[scene.slot(prim) as usize],
                format::length(pick.hit.t)
            );
        }
        None => text += "    nothing",
    }
    let rect = tag(ui, painter, painter.clip_rect().left_bottom(), &text);
    let place = ui.interact(rect, ui.scope_id().with("readout"), Sense::hover());
    place.widget_info(|| WidgetInfo::labeled(Role::Label, true, &text));
}

/// Linear light of a pixel and its standard error.
fn radiance(pixel: &Pixel) -> String {
    let numbers = |v: Vec3| v.to_array().map(format::short).join(" ");
    let mut text = format!("RGB {}", numbers(pixel.mean));
    if let Some(error) = pixel.error {
        text += &format!(" ± {}", numbers(error));
    }
    if pixel.invalid > 0 {
        text += &format!("    {}", format::counted(pixel.invalid, "invalid sample"));
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_box_has_twelve_edges_along_the_axes() {
        let bounds = Aabb {
            min: Vec3::ZERO,
            max: Vec3::new(1.0, 2.0, 3.0),
        };
        let lengths: Vec<f32> = edges(&bounds).map(|[a, b]| a.distance(b)).collect();
        for length in [1.0, 2.0, 3.0] {
            assert_eq!(lengths.iter().filter(|l| **l == length).count(), 4);
        }
    }
}
