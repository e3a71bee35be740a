//! Tiles as bytes, for files.
//!
//! The sums of a tile are numbers of one magnitude, so that most of their bytes are zero: of each
//! column (one channel of one half and stratum, or of splats, over all pixels) only the bytes that differ from
//! zero somewhere are kept. That makes a picture's sums about a third as long, at the speed of
//! memory.

use super::survey::{LENGTHS, Survey};
use super::{Cell, Film, INVALID_KEPT, InvalidSample, Tile};

/// Bytes of the longest packed tile: no honest record exceeds it.
pub(crate) const LONGEST_PACKED: usize = {
    let cells = (super::TILE * super::TILE) as usize * 6;
    32 + INVALID_KEPT * 16 + cells * COLUMNS * (16 + 2) + 16 + (LENGTHS + 1) * 16
};

/// Columns of a cell: three sums and the count.
const COLUMNS: usize = 4;

impl Cell {
    fn column(&self, column: usize) -> u128 {
        match self.sum.get(column) {
            Some(sum) => sum.cast_unsigned(),
            None => self.count.into(),
        }
    }

    fn add_to_column(&mut self, column: usize, value: u128) -> Option<()> {
        match self.sum.get_mut(column) {
            Some(sum) => *sum = sum.checked_add(value.cast_signed())?,
            None => self.count = self.count.checked_add(value.try_into().ok()?)?,
        }
        Some(())
    }
}

impl Tile {
    /// Appends the tile to `bytes`.
    pub(crate) fn pack(&self, bytes: &mut Vec<u8>) {
        for number in [
            self.samples,
            self.rays,
            self.invalid_count,
            self.invalid.len() as u64,
        ] {
            bytes.extend(number.to_le_bytes());
        }
        for InvalidSample { pixel, sample } in &self.invalid {
            bytes.extend(pixel.iter().flat_map(|x| x.to_le_bytes()));
            bytes.extend(sample.to_le_bytes());
        }
        let Survey {
            paths,
            beyond,
            by_length,
        } = &self.survey;
        for number in [*paths, by_length.len() as u64] {
            bytes.extend(number.to_le_bytes());
        }
        for sum in [beyond].into_iter().chain(by_length) {
            bytes.extend(sum.to_le_bytes());
        }
        for lane in 0..2 * self.lanes {
            for column in 0..COLUMNS {
                let values = || self.pixels().map(|cells| cells[lane].column(column));
                let used = values().fold(0, |used, value| used | value);
                let start = if used == 0 {
                    0
                } else {
                    used.trailing_zeros() as usize / 8
                };
                let end = 16 - used.leading_zeros() as usize / 8;
                bytes.extend([start as u8, end as u8]);
                for value in values() {
                    bytes.extend_from_slice(&value.to_le_bytes()[start..end]);
                }
            }
        }
    }

    /// Number of invalid samples, and the first of them.
    pub(crate) fn invalid(&self) -> (u64, &[InvalidSample]) {
        (self.invalid_count, &self.invalid)
    }

    /// Adds a packed tile of the same place, and returns its [`Tile::samples`], which this tile
    /// then has at least. `None` if the bytes do not hold such a tile.
    pub(crate) fn add_packed(&mut self, bytes: &[u8]) -> Option<u64> {
        let mut rest = bytes;
        let mut number = || rest.split_off(..8)?.try_into().ok().map(u64::from_le_bytes);
        let (samples, rays, invalid_count, kept) = (number()?, number()?, number()?, number()?);
        if kept > INVALID_KEPT as u64 {
            return None;
        }
        let mut invalid = Vec::new();
        for _ in 0..kept {
            let (pixel, sample) = (rest.split_off(..8)?, rest.split_off(..8)?);
            let [x, y] = [0, 4].map(|i| pixel[i..i + 4].try_into().map(u32::from_le_bytes));
            invalid.push(InvalidSample {
                pixel: [x.ok()?, y.ok()?],
                sample: u64::from_le_bytes(sample.try_into().ok()?),
            });
        }
        let mut number = || rest.split_off(..8)?.try_into().ok().map(u64::from_le_bytes);
        let (paths, lengths) = (number()?, number()?);
        if lengths > LENGTHS as u64 {
            return None;
        }
        let mut sum = || {
            rest.split_off(..16)?
                .try_into()
                .ok()
                .map(i128::from_le_bytes)
        };
        self.survey.add(&Survey {
            paths,
            beyond: sum()?,
            by_length: (0..lengths).map(|_| sum()).collect::<Option<_>>()?,
        })?;
        if self.cells.is_empty() {
            self.cells = self.batch().cells;
        }
        let lanes = 2 * self.lanes;
        let mut column_bytes = Vec::new();
        for lane in 0..lanes {
            for column in 0..COLUMNS {
                let &[start, end] = rest.split_off(..2)? else {
                    return None;
                };
                let (start, end) = (usize::from(start), usize::from(end));
                if start > end || end > 16 {
                    return None;
                }
                let width = end - start;
                if width == 0 {
                    continue;
                }
                let pixels = self.cells.len() / lanes;
                // Followed by zeros, so that 16 bytes can be read at every value.
                column_bytes.clear();
                column_bytes.extend_from_slice(rest.split_off(..width * pixels)?);
                column_bytes.extend([0; 16]);
                let used = u128::MAX >> (128 - 8 * width);
                let windows = column_bytes.windows(16).step_by(width);
                for (cells, window) in self.cells.chunks_exact_mut(lanes).zip(windows) {
                    let value = u128::from_le_bytes(window.try_into().ok()?) & used;
                    cells[lane].add_to_column(column, value << (8 * start))?;
                }
            }
        }
        self.samples = self.samples.max(samples);
        self.rays = self.rays.checked_add(rays)?;
        self.count_invalid(invalid_count, &invalid);
        rest.is_empty().then_some(samples)
    }
}

impl Film {
    /// Appends tile `i` to `bytes`.
    pub(crate) fn pack_tile(&self, i: usize, bytes: &mut Vec<u8>) {
        self.tile(i).pack(bytes);
    }

    /// A tile in the place of tile `i`, without samples.
    pub(crate) fn empty_tile(&self, i: usize) -> Tile {
        let tile = self.tile(i);
        Tile::empty(tile.rect, tile.lanes)
    }

    /// Replaces tile `i`, which has no samples yet.
    pub(crate) fn set_tile(&self, i: usize, tile: Tile) {
        let pixels = u64::from(tile.rect.width * tile.rect.height);
        self.count_light_paths(&(self.first..tile.samples), pixels);
        *self.tile(i) = tile;
    }
}
