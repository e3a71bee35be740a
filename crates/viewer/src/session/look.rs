//! What a picture is shown as.

use lightbox_core::Film;
use lightbox_core::color::ToneMap;
use lightbox_core::film::TileRect;

/// How light gets to the screen, and whether the error of each pixel stands in its place.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Look {
    /// From light to screen.
    pub tone: ToneMap,
    /// Whether pixels show how noisy they are, in the colours of [`error_color`].
    pub shows_error: bool,
}

/// Relative errors at the ends of the scale of colours.
pub const ERRORS: [f32; 2] = [1e-3, 1.0];

/// Colours along the scale, evenly spaced: five of the colour map viridis (van der Walt & Smith
/// 2015), which rises in lightness and reads without telling red from green.
const COLORS: [[f32; 3]; 5] = [
    [68.0, 1.0, 84.0],
    [59.0, 82.0, 139.0],
    [33.0, 145.0, 140.0],
    [94.0, 201.0, 98.0],
    [253.0, 231.0, 37.0],
];

/// sRGB of a relative error, evenly along its logarithm.
pub fn error_color(error: f32) -> [u8; 3] {
    let [low, high] = ERRORS;
    let along = (error.max(low) / low).ln() / (high / low).ln();
    let place = along.min(1.0) * (COLORS.len() - 1) as f32;
    let i = (place as usize).min(COLORS.len() - 2);
    let (a, b, t) = (COLORS[i], COLORS[i + 1], place - i as f32);
    std::array::from_fn(|c| (a[c] + t * (b[c] - a[c])).round() as u8)
}

impl Look {
    /// sRGB of the pixels of a tile; `None` before its first samples. Light is shown where the
    /// error is not known yet.
    pub(super) fn tile(&self, film: &Film, i: usize) -> Option<(TileRect, Vec<[u8; 3]>)> {
        if self.shows_error
            && let Some((rect, errors)) = film.pixel_errors(i)
        {
            return Some((rect, errors.into_iter().map(error_color).collect()));
        }
        let tile = film.develop_tile(i)?;
        let rgb = tile.pixels.iter().map(|p| self.tone.apply(*p)).collect();
        Some((tile.rect, rgb))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn larger_errors_are_lighter_up_to_the_ends_of_the_scale() {
        let lightness = |error: f32| {
            let [r, g, b] = error_color(error).map(f32::from);
            0.2126 * r + 0.7152 * g + 0.0722 * b
        };
        let errors = [1e-3, 3e-3, 0.01, 0.05, 0.2, 0.7, 1.0];
        assert!(errors.is_sorted_by(|a, b| lightness(*a) < lightness(*b)));
        for (error, end) in [(0.0, 1e-3), (1e-9, 1e-3), (7.0, 1.0), (f32::INFINITY, 1.0)] {
            assert_eq!(error_color(error), error_color(end));
        }
        assert_eq!(error_color(1.0), [253, 231, 37]);
    }
}
