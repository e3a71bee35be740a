//! Coarse pictures while things move: how coarse, and how they fill the window.

use std::time::Duration;

use glam::Vec3;
use lightbox_core::Image;

/// How long the first preview after a wish may take. A wish can come while another preview is
/// being traced, so twice this and the display must fit in 33 ms.
const FIRST: Duration = Duration::from_millis(11);

/// Coarsest preview: pixels of the picture per pixel of the preview, across and down.
const COARSEST: u32 = 32;

/// Chooses preview sizes from the measured cost of a path.
pub(super) struct Governor {
    /// Seconds per path over all threads.
    cost: f64,
}

impl Default for Governor {
    /// A cautious guess for a scene never seen.
    fn default() -> Self {
        Self { cost: 5e-6 }
    }
}

impl Governor {
    /// Takes note of a preview.
    pub fn measured(&mut self, time: Duration, paths: u64) {
        let cost = time.as_secs_f64() / paths.max(1) as f64;
        // Up at once, down slowly: a preview too coarse is better than one too late.
        self.cost = if cost > self.cost {
            cost
        } else {
            0.5 * (self.cost + cost)
        };
    }

    /// Scales to show one after another before the full picture, the first one last: the finest
    /// that keeps within its time, then halves of it. Empty if the full picture is fast enough.
    pub fn scales(&self, width: u32, height: u32) -> Vec<u32> {
        let full = self.cost * f64::from(width) * f64::from(height);
        let scale = (full / FIRST.as_secs_f64()).sqrt().ceil();
        let first = (scale as u32).clamp(1, COARSEST);
        let mut scales: Vec<u32> = std::iter::successors(Some(first), |s| Some(s / 2))
            .take_while(|s| *s > 1)
            .collect();
        scales.reverse();
        scales
    }
}

/// The picture at full size with each pixel of a preview as a square.
pub(super) fn enlarge(image: &Image, scale: u32, width: u32, height: u32) -> Image {
    let row = |y: u32| {
        let start = (y / scale * image.width) as usize;
        &image.pixels[start..start + image.width as usize]
    };
    let pixels: Vec<Vec3> = (0..height)
        .flat_map(|y| (0..width).map(move |x| row(y)[(x / scale) as usize]))
        .collect();
    Image {
        width,
        height,
        pixels,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn previews_get_finer_until_the_picture() {
        let governor = Governor { cost: 1e-6 };
        let scales = governor.scales(1280, 720);
        assert_eq!(scales.last(), Some(&10));
        assert!(
            scales.windows(2).all(|w| w[0] < w[1]) && scales[0] > 1,
            "{scales:?}"
        );
        assert!(Governor { cost: 1e-9 }.scales(640, 480).is_empty());
    }

    #[test]
    fn an_enlarged_preview_covers_the_picture() {
        let small = Image {
            width: 2,
            height: 1,
            pixels: vec![Vec3::X, Vec3::Y],
        };
        let large = enlarge(&small, 3, 5, 2);
        assert_eq!(large.pixels.len(), 10);
        assert_eq!(
            large.pixels[..5],
            [Vec3::X, Vec3::X, Vec3::X, Vec3::Y, Vec3::Y]
        );
    }
}
