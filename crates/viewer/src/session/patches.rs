//! The pixels of a picture as they are shown, cut into patches: a slice changes a few of them, and
//! only those are copied and go to the graphics card.

use std::sync::Arc;

use egui::{Color32, ColorImage};
use lightbox_core::film::{TILE, TileRect};

/// Edge of a patch: a few tiles, so that each tile lies in one.
const EDGE: usize = 4 * TILE as usize;

/// Patches row by row from the top, each shared by all pictures in which it is the same.
#[derive(Clone, Debug, Default)]
pub struct Patches {
    size: [usize; 2],
    patches: Vec<Arc<ColorImage>>,
}

impl Patches {
    /// Of sRGB bytes, row by row from the top.
    pub(crate) fn from_rgb(size: [usize; 2], rgb: &[u8]) -> Self {
        let patches = corners(size).map(|[x, y]| {
            let [width, height] = [size[0] - x, size[1] - y].map(|n| n.min(EDGE));
            let rows = (y..y + height).map(|y| &rgb[3 * (y * size[0] + x)..][..3 * width]);
            let pixels = rows.flat_map(|row| row.as_chunks().0);
            let pixels = pixels.map(|[r, g, b]| Color32::from_rgb(*r, *g, *b));
            Arc::new(ColorImage::new([width, height], pixels.collect()))
        });
        Self {
            size,
            patches: patches.collect(),
        }
    }

    /// A black picture.
    pub(crate) fn black(size: [usize; 2]) -> Self {
        Self::from_rgb(size, &vec![0; 3 * size[0] * size[1]])
    }

    /// Whether there is nothing yet.
    pub(crate) fn is_empty(&self) -> bool {
        self.patches.is_empty()
    }

    /// Puts the pixels of a tile where they belong.
    pub(crate) fn put(&mut self, rect: TileRect, pixels: &[[u8; 3]]) {
        let [x, y, width] = [rect.x, rect.y, rect.width].map(|n| n as usize);
        let place = y / EDGE * self.size[0].div_ceil(EDGE) + x / EDGE;
        let Some(patch) = self.patches.get_mut(place) else {
            return;
        };
        let patch = Arc::make_mut(patch);
        let rows = patch.pixels.chunks_exact_mut(patch.size[0]).skip(y % EDGE);
        for (to, row) in rows.zip(pixels.chunks_exact(width)) {
            let to = &mut to[x % EDGE..][..width];
            for (to, [r, g, b]) in to.iter_mut().zip(row) {
                *to = Color32::from_rgb(*r, *g, *b);
            }
        }
    }

    /// Patches that a picture of the same size did not have, and where their upper left corners are.
    pub fn since<'a>(
        &'a self,
        before: &'a Self,
    ) -> impl Iterator<Item = ([usize; 2], &'a Arc<ColorImage>)> {
        let pairs = self.patches.iter().zip(&before.patches);
        let changed = corners(self.size).zip(pairs);
        changed.filter_map(|(at, (now, then))| (!Arc::ptr_eq(now, then)).then_some((at, now)))
    }

    /// All of it in one.
    pub fn whole(&self) -> ColorImage {
        let [width, height] = self.size;
        let mut pixels = Vec::with_capacity(width * height);
        for row in self.patches.chunks(width.div_ceil(EDGE).max(1)) {
            for y in 0..row.first().map_or(0, |patch| patch.size[1]) {
                for patch in row {
                    let across = patch.size[0];
                    pixels.extend_from_slice(&patch.pixels[y * across..][..across]);
                }
            }
        }
        ColorImage::new(self.size, pixels)
    }

    /// sRGB bytes, row by row from the top.
    pub fn rgb(&self) -> Vec<u8> {
        let pixels = self.whole().pixels.into_iter();
        pixels.flat_map(|p| [p.r(), p.g(), p.b()]).collect()
    }
}

/// Where the patches of a picture begin.
fn corners([width, height]: [usize; 2]) -> impl Iterator<Item = [usize; 2]> {
    let rows = (0..height).step_by(EDGE);
    rows.flat_map(move |y| (0..width).step_by(EDGE).map(move |x| [x, y]))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_tile_changes_its_patch_and_no_other() {
        let [width, height] = [101, 72];
        let rgb: Vec<u8> = (0..3 * width * height).map(|i| (i % 251) as u8).collect();
        let before = Patches::from_rgb([width, height], &rgb);
        assert!(before.rgb() == rgb && before.whole().size == [width, height]);
        let mut after = before.clone();
        let rect = TileRect {
            x: 96,
            y: 16,
            width: 5,
            height: 16,
        };
        after.put(rect, &[[252, 253, 254]; 5 * 16]);
        let changed = after.since(&before).map(|(at, patch)| (at, patch.size));
        assert_eq!(changed.collect::<Vec<_>>(), [([64, 0], [37, 64])]);
        assert_eq!(before.since(&before.clone()).count(), 0);
        for (i, (now, then)) in after.rgb().iter().zip(&rgb).enumerate() {
            let (x, y) = (i / 3 % width, i / 3 / width);
            let is_within = x >= 96 && (16..32).contains(&y);
            let expected = if is_within {
                252 + (i % 3) as u8
            } else {
                *then
            };
            assert_eq!(*now, expected, "{x}, {y}");
        }
        // The last one has fewer rows.
        let rect = TileRect {
            x: 0,
            y: 64,
            width: 16,
            height: 8,
        };
        after.put(rect, &[[1; 3]; 16 * 8]);
        assert_eq!(after.since(&before).count(), 2);
        assert!(Patches::black([3, 2]).rgb() == [0; 18]);
    }
}
