//! A picture on the graphics card.

use egui::{Color32, Context, Painter, Pos2, Rect, TextureHandle, TextureOptions};

use crate::session::{Patches, Snapshot};

/// From how many screen pixels per pixel on single pixels are meant to be seen.
const SINGLE: f32 = 2.0;

/// The newest snapshot of its kind, uploaded when it is new.
pub struct Texture {
    name: &'static str,
    shown: Option<Shown>,
}

struct Shown {
    texture: TextureHandle,
    size: [usize; 2],
    patches: Patches,
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
        self.upload(ctx, snapshot, options);
        if let Some(shown) = &self.shown {
            let whole = Rect::from_min_max(Pos2::ZERO, Pos2::new(1.0, 1.0));
            painter.image(shown.texture.id(), rect, whole, Color32::WHITE);
        }
    }

    /// Brings what the graphics card has up to date: by what has changed where it has a picture of the
    /// same size.
    fn upload(&mut self, ctx: &Context, snapshot: &Snapshot, options: TextureOptions) {
        let (size, patches) = (snapshot.size, snapshot.patches.clone());
        match &mut self.shown {
            Some(shown) if (shown.size, shown.options) == (size, options) => {
                for (at, patch) in patches.since(&shown.patches) {
                    shown.texture.set_partial(at, patch.clone(), options);
                }
                shown.patches = patches;
            }
            Some(shown) => {
                shown.texture.set(patches.whole(), options);
                (shown.size, shown.patches, shown.options) = (size, patches, options);
            }
            None => {
                let texture = ctx.load_texture(self.name, patches.whole(), options);
                self.shown = Some(Shown {
                    texture,
                    size,
                    patches,
                    options,
                });
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use egui::{RawInput, TextureId};

    use super::*;
    use crate::aov::Aov;

    /// What goes to the graphics card, besides egui's fonts: where, and how many pixels across and down.
    fn uploads(
        ctx: &Context,
        texture: &mut Texture,
        snapshot: &Snapshot,
    ) -> Vec<(Option<[usize; 2]>, [usize; 2])> {
        let mut output = ctx.run_ui(RawInput::default(), |ui| {
            let rect = Rect::from_min_size(Pos2::ZERO, egui::vec2(40.0, 40.0));
            texture.draw(ui.painter(), rect, snapshot);
        });
        let set = output.textures_delta.set.drain();
        let set = set.filter(|(id, _)| *id != TextureId::default());
        set.flat_map(|(_, deltas)| deltas)
            .map(|d| (d.pos, d.image.size()))
            .collect()
    }

    fn snapshot(size: [usize; 2], patches: Patches) -> Snapshot {
        Snapshot {
            size,
            patches,
            picture: size,
            preview: None,
            past: None,
            aov: Aov::COLOR,
            number: 0,
        }
    }

    #[test]
    fn only_what_has_changed_is_uploaded() {
        let (ctx, mut texture) = (Context::default(), Texture::new("test"));
        let mut patches = Patches::black([100, 100]);
        let before = snapshot([100, 100], patches.clone());
        assert_eq!(uploads(&ctx, &mut texture, &before), [(None, [100, 100])]);
        assert_eq!(uploads(&ctx, &mut texture, &before), []);
        let rect = lightbox_core::film::TileRect {
            x: 64,
            y: 16,
            width: 16,
            height: 16,
        };
        patches.put(rect, &[[255; 3]; 256]);
        let after = snapshot([100, 100], patches);
        let patch = (Some([64, 0]), [36, 64]);
        assert_eq!(uploads(&ctx, &mut texture, &after), [patch]);
        // Back to another one, as looking back does.
        assert_eq!(uploads(&ctx, &mut texture, &before), [patch]);
        let small = snapshot([20, 20], Patches::black([20, 20]));
        assert_eq!(uploads(&ctx, &mut texture, &small), [(None, [20, 20])]);
        assert_eq!(uploads(&ctx, &mut texture, &after), [(None, [100, 100])]);
    }
}
