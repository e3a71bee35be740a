//! Light by way of a mirror sphere: the place on the sphere where one point sees another.
//!
//! Between two points outside a sphere there is one path by way of its outside that obeys the law
//! of reflection, if any (Alhazen's problem; of its four solutions the others lie in shadow). In
//! the plane of the two points and the centre it is found by Newton's method, kept between bounds
//! that close in on it.

use glam::DVec3;

use crate::shape::Sphere;

/// A mirror image.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Reflection {
    /// Unit normal of the sphere where it is seen.
    pub n: DVec3,
    /// Solid angle at the one point for each unit of area at the other, perpendicular to the last
    /// segment: the same in either direction.
    pub density: f64,
}

/// A direction in the plane: cosine and sine of its angle.
type Turn = [f64; 2];

/// Positive if `b` is further round than `a`, by less than half a turn.
fn beyond(a: Turn, b: Turn) -> f64 {
    a[0] * b[1] - a[1] * b[0]
}

fn unit([x, y]: Turn) -> Turn {
    let length = (x * x + y * y).sqrt();
    [x / length, y / length]
}

/// Newton's step, as an angle, after which the next would change nothing.
const CLOSE: f64 = 1e-6;

/// Steps at most; half a dozen are usual.
const STEPS: usize = 60;

impl Reflection {
    /// The image of `y` that `x` sees on the outside of a sphere, and the other way round.
    pub fn between(sphere: &Sphere, x: DVec3, y: DVec3) -> Option<Self> {
        let (center, radius) = (sphere.center.as_dvec3(), f64::from(sphere.radius));
        let (x, y) = ((x - center) / radius, (y - center) / radius);
        let (a, b) = (x.length(), y.length());
        if !(a > 1.0 && b > 1.0) {
            return None;
        }
        // The plane's axes: towards x, and across it on the side of y.
        let along = x / a;
        let y_along = y.dot(along) / b;
        let across = y / b - y_along * along;
        let y_across = across.length();
        let across = across.normalize_or(along.any_orthonormal_vector());
        let to_y = [y_along, y_across];
        // From where both are above the horizon.
        let horizon = |d: f64| [1.0 / d, (1.0 - 1.0 / (d * d)).sqrt()];
        let (of_x, [cos, sin]) = (horizon(a), horizon(b));
        let mut high = if y_along > of_x[0] { to_y } else { of_x };
        let mut low = if y_along >= cos {
            [1.0, 0.0]
        } else {
            [
                y_along * cos + y_across * sin,
                y_across * cos - y_along * sin,
            ]
        };
        if !(beyond(low, high) >= 0.0) {
            return None;
        }
        // As in a plane mirror, which divides the way as the heights above it.
        let t = (a - 1.0) / (a + b - 2.0);
        let mut n = unit([1.0 - t + t * y_along, t * y_across]);
        for _ in 0..STEPS {
            if !(beyond(low, n) >= 0.0 && beyond(n, high) >= 0.0) {
                n = unit([low[0] + high[0], low[1] + high[1]]);
            }
            let [c, s] = n;
            // Angle from the normal to y.
            let (cos, sin) = (y_along * c + y_across * s, y_across * c - y_along * s);
            // Tangent of the angle to x less that of the angle to y, over positive factors.
            let off = a * b * (s * cos - c * sin) - a * s + b * sin;
            let slope = 2.0 * a * b * (c * cos + s * sin) - a * c - b * cos;
            *(if off > 0.0 { &mut high } else { &mut low }) = n;
            let step = -off / slope;
            n = unit([c - s * step, s + c * step]);
            if step.abs() < CLOSE {
                break;
            }
        }
        let [c, s] = n;
        let cos = y_along * c + y_across * s;
        let (up_x, up_y) = (a * c - 1.0, b * cos - 1.0);
        if !(up_x > 0.0 && up_y > 0.0) {
            return None;
        }
        let (to_x, to_y) = (
            (a * a - 2.0 * a * c + 1.0).sqrt(),
            (b * b - 2.0 * b * cos + 1.0).sqrt(),
        );
        // A thin pencil spreads as it would straight on, and more by the curvature: in the plane of
        // incidence and across it (Coddington 1829).
        let (sum, product, cos) = (to_x + to_y, 2.0 * to_x * to_y, up_x / to_x);
        let spread = (sum + product / cos) * (sum + product * cos);
        Some(Self {
            n: c * along + s * across,
            density: 1.0 / (spread * radius * radius),
        })
    }
}

#[cfg(test)]
mod tests {
    use glam::Vec3;

    use super::*;
    use crate::sampler::{Dim, Sampler};
    use crate::settings::SamplerKind;

    fn number(i: u32, dimension: u32) -> f64 {
        let sampler = Sampler::new(SamplerKind::Independent, 3, [i, dimension], 0);
        f64::from(sampler.get_1d(Dim::Lobe(0)))
    }

    fn direction(i: u32, dimension: u32) -> DVec3 {
        let axis = |k| 2.0 * number(i, dimension + k) - 1.0;
        DVec3::new(axis(0), axis(1), axis(2)).normalize()
    }

    /// From touching distance to far away.
    fn height(i: u32, dimension: u32) -> f64 {
        10f64.powf(7.0 * number(i, dimension) - 5.0)
    }

    fn case(i: u32) -> (Sphere, DVec3, DVec3) {
        let sphere = Sphere {
            center: Vec3::new(1.0, -2.0, 0.5),
            radius: 0.75,
        };
        let place = |dimension| {
            let r = f64::from(sphere.radius) * (1.0 + height(i, dimension + 3));
            sphere.center.as_dvec3() + r * direction(i, dimension)
        };
        (sphere, place(0), place(10))
    }

    #[test]
    fn angles_are_equal_and_nothing_visible_is_missed() {
        let (mut found, mut hidden) = (0, 0);
        for i in 0..100_000 {
            let (sphere, x, y) = case(i);
            let (center, radius) = (sphere.center.as_dvec3(), f64::from(sphere.radius));
            let Some(Reflection { n, .. }) = Reflection::between(&sphere, x, y) else {
                // The ends of the widest arc that x sees, and y: they do not overlap.
                let angle = |p: DVec3| (radius / (p - center).length()).acos();
                let between = (x - center).angle_between(y - center);
                assert!(between > angle(x) + angle(y) - 1e-6, "{i}");
                hidden += 1;
                continue;
            };
            found += 1;
            let p = center + radius * n;
            let (to_x, to_y) = ((x - p).normalize(), (y - p).normalize());
            let mirrored = 2.0 * to_x.dot(n) * n - to_x;
            assert!((n.length() - 1.0).abs() < 1e-12 && to_x.dot(n) > 0.0, "{i}");
            // Points at touching distance are known to fewer digits as seen from the sphere.
            let near = (x - p).length().min((y - p).length()) / radius;
            assert!(
                (mirrored - to_y).length() < 1e-9 / near,
                "{i}: {mirrored} {to_y}"
            );
        }
        assert!(found > 20_000 && hidden > 20_000, "{found} {hidden}");
    }

    #[test]
    fn both_ways_are_one() {
        for i in 0..10_000 {
            let (sphere, x, y) = case(i);
            let there = Reflection::between(&sphere, x, y);
            let back = Reflection::between(&sphere, y, x);
            assert_eq!(there.is_some(), back.is_some());
            if let (Some(a), Some(b)) = (there, back) {
                assert!((a.n - b.n).length() < 1e-7);
                assert!((a.density / b.density - 1.0).abs() < 1e-5, "{a:?} {b:?}");
            }
        }
    }

    /// Against the spot that a thin pencil of reflected rays makes.
    #[test]
    fn the_density_is_that_of_a_pencil_of_rays() {
        let mut checked = 0;
        for i in 0..2_000 {
            let (sphere, x, y) = case(i);
            let (center, radius) = (sphere.center.as_dvec3(), f64::from(sphere.radius));
            let Some(Reflection { n, density }) = Reflection::between(&sphere, x, y) else {
                continue;
            };
            let p = center + radius * n;
            let (forth, last) = ((p - x).normalize(), (y - p).normalize());
            let clearance = (x - center).length().min((y - center).length()) / radius - 1.0;
            if -forth.dot(n) < 0.1 || clearance < 1e-2 {
                continue; // Too steep for differences.
            }
            // Where the ray from x in some direction crosses the plane through y.
            let spot = |dir: DVec3| {
                let f = x - center;
                let half = f.dot(dir);
                let t = -half - (half * half - f.length_squared() + radius * radius).sqrt();
                let q = x + t * dir;
                let n = (q - center) / radius;
                let out = dir - 2.0 * dir.dot(n) * n;
                q + out * ((y - q).dot(last) / out.dot(last))
            };
            let (u, v) = forth.any_orthonormal_pair();
            let h = 1e-6;
            let derivative = |w: DVec3| {
                (spot((forth + h * w).normalize()) - spot((forth - h * w).normalize())) / (2.0 * h)
            };
            let area = derivative(u).cross(derivative(v)).length();
            assert!(
                (area * density - 1.0).abs() < 1e-3,
                "{i}: {}",
                area * density
            );
            checked += 1;
        }
        assert!(checked > 300, "{checked}");
    }

    #[test]
    fn in_the_line_of_the_centre_and_inside() {
        let sphere = Sphere {
            center: Vec3::ZERO,
            radius: 1.0,
        };
        let up = DVec3::Y;
        let seen = Reflection::between(&sphere, 3.0 * up, 2.0 * up).expect("straight below");
        assert!((seen.n - up).length() < 1e-12);
        let spread = 2.0 + 1.0 + 2.0 * 2.0 * 1.0;
        assert!((seen.density * spread * spread - 1.0).abs() < 1e-12);
        assert!(Reflection::between(&sphere, 3.0 * up, -2.0 * up).is_none());
        for inside in [0.5 * up, DVec3::ZERO, up, DVec3::NAN] {
            assert!(Reflection::between(&sphere, inside, 2.0 * up).is_none());
            assert!(Reflection::between(&sphere, 2.0 * up, inside).is_none());
        }
    }
}
