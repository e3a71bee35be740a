//! A closer look at the pixels there are: the camera stays where it is.

use egui::{Rect, Response, Vec2};

/// Most screen pixels per pixel of the picture, as a multiple of the whole.
const MOST: f32 = 64.0;

/// How close one comes to a pixel that is to be seen.
const CLOSE: f32 = 8.0;

/// Which part of the picture fills its place.
pub struct Zoom {
    scale: f32,
    /// What is in the middle, in shares of the picture.
    middle: Vec2,
    /// Where the pointer was last: shares of the picture, and points from the middle.
    pointer: (Vec2, Vec2),
}

impl Default for Zoom {
    fn default() -> Self {
        let middle = Vec2::splat(0.5);
        Self {
            scale: 1.0,
            middle,
            pointer: (middle, Vec2::ZERO),
        }
    }
}

impl Zoom {
    /// Where the whole picture lies, which without zoom would be `rect`.
    pub fn applied(&self, rect: Rect) -> Rect {
        if self.scale == 1.0 {
            return rect;
        }
        let size = rect.size() * self.scale;
        Rect::from_min_size(rect.center() - self.middle * size, size)
    }

    /// Takes note of the pointer over the picture in `zoomed`, without zoom `rect`.
    pub fn follow(&mut self, response: &Response, rect: Rect, zoomed: Rect) {
        let pos = response.hover_pos().unwrap_or(rect.center());
        self.pointer = (
            (pos - zoomed.min) / zoomed.size(),
            (pos - rect.center()) / rect.size(),
        );
    }

    /// Comes closer by a factor to what is under the pointer.
    pub fn by(&mut self, factor: f32) {
        self.scale = (self.scale * factor).clamp(1.0, MOST);
        let (share, offset) = self.pointer;
        self.look_at(share - offset / self.scale);
        self.pointer = (self.middle + offset / self.scale, offset);
    }

    /// Comes close to a place, in shares of the picture.
    pub fn show(&mut self, place: Vec2) {
        self.scale = self.scale.max(CLOSE);
        self.look_at(place);
    }

    /// Whether less than all of the picture is seen.
    pub fn is_close(&self) -> bool {
        self.scale > 1.0
    }

    /// Shifts what is seen of the picture, all of which lies in `zoomed`.
    pub fn pan(&mut self, by: Vec2, zoomed: Rect) {
        self.look_at(self.middle - by / zoomed.size());
    }

    /// No more is seen beside the picture than without zoom.
    fn look_at(&mut self, middle: Vec2) {
        let half = 0.5 / self.scale;
        self.middle = middle.clamp(Vec2::splat(half), Vec2::splat(1.0 - half));
    }

    /// All of the picture.
    pub fn reset(&mut self) {
        *self = Self::default();
    }
}

#[cfg(test)]
mod tests {
    use egui::Pos2;

    use super::*;

    #[test]
    fn what_is_under_the_pointer_stays_there() {
        let rect = Rect::from_min_size(Pos2::new(10.0, 20.0), Vec2::new(200.0, 100.0));
        let mut zoom = Zoom::default();
        assert_eq!(zoom.applied(rect), rect);
        let pos = Pos2::new(150.0, 60.0);
        let share = |zoom: &Zoom| (pos - zoom.applied(rect).min) / zoom.applied(rect).size();
        let before = share(&zoom);
        zoom.pointer = (before, (pos - rect.center()) / rect.size());
        for _ in 0..3 {
            zoom.by(2.0);
            assert!((share(&zoom) - before).length() < 1e-5);
            assert!(zoom.applied(rect).contains_rect(rect));
        }
        assert_eq!(zoom.applied(rect).width(), 1600.0);
        for _ in 0..5 {
            zoom.by(0.5);
        }
        assert_eq!(zoom.applied(rect), rect);
        zoom.by(1e9);
        assert_eq!(zoom.applied(rect).width(), 200.0 * MOST);
        zoom.reset();
        assert_eq!(zoom.applied(rect), rect);
        assert!(!zoom.is_close());
    }

    #[test]
    fn a_pan_takes_the_picture_along_but_not_beside_its_place() {
        let rect = Rect::from_min_size(Pos2::new(10.0, 20.0), Vec2::new(200.0, 100.0));
        let mut zoom = Zoom::default();
        zoom.by(4.0);
        let before = zoom.applied(rect);
        zoom.pan(Vec2::new(-30.0, 7.0), before);
        let after = zoom.applied(rect);
        assert!((after.min - before.min - Vec2::new(-30.0, 7.0)).length() < 1e-3);
        assert_eq!(after.size(), before.size());
        zoom.pan(Vec2::new(1e5, -1e5), after);
        let corner = zoom.applied(rect);
        assert!(corner.contains_rect(rect.shrink(1e-3)), "{corner}");
        assert!((corner.left_bottom() - rect.left_bottom()).length() < 1e-3);
    }
}
