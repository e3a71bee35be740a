//! What the depth of paths leaves out: a few paths are followed to their ends, and the light that
//! they bring is counted by the number of their segments. None of it enters the picture.
//!
//! All pixels of a tile are followed together, at one sample in [`interval`]. Russian roulette ends
//! each path at last, so what is counted beyond the depth is an unbiased estimate of what is lost.

use serde::Serialize;

use super::tile::{RADIANCE_LIMIT, UNIT, real};
use super::{Film, TILE, Tile, TileRect};

/// Numbers of segments that are told apart; the last stands for all above it too.
pub const LENGTHS: usize = 64;

/// One sample in this many of a tile is followed to its end. It goes on for about twenty segments
/// at worst, as one path in twenty ends at each, so that with paths of some depth this costs a
/// hundredth at most of what they do.
fn interval(depth: u32) -> u64 {
    u64::from((2048 / depth).next_power_of_two().max(64))
}

/// Whether the paths of a tile at a sample are followed to their ends: spread evenly over tiles
/// and samples (the R₂ sequence of Roberts 2018 over tiles).
pub(crate) fn is_followed(rect: &TileRect, sample: u64, depth: u32) -> bool {
    let phase = (rect.x / TILE)
        .wrapping_mul(0xc13f_a9a9)
        .wrapping_add((rect.y / TILE).wrapping_mul(0x91e1_0da5));
    let interval = interval(depth);
    let phase = u64::from(phase) >> (32 - interval.trailing_zeros());
    (sample + phase).is_multiple_of(interval)
}

/// Light that paths followed together have brought, sum over paths and channels, by their number
/// of segments less 1.
#[derive(Clone, Debug)]
pub(crate) struct Followed {
    by_length: [f64; LENGTHS],
    /// Beyond the depth of the picture.
    beyond: f64,
}

impl Default for Followed {
    fn default() -> Self {
        Self {
            by_length: [0.0; LENGTHS],
            beyond: 0.0,
        }
    }
}

impl Followed {
    /// Adds what paths of some number of segments have brought.
    pub fn add(&mut self, segments: u32, light: f64, is_beyond: bool) {
        self.by_length[(segments as usize).clamp(1, LENGTHS) - 1] += light;
        self.beyond += if is_beyond { light } else { 0.0 };
    }
}

/// What has been found by following paths of a tile, in the film's exact numbers.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(super) struct Survey {
    pub paths: u64,
    pub beyond: i128,
    pub by_length: Vec<i128>,
}

impl Survey {
    /// `None` if a sum does not fit.
    pub fn add(&mut self, other: &Self) -> Option<()> {
        self.paths = self.paths.checked_add(other.paths)?;
        self.beyond = self.beyond.checked_add(other.beyond)?;
        if self.by_length.len() < other.by_length.len() {
            self.by_length.resize(other.by_length.len(), 0);
        }
        for (a, b) in self.by_length.iter_mut().zip(&other.by_length) {
            *a = a.checked_add(*b)?;
        }
        Some(())
    }
}

impl Tile {
    /// Adds what some paths have brought. Nothing if one of them was no radiance.
    pub(crate) fn add_followed(&mut self, paths: u64, followed: &Followed) {
        let limit = f64::from(RADIANCE_LIMIT) * paths as f64;
        let exact = |x: f64| (x / UNIT) as i128;
        let used = followed.by_length.iter().rposition(|x| *x != 0.0);
        let by_length = &followed.by_length[..used.map_or(0, |last| last + 1)];
        if by_length.iter().all(|x| (0.0..limit).contains(x)) {
            let survey = Survey {
                paths,
                beyond: exact(followed.beyond),
                by_length: by_length.iter().map(|x| exact(*x)).collect(),
            };
            // Sums of the film's own samples would not fit before these.
            let _ = self.survey.add(&survey);
        }
    }
}

/// Light that the depth of paths leaves out.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[non_exhaustive]
pub struct Lost {
    /// Share of all light.
    pub share: f64,
    /// Its standard error.
    pub error: f64,
    /// Paths that were followed to their ends to find out.
    pub paths: u64,
}

/// Where the light of a picture comes from, by the number of segments of the paths that bring it.
#[derive(Clone, Debug, Default)]
pub struct Light {
    sum: Survey,
    /// What the depth leaves out, and paths, of each tile of which some were followed.
    tiles: Vec<[f64; 2]>,
}

impl Light {
    pub(crate) fn add(&mut self, tile: &Tile) {
        if tile.survey.paths > 0 {
            // Each was part of a sum that fits; a longer film could not be held either.
            let _ = self.sum.add(&tile.survey);
            let Survey { paths, beyond, .. } = tile.survey;
            self.tiles.push([real(beyond), paths as f64]);
        }
    }

    /// What the depth of a picture of some `mean` radiance ([`super::ErrorEstimate::mean`]) leaves out.
    /// `None` as long as less than two tiles tell of it. What is found within the depth is known
    /// from all samples; what is beyond, from the paths followed, with the standard error of a
    /// mean over tiles (Cochran 1977, Sampling Techniques, section 9.3).
    pub fn lost(&self, mean: f64) -> Option<Lost> {
        let n = self.tiles.len() as f64;
        let (beyond, all) = (self.per_path(&[self.sum.beyond]), self.all(mean)?);
        if n < 2.0 {
            return None;
        }
        let squares = self.tiles.iter().map(|[l, p]| (l - beyond * p).powi(2));
        let variance = n / (n - 1.0) * squares.sum::<f64>() / (self.sum.paths as f64).powi(2);
        Some(Lost {
            share: beyond / all,
            error: variance.sqrt() * (all - beyond) / (all * all),
            paths: self.sum.paths,
        })
    }

    /// Share of all light that paths of more than `depth` segments bring; known up to 63, and up to
    /// the depth of the picture.
    pub(crate) fn beyond(&self, depth: u32, mean: f64) -> Option<f64> {
        let within = usize::try_from(depth).ok().filter(|d| *d < LENGTHS)?;
        let rest = self.sum.by_length.get(within..).unwrap_or_default();
        Some(self.per_path(rest) / self.all(mean)?)
    }

    /// The least depth that leaves out less than a share of all light.
    pub fn least_depth(&self, share: f64, mean: f64) -> Option<u32> {
        let is_enough = |depth: &u32| self.beyond(*depth, mean).is_some_and(|lost| lost < share);
        (1..LENGTHS as u32).find(is_enough)
    }

    /// Radiance per path, channels summed: within the depth and beyond; `None` without any.
    fn all(&self, mean: f64) -> Option<f64> {
        let all = 3.0 * mean + self.per_path(&[self.sum.beyond]);
        (self.sum.paths > 0 && all > 0.0).then_some(all)
    }

    fn per_path(&self, sums: &[i128]) -> f64 {
        sums.iter().map(|x| real(*x)).sum::<f64>() / self.sum.paths as f64
    }
}

impl Film {
    /// Where the light comes from, as far as paths were followed.
    pub fn light(&self) -> Light {
        let mut light = Light::default();
        for i in 0..self.tiles() {
            light.add(&self.tile(i));
        }
        light
    }
}

#[cfg(test)]
mod test;
