//! A picture on the graphics card.

use egui::{Color32, Painter, Pos2, Rect, TextureHandle, TextureOptions};

use crate::session::Snapshot;

/// From how many screen pixels per pixel on single pixels are meant to be seen.
const SINGLE: f32 = 2.0;

/// The newest snapshot of its kind, uploaded when it is new.
pub struct Texture {
    name: &'static str,
    shown: Option<Shown>,
}

struct Shown {
    texture: TextureHandle,
    number: u64,
    options: TextureOptions,
}

impl Texture {
    /// Nothing yet.
    pub fn new(name: &'static str) -> Self {
        Self { name, shown: None }
    }

    /// Draws a snapshot into a rectangle.
    pub fn draw(&mut self, painter: &Painter, rect: Rect, snapshot: &Snapshot) {
        let ctx = painter.ctx();
        let pixels = rect.size() * ctx.pixels_per_point();
        let scale = pixels.x / snapshot.size[0] as f32;
        let one_to_one = (pixels.x - snapshot.size[0] as f32).abs() < 1.0;
        let is_coarse = snapshot.size != snapshot.picture;
        let options = if is_coarse || one_to_one || scale >= SINGLE {
            TextureOptions::NEAREST
        } else {
            TextureOptions::LINEAR
        };
        let is_current = |t: &Shown| (t.number, t.options) == (snapshot.number, options);
        if !self.shown.as_ref().is_some_and(is_current) {
            let image = snapshot.image.clone();
            match &mut self.shown {
                Some(shown) => {
                    shown.texture.set(image, options);
                    (shown.number, shown.options) = (snapshot.number, options);
                }
                None => {
                    let texture = ctx.load_texture(self.name, image, options);
                    self.shown = Some(Shown {
                        texture,
                        number: snapshot.number,
                        options,
                    });
                }
            }
        }
        if let Some(shown) = &self.shown {
            let whole = Rect::from_min_max(Pos2::ZERO, Pos2::new(1.0, 1.0));
            painter.image(shown.texture.id(), rect, whole, Color32::WHITE);
        }
    }
}
