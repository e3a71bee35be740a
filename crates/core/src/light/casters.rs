//! Where to send light that is to form caustics: towards what mirrors or refracts.

use std::f32::consts::{FRAC_1_PI, TAU};

use glam::Vec3;

use crate::bsdf::diffuse_direction;
use crate::geometry::SurfacePoint;
use crate::math::Frame;
use crate::shape::Sphere;

/// Most spheres that casters are told apart by: a direction is asked of each of them.
const MOST: usize = 8;

/// Spheres around all that mirrors or refracts. Light that is to meet such surfaces first leaves
/// a lamp within the cones that they fill, uniformly over the cones; from within a sphere, by the
/// cosine.
#[derive(Debug, Default)]
pub(crate) struct Casters(Vec<Sphere>);

/// The directions from a lamp to one of the spheres.
enum Reach {
    Cone {
        axis: Vec3,
        /// 1 − cos of the half-angle.
        one_minus_cos: f32,
    },
    /// The lamp is within.
    Hemisphere,
}

impl Reach {
    /// `None` if the sphere lies behind a lamp at `from`.
    #[inline]
    fn of(sphere: &Sphere, from: &SurfacePoint) -> Option<Self> {
        let way = sphere.center - from.p;
        if way.dot(from.n) < -sphere.radius {
            return None;
        }
        let distance = way.length();
        let sin = sphere.radius / distance;
        Some(if sin < 1.0 {
            Self::Cone {
                axis: way / distance,
                one_minus_cos: sin * sin / (1.0 + ((1.0 - sin) * (1.0 + sin)).sqrt()),
            }
        } else {
            Self::Hemisphere
        })
    }

    /// Solid angle that it is worth, over 2π.
    #[inline]
    fn worth(&self) -> f32 {
        match self {
            Self::Cone { one_minus_cos, .. } => *one_minus_cos,
            Self::Hemisphere => 0.5,
        }
    }

    /// Density of a direction, per solid angle, in units of `1/(2π·worth)`.
    #[inline]
    fn density(&self, n: Vec3, dir: Vec3) -> f32 {
        match self {
            // 1 − cos of the angle between them, without cancellation.
            Self::Cone {
                axis,
                one_minus_cos,
            } => f32::from((dir - *axis).length_squared() * 0.5 <= *one_minus_cos),
            Self::Hemisphere => dir.dot(n).max(0.0),
        }
    }

    #[inline]
    fn sample(&self, n: Vec3, u: [f32; 2]) -> Vec3 {
        match self {
            Self::Cone {
                axis,
                one_minus_cos,
            } => {
                let below = u[0] * one_minus_cos;
                let sin = (below * (2.0 - below)).sqrt();
                let (sin_phi, cos_phi) = libm::sincosf(TAU * u[1]);
                let local = Vec3::new(sin * cos_phi, sin * sin_phi, 1.0 - below);
                Frame::around(*axis).world_from_local(local).normalize()
            }
            Self::Hemisphere => diffuse_direction(n, u).0,
        }
    }
}

impl Casters {
    /// Around spheres that each hold something that mirrors or refracts.
    pub fn new(spheres: Vec<Sphere>) -> Self {
        if spheres.len() <= MOST {
            return Self(spheres);
        }
        let count = spheres.len() as f32;
        let center = spheres.iter().map(|s| s.center / count).sum();
        let reach = |s: &Sphere| s.center.distance(center) + s.radius;
        let radius = spheres.iter().map(reach).fold(0.0, f32::max);
        Self(vec![Sphere { center, radius }])
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// Draws a direction from a point of a lamp, and its density per solid angle. `None` if
    /// nothing can be reached from there, or the direction leads behind the lamp.
    #[inline]
    pub fn sample(
        &self,
        from: &SurfacePoint,
        pick: impl FnOnce() -> f32,
        u: impl FnOnce() -> [f32; 2],
    ) -> Option<(Vec3, f32)> {
        let reaches = || self.0.iter().filter_map(|sphere| Reach::of(sphere, from));
        let all: f32 = reaches().map(|reach| reach.worth()).sum();
        if !(all > 0.0) {
            return None;
        }
        let mut left = if self.0.len() > 1 { pick() * all } else { 0.0 };
        let chosen = reaches().reduce(|chosen, reach| {
            if left < chosen.worth() {
                return chosen;
            }
            left -= chosen.worth();
            reach
        })?;
        let dir = chosen.sample(from.n, u());
        let pdf = self.pdf(from, dir);
        (dir.dot(from.n) > 0.0 && pdf > 0.0).then_some((dir, pdf))
    }

    /// Density per solid angle with which [`Self::sample`] draws `dir`; 0 if never.
    #[inline]
    pub fn pdf(&self, from: &SurfacePoint, dir: Vec3) -> f32 {
        let (mut density, mut all) = (0.0, 0.0);
        for reach in self.0.iter().filter_map(|sphere| Reach::of(sphere, from)) {
            density += reach.density(from.n, dir);
            all += reach.worth();
        }
        if all > 0.0 {
            0.5 * FRAC_1_PI * density / all
        } else {
            0.0
        }
    }
}

#[cfg(test)]
mod test {
    use super::*;
    use crate::sampler::{Dim, Sampler};
    use crate::settings::SamplerKind;

    /// From a lamp beside, over, far from and within its casters: densities add up to the share
    /// of directions that are drawn, told by directions that are uniform over the hemisphere, and
    /// what is drawn has the density that it is said to have.
    #[test]
    fn densities_are_those_of_the_directions_drawn() {
        let at = |x: f32, y: f32, z: f32, radius: f32| Sphere {
            center: Vec3::new(x, y, z),
            radius,
        };
        let lamp = SurfacePoint {
            p: Vec3::ZERO,
            n: Vec3::Z,
            surface: [0.0; 2],
        };
        for (name, spheres) in [
            ("one", vec![at(0.0, 1.0, 3.0, 1.0)]),
            (
                "two that overlap",
                vec![at(0.0, 1.0, 3.0, 1.0), at(0.5, 1.0, 4.0, 2.0)],
            ),
            (
                "one behind",
                vec![at(0.0, 1.0, 3.0, 1.0), at(0.0, 0.0, -3.0, 1.0)],
            ),
            (
                "around",
                vec![at(0.0, 0.0, 0.1, 1.0), at(2.0, 1.0, 3.0, 0.5)],
            ),
            ("half below", vec![at(3.0, 0.0, 0.5, 1.0)]),
            (
                "more than are told apart",
                (0..20).map(|i| at(i as f32, 9.0, 9.0, 1.0)).collect(),
            ),
        ] {
            let casters = Casters::new(spheres);
            let n = 1 << 16;
            let (mut integral, mut drawn, mut centroid, mut expected) = (0.0, 0.0, 0.0, 0.0);
            for i in 0..n {
                let sampler = Sampler::new(SamplerKind::Sobol, 7, [0; 2], 2 * i);
                let (pick, u) = (
                    || sampler.get_1d(Dim::LightPick(0)),
                    || sampler.get_2d(Dim::LightPoint(0)),
                );
                let sample = casters.sample(&lamp, pick, u);
                if let Some((dir, pdf)) = sample {
                    assert!(
                        (pdf - casters.pdf(&lamp, dir)).abs() <= 1e-5 * pdf,
                        "{name}"
                    );
                    drawn += 1.0 / n as f64;
                    centroid += f64::from(dir.y) / n as f64;
                }
                let [x, y] = sampler.get_2d(Dim::Pixel);
                let (sin, cos) = libm::sincosf(TAU * y);
                let r = (1.0 - x * x).sqrt();
                let dir = Vec3::new(r * cos, r * sin, x);
                let density = f64::from(casters.pdf(&lamp, dir) * TAU) / n as f64;
                integral += density;
                expected += density * f64::from(dir.y);
            }
            assert!(
                (integral - drawn).abs() < 2e-3,
                "{name}: {integral} {drawn}"
            );
            assert!(
                (expected - centroid).abs() < 2e-3,
                "{name}: {expected} {centroid}"
            );
        }
    }
}
