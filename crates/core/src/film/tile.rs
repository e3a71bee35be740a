//! The samples of a tile: exact sums, pixel by pixel.

use glam::Vec3;

use super::splats::Splat;
use super::survey::Survey;
use crate::planted::{self, Bug};

/// Edge of a tile, pixels.
pub const TILE: u32 = 16;

/// Radiance from which on a sample does not fit the sums: 2⁴⁰ W/(m²·sr). Sums hold 2²⁷ such.
pub(super) const RADIANCE_LIMIT: f32 = (1u64 << 40) as f32;

/// Fraction bits of the sums.
const FRACTION_BITS: i32 = 60;

/// What 1 in the sums stands for, and 1 in their upper 64 bits.
pub(super) const UNIT: f64 = 1.0 / (1u64 << FRACTION_BITS) as f64;
const UPPER_UNIT: f64 = (1u64 << (64 - FRACTION_BITS)) as f64;

/// Most invalid samples whose place is remembered.
pub(crate) const INVALID_KEPT: usize = 64;

/// Sum and count of the samples of one pixel in one half and one filter stratum.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Cell {
    pub sum: [i128; 3],
    pub count: u64,
}

/// A sample that was not a finite, non-negative radiance: left out of the picture and counted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct InvalidSample {
    /// Pixel, across and down from the upper left.
    pub pixel: [u32; 2],
    /// Sample index.
    pub sample: u64,
}

/// Where a tile lies in the picture.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct TileRect {
    /// Upper left pixel.
    pub x: u32,
    /// Upper left pixel.
    pub y: u32,
    /// Pixels across; [`TILE`] except at the right border.
    pub width: u32,
    /// Pixels down; [`TILE`] except at the lower border.
    pub height: u32,
}

impl TileRect {
    /// Its pixels, row by row.
    pub fn pixels(self) -> impl Iterator<Item = [u32; 2]> {
        let columns = self.x..self.x + self.width;
        (self.y..self.y + self.height).flat_map(move |y| columns.clone().map(move |x| [x, y]))
    }
}

/// The samples of one tile: in the film, or a batch on its way there.
#[derive(Clone, Debug)]
pub struct Tile {
    /// Position.
    pub rect: TileRect,
    /// One more than the index of the last sample taken of each pixel.
    pub samples: u64,
    /// Rays cast: those of a batch, or in a film's first tile those of all.
    pub rays: u64,
    /// Cells of a half: one for each filter stratum, and one for splats if the film takes them.
    pub(super) lanes: usize,
    /// Per pixel, row by row: `[half][lane]`; empty before the first samples.
    pub(super) cells: Vec<Cell>,
    /// Of a batch: light for other tiles.
    pub(super) splats: Vec<Splat>,
    pub(super) invalid: Vec<InvalidSample>,
    pub(super) invalid_count: u64,
    pub(super) survey: Survey,
}

impl Tile {
    /// A tile that takes up memory only once samples come.
    pub(super) fn empty(rect: TileRect, lanes: usize) -> Self {
        Self {
            rect,
            samples: 0,
            rays: 0,
            lanes,
            cells: Vec::new(),
            splats: Vec::new(),
            invalid: Vec::new(),
            invalid_count: 0,
            survey: Survey::default(),
        }
    }

    /// An empty batch for the same pixels.
    pub(crate) fn batch(&self) -> Self {
        let cells = (self.rect.width * self.rect.height) as usize * 2 * self.lanes;
        Self {
            cells: vec![Cell::default(); cells],
            ..Self::empty(self.rect, self.lanes)
        }
    }

    /// Adds one sample to pixel (x, y), counted from the tile's corner.
    #[inline]
    pub fn add(&mut self, [x, y]: [u32; 2], sample: u64, stratum: usize, radiance: Vec3) {
        // Component by component, so that NaN fails too.
        let limit = Vec3::splat(RADIANCE_LIMIT);
        let valid = radiance.cmpge(Vec3::ZERO).all() && radiance.cmplt(limit).all();
        if !(valid || planted::has(Bug::InvalidSamplesKept)) {
            self.invalid_count += 1;
            if self.invalid.len() < INVALID_KEPT {
                self.invalid.push(InvalidSample {
                    pixel: [self.rect.x + x, self.rect.y + y],
                    sample,
                });
            }
            return;
        }
        let pixel = (y * self.rect.width + x) as usize;
        let cell = &mut self.cells[(pixel * 2 + (sample & 1) as usize) * self.lanes + stratum];
        for (sum, value) in cell.sum.iter_mut().zip(radiance.to_array()) {
            *sum += fixed(value);
        }
        cell.count += 1;
    }

    /// The cells of each pixel, row by row; nothing before the first samples.
    pub(super) fn pixels(&self) -> impl Iterator<Item = &[Cell]> {
        self.cells.chunks_exact(2 * self.lanes)
    }

    pub(super) fn merge(&mut self, batch: &Self) {
        if self.cells.is_empty() {
            self.cells = vec![Cell::default(); batch.cells.len()];
        }
        for (to, from) in self.cells.iter_mut().zip(&batch.cells) {
            for (a, b) in to.sum.iter_mut().zip(from.sum) {
                *a += b;
            }
            to.count += from.count;
        }
        // What does not fit is no estimate; the picture does not depend on it.
        let _ = self.survey.add(&batch.survey);
        self.count_invalid(batch.invalid_count, &batch.invalid);
    }

    /// Adds to the invalid samples, of which the first are kept: whichever come first here.
    pub(super) fn count_invalid(&mut self, count: u64, kept: &[InvalidSample]) {
        self.invalid_count += count;
        if !kept.is_empty() {
            self.invalid.extend_from_slice(kept);
            self.invalid
                .sort_by_key(|i| (i.pixel[1], i.pixel[0], i.sample));
            self.invalid.truncate(INVALID_KEPT);
        }
    }
}

/// A non-negative f32 below [`RADIANCE_LIMIT`] in units of 2⁻⁶⁰, rounded down.
#[inline]
pub(super) fn fixed(x: f32) -> i128 {
    let bits = x.to_bits();
    let exponent = ((bits >> 23) & 0xff) as i32;
    // Subnormals are far below the unit: reading them as normal numbers changes nothing.
    let mantissa = i128::from((bits & 0x7f_ffff) | 0x80_0000);
    let shift = exponent - 127 - 23 + FRACTION_BITS;
    if shift >= 0 {
        mantissa << shift
    } else {
        mantissa >> (-shift).min(127)
    }
}

/// A sum in radiance, to the last bit or its neighbour. In two words, which the processor
/// converts itself: one of 128 bits takes a call.
#[inline]
pub(super) fn real(x: i128) -> f64 {
    let (high, low) = ((x >> 64) as i64 as f64, x as u64 as f64);
    high * UPPER_UNIT + low * UNIT
}
