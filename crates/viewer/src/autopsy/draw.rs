//! Paths in the picture.

use egui::{Color32, Painter, Pos2, Rect, Shape, Stroke, StrokeKind, Vec2};
use glam::Vec3;
use lightbox_core::Scene;
use lightbox_core::integrator::replay::{Segment, Strategy};
use lightbox_core::scene::CameraDesc;

use crate::orbit;

/// Colours of what strategies have found, in the picture and in tables.
pub const COLORS: [Color32; Strategy::ALL.len()] = [
    Color32::from_rgb(110, 180, 255),
    Color32::from_rgb(255, 190, 60),
    Color32::from_rgb(120, 220, 130),
];

/// Colour of what is in the shade.
pub const SHADED: Color32 = Color32::from_rgb(200, 80, 90);

/// The nearest that something is drawn, as a share of the distance to the camera's target.
const NEAR: f32 = 1e-3;

/// A picture that can be drawn into.
pub struct Canvas<'a> {
    painter: Painter,
    rect: Rect,
    camera: &'a CameraDesc,
    /// How far what leaves the scene is drawn.
    far: f32,
}

impl<'a> Canvas<'a> {
    pub fn new(painter: Painter, rect: Rect, camera: &'a CameraDesc, scene: &Scene) -> Self {
        let far = scene.geometry().bounds().diagonal();
        Self {
            painter,
            rect,
            camera,
            far,
        }
    }

    /// A frame around a pixel.
    pub fn pixel(&self, [x, y]: [u32; 2], [width, height]: [u32; 2]) {
        let scale = Vec2::new(
            self.rect.width() / width as f32,
            self.rect.height() / height as f32,
        );
        let min = self.rect.min + Vec2::new(x as f32, y as f32) * scale;
        let rect = Rect::from_min_size(min, scale).expand(2.0);
        for (width, color) in [(3.0, Color32::from_black_alpha(160)), (1.0, Color32::WHITE)] {
            let stroke = Stroke::new(width, color);
            self.painter
                .rect_stroke(rect, 0.0, stroke, StrokeKind::Outside);
        }
    }

    /// All of a path, faintly.
    pub fn faint(&self, segments: &[Segment]) {
        let stroke = Stroke::new(1.0, Color32::from_white_alpha(28));
        for segment in segments.iter().skip(1) {
            self.line(segment.from, self.end(segment), stroke);
        }
    }

    /// Some segments of a path, with all that was looked for on the way.
    pub fn path(&self, segments: &[Segment]) {
        for segment in segments {
            let end = self.end(segment);
            for (width, color) in [(4.0, Color32::from_black_alpha(150)), (2.0, Color32::WHITE)] {
                self.line(segment.from, end, Stroke::new(width, color));
            }
            for aim in &segment.aims {
                let color = if aim.is_free {
                    COLORS[aim.strategy as usize]
                } else {
                    SHADED
                };
                let middle = aim.by.unwrap_or(end);
                for (a, b) in [(end, middle), (middle, aim.to)] {
                    self.dashes(a, b, Stroke::new(1.5, color));
                }
            }
        }
        for segment in segments.iter().filter(|segment| segment.end.is_some()) {
            let met = segment.met != Vec3::ZERO;
            let color = if met {
                COLORS[Strategy::Met as usize]
            } else {
                Color32::WHITE
            };
            if let Some(at) = self.at(self.end(segment)) {
                self.painter
                    .circle_filled(at, 4.0, Color32::from_black_alpha(200));
                self.painter.circle_filled(at, 3.0, color);
            }
        }
    }

    fn end(&self, segment: &Segment) -> Vec3 {
        let far = || segment.from + self.far * segment.dir;
        segment.end.map_or_else(far, |(end, _)| end)
    }

    fn at(&self, point: Vec3) -> Option<Pos2> {
        let ([x, y], _) = orbit::projected(self.camera, point)?;
        Some(self.rect.center() + Vec2::new(x, y) * self.rect.height())
    }

    /// Ends of the part of a line that is before the camera.
    fn seen(&self, a: Vec3, b: Vec3) -> Option<[Pos2; 2]> {
        let [a, b] = before(self.camera, a, b)?;
        Some([self.at(a)?, self.at(b)?])
    }

    fn line(&self, a: Vec3, b: Vec3, stroke: Stroke) {
        if let Some(ends) = self.seen(a, b) {
            self.painter.line_segment(ends, stroke);
        }
    }

    fn dashes(&self, a: Vec3, b: Vec3, stroke: Stroke) {
        if let Some([a, b]) = self.seen(a, b) {
            // What lies far outside the window is not dashed: it would take for ever.
            let reach = 4.0 * self.rect.size().length();
            if a.distance(b) < reach {
                self.painter
                    .extend(Shape::dashed_line(&[a, b], stroke, 6.0, 4.0));
            } else {
                self.painter.line_segment([a, b], stroke);
            }
        }
    }
}

/// The part of a line that lies before a camera.
fn before(camera: &CameraDesc, a: Vec3, b: Vec3) -> Option<[Vec3; 2]> {
    let way = camera.target - camera.eye;
    let forward = way.normalize_or_zero();
    let near = NEAR * way.length();
    let depth = |p: Vec3| (p - camera.eye).dot(forward) - near;
    let (da, db) = (depth(a), depth(b));
    let cut = || a + (b - a) * (da / (da - db));
    match (da > 0.0, db > 0.0) {
        (true, true) => Some([a, b]),
        (true, false) => Some([a, cut()]),
        (false, true) => Some([cut(), b]),
        (false, false) => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_behind_the_camera_is_cut_off() {
        let camera = CameraDesc {
            eye: Vec3::new(0.0, 0.0, 2.0),
            target: Vec3::ZERO,
            up: Vec3::Y,
            fov: 40.0,
        };
        let (front, back) = (Vec3::new(1.0, 0.0, 0.0), Vec3::new(1.0, 0.0, 4.0));
        assert_eq!(before(&camera, front, front), Some([front, front]));
        assert_eq!(before(&camera, back, back), None);
        for [a, b] in [[front, back], [back, front]] {
            let ends = before(&camera, a, b).expect("a part of it");
            assert!(ends.contains(&front));
            assert!(ends.iter().all(|p| orbit::projected(&camera, *p).is_some()));
            assert!(ends.iter().any(|p| (p.z - 1.998).abs() < 1e-5));
        }
    }
}
