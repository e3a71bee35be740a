//! The accumulation buffer.
//!
//! Sums are 128-bit integers in units of 2⁻⁶⁰ W/(m²·sr): exact and associative, so any order and
//! grouping of the same samples gives the same bits, and no sum ever freezes as f32 does. Each
//! pixel holds two half-films (even and odd samples, see [`crate::sampler`]), whose difference
//! estimates the noise without a reference. The film is cut into tiles; a tile is locked a few times per
//! finished batch, never per sample.

use std::sync::{Mutex, MutexGuard, PoisonError, RwLock, RwLockReadGuard, RwLockWriteGuard};

use glam::{DVec3, Vec3};
use rayon::prelude::*;

use crate::filter::FilterSampler;

mod error;
mod pack;
mod pixel;
mod splats;
mod survey;
mod tile;

pub(crate) use error::TileLight;
pub use error::{BAND_FROM, ErrorEstimate, TileError};
pub(crate) use pack::LONGEST_PACKED;
pub use pixel::Pixel;
use splats::Landing;
pub(crate) use splats::Splat;
pub(crate) use survey::{Followed, is_followed};
pub use survey::{Light, Lost};
pub(crate) use tile::INVALID_KEPT;
use tile::{Cell, real};
pub use tile::{InvalidSample, TILE, Tile, TileRect};

/// Pixels of a tile that may share light are so far apart, across and down: neighbours have nothing in
/// common.
pub(crate) const APART: u32 = 4;

/// How far a tile is from the centre of a picture, squared, in units of half a pixel.
fn from_center(rect: &TileRect, [width, height]: [u32; 2]) -> i64 {
    let dx = i64::from(2 * rect.x + rect.width) - i64::from(width);
    let dy = i64::from(2 * rect.y + rect.height) - i64::from(height);
    dx * dx + dy * dy
}

/// A picture in linear sRGB, row by row from the upper left.
#[derive(Clone, Debug, PartialEq)]
pub struct Image {
    /// Pixels across.
    pub width: u32,
    /// Pixels down.
    pub height: u32,
    /// `width·height` pixels.
    pub pixels: Vec<Vec3>,
}

impl Image {
    pub(crate) fn place(&mut self, tile: &Developed) {
        let rows = tile.pixels.chunks_exact(tile.rect.width as usize);
        for (y, row) in (tile.rect.y..).zip(rows) {
            let start = (y * self.width + tile.rect.x) as usize;
            self.pixels[start..start + row.len()].copy_from_slice(row);
        }
    }
}

/// A tile of the picture so far.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Developed {
    /// Position.
    pub rect: TileRect,
    /// Linear sRGB, row by row.
    pub pixels: Vec<Vec3>,
}

/// The film of one render: belongs to one scene, camera and settings for its whole life. A
/// change starts a new film, so that nothing late can land in it.
#[derive(Debug)]
pub struct Film {
    width: u32,
    height: u32,
    /// Index of the first sample.
    first: u64,
    /// Weight of each filter stratum's mean.
    weights: [f64; 2],
    /// From the centre of the picture outwards.
    tiles: Vec<Mutex<Tile>>,
    /// Shared by those who add, alone with who must not see batches half added.
    whole: RwLock<()>,
    /// If it takes splats.
    landing: Option<Landing>,
}

impl Clone for Film {
    /// Samples that come in the meantime wait.
    fn clone(&self) -> Self {
        let _still = self.stand_still();
        let tiles = (0..self.tiles.len()).map(|i| Mutex::new(self.tile(i).clone()));
        Self {
            tiles: tiles.collect(),
            landing: self.copy_landing(),
            whole: RwLock::new(()),
            ..*self
        }
    }
}

impl Film {
    /// An empty film; sizes must be at least 1.
    pub fn new(width: u32, height: u32, filter: &FilterSampler) -> Self {
        let mut rects = Vec::new();
        for y in (0..height).step_by(TILE as usize) {
            for x in (0..width).step_by(TILE as usize) {
                rects.push(TileRect {
                    x,
                    y,
                    width: TILE.min(width - x),
                    height: TILE.min(height - y),
                });
            }
        }
        rects.sort_by_key(|rect| from_center(rect, [width, height]));
        let tiles = rects
            .into_iter()
            .map(|r| Mutex::new(Tile::empty(r, filter.strata())))
            .collect();
        Self {
            width,
            height,
            first: 0,
            weights: filter.weights(),
            tiles,
            whole: RwLock::new(()),
            landing: None,
        }
    }

    /// The empty film of a slice: its first sample is that of index `first`.
    pub fn starting_at(mut self, first: u64) -> Self {
        self.first = first;
        for tile in &mut self.tiles {
            let tile = tile.get_mut().unwrap_or_else(PoisonError::into_inner);
            tile.samples = first;
        }
        self
    }

    /// Index of the first sample: 0 unless the film is that of a slice.
    pub fn first(&self) -> u64 {
        self.first
    }

    /// Pixels across and down.
    pub fn size(&self) -> [u32; 2] {
        [self.width, self.height]
    }

    /// Number of tiles.
    pub fn tiles(&self) -> usize {
        self.tiles.len()
    }

    /// Where tile `i` lies.
    pub fn tile_rect(&self, i: usize) -> TileRect {
        self.tile(i).rect
    }

    /// One tile, locked. A panic elsewhere cannot leave it half-written: only [`Film::merge`]
    /// writes, and it does not panic.
    fn tile(&self, i: usize) -> MutexGuard<'_, Tile> {
        self.tiles[i].lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// An empty batch for tile `i`, and the index of the first sample it lacks.
    pub fn batch(&self, i: usize) -> (Tile, u64) {
        let tile = self.tile(i);
        (tile.batch(), tile.samples)
    }

    /// How many samples tile `i` lacks up to so many.
    pub(crate) fn missing(&self, i: usize, samples: u64) -> u64 {
        samples.saturating_sub(self.tile(i).samples)
    }

    /// Adds a batch that holds the samples `first..end` of tile `i`. Refused (returns false) if
    /// those are not the ones that come next.
    pub fn merge(&self, i: usize, batch: &Tile, first: u64, end: u64) -> bool {
        self.merge_all([(i, batch, first)], end, batch.rays)
    }

    /// Adds batches, each of a tile and from some sample on, and the rays that were cast for all of them: whoever
    /// copies or writes the film meets all or none. Returns false, and counts no rays, if all were refused.
    pub(crate) fn merge_all<'a>(
        &self,
        batches: impl IntoIterator<Item = (usize, &'a Tile, u64)>,
        end: u64,
        rays: u64,
    ) -> bool {
        let _whole = self.landing();
        let mut is_taken = false;
        for (i, batch, first) in batches {
            is_taken |= self.add(i, batch, first, end);
        }
        if is_taken {
            // Tiles are rendered together, so that these are of no tile; and the same whichever were.
            self.tile(0).rays += rays;
        }
        is_taken
    }

    fn add(&self, i: usize, batch: &Tile, first: u64, end: u64) -> bool {
        let mut tile = self.tile(i);
        if tile.samples != first || batch.rect != tile.rect {
            return false;
        }
        tile.merge(batch);
        tile.samples = end;
        drop(tile);
        let pixels = u64::from(batch.rect.width * batch.rect.height);
        self.count_light_paths(&(first..end), pixels);
        self.land(batch.splats.clone());
        true
    }

    /// Held while batches are added.
    fn landing(&self) -> RwLockReadGuard<'_, ()> {
        self.whole.read().unwrap_or_else(PoisonError::into_inner)
    }

    /// Held while tiles must fit together: no batch is added meanwhile.
    pub(crate) fn stand_still(&self) -> RwLockWriteGuard<'_, ()> {
        self.whole.write().unwrap_or_else(PoisonError::into_inner)
    }

    /// One more than the index of the last sample that every tile has: samples per pixel, in a
    /// film that begins with the first.
    pub fn samples(&self) -> u64 {
        (0..self.tiles.len())
            .map(|i| self.tile(i).samples)
            .min()
            .unwrap_or(0)
    }

    /// The same of the tile that has most.
    pub fn most_samples(&self) -> u64 {
        (0..self.tiles.len())
            .map(|i| self.tile(i).samples)
            .max()
            .unwrap_or(0)
    }

    /// Paths traced for the picture so far, and rays cast.
    pub fn work(&self) -> [u64; 2] {
        (0..self.tiles.len()).fold([0; 2], |[paths, rays], i| {
            let tile = self.tile(i);
            let pixels = u64::from(tile.rect.width * tile.rect.height);
            let samples = tile.samples - self.first;
            [paths + samples * pixels, rays + tile.rays]
        })
    }

    /// Number of samples left out because they were NaN, infinite, negative or too large, and
    /// the first few of them.
    pub fn invalid(&self) -> (u64, Vec<InvalidSample>) {
        let mut count = 0;
        let mut kept = Vec::new();
        for i in 0..self.tiles.len() {
            let tile = self.tile(i);
            count += tile.invalid_count;
            kept.extend_from_slice(&tile.invalid);
        }
        kept.truncate(INVALID_KEPT);
        (count, kept)
    }

    /// The picture so far; pixels without samples are black. Runs on the threads of the current
    /// rayon pool.
    pub fn develop(&self) -> Image {
        let mut image = self.black();
        let tiles: Vec<_> = (0..self.tiles.len())
            .into_par_iter()
            .filter_map(|i| self.develop_tile(i))
            .collect();
        for tile in tiles {
            image.place(&tile);
        }
        image
    }

    /// A picture of the film's size without light.
    fn black(&self) -> Image {
        Image {
            width: self.width,
            height: self.height,
            pixels: vec![Vec3::ZERO; self.width as usize * self.height as usize],
        }
    }

    /// One tile of the picture so far; `None` before its first samples.
    pub fn develop_tile(&self, i: usize) -> Option<Developed> {
        self.developed(&self.tile(i))
    }

    pub(crate) fn developed(&self, tile: &Tile) -> Option<Developed> {
        let pixels: Vec<Vec3> = tile
            .pixels()
            .map(|cells| self.mean(cells, [0, 1]).as_vec3())
            .collect();
        (!pixels.is_empty()).then_some(Developed {
            rect: tile.rect,
            pixels,
        })
    }

    /// Mean radiance of some halves of a pixel.
    fn mean<const N: usize>(&self, cells: &[Cell], halves: [usize; N]) -> DVec3 {
        let lanes = cells.len() / 2;
        let strata = lanes - usize::from(self.takes_splats());
        let stratum = |s: usize| {
            let mut sum = [0i128; 3];
            let mut count = 0;
            for half in halves {
                let cell = &cells[half * lanes + s];
                count += cell.count;
                for (a, b) in sum.iter_mut().zip(cell.sum) {
                    *a += b;
                }
            }
            (count > 0).then(|| DVec3::from_array(sum.map(real)) / count as f64)
        };
        let mean = match (stratum(0), (strata > 1).then(|| stratum(1)).flatten()) {
            (Some(p), Some(n)) => self.weights[0] * p + self.weights[1] * n,
            // One stratum not sampled yet: the other stands for both, as in a constant scene.
            (Some(mean), None) | (None, Some(mean)) => mean,
            (None, None) => DVec3::ZERO,
        };
        mean + self.splatted(cells, halves)
    }

    /// What light paths have brought to some halves of a pixel.
    fn splatted<const N: usize>(&self, cells: &[Cell], halves: [usize; N]) -> DVec3 {
        let light_paths = self.light_paths(halves);
        if light_paths == 0.0 {
            return DVec3::ZERO;
        }
        let lanes = cells.len() / 2;
        let sums =
            halves.map(|half| DVec3::from_array(cells[(half + 1) * lanes - 1].sum.map(real)));
        sums.iter().sum::<DVec3>() / light_paths
    }
}

#[cfg(test)]
mod test;
