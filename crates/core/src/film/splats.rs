//! Light that lands anywhere in the picture, whichever pixel's sample has brought it.
//!
//! Every sample of a pixel traces a light path beside the camera path ([`crate::integrator`]), and
//! what that finds is added to the pixels that see it, in a cell of its own: exact numbers whose
//! sum is the same in any order. The mean is over all light paths of the picture, of the same
//! half as the sample.

use std::ops::Range;
use std::sync::PoisonError;
use std::sync::atomic::{AtomicU64, Ordering};

use glam::Vec3;

use super::tile::{RADIANCE_LIMIT, fixed};
use super::{Film, InvalidSample, TILE, Tile};

/// Light for one pixel.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Splat {
    /// Where it lands.
    pub pixel: [u32; 2],
    /// Even and odd samples.
    pub half: u8,
    /// Its share of the pixel's radiance, W/(m²·sr), if each pixel had traced one light path.
    /// May be negative where the pixel filter is.
    pub radiance: Vec3,
}

/// What a film that takes splats holds beside its tiles.
#[derive(Debug, Default)]
pub(super) struct Landing {
    /// Light paths traced, by half.
    paths: [AtomicU64; 2],
    /// Index of the tile in each place, row by row.
    grid: Vec<u32>,
}

/// Even and odd numbers within a range.
fn halves(samples: &Range<u64>) -> [u64; 2] {
    let even = samples.end.div_ceil(2) - samples.start.div_ceil(2);
    [even, samples.end - samples.start - even]
}

impl Tile {
    /// Adds light that a sample of a pixel, counted from the corner, has brought to other pixels.
    pub(crate) fn add_splat(&mut self, [x, y]: [u32; 2], sample: u64, splat: Splat) {
        let limit = Vec3::splat(RADIANCE_LIMIT);
        if splat.radiance.abs().cmplt(limit).all() {
            self.splats.push(splat);
        } else {
            let pixel = [self.rect.x + x, self.rect.y + y];
            self.count_invalid(1, &[InvalidSample { pixel, sample }]);
        }
    }
}

impl Film {
    /// The same, to take splats; before the first samples.
    pub(crate) fn with_splats(mut self) -> Self {
        let columns = self.width.div_ceil(TILE);
        let mut grid = vec![0; self.tiles.len()];
        for (i, tile) in self.tiles.iter_mut().enumerate() {
            let tile = tile.get_mut().unwrap_or_else(PoisonError::into_inner);
            tile.lanes += 1;
            let [column, row] = [tile.rect.x / TILE, tile.rect.y / TILE];
            grid[(row * columns + column) as usize] = i as u32;
        }
        self.landing = Some(Landing {
            grid,
            ..Landing::default()
        });
        self
    }

    /// Whether it takes splats.
    pub fn takes_splats(&self) -> bool {
        self.landing.is_some()
    }

    /// Counts the light paths of some samples of so many pixels.
    pub(crate) fn count_light_paths(&self, samples: &Range<u64>, pixels: u64) {
        if let Some(landing) = &self.landing {
            for (paths, more) in landing.paths.iter().zip(halves(samples)) {
                paths.fetch_add(more * pixels, Ordering::Relaxed);
            }
        }
    }

    /// Lets the light of a batch land.
    pub(super) fn land(&self, mut splats: Vec<Splat>) {
        let Some(Landing { grid, .. }) = &self.landing else {
            return;
        };
        let columns = self.width.div_ceil(TILE);
        let tile_of = |splat: &Splat| {
            let [column, row] = splat.pixel.map(|x| x / TILE);
            grid[(row * columns + column) as usize]
        };
        // Each tile is locked once.
        splats.sort_unstable_by_key(tile_of);
        for splats in splats.chunk_by(|a, b| tile_of(a) == tile_of(b)) {
            let mut tile = self.tile(tile_of(&splats[0]) as usize);
            let (rect, lanes) = (tile.rect, tile.lanes);
            if tile.cells.is_empty() {
                tile.cells = tile.batch().cells;
            }
            for splat in splats {
                let [x, y] = splat.pixel;
                let pixel = ((y - rect.y) * rect.width + (x - rect.x)) as usize;
                let cell = &mut tile.cells[(2 * pixel + usize::from(splat.half) + 1) * lanes - 1];
                for (sum, value) in cell.sum.iter_mut().zip(splat.radiance.to_array()) {
                    let size = fixed(value.abs());
                    *sum += if value < 0.0 { -size } else { size };
                }
            }
        }
    }

    /// Light paths of some halves per pixel.
    pub(super) fn light_paths<const N: usize>(&self, halves: [usize; N]) -> f64 {
        let Some(landing) = &self.landing else {
            return 0.0;
        };
        let paths = halves.map(|half| landing.paths[half].load(Ordering::Relaxed));
        let pixels = f64::from(self.width) * f64::from(self.height);
        paths.iter().sum::<u64>() as f64 / pixels
    }

    /// What a copy holds beside its tiles.
    pub(super) fn copy_landing(&self) -> Option<Landing> {
        let landing = self.landing.as_ref()?;
        let paths = &landing.paths;
        Some(Landing {
            paths: [0, 1].map(|half| AtomicU64::new(paths[half].load(Ordering::Relaxed))),
            grid: landing.grid.clone(),
        })
    }
}
