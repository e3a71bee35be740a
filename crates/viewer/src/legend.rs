//! What the colours of the picture mean, over its edge.

use egui::accesskit::Role;
use egui::{Area, Color32, Order, Rect, Sense, Ui, Vec2, WidgetInfo};

use crate::aov::{Aov, Legend, Scope};

/// Size of the scale's colours, points.
const SCALE: Vec2 = Vec2::new(120.0, 12.0);

/// Distance from the edge of the picture and from other things, points.
const GAP: f32 = 6.0;

/// Edge of the square of a colour that stands by itself, points.
const SWATCH: f32 = 12.0;

/// Shows the legend in the lower right corner of `space`, or above what is `taken` there; none for
/// plain light.
pub fn show(ui: &Ui, space: Rect, taken: Option<Rect>, aov: Aov, scope: &Scope<'_>) {
    if aov == Aov::COLOR {
        return;
    }
    let legend = aov.legend(scope);
    let id = egui::Id::unique("legend");
    let mut corner = space.right_bottom() - Vec2::splat(GAP);
    let width = ui.memory(|m| m.area_rect(id)).map_or(0.0, |r| r.width());
    if let Some(taken) = taken.filter(|taken| taken.right() + GAP > corner.x - width) {
        corner.y = taken.top() - GAP;
    }
    let area = Area::new(id)
        .order(Order::Background)
        .interactable(false)
        .pivot(egui::Align2::RIGHT_BOTTOM)
        .fixed_pos(corner);
    area.show(ui.ctx(), |ui| {
        let frame = egui::Frame::new()
            .fill(Color32::from_black_alpha(170))
            .corner_radius(3)
            .inner_margin(egui::Margin::symmetric(6, 3));
        frame.show(ui, |ui| {
            ui.visuals_mut().override_text_color = Some(Color32::from_gray(230));
            ui.style_mut().wrap_mode = Some(egui::TextWrapMode::Extend);
            contents(ui, aov, legend);
        });
    });
}

fn contents(ui: &mut Ui, aov: Aov, legend: Legend) {
    // Strong text would be black in a light theme.
    let name = |ui: &mut Ui| ui.label(egui::RichText::new(aov.name()).color(Color32::WHITE));
    match legend {
        Legend::None => {
            name(ui);
        }
        Legend::Words(words) => {
            ui.horizontal(|ui| {
                name(ui);
                ui.label(words);
            });
        }
        Legend::Scale { color, ends } => {
            ui.horizontal(|ui| {
                name(ui);
                let [low, high] = ends;
                ui.label(low);
                scale(ui, color);
                ui.label(high);
            });
        }
        Legend::Swatches(swatches) if swatches.len() <= 6 => {
            ui.horizontal(|ui| {
                name(ui);
                for (color, text) in swatches {
                    swatch(ui, color);
                    ui.label(text);
                }
            });
        }
        Legend::Swatches(swatches) => {
            name(ui);
            for (color, text) in swatches {
                ui.horizontal(|ui| {
                    swatch(ui, color);
                    ui.label(text);
                });
            }
        }
    }
}

fn rgb([r, g, b]: [u8; 3]) -> Color32 {
    Color32::from_rgb(r, g, b)
}

fn swatch(ui: &mut Ui, color: [u8; 3]) {
    let (rect, _) = ui.allocate_exact_size(Vec2::splat(SWATCH), Sense::hover());
    ui.painter().rect_filled(rect, 2.0, rgb(color));
}

fn scale(ui: &mut Ui, color: fn(f32) -> [u8; 3]) {
    let (rect, response) = ui.allocate_exact_size(SCALE, Sense::hover());
    response.widget_info(|| WidgetInfo::labeled(Role::Image, true, "Scale of colours"));
    let steps = SCALE.x as u16;
    for i in 0..steps {
        let left = rect.left() + f32::from(i);
        let strip = Rect::from_x_y_ranges(left..=left + 1.0, rect.y_range());
        let color = color(f32::from(i) / f32::from(steps - 1));
        ui.painter().rect_filled(strip, 0.0, rgb(color));
    }
}
