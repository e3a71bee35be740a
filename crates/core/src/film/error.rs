//! How far a picture is from what it would be with endless samples, told from its own samples.
//!
//! The halves A and B of a pixel are independent and share one expectation μ. With a = A − μ and
//! b = B − μ, the error of their mean is (a + b)/2 and half their difference (a − b)/2. The squares
//! of the two are the same in the mean, whatever the shape of the noise, and differ by ab. So the
//! squared differences of all pixels together estimate the squared error of this very picture,
//! and are off by a sum of products ab: of mean 0 and variance σ⁴ each, with σ² the variance of a
//! half. Of normal noise σ⁴ is 4/3 of the mean fourth power of half the difference. The band is
//! thus as wide as the spread over pixels says, and nothing counts degrees of freedom.
//!
//! Pixels that share light, each [`APART`]th across and down of a tile ([`crate::Method::Reuse`]), have
//! errors in common. Half the differences have that in common too: over all pairs of such pixels of the tile
//! their products tell how much, and the band is as much wider.
//!
//! The relative error's denominator μ² + 0.01 takes μ from the neighbours as far as the pixel
//! seems to be one of them (after local statistics, Lee 1980). Taken from the pixel itself it
//! would rise with the very error that stands above it: outliers would hide themselves.

use glam::DVec3;
use rayon::prelude::*;

use super::{APART, Cell, Film, TILE, Tile, TileRect};

/// Estimate of a picture's error: noise, not bias. Light that no sample has met yet is missing
/// from it as it is from the picture.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct ErrorEstimate {
    /// Estimated relMSE: the mean over pixels and channels of (x − truth)²/(truth² + 0.01).
    pub rel_mse: f64,
    /// Lower end of the band that holds the true relMSE of nine pictures of ten, from
    /// [`BAND_FROM`] samples per pixel on.
    pub low: f64,
    /// Its upper end.
    pub high: f64,
    /// Mean radiance over pixels and channels, W/(m²·sr).
    pub mean: f64,
}

/// What a tile contributes to the estimate.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct TileError {
    /// Estimated squared error over (truth² + 0.01), summed over pixels and channels.
    sum: f64,
    /// Estimated variance of `sum` around what it estimates.
    variance: f64,
    /// Radiance, summed likewise.
    light: f64,
    pixels: u32,
}

/// Sums over the pixels of a tile, in one film or several.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct TileLight {
    pub rect: TileRect,
    /// Number of pixels.
    pub pixels: f64,
    /// Of radiance, channels summed.
    pub sum: f64,
    /// Of the squares that estimate the variance of each group of pixels that may share light.
    pub square: f64,
    /// Of their squares.
    pub fourth: f64,
}

/// Samples per pixel from which the band holds what it says. With fewer, much of the error lies
/// in outliers that either half has met once or not at all, and the band is too narrow.
pub const BAND_FROM: u64 = 64;

/// Pixels of a tile that may share light.
const GROUP: u32 = (TILE / APART) * (TILE / APART);

/// Quantile 0.95 of the normal distribution: nine of ten lie within as many standard deviations.
const NINE_OF_TEN: f64 = 1.644_853_627;

impl ErrorEstimate {
    /// The estimate from every tile of a picture, in order; `None` if one has nothing to tell yet.
    pub fn of(tiles: impl IntoIterator<Item = Option<TileError>>) -> Option<Self> {
        let mut all = TileError::default();
        for tile in tiles {
            let tile = tile?;
            all.sum += tile.sum;
            all.variance += tile.variance;
            all.light += tile.light;
            all.pixels += tile.pixels;
        }
        let rel_mse = all.rel_mse();
        // In the logarithm, so that the band stays above 0.
        let factor = if all.sum > 0.0 {
            (NINE_OF_TEN * all.variance.sqrt() / all.sum).exp()
        } else {
            1.0
        };
        Some(Self {
            rel_mse,
            low: rel_mse / factor,
            high: rel_mse * factor,
            mean: all.light / (3.0 * f64::from(all.pixels)),
        })
    }

    /// The band of [`ErrorEstimate::noise`].
    pub(crate) fn band(&self) -> [f64; 2] {
        [self.low.sqrt(), self.high.sqrt()]
    }

    /// Relative error, as a fraction: the square root of the relMSE.
    pub fn noise(&self) -> f64 {
        self.rel_mse.sqrt()
    }
}

impl TileError {
    /// Estimated relMSE of the tile.
    pub(crate) fn rel_mse(&self) -> f64 {
        self.sum / (3.0 * f64::from(self.pixels))
    }
}

impl Film {
    /// Estimated error of the picture so far; `None` below two samples per pixel. Runs on the
    /// threads of the current rayon pool.
    pub fn error(&self) -> Option<ErrorEstimate> {
        let tiles: Vec<Option<TileError>> = (0..self.tiles.len())
            .into_par_iter()
            .map(|i| self.tile_error(i))
            .collect();
        ErrorEstimate::of(tiles)
    }

    /// Estimated relative error of each pixel of a tile, as a fraction, row by row: the root of
    /// the mean square over channels and over the pixel and its neighbours, because one pixel's
    /// halves differ too little or too much by chance. `None` as for [`Film::error`].
    pub fn pixel_errors(&self, i: usize) -> Option<(TileRect, Vec<f32>)> {
        let tile = self.tile(i);
        let (squares, _, _) = self.relative_squares(&tile)?;
        let (around, counts) = (around(&squares), around(&ones(tile.rect)));
        let error = |i: usize| ((squares[i] + around[i]) / (3.0 * (counts[i] + 1.0))).sqrt();
        Some((tile.rect, places(tile.rect).map(error).collect()))
    }

    /// What tile `i` contributes to the estimate; `None` where a pixel lacks a sample in either
    /// half.
    pub fn tile_error(&self, i: usize) -> Option<TileError> {
        self.error_of(&self.tile(i))
    }

    pub(crate) fn error_of(&self, tile: &Tile) -> Option<TileError> {
        let (squares, signs, light) = self.relative_squares(tile)?;
        let roots = places(tile.rect).map(|i| f64::from(squares[i].sqrt().copysign(signs[i])));
        let groups = group_sums(tile.rect, roots);
        let mut error = TileError {
            light,
            pixels: tile.rect.width * tile.rect.height,
            ..TileError::default()
        };
        for i in places(tile.rect) {
            let square = f64::from(squares[i]);
            error.sum += square;
            error.variance += 4.0 / 3.0 * square * square;
        }
        if error.sum > 0.0 {
            // What pairs have in common, and products of halves have the squares of the covariances.
            let common = groups.iter().map(|sum| sum * sum).sum::<f64>() / error.sum - 1.0;
            error.variance *= 1.0 + common * common / f64::from(GROUP - 1);
        }
        Some(error)
    }

    /// Mean of a pixel, and the difference of its halves scaled so that its square estimates the
    /// mean's variance; `None` where a half has no sample.
    #[inline]
    pub(super) fn halves(&self, cells: &[Cell]) -> Option<(DVec3, DVec3)> {
        let (even, odd) = cells.split_at(cells.len() / 2);
        let count = |half: &[Cell]| half.iter().map(|c| c.count).sum::<u64>() as f64;
        let (n0, n1) = (count(even), count(odd));
        if n0 == 0.0 || n1 == 0.0 {
            return None;
        }
        let (a, b) = (self.mean(cells, [0]), self.mean(cells, [1]));
        let mean = (a * n0 + b * n1) / (n0 + n1);
        Some((mean, (a - b) * ((n0 * n1).sqrt() / (n0 + n1))))
    }

    /// Light of a tile and its noise, for comparison with another film's; `None` as for
    /// [`Film::error`].
    pub(crate) fn tile_light(&self, i: usize) -> Option<TileLight> {
        let tile = self.tile(i);
        let mut light = TileLight {
            rect: tile.rect,
            pixels: f64::from(tile.rect.width * tile.rect.height),
            ..TileLight::default()
        };
        if tile.samples < 2 {
            return None;
        }
        let mut differences = Vec::with_capacity(light.pixels as usize);
        for cells in tile.pixels() {
            let (mean, difference) = self.halves(cells)?;
            light.sum += mean.element_sum();
            differences.push(difference.element_sum());
        }
        for sum in group_sums(tile.rect, differences.into_iter()) {
            light.square += sum.powi(2);
            light.fourth += sum.powi(4);
        }
        Some(light)
    }

    /// Estimated squared error over (truth² + 0.01) of each pixel, summed over channels; which half
    /// was brighter, by sign; and the radiance of all, summed likewise.
    fn relative_squares(&self, tile: &Tile) -> Option<(Plane, Plane, f64)> {
        if tile.samples < 2 {
            return None;
        }
        let mut means = [EMPTY; 3];
        let mut squares = [EMPTY; 3];
        let mut signs = EMPTY;
        let mut light = 0.0;
        for (i, cells) in places(tile.rect).zip(tile.pixels()) {
            let (mean, difference) = self.halves(cells)?;
            let square = difference * difference;
            light += mean.element_sum();
            signs[i] = difference.element_sum() as f32;
            for channel in 0..3 {
                means[channel][i] = mean[channel] as f32;
                squares[channel][i] = square[channel] as f32;
            }
        }
        let counts = around(&ones(tile.rect));
        let mut relative = EMPTY;
        for (means, squares) in means.iter().zip(&squares) {
            let sums = around(means);
            let sums_of_squares = around(&means.map(|m| m * m));
            let noises = around(squares);
            for i in places(tile.rect) {
                let (own, square) = (means[i], squares[i]);
                let each = 1.0 / counts[i].max(1.0);
                let (mean, noise) = (sums[i] * each, noises[i] * each);
                // What noise does not explain: how much the neighbours differ from each other, or
                // the pixel from them.
                let among = sums_of_squares[i] * each - mean * mean - noise;
                let from = (own - mean) * (own - mean) - square;
                let structure = among.max(from).max(0.0);
                let all = structure + noise + square;
                let alike = if all > 0.0 && counts[i] > 0.0 {
                    1.0 - structure / all
                } else {
                    0.0
                };
                let truth = own + alike * (mean - own);
                relative[i] += square / (truth * truth + 0.01);
            }
        }
        Some((relative, signs, light))
    }
}

/// Edge of a tile with a margin of a pixel.
const STRIDE: usize = TILE as usize + 2;

/// A number for each pixel of a tile, and zeros around and beyond.
type Plane = [f32; STRIDE * STRIDE];

const EMPTY: Plane = [0.0; STRIDE * STRIDE];

/// Where the pixels of a tile stand in a plane, row by row.
fn places(rect: TileRect) -> impl Iterator<Item = usize> {
    let (width, height) = (rect.width as usize, rect.height as usize);
    (1..=height).flat_map(move |y| (1..=width).map(move |x| y * STRIDE + x))
}

/// Sums over the pixels of each group of a tile that may share light.
fn group_sums(
    rect: TileRect,
    values: impl Iterator<Item = f64>,
) -> [f64; (APART * APART) as usize] {
    let mut sums = [0.0; (APART * APART) as usize];
    let pixels = (0..rect.height).flat_map(|y| (0..rect.width).map(move |x| [x, y]));
    for ([x, y], value) in pixels.zip(values) {
        sums[(y % APART * APART + x % APART) as usize] += value;
    }
    sums
}

/// 1 for every pixel.
fn ones(rect: TileRect) -> Plane {
    let mut plane = EMPTY;
    for i in places(rect) {
        plane[i] = 1.0;
    }
    plane
}

/// Sum over the neighbours of each pixel, itself left out.
fn around(plane: &Plane) -> Plane {
    let within = STRIDE..EMPTY.len() - STRIDE;
    let (mut columns, mut sums) = (EMPTY, EMPTY);
    for i in within.clone() {
        columns[i] = plane[i - STRIDE] + plane[i] + plane[i + STRIDE];
    }
    for i in within {
        sums[i] = columns[i - 1] + plane[i - STRIDE] + plane[i + STRIDE] + columns[i + 1];
    }
    sums
}
