//! Colour: linear sRGB inside, and the way to what a screen shows.

use std::fmt;
use std::str::FromStr;
use std::sync::LazyLock;

use glam::Vec3;
use serde::{Deserialize, Serialize};

/// Relative luminance of linear sRGB (Rec. 709 weights).
pub fn luminance(rgb: Vec3) -> f32 {
    rgb.dot(Vec3::new(0.2126, 0.7152, 0.0722))
}

/// Linear light of an 8-bit sRGB value, in [0, 1] (IEC 61966-2-1).
pub fn linear_from_srgb(value: u8) -> f32 {
    static TABLE: LazyLock<[f32; 256]> = LazyLock::new(|| {
        std::array::from_fn(|i| {
            let x = i as f32 / 255.0;
            if x <= 0.04045 {
                x / 12.92
            } else {
                libm::powf((x + 0.055) / 1.055, 2.4)
            }
        })
    });
    TABLE[value as usize]
}

/// 8-bit sRGB of linear light; clamps to [0, 1], NaN gives 0.
pub fn srgb_from_linear(x: f32) -> u8 {
    /// Linear light at which the output steps from i to i + 1.
    static STEPS: LazyLock<[f32; 255]> = LazyLock::new(|| {
        std::array::from_fn(|i| {
            let x = (i as f32 + 0.5) / 255.0;
            if x <= 0.04045 {
                x / 12.92
            } else {
                libm::powf((x + 0.055) / 1.055, 2.4)
            }
        })
    });
    STEPS.partition_point(|step| *step <= x) as u8
}

/// How scene light is bent into the range of a screen.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
#[non_exhaustive]
pub enum ToneCurve {
    /// Linear up to white, clipped above.
    #[default]
    Linear,
    /// A film-like shoulder (Narkowicz 2015, a fit to the ACES curve).
    Filmic,
}

impl ToneCurve {
    /// Every curve, in the order of menus.
    pub const ALL: [Self; 2] = [Self::Linear, Self::Filmic];

    /// The name on the command line and in the UI.
    pub fn name(self) -> &'static str {
        match self {
            Self::Linear => "linear",
            Self::Filmic => "filmic",
        }
    }
}

impl fmt::Display for ToneCurve {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}

impl FromStr for ToneCurve {
    type Err = String;
    fn from_str(text: &str) -> Result<Self, String> {
        let names = Self::ALL.map(Self::name);
        Self::ALL
            .into_iter()
            .find(|c| c.name() == text)
            .ok_or_else(|| {
                format!(
                    "unknown tone curve \"{text}\"{}",
                    crate::suggest::among(text, &names)
                )
            })
    }
}

/// What happens between measured light and shown colour. Never touches what is measured.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct ToneMap {
    /// Brightness in photographic stops: light is multiplied by 2^exposure.
    pub exposure: f32,
    /// What is added then.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub offset: f32,
    /// The curve applied at last.
    pub curve: ToneCurve,
}

#[expect(
    clippy::trivially_copy_pass_by_ref,
    reason = "the signature serde asks for"
)]
fn is_zero(offset: &f32) -> bool {
    *offset == 0.0
}

impl ToneMap {
    /// The exposure and offset that make black and white of the luminances within which all but
    /// one in a hundred of the darkest and of the brightest pixels lie.
    pub fn fitted(self, pixels: &[Vec3]) -> Self {
        let mut luminances: Vec<f32> = pixels.iter().map(|p| luminance(*p)).collect();
        luminances.sort_unstable_by(f32::total_cmp);
        let last = luminances.len().saturating_sub(1);
        let rank = |percent: usize| luminances.get(last * percent / 100).copied();
        let (Some(dark), Some(bright)) = (rank(1), rank(99)) else {
            return self;
        };
        let range = if bright > dark { bright - dark } else { bright };
        if !(range > 0.0 && range < f32::INFINITY) {
            return self;
        }
        let black = if bright > dark { dark } else { 0.0 };
        Self {
            exposure: -libm::log2f(range),
            offset: -black / range,
            ..self
        }
    }

    /// The linear light that a screen is asked for: 1 is white, and what is more it cannot show.
    pub fn curved(&self, rgb: Vec3) -> Vec3 {
        let x = (rgb * libm::exp2f(self.exposure) + self.offset).max(Vec3::ZERO);
        match self.curve {
            ToneCurve::Linear => x,
            ToneCurve::Filmic => {
                // The fit is made for light scaled by 0.6; the ratio tends to 2.51/2.43.
                let x = (x * 0.6).min(Vec3::splat(1e4));
                x * (2.51 * x + 0.03) / (x * (2.43 * x + 0.59) + 0.14)
            }
        }
    }

    /// The 8-bit sRGB colour shown for some light.
    pub fn apply(&self, rgb: Vec3) -> [u8; 3] {
        self.curved(rgb).to_array().map(srgb_from_linear)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fitted_light_goes_from_black_to_white() {
        // From 2 to 4, but for one pixel in a hundred at either end.
        let ramp = |i: i32| Vec3::splat(2.0 + i as f32 / 512.0);
        let mut pixels: Vec<Vec3> = (0..=1024).map(ramp).collect();
        pixels.extend([Vec3::ZERO; 8].into_iter().chain([Vec3::splat(1e6); 8]));
        let tone = ToneMap::default().fitted(&pixels);
        assert!((tone.exposure + 1.0).abs() < 0.02, "{tone:?}");
        assert!((tone.offset + 1.0).abs() < 0.02, "{tone:?}");
        assert_eq!(tone.apply(Vec3::splat(1.9)), [0; 3]);
        assert_eq!(tone.apply(Vec3::splat(4.1)), [255; 3]);
        // Flat light becomes white; nothing changes where there is none.
        let flat = ToneMap::default().fitted(&[Vec3::splat(0.25); 9]);
        assert_eq!((flat.exposure, flat.offset), (2.0, 0.0));
        for nothing in [&[][..], &[Vec3::ZERO; 4]] {
            assert_eq!(ToneMap::default().fitted(nothing), ToneMap::default());
        }
    }
}
