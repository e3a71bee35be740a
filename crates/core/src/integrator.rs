//! Light transport: the radiance that paths find.
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
//!
//! Paths advance together, a bounce at a time, as a [`Wave`]: all their rays are cast, then all
//! hits are shaded, then all shadow rays are cast. No path sees another, so what a path finds
//! does not depend on its wave.

use std::sync::atomic::{AtomicBool, Ordering};

use glam::Vec3;

use crate::bsdf::Bsdf;
use crate::geometry::{Hit, SurfacePoint};
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

/// Density of a direction that was the only one possible: from the camera, mirror or glass.
const ONLY: f32 = f32::INFINITY;

/// A path on its way.
#[derive(Clone, Copy, Debug)]
struct Path {
    sampler: Sampler,
    throughput: Vec3,
    /// Density per solid angle with which the direction of its ray was drawn, or [`ONLY`].
    direction_pdf: f32,
    /// Where its radiance is added up.
    index: u32,
}

/// A ray to a point on a light, and what arrives if nothing stands between.
#[derive(Clone, Copy, Debug)]
struct ShadowRay {
    ray: Ray,
    /// The light itself, which is not asked.
    light: u32,
    radiance: Vec3,
    /// Index of its path.
    index: u32,
}

/// Paths that advance together. Its memory is used again from wave to wave.
#[derive(Debug, Default)]
pub struct Wave {
    paths: Vec<Path>,
    /// The next segment of each path.
    rays: Vec<Ray>,
    hits: Vec<Option<Hit>>,
    shadow_rays: Vec<ShadowRay>,
    radiance: Vec<Vec3>,
}

impl Wave {
    /// Adds a path that starts with `ray`. Paths are numbered in the order in which they are added.
    #[inline]
    pub fn push(&mut self, ray: Ray, sampler: Sampler) {
        self.paths.push(Path {
            sampler,
            throughput: Vec3::ONE,
            direction_pdf: ONLY,
            index: self.radiance.len() as u32,
        });
        self.rays.push(ray);
        self.radiance.push(Vec3::ZERO);
    }

    /// Number of paths added.
    pub fn len(&self) -> usize {
        self.radiance.len()
    }

    /// Whether none was added.
    pub fn is_empty(&self) -> bool {
        self.radiance.is_empty()
    }

    /// Forgets all paths.
    pub fn clear(&mut self) {
        self.paths.clear();
        self.rays.clear();
        self.radiance.clear();
    }

    /// Follows all paths to their ends and returns the radiance that each brings back,
    /// W/(m²·sr); `rays` counts the rays cast. `None` if `cancel` was set meanwhile.
    pub fn trace(
        &mut self,
        scene: &Scene,
        method: Method,
        depth: u32,
        cancel: &AtomicBool,
        rays: &mut u64,
    ) -> Option<&[Vec3]> {
        for bounce in 0..depth {
            if self.paths.is_empty() {
                break;
            }
            if cancel.load(Ordering::Relaxed) {
                return None;
            }
            *rays += self.rays.len() as u64;
            scene.intersect_all(&self.rays, &mut self.hits);
            self.shade(scene, method, bounce, bounce + 1 == depth);
            *rays += self.shadow_rays.len() as u64;
            let shadow_rays = &self.shadow_rays;
            scene.geometry().occluded_many(
                shadow_rays.len(),
                |i| (shadow_rays[i].ray, shadow_rays[i].light),
                |i, shaded| {
                    if !shaded {
                        let ShadowRay {
                            index, radiance, ..
                        } = shadow_rays[i];
                        self.radiance[index as usize] += radiance;
                    }
                },
            );
        }
        Some(&self.radiance)
    }

    /// Adds the light that the paths have run into, aims at lights, and sends the paths on; those
    /// that end, all if this `is_last`, are taken out.
    fn shade(&mut self, scene: &Scene, method: Method, bounce: u32, is_last: bool) {
        self.shadow_rays.clear();
        let mut kept = 0;
        for i in 0..self.paths.len() {
            let (mut path, ray) = (self.paths[i], self.rays[i]);
            let radiance = &mut self.radiance[path.index as usize];
            let Some(hit) = self.hits[i] else {
                *radiance += path.throughput * scene.background();
                continue;
            };
            let point = scene.primitives().surface_point(&ray, &hit);
            let wo = -ray.dir;
            let front = wo.dot(point.n) > 0.0;
            let material = scene.material(hit.prim);
            if front != planted::has(Bug::OneSidedFlagFlipped) && material.emits() {
                let weight = match method {
                    Method::Naive => 1.0,
                    Method::Nee => f32::from(path.direction_pdf == ONLY),
                    Method::Mis if path.direction_pdf == ONLY => 1.0,
                    Method::Mis => power_heuristic(
                        path.direction_pdf,
                        scene.lights().pdf(ray.origin, hit.prim, point.p),
                    ),
                };
                *radiance += weight * path.throughput * material.emission;
                if is_last && planted::has(Bug::LastBounceEmissionDoubled) {
                    *radiance += weight * path.throughput * material.emission;
                }
            }
            if is_last {
                continue;
            }

            let bsdf = material.bsdf(|| scene.primitives().uv(&hit));
            let n = if front { point.n } else { -point.n };
            if method != Method::Naive && bsdf.diffuse() != Vec3::ZERO {
                self.shadow_rays
                    .extend(aim(scene, method, &point, n, &bsdf, &path, bounce));
            }
            if let Some(ray) = scatter(&mut path, wo, &point, n, front, &bsdf, bounce) {
                (self.paths[kept], self.rays[kept]) = (path, ray);
                kept += 1;
            }
        }
        self.paths.truncate(kept);
        self.rays.truncate(kept);
    }
}

/// Draws where a path goes from a surface, and whether: the next ray.
#[inline(always)]
fn scatter(
    path: &mut Path,
    wo: Vec3,
    point: &SurfacePoint,
    n: Vec3,
    front: bool,
    bsdf: &Bsdf,
    bounce: u32,
) -> Option<Ray> {
    let sampler = &path.sampler;
    let lobe = || sampler.get_1d(Dim::Lobe(bounce));
    let u = || sampler.get_2d(Dim::BsdfDirection(bounce));
    let sample = bsdf.sample(wo, n, front, lobe, u)?;
    path.throughput *= sample.weight;
    if bounce >= ROULETTE_FROM {
        let survival = path.throughput.max_element().clamp(SURVIVAL.0, SURVIVAL.1);
        if path.sampler.get_1d(Dim::Roulette(bounce)) >= survival {
            return None;
        }
        if !planted::has(Bug::RouletteWeightOmitted) {
            path.throughput /= survival;
        }
    }
    let is_only = sample.specular && !planted::has(Bug::MirrorWeighted);
    path.direction_pdf = if is_only { ONLY } else { sample.pdf };
    Some(Ray::new(point.leave(sample.wi), sample.wi))
}

/// Aims at one point of one light: the light that would reach `point` from there and leave along
/// the path, over the probability of the choice.
#[inline(always)]
fn aim(
    scene: &Scene,
    method: Method,
    point: &SurfacePoint,
    n: Vec3,
    bsdf: &Bsdf,
    path: &Path,
    bounce: u32,
) -> Option<ShadowRay> {
    let pick = || path.sampler.get_1d(Dim::LightPick(bounce));
    let u = || path.sampler.get_2d(Dim::LightPoint(bounce));
    let light = scene.lights().sample(point.p, pick, u)?;
    let toward = (light.point.p - point.p).normalize();
    let cos = n.dot(toward);
    if !(cos > 0.0) {
        return None;
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
    let arriving = f * scene.material(light.prim).emission * (weight * cos / light.pdf);
    // Both ends leave their surface, so that nothing but what truly stands between can shade.
    let from = point.leave(toward);
    let segment = light.point.leave(-toward) - from;
    let distance = segment.length();
    Some(ShadowRay {
        ray: Ray {
            origin: from,
            dir: segment / distance,
            t_max: distance,
        },
        light: light.prim,
        radiance: path.throughput * arriving,
        index: path.index,
    })
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
