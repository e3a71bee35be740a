//! Sine, cosine and arc tangent without a branch or a call, so that a loop over many goes side by
//! side. Within a few ulp on the ranges named; the same bits on every machine.

use std::f64::consts::{FRAC_2_PI, FRAC_PI_2, FRAC_PI_4, PI};

/// Sine and cosine for |x| ≤ π/4 (polynomials of Moshier's Cephes).
#[inline(always)]
pub fn sin_cos_of_small(x: f32) -> [f32; 2] {
    let z = x * x;
    let sin = ((-1.951_529_6e-4 * z + 8.332_161e-3) * z - 1.666_665_5e-1) * z * x + x;
    let cos = (2.443_315_7e-5 * z - 1.388_731_6e-3) * z + 4.166_664_6e-2;
    [sin, cos * z * z - 0.5 * z + 1.0]
}

/// Sine and cosine for |x| ≤ 100 (reduction to a quarter turn in two parts, polynomials of Sun's
/// fdlibm).
#[inline(always)]
pub fn sin_cos(x: f64) -> [f64; 2] {
    // Adding it leaves the nearest integer in the lowest bits.
    const ROUND: f64 = 6_755_399_441_055_744.0;
    const QUARTER: [f64; 2] = [1.570_796_326_734_125_6, 6.077_100_506_506_192e-11];
    let shifted = x * FRAC_2_PI + ROUND;
    let (turns, quadrant) = (shifted - ROUND, shifted.to_bits());
    let r = x - turns * QUARTER[0] - turns * QUARTER[1];
    let z = r * r;
    let s = 1.589_690_995_211_55e-10 * z - 2.505_076_025_340_686_3e-8;
    let s = (s * z + 2.755_731_370_707_006_8e-6) * z - 1.984_126_982_985_795e-4;
    let s = (s * z + 8.333_333_333_322_49e-3) * z - 1.666_666_666_666_663_2e-1;
    let s = r + r * z * s;
    let c = -1.135_964_755_778_819_5e-11 * z + 2.087_572_321_298_175e-9;
    let c = (c * z - 2.755_731_435_139_066_3e-7) * z + 2.480_158_728_947_673e-5;
    let c = (c * z - 1.388_888_888_887_411e-3) * z + 4.166_666_666_666_66e-2;
    let c = 1.0 - 0.5 * z + z * z * c;
    let (sin, cos) = if quadrant & 1 == 0 { (s, c) } else { (c, s) };
    let sign = |bit: u64| if bit & 2 == 0 { 1.0 } else { -1.0 };
    [sin * sign(quadrant), cos * sign(quadrant.wrapping_add(1))]
}

/// The angle of the vector (`x`, `y`), in [−π, π]; NaN for no vector (rational approximation of
/// Moshier's Cephes).
#[inline(always)]
pub fn atan2(y: f64, x: f64) -> f64 {
    let (ax, ay) = (x.abs(), y.abs());
    let (near, far) = if ay > ax { (ax, ay) } else { (ay, ax) };
    // The tangent, or that of an eighth of a turn less.
    let is_steep = near > 0.66 * far;
    let (num, den, base) = if is_steep {
        (near - far, near + far, FRAC_PI_4)
    } else {
        (near, far, 0.0)
    };
    let t = num / den;
    let z = t * t;
    let p = -8.750_608_600_031_904e-1 * z - 1.615_753_718_733_365e1;
    let p = (p * z - 7.500_855_792_314_705e1) * z - 1.228_866_684_490_136_2e2;
    let p = p * z - 6.485_021_904_942_025e1;
    let q = (z + 2.485_846_490_142_306e1) * z + 1.650_270_098_316_988_5e2;
    let q = (q * z + 4.328_810_604_912_903e2) * z + 4.853_903_996_359_137e2;
    let q = q * z + 1.945_506_571_482_614e2;
    let angle = base + (t + t * z * (p / q));
    let angle = if ay > ax { FRAC_PI_2 - angle } else { angle };
    let angle = if x < 0.0 { PI - angle } else { angle };
    angle.copysign(y)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Largest error of `f` against the reference over a grid, in ulp of 1 or of the value.
    fn worst(range: f64, f: impl Fn(f64) -> [f64; 2], exact: impl Fn(f64) -> [f64; 2]) -> f64 {
        let mut worst = 0.0f64;
        for i in -100_000..=100_000 {
            let x = f64::from(i) / 100_000.0 * range;
            for (a, b) in f(x).into_iter().zip(exact(x)) {
                worst = worst.max((a - b).abs() / b.abs().max(1e-3));
            }
        }
        worst
    }

    #[test]
    fn sines_and_cosines_are_those_of_libm() {
        let exact = |x: f64| [libm::sin(x), libm::cos(x)];
        let worst_f64 = worst(100.0, sin_cos, exact);
        assert!(worst_f64 < 1e-12, "{worst_f64:e}");
        let small = |x: f64| sin_cos_of_small(x as f32).map(f64::from);
        let worst_f32 = worst(FRAC_PI_4, small, |x| exact(f64::from(x as f32)));
        assert!(worst_f32 < 2e-7, "{worst_f32:e}");
    }

    #[test]
    fn arc_tangents_are_those_of_libm() {
        for (x, y) in [
            (0.0, 1.0),
            (0.0, -1.0),
            (-1.0, 0.0),
            (-1.0, -0.0),
            (2.0, 1e-300),
        ] {
            assert!((atan2(y, x) - libm::atan2(y, x)).abs() <= 1e-15 * PI);
        }
        let f = |x: f64| [atan2(x.sin(), x.cos()), atan2(1e-9 * x, -x)];
        let exact = |x: f64| [libm::atan2(x.sin(), x.cos()), libm::atan2(1e-9 * x, -x)];
        let worst = worst(3.2, f, exact);
        assert!(worst < 1e-15, "{worst:e}");
        assert!(atan2(0.0, 0.0).is_nan());
    }
}
