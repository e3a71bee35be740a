//! What samples tell of a pixel.

use glam::Vec3;
use lightbox_core::Film;
use lightbox_core::color::{luminance, srgb_from_linear};
use lightbox_core::compare::check_size;

use super::colors::{ERRORS, error_color, log_share, signed, viridis};
use super::{Colors, Legend, Scope};
use crate::panels::format::{count as counted, percent, short};

/// Stops below and above white that false colours tell apart.
const STOPS: [f32; 2] = [-8.0, 4.0];

pub fn color(scope: &Scope<'_>, film: &Film, i: usize) -> Option<Colors> {
    let pixels = film.develop_tile(i)?.pixels;
    Some(pixels.iter().map(|p| scope.tone.apply(*p)).collect())
}

pub fn noise(_: &Scope<'_>, film: &Film, i: usize) -> Option<Colors> {
    let (_, errors) = film.pixel_errors(i)?;
    Some(errors.into_iter().map(error_color).collect())
}

pub fn noise_legend() -> Legend {
    let ends = ERRORS.map(|end| percent(f64::from(end)));
    Legend::Scale {
        color: viridis,
        ends,
    }
}

pub fn count(scope: &Scope<'_>, film: &Film, i: usize) -> Option<Colors> {
    let samples = film.tile_samples(i);
    let rect = film.tile_rect(i);
    let share = log_share(samples as f32, [1.0, scope.settings.samples.max(2) as f32]);
    let color = viridis(share);
    (samples > 0).then(|| vec![color; (rect.width * rect.height) as usize])
}

pub fn count_legend(scope: &Scope<'_>) -> Legend {
    let ends = [1, scope.settings.samples.max(2)].map(|n| format!("{} spp", counted(n)));
    Legend::Scale {
        color: viridis,
        ends,
    }
}

/// The difference that is shown in full colour, W/(m²·sr): a tenth of what is shown white.
fn largest_difference(scope: &Scope<'_>) -> f32 {
    0.1 * (-scope.tone.exposure).exp2()
}

pub fn difference(scope: &Scope<'_>, film: &Film, i: usize) -> Option<Colors> {
    let reference = &scope.reference?.image;
    check_size(film.size(), reference).ok()?;
    let tile = film.develop_tile(i)?;
    let (rect, largest) = (tile.rect, largest_difference(scope));
    let at = rect.pixels().map(|[x, y]| y * reference.width + x);
    let pixels = tile.pixels.iter().zip(at);
    let color = |(x, at): (&Vec3, u32)| {
        let more = luminance(*x) - luminance(reference.pixels[at as usize]);
        signed(0.5 + 0.5 * more / largest)
    };
    Some(pixels.map(color).collect())
}

pub fn difference_legend(scope: &Scope<'_>) -> Legend {
    if scope.reference.is_none() {
        return Legend::Words("no reference to compare with: K keeps this picture as one");
    }
    let end = short(largest_difference(scope));
    Legend::Scale {
        color: signed,
        ends: [format!("−{end}"), format!("+{end} W/(m²·sr)")],
    }
}

pub fn invalid(_: &Scope<'_>, film: &Film, i: usize) -> Option<Colors> {
    let (tile, invalid) = (film.develop_tile(i)?, film.tile_invalid(i));
    let dim = |p: &Vec3| [srgb_from_linear(0.1 * luminance(*p).min(1.0)); 3];
    let pixels = tile.pixels.iter().zip(invalid);
    let color = |(p, invalid)| if invalid > 0 { INVALID } else { dim(p) };
    Some(pixels.map(color).collect())
}

/// Colour of a pixel with invalid samples.
const INVALID: [u8; 3] = [255, 40, 60];

/// Colours of pixels that the screen cannot show, as they are too bright or too dark.
const CLIPPED: [[u8; 3]; 2] = [[255, 40, 60], [60, 130, 255]];

/// White and half a step of eight bits, linear: up to there light is rounded, not cut off.
const WHITE: f32 = 1.0045;

pub fn clipped(scope: &Scope<'_>, film: &Film, i: usize) -> Option<Colors> {
    let pixels = film.develop_tile(i)?.pixels;
    let color = |p: &Vec3| {
        let curved = scope.tone.curved(*p);
        if curved.max_element() > WHITE {
            CLIPPED[0]
        } else if luminance(*p) > 0.0 && scope.tone.apply(*p) == [0; 3] {
            CLIPPED[1]
        } else {
            [srgb_from_linear(0.4 * luminance(curved)); 3]
        }
    };
    Some(pixels.iter().map(color).collect())
}

pub fn clipped_legend() -> Legend {
    let texts = ["brighter than white", "shown black, but not without light"];
    let swatches = CLIPPED.into_iter().zip(texts.map(str::to_owned));
    Legend::Swatches(swatches.collect())
}

pub fn invalid_legend() -> Legend {
    let swatch = |color, text: &str| (color, text.to_owned());
    Legend::Swatches(vec![
        swatch(INVALID, "samples that were no numbers"),
        swatch([40; 3], "none"),
    ])
}

/// What false colours tell apart, W/(m²·sr).
fn luminances(scope: &Scope<'_>) -> [f32; 2] {
    STOPS.map(|stop| (stop - scope.tone.exposure).exp2())
}

pub fn false_color(scope: &Scope<'_>, film: &Film, i: usize) -> Option<Colors> {
    let pixels = film.develop_tile(i)?.pixels;
    let ends = luminances(scope);
    let color = |p: &Vec3| viridis(log_share(luminance(*p), ends));
    Some(pixels.iter().map(color).collect())
}

pub fn false_color_legend(scope: &Scope<'_>) -> Legend {
    let [low, high] = luminances(scope).map(short);
    Legend::Scale {
        color: viridis,
        ends: [low, format!("{high} W/(m²·sr)")],
    }
}
