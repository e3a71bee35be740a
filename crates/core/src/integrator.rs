//! Light transport: the radiance that one path finds.
//!
//! A path of depth d has d segments from the camera to the light: depth 1 is light seen
//! directly. The three methods share one loop and differ only in how they count light that a
//! segment runs into and whether they also aim at lights:
//!
//! | method | light run into | light aimed at |
//! |---|---|---|
//! | naive | 1 | – |
//! | nee | 1 from the camera and after mirror or glass, else 0 | 1 |
//! | mis | 1 from the camera and after mirror or glass, else its power-heuristic weight | its weight |
//!
//! The background is not aimed at: it counts fully in every method.

use glam::Vec3;

use crate::bsdf::Bsdf;
use crate::geometry::SurfacePoint;
use crate::math::Ray;
use crate::planted::{self, Bug};
use crate::sampler::{Dim, Sampler};
use crate::scene::Scene;
use crate::settings::Method;

/// Bounces that every path takes before Russian roulette may end it.
const ROULETTE_FROM: u32 = 3;

/// Bounds on the probability that a path survives roulette: below, weights would explode; above,
/// a path between perfect mirrors would never end.
const SURVIVAL: (f32, f32) = (0.05, 0.95);

/// Follows a path from `ray` and returns the radiance it brings back, W/(m²·sr); `rays` counts
/// the rays cast.
pub fn radiance(
    scene: &Scene,
    method: Method,
    depth: u32,
    mut ray: Ray,
    sampler: &Sampler,
    rays: &mut u64,
) -> Vec3 {
    let mut radiance = Vec3::ZERO;
    let mut throughput = Vec3::ONE;
    // The density with which the last direction was drawn; `None` if it was the only one.
    let mut direction_pdf: Option<f32> = None;
    for bounce in 0.. {
        *rays += 1;
        let Some(hit) = scene.intersect(&ray) else {
            radiance += throughput * scene.background();
            break;
        };
        let point = scene.primitives().surface_point(&ray, &hit);
        let wo = -ray.dir;
        let front = wo.dot(point.n) > 0.0;
        let material = scene.material(hit.prim);
        if front != planted::has(Bug::OneSidedFlagFlipped) && material.emits() {
            let weight = match (method, direction_pdf) {
                (Method::Naive, _) | (_, None) => 1.0,
                (Method::Nee, _) => 0.0,
                (Method::Mis, Some(pdf)) => {
                    let light_pdf =
                        scene
                            .lights()
                            .pdf(scene.primitives(), ray.origin, hit.prim, point.p);
                    power_heuristic(pdf, light_pdf)
                }
            };
            radiance += weight * throughput * material.emission;
            if planted::has(Bug::LastBounceEmissionDoubled) && bounce + 1 >= depth {
                radiance += weight * throughput * material.emission;
            }
        }
        if bounce + 1 >= depth {
            break;
        }

        let bsdf = material.bsdf(|| scene.primitives().uv(&hit));
        let n = if front { point.n } else { -point.n };
        if method != Method::Naive && bsdf.diffuse() != Vec3::ZERO {
            radiance +=
                throughput * direct_light(scene, method, &point, n, &bsdf, sampler, bounce, rays);
        }

        let [choice, roulette] = sampler.get_2d(Dim::Choice(bounce));
        let u = sampler.get_2d(Dim::BsdfDirection(bounce));
        let Some(sample) = bsdf.sample(wo, n, front, choice, u) else {
            break;
        };
        throughput *= sample.weight;
        if bounce >= ROULETTE_FROM {
            let survival = throughput.max_element().clamp(SURVIVAL.0, SURVIVAL.1);
            if roulette >= survival {
                break;
            }
            if !planted::has(Bug::RouletteWeightOmitted) {
                throughput /= survival;
            }
        }
        direction_pdf =
            (!sample.specular || planted::has(Bug::MirrorWeighted)).then_some(sample.pdf);
        ray = Ray::new(point.leave(sample.wi), sample.wi);
    }
    radiance
}

/// Light that reaches `point` straight from one point of one light and leaves along the path,
/// over the probability of the choice.
#[expect(clippy::too_many_arguments, reason = "one step of the loop above")]
fn direct_light(
    scene: &Scene,
    method: Method,
    point: &SurfacePoint,
    n: Vec3,
    bsdf: &Bsdf,
    sampler: &Sampler,
    bounce: u32,
    rays: &mut u64,
) -> Vec3 {
    let [pick, _] = sampler.get_2d(Dim::LightPick(bounce));
    let u = sampler.get_2d(Dim::LightPoint(bounce));
    let Some(light) = scene.lights().sample(scene.primitives(), point.p, pick, u) else {
        return Vec3::ZERO;
    };
    let toward = (light.point.p - point.p).normalize();
    let cos = n.dot(toward);
    if !(cos > 0.0) {
        return Vec3::ZERO;
    }
    // Both ends leave their surface, and the light itself is not asked, so that nothing but
    // what truly stands between can shade.
    let from = point.leave(toward);
    let segment = light.point.leave(-toward) - from;
    let distance = segment.length();
    let shadow = Ray {
        origin: from,
        dir: segment / distance,
        t_max: distance,
    };
    *rays += 1;
    if scene.occluded(&shadow, light.prim) {
        return Vec3::ZERO;
    }
    let weight = match method {
        Method::Mis => power_heuristic(light.pdf, bsdf.pdf(cos)),
        Method::Naive | Method::Nee => 1.0,
    };
    let cos = if planted::has(Bug::CosineDropped) {
        1.0
    } else {
        cos
    };
    let f = bsdf.diffuse() * std::f32::consts::FRAC_1_PI;
    f * scene.material(light.prim).emission * (weight * cos / light.pdf)
}

/// Weight of a sample drawn with density `a` where `b` could have drawn it too:
/// a²/(a² + b²), in a form that neither overflows nor divides 0 by 0 (Veach & Guibas 1995).
pub(crate) fn power_heuristic(a: f32, b: f32) -> f32 {
    if a >= b {
        let r = b / a;
        1.0 / (1.0 + r * r)
    } else {
        let r = a / b;
        r * r / (1.0 + r * r)
    }
}

#[cfg(test)]
mod tests {
    use super::power_heuristic;

    #[test]
    fn weights_sum_to_one_at_any_magnitude() {
        for (a, b) in [
            (1.0, 1.0),
            (1e20, 1e20),
            (1e-23, 1e-23),
            (3e38, 1e-38),
            (2.0, 0.0),
            (0.3, 7.0),
        ] {
            let sum = power_heuristic(a, b) + power_heuristic(b, a);
            assert!((sum - 1.0).abs() <= 1e-6, "{a} {b}: {sum}");
        }
        assert_eq!(power_heuristic(f32::INFINITY, 1.0), 1.0);
    }
}
