//! Whether two pictures of one scene differ by more than their noise: a test of two methods
//! against each other that needs no reference.
//!
//! Each tile's mean is compared by Welch's t test. Its variance is the sum of those of its groups of
//! pixels that may share light ([`crate::Method::Reuse`]), each told by the difference of the group's
//! halves; the degrees of freedom are those of that sum (Satterthwaite 1946), so that a tile whose noise
//! is that of one bright outlier proves little.
//! The smallest of m tile p-values is corrected for their number: 1 − (1 − p)^m (Šidák 1967).

use statrs::distribution::{ContinuousCDF as _, StudentsT};

use crate::film::{Film, TileLight, TileRect};

/// Chance of an alarm where nothing differs: below this p the pictures are said to disagree.
pub const LEVEL: f64 = 0.01;

/// Smallest relative error of a tile's mean, to which radiances are rounded: stands for noise
/// where there is none.
const ROUNDING: f64 = 1e-6;

/// The light of a picture by tiles, from one film or from several with different seeds.
#[derive(Clone, Debug, PartialEq)]
pub struct Light(Vec<TileLight>);

impl Light {
    /// The light of a film; `None` below two samples per pixel.
    pub fn of(film: &Film) -> Option<Self> {
        let tiles = (0..film.tiles()).map(|i| film.tile_light(i));
        tiles.collect::<Option<_>>().map(Self)
    }

    /// Adds the light of another film of the same view with another seed.
    ///
    /// # Panics
    /// If the films differ in size.
    pub(crate) fn add(&mut self, other: &Self) {
        assert_eq!(self.0.len(), other.0.len(), "films of one size");
        for (to, from) in self.0.iter_mut().zip(&other.0) {
            to.pixels += from.pixels;
            to.sum += from.sum;
            to.square += from.square;
            to.fourth += from.fourth;
        }
    }

    /// Variance over mean of a typical tile. Of rare light it is the same everywhere but for
    /// albedo, and so tells the variance where no sample has met any.
    fn variance_ratio(&self) -> f64 {
        let lit = self.0.iter().filter(|tile| tile.square > 0.0);
        let mut ratios: Vec<f64> = lit.map(|t| variance(t) / mean(t)).collect();
        ratios.sort_unstable_by(f64::total_cmp);
        ratios.get(ratios.len() / 2).copied().unwrap_or(0.0)
    }
}

#[cfg(test)]
impl Light {
    /// The same with one tile brighter.
    pub(crate) fn brighter(mut self, factor: f64) -> Self {
        self.0[0].sum *= factor;
        self
    }
}

/// How far two pictures differ in a tile.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct TileDifference {
    /// Where.
    pub rect: TileRect,
    /// Difference of the means, in standard deviations; positive where the first is brighter.
    pub t: f64,
    /// Chance of a difference as large if nothing but noise differs.
    pub p: f64,
}

/// The outcome of comparing two pictures.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Agreement {
    /// Chance that some tile differs as much if nothing but noise differs.
    pub p: f64,
    /// Every tile, in the order of the film.
    pub tiles: Vec<TileDifference>,
}

impl Agreement {
    /// Compares two pictures, whose samples must be independent: of different seeds.
    ///
    /// # Panics
    /// If they differ in size.
    pub fn between(a: &Light, b: &Light) -> Self {
        assert_eq!(a.0.len(), b.0.len(), "pictures of one size");
        let ratios = [a, b].map(Light::variance_ratio);
        let tiles: Vec<TileDifference> =
            a.0.iter()
                .zip(&b.0)
                .map(|(a, b)| difference([a, b], ratios))
                .collect();
        let least = tiles.iter().map(|tile| tile.p).fold(1.0, f64::min);
        let p = -((tiles.len() as f64) * (-least).ln_1p()).exp_m1();
        Self { p, tiles }
    }

    /// Whether noise explains all differences, at [`LEVEL`].
    pub fn holds(&self) -> bool {
        self.p >= LEVEL
    }

    /// One line: `mis and naive agree, p = 0.41`.
    pub fn headline(&self, a: &str, b: &str) -> String {
        if self.holds() {
            return format!("{a} and {b} agree, p = {:.2}", self.p);
        }
        let worst = self.tiles.iter().min_by(|s, t| s.p.total_cmp(&t.p));
        let place = worst.map_or_else(String::new, |tile| {
            format!(", most at pixel {},{}", tile.rect.x, tile.rect.y)
        });
        format!("{a} and {b} disagree, p = {:.1e}{place}", self.p)
    }
}

fn mean(t: &TileLight) -> f64 {
    t.sum / t.pixels
}

fn variance(t: &TileLight) -> f64 {
    t.square / (t.pixels * t.pixels)
}

/// Compares a tile of two pictures, whose typical ratios of variance to mean are known. The noise
/// is at least what those say of the light that both together have found: halves that have met
/// next to nothing hardly differ, and prove nothing.
fn difference([a, b]: [&TileLight; 2], ratios: [f64; 2]) -> TileDifference {
    // Variance of the variance, over 2: of normal noise, a group's σ⁴ is a third of its mean
    // fourth power.
    let doubt = |t: &TileLight| t.fourth / (3.0 * t.pixels.powi(4));
    let difference = mean(a) - mean(b);
    let light = (mean(a) + mean(b)) / 2.0;
    let rounding = (ROUNDING * mean(a).abs().max(mean(b).abs())).powi(2);
    let noise = variance(a).max(ratios[0] * light) + variance(b).max(ratios[1] * light);
    let (t, p) = if noise + rounding == 0.0 {
        (0.0, 1.0)
    } else {
        let t = difference / (noise + rounding).sqrt();
        let freedom = (noise * noise / (doubt(a) + doubt(b))).clamp(1.0, 1e6);
        // Without any noise only rounding is left, and many degrees of freedom.
        let freedom = if freedom.is_nan() { 1e6 } else { freedom };
        let p = StudentsT::new(0.0, 1.0, freedom).map_or(f64::NAN, |s| 2.0 * s.sf(t.abs()));
        (t, p.min(1.0))
    };
    TileDifference { rect: a.rect, t, p }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::accel::test::Rng;
    use crate::film::APART;
    use crate::filter::{Filter, FilterSampler};
    use glam::Vec3;

    /// The light of four tiles whose noise is normal enough: that of the first is common to every fourth pixel across
    /// and down, that of the others each pixel's own.
    fn noisy(rng: &mut Rng) -> Light {
        let film = Film::new(64, 16, &FilterSampler::new(Filter::default()));
        for i in 0..film.tiles() {
            let (mut batch, _) = film.batch(i);
            for sample in 0..2 {
                let mut noise = || (0..12).map(|_| rng.unit()).sum::<f32>() - 6.0;
                let common: Vec<f32> = (0..APART * APART).map(|_| noise()).collect();
                for (x, y) in (0..16).flat_map(|y| (0..16).map(move |x| (x, y))) {
                    let noise = match i {
                        0 => common[(y % APART * APART + x % APART) as usize],
                        _ => noise(),
                    };
                    batch.add([x, y], sample, 0, Vec3::splat(10.0 + noise));
                }
            }
            assert!(film.merge(i, &batch, 0, 2));
        }
        Light::of(&film).expect("two samples")
    }

    #[test]
    fn differences_are_as_large_as_noise_says_wherever_pixels_share_light() {
        const PAIRS: u32 = 400;
        let mut rng = Rng(41);
        let mut squares = [0.0; 4];
        for _ in 0..PAIRS {
            let found = Agreement::between(&noisy(&mut rng), &noisy(&mut rng));
            for (sum, tile) in squares.iter_mut().zip(&found.tiles) {
                *sum += tile.t * tile.t / f64::from(PAIRS);
            }
        }
        // Of Student's t with 30 degrees of freedom or so; less where the noise of a typical tile is more.
        for square in squares {
            assert!((0.7..1.3).contains(&square), "{squares:?}");
        }
    }
}
