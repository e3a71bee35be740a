//! What is drawn over the picture: the outline of the selection, the pivot, small texts.

use egui::accesskit::Role;
use egui::{Color32, Painter, Pos2, Rect, Response, Sense, Shape, Stroke, Ui, Vec2, WidgetInfo};
use glam::Vec3;
use lightbox_core::Scene;
use lightbox_core::film::Pixel;
use lightbox_core::math::Aabb;
use lightbox_core::scene::{CameraDesc, Object, ObjectKind, SphereDesc};

use crate::gestures::{pick, share};
use crate::model::Model;
use crate::panels::format;
use crate::session::Region;
use crate::silhouette::Loops;

/// Color of the selection's outline.
const SELECTED: Color32 = Color32::from_rgb(255, 190, 60);

/// Lines of a sphere's outline.
const ROUND: u32 = 64;

/// Draws the outline of the selected object as it is edited: a sphere's rim, a quad's edges, of a mesh
/// its silhouette, or the box around it while that is not known.
pub fn outline(
    painter: &Painter,
    rect: Rect,
    object: &Object,
    silhouette: Option<&Loops>,
    model: &Model,
) {
    let pens = [(3.0, Color32::from_black_alpha(110)), (1.5, SELECTED)];
    let pens = pens.map(|(width, color)| Stroke::new(width, color));
    if let Some(loops) = silhouette {
        let at = |share: &Vec2| rect.min + *share * rect.size();
        for line in loops {
            let points: Vec<Pos2> = line.iter().map(at).collect();
            for pen in pens {
                painter.add(Shape::closed_line(points.clone(), pen));
            }
        }
        return;
    }
    let desc = &model.desc;
    let lines: Vec<[Vec3; 2]> = match object.kind {
        ObjectKind::Sphere(i) => desc
            .spheres
            .get(i)
            .map_or_else(Vec::new, |sphere| ring(&rim(sphere, desc.camera.eye))),
        ObjectKind::Quad(i) => desc
            .quads
            .get(i)
            .map_or_else(Vec::new, |quad| ring(&quad.corners)),
        ObjectKind::Mesh(i) => desc.meshes.get(i).map_or_else(Vec::new, |mesh| {
            let place = mesh.placement();
            edges(&object.bounds).map(|line| line.map(&place)).collect()
        }),
    };
    for pen in pens {
        for line in &lines {
            if let Some(line) = on_screen(rect, &desc.camera, *line) {
                painter.line_segment(line, pen);
            }
        }
    }
}

/// The circle in which rays from the eye touch a sphere; nothing from within.
fn rim(sphere: &SphereDesc, eye: Vec3) -> Vec<Vec3> {
    let way = sphere.center - eye;
    let (distance, radius) = (way.length(), sphere.radius);
    if !(distance > radius) {
        return Vec::new();
    }
    let axis = way / distance;
    let near = radius / distance;
    let (center, around) = (
        sphere.center - axis * (radius * near),
        radius * (1.0 - near * near).sqrt(),
    );
    let (a, b) = axis.any_orthonormal_pair();
    (0..ROUND)
        .map(|i| {
            let (sin, cos) = (i as f32 / ROUND as f32 * std::f32::consts::TAU).sin_cos();
            center + (a * cos + b * sin) * around
        })
        .collect()
}

/// The lines around some corners.
fn ring(corners: &[Vec3]) -> Vec<[Vec3; 2]> {
    let next = corners.iter().cycle().skip(1);
    corners.iter().zip(next).map(|(a, b)| [*a, *b]).collect()
}

/// The twelve edges of a box.
fn edges(bounds: &Aabb) -> impl Iterator<Item = [Vec3; 2]> + use<> {
    let (lo, hi) = (bounds.min, bounds.max);
    let corner = move |i: usize| {
        let pick = |bit: usize, lo: f32, hi: f32| if i >> bit & 1 == 1 { hi } else { lo };
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

/// Where a line is seen, as far as it is in front of the camera; from its nearer end.
fn on_screen(rect: Rect, camera: &CameraDesc, [a, b]: [Vec3; 2]) -> Option<[Pos2; 2]> {
    let axis = (camera.target - camera.eye).normalize_or_zero();
    let depth = |p: Vec3| (p - camera.eye).dot(axis);
    let (near, far) = if depth(a) < depth(b) { (a, b) } else { (b, a) };
    // Nearer than that, coordinates would grow out of bounds.
    let least = depth(far) * 1e-3;
    if !(least > 0.0) {
        return None;
    }
    let hidden = ((least - depth(near)) / (depth(far) - depth(near))).max(0.0);
    let near = if hidden > 0.0 {
        near.lerp(far, hidden)
    } else {
        near
    };
    Some([seen(rect, camera, near)?, seen(rect, camera, far)?])
}

/// Where a point is seen, if it is in front of the camera.
pub fn seen(rect: Rect, camera: &CameraDesc, point: Vec3) -> Option<Pos2> {
    let ([x, y], _) = crate::orbit::projected(camera, point)?;
    Some(rect.center() + Vec2::new(x, y) * rect.height())
}

/// The region that is rendered first.
pub fn region(painter: &Painter, rect: Rect, [left, top, right, bottom]: Region) {
    let at = |x: f32, y: f32| rect.min + rect.size() * Vec2::new(x, y);
    let frame = Rect::from_min_max(at(left, top), at(right, bottom));
    for (width, color) in [(3.0, Color32::from_black_alpha(110)), (1.0, Color32::WHITE)] {
        let stroke = Stroke::new(width, color);
        painter.rect_stroke(frame, 0.0, stroke, egui::StrokeKind::Middle);
    }
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

/// Tells what is under the cursor, and where it does; `told` is what is known of a pixel, and what the
/// view tells of it.
pub fn readout(
    ui: &Ui,
    painter: &Painter,
    response: &Response,
    rect: Rect,
    scene: &Scene,
    model: &Model,
    told: impl FnOnce([u32; 2]) -> (Option<Pixel>, Option<String>),
) -> Option<Rect> {
    let pos = response
        .hover_pos()
        .filter(|p| rect.contains(*p) && !response.dragged())?;
    let at = share(rect, pos);
    let size = [model.desc.render.width, model.desc.render.height];
    let pixel = [0, 1].map(|i| ((at[i] * size[i] as f32) as u32).min(size[i] - 1));
    let mut text = format!("{}, {}", pixel[0], pixel[1]);
    let (pixel, reading) = told(pixel);
    if let Some(pixel) = pixel {
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
    if let Some(reading) = reading {
        text += &format!("    {reading}");
    }
    let rect = tag(ui, painter, painter.clip_rect().left_bottom(), &text);
    let place = ui.interact(rect, ui.scope_id().with("readout"), Sense::hover());
    place.widget_info(|| WidgetInfo::labeled(Role::Label, true, &text));
    Some(rect)
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
    use crate::orbit::tests::FRESH;

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

    #[test]
    fn rays_touch_a_sphere_at_its_rim() {
        let sphere = SphereDesc {
            name: String::new(),
            material: String::new(),
            center: Vec3::new(0.5, 0.2, 1.0),
            radius: 0.7,
        };
        let points = rim(&sphere, FRESH.eye);
        assert_eq!(ring(&points).len(), ROUND as usize);
        for point in points {
            let out = point - sphere.center;
            assert!((out.length() - sphere.radius).abs() < 1e-5);
            assert!(out.dot(point - FRESH.eye).abs() < 1e-5);
        }
        assert!(rim(&sphere, sphere.center).is_empty());
    }

    #[test]
    fn a_line_that_passes_the_camera_is_cut_off() {
        let rect = Rect::from_min_size(Pos2::ZERO, Vec2::new(200.0, 100.0));
        let (front, back) = (Vec3::new(0.5, 0.0, 0.0), Vec3::new(0.5, 0.0, 9.0));
        let seen = on_screen(rect, &FRESH, [front, back]).unwrap();
        assert_eq!(on_screen(rect, &FRESH, [back, front]).unwrap(), seen);
        // Outwards to the right, from where its front end is seen.
        assert!(
            seen[0].x > 1000.0 && seen[1].x > 100.0 && seen[1].x < 150.0,
            "{seen:?}"
        );
        assert_eq!(on_screen(rect, &FRESH, [back, back + Vec3::Z]), None);
        let whole = on_screen(rect, &FRESH, [Vec3::ZERO, Vec3::X]).unwrap();
        assert!(whole.iter().all(|p| p.y == 50.0));
    }
}
