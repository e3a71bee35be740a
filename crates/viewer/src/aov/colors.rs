//! Scales of colours.

/// Relative errors at the ends of their scale.
pub const ERRORS: [f32; 2] = [1e-3, 1.0];

/// Colours along the scale, evenly spaced: five of the colour map viridis (van der Walt & Smith
/// 2015), which rises in lightness and reads without telling red from green.
const VIRIDIS: [[f32; 3]; 5] = [
    [68.0, 1.0, 84.0],
    [59.0, 82.0, 139.0],
    [33.0, 145.0, 140.0],
    [94.0, 201.0, 98.0],
    [253.0, 231.0, 37.0],
];

/// Blue below, black in the middle, orange above: as light on both sides.
const SIGNED: [[f32; 3]; 3] = [[90.0, 170.0, 255.0], [0.0; 3], [255.0, 150.0, 40.0]];

/// The colour at a share of the way from dark to light.
pub fn viridis(share: f32) -> [u8; 3] {
    along(&VIRIDIS, share)
}

/// The colour at a share of the way from the most below to the most above.
pub fn signed(share: f32) -> [u8; 3] {
    along(&SIGNED, share)
}

/// The colour of a relative error, evenly along its logarithm.
pub fn error_color(error: f32) -> [u8; 3] {
    viridis(log_share(error, ERRORS))
}

/// How far a number is along the logarithm from one end to the other.
pub fn log_share(x: f32, [low, high]: [f32; 2]) -> f32 {
    (x.max(low) / low).ln() / (high / low).ln()
}

fn along(colors: &[[f32; 3]], share: f32) -> [u8; 3] {
    let place = share.clamp(0.0, 1.0) * (colors.len() - 1) as f32;
    let i = (place as usize).min(colors.len() - 2);
    let (a, b, t) = (colors[i], colors[i + 1], place - i as f32);
    std::array::from_fn(|c| (a[c] + t * (b[c] - a[c])).round() as u8)
}

/// A colour for a number of something: far from those of the numbers around it.
pub fn distinct(i: u64) -> [u8; 3] {
    // Hues by the golden ratio; by turns dark and light, pale and full.
    let hue = (i as f32 * 0.618_034 + 0.08).fract() * 6.0;
    let (value, chroma) = (
        [0.95, 0.7, 0.85][i as usize % 3],
        [0.75, 0.5][i as usize % 2],
    );
    let channel = |shift: f32| {
        let k = (shift + hue) % 6.0;
        let x = value - value * chroma * k.min(4.0 - k).clamp(0.0, 1.0);
        (x * 255.0).round() as u8
    };
    [5.0, 3.0, 1.0].map(channel)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn lightness(color: [u8; 3]) -> f32 {
        let [r, g, b] = color.map(f32::from);
        0.2126 * r + 0.7152 * g + 0.0722 * b
    }

    #[test]
    fn larger_errors_are_lighter_up_to_the_ends_of_the_scale() {
        let errors = [1e-3, 3e-3, 0.01, 0.05, 0.2, 0.7, 1.0];
        let light = errors.map(|e| lightness(error_color(e)));
        assert!(light.is_sorted_by(|a, b| a < b), "{light:?}");
        for (error, end) in [(0.0, 1e-3), (1e-9, 1e-3), (7.0, 1.0), (f32::INFINITY, 1.0)] {
            assert_eq!(error_color(error), error_color(end));
        }
        assert_eq!(error_color(1.0), [253, 231, 37]);
    }

    #[test]
    fn nothing_is_black_between_blue_and_orange() {
        assert_eq!(signed(0.5), [0; 3]);
        let [[r0, .., b0], [r1, .., b1]] = [signed(0.2), signed(0.8)];
        assert!(b0 > r0 && r1 > b1);
    }

    #[test]
    fn neighbours_differ() {
        for i in 0..200 {
            for j in i + 1..i + 6 {
                let (a, b) = (distinct(i), distinct(j));
                let far: u32 = (0..3).map(|c| u32::from(a[c].abs_diff(b[c]))).sum();
                assert!(far > 60, "{i} {a:?}, {j} {b:?}");
            }
        }
    }
}
