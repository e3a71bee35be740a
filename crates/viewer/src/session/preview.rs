//! Coarse pictures while things move: how coarse, and how they fill the window.

use std::time::Duration;

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
    /// Seconds per path over all threads.
    pub fn cost(&self) -> f64 {
        self.cost
    }

    /// Takes note of a first picture.
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

/// sRGB bytes of a picture of some width and height, with each pixel of a preview as a square.
pub(super) fn enlarge(preview: &[u8], scale: u32, width: u32, height: u32) -> Vec<u8> {
    let row_bytes = 3 * width.div_ceil(scale) as usize;
    let mut rgb = Vec::with_capacity(3 * width as usize * height as usize);
    for rows in (0..height).step_by(scale as usize) {
        let start = rgb.len();
        let from = &preview[(rows / scale) as usize * row_bytes..][..row_bytes];
        for (x, pixel) in (0..width).step_by(scale as usize).zip(from.chunks_exact(3)) {
            for _ in x..(x + scale).min(width) {
                rgb.extend_from_slice(pixel);
            }
        }
        let row = start..rgb.len();
        for _ in rows + 1..(rows + scale).min(height) {
            rgb.extend_from_within(row.clone());
        }
    }
    rgb
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
        let (a, b, c, d) = ([1; 3], [2; 3], [3; 3], [4; 3]);
        let large = enlarge([a, b, c, d].as_flattened(), 3, 5, 4);
        let rows = [[a, a, a, b, b]; 3].into_iter().chain([[c, c, c, d, d]]);
        assert_eq!(large, rows.flatten().flatten().collect::<Vec<u8>>());
    }
}
