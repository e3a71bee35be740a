//! A tile or a pixel of a film, looked at closely.

use glam::Vec3;

use super::{Cell, Film, TILE, Tile, TileRect, from_center};

/// What the film knows of one pixel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pixel {
    /// Mean radiance, W/(m²·sr).
    pub mean: Vec3,
    /// What light paths have brought of it.
    pub by_light_paths: Vec3,
    /// Its standard error (noise, not bias): the root of the mean square over the pixel and its
    /// neighbours within the tile, because one pixel's halves differ too little or too much by
    /// chance. `None` where a half has no sample yet.
    pub error: Option<Vec3>,
    /// Samples taken.
    pub samples: u64,
    /// Samples that were left out because they were no radiance.
    pub invalid: u64,
}

impl Film {
    /// The samples taken of each pixel of a tile.
    pub fn tile_samples(&self, i: usize) -> u64 {
        self.tile(i).samples - self.first
    }

    /// Of each pixel of a tile, row by row, how many samples were left out; nothing before its first.
    pub fn tile_invalid(&self, i: usize) -> Vec<u64> {
        let tile = self.tile(i);
        let pixels = tile.pixels();
        pixels.map(|cells| self.left_out(&tile, cells)).collect()
    }

    /// What is known of pixel (x, y); `None` before its first sample and outside the picture.
    pub fn pixel(&self, [x, y]: [u32; 2]) -> Option<Pixel> {
        let tile = self.tile(self.tile_at([x, y])?);
        let at = |x: u32, y: u32| {
            let start = ((y * tile.rect.width + x) as usize) * 2 * tile.lanes;
            tile.cells.get(start..start + 2 * tile.lanes)
        };
        let (x, y) = (x - tile.rect.x, y - tile.rect.y);
        let cells = at(x, y)?;
        if tile.samples == self.first {
            return None;
        }
        let (mut square, mut count) = (glam::DVec3::ZERO, 0.0);
        for y in y.saturating_sub(1)..=(y + 1).min(tile.rect.height - 1) {
            for x in x.saturating_sub(1)..=(x + 1).min(tile.rect.width - 1) {
                if let Some((_, difference)) = self.halves(at(x, y)?) {
                    square += difference * difference;
                    count += 1.0;
                }
            }
        }
        let is_known = self.halves(cells).is_some();
        let error = (square / count).map(f64::sqrt).as_vec3();
        Some(Pixel {
            mean: self.mean(cells, [0, 1]).as_vec3(),
            by_light_paths: self.splatted(cells, [0, 1]).as_vec3(),
            error: is_known.then_some(error),
            samples: tile.samples - self.first,
            invalid: self.left_out(&tile, cells),
        })
    }

    fn left_out(&self, tile: &Tile, cells: &[Cell]) -> u64 {
        (tile.samples - self.first) - cells.iter().map(|c| c.count).sum::<u64>()
    }

    /// The tile that holds a pixel: tiles are in order of their distance from the centre.
    fn tile_at(&self, [x, y]: [u32; 2]) -> Option<usize> {
        if x >= self.width || y >= self.height {
            return None;
        }
        let size = [self.width, self.height];
        let corner = [x, y].map(|n| n / TILE * TILE);
        let wanted = TileRect {
            x: corner[0],
            y: corner[1],
            width: TILE.min(self.width - corner[0]),
            height: TILE.min(self.height - corner[1]),
        };
        let far = from_center(&wanted, size);
        let (mut low, mut high) = (0, self.tiles.len());
        while low < high {
            let middle = low.midpoint(high);
            if from_center(&self.tile_rect(middle), size) < far {
                low = middle + 1;
            } else {
                high = middle;
            }
        }
        (low..self.tiles.len()).find(|i| self.tile_rect(*i) == wanted)
    }
}
