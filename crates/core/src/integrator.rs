//! Light transport: the radiance that paths find.
//!
//! A path of depth d has d segments from the camera to the light: depth 1 is light seen
//! directly. The methods share one loop and differ only in how they count light that a
//! segment runs into and whether they also aim at lights:
//!
//! | method | light run into | light aimed at |
//! |---|---|---|
//! | naive | 1 | – |
//! | nee | 1 from the camera and after mirror or glass, else 0 | 1 |
//! | mis | 1 from the camera and after mirror or glass, else its power-heuristic weight | its weight |
//! | caustics | the same, but its weight where light paths find it too | its weight |
//! | reuse | as caustics | as caustics |
//!
//! `caustics` also traces paths from the lights, for light that comes to diffuse surfaces by way of
//! mirror and glass (`light_paths`), looks for such light where mirrors and glass show it
//! (`vertices::anchors`), and goes both ways at glass that the camera sees (`vertices::branches`); where nothing is specular it is `mis`. `reuse` is `caustics`, and
//! paths of a group share what they find (`reuse`). All that aim at lights also aim at them by way of
//! mirror spheres ([`crate::light`]): the one path from a diffuse surface by the outside of a sphere to
//! a point on a light is found, not met. Light that a path then runs into that way, diffuse, mirror
//! sphere, light, does not count.
//!
//! The background is not aimed at: it counts fully in every method. Where a path has sights (`render/outlines.rs`), lamps that mirrors
//! or nothing show to the camera count for these instead.
//!
//! Paths advance together, a bounce at a time, as a wave: all their rays are cast, then all
//! hits are shaded, `GROUP` side by side, then all shadow rays are cast. No path sees another, but for
//! those of a group at the end with `reuse`, so what a path finds does not depend on its wave.

use std::sync::atomic::{AtomicBool, Ordering};

use glam::Vec3;

use crate::film::Followed;
use crate::geometry::Hit;
use crate::math::{GROUP, Ray};
use crate::plan::Part;
use crate::sampler::Sampler;
use crate::settings::{Method, UNLIMITED};
use crate::simd::{Lanes, Task};
use crate::work::{Stage, Stopwatch};
use caustics::Caustics;
use reuse::Reuse;
pub(crate) use transport::Transport;
use vertices::Vertices;

mod caustics;
pub(crate) mod light_paths;
mod meet;
pub mod replay;
pub(crate) mod reuse;
mod transport;
mod vertices;

/// Density of a direction that was the only one possible: from the camera, mirror or glass.
const ONLY: f32 = f32::INFINITY;

/// Stands for the density of a direction that was the only one possible at a mirror sphere whose
/// light the diffuse surface before it has aimed at.
const AIMED_AT: f32 = f32::MAX;

/// Whether a direction was the only one possible, by its density.
#[inline(always)]
fn is_only(direction_pdf: f32) -> bool {
    direction_pdf >= AIMED_AT
}

/// A path on its way.
#[derive(Clone, Copy, Debug)]
struct Path {
    sampler: Sampler,
    throughput: Vec3,
    /// Density per solid angle with which the direction of its ray was drawn, or [`ONLY`] and the
    /// like.
    direction_pdf: f32,
    /// Where its radiance is added up.
    index: u32,
    kind: Kind,
}

/// What a path is for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    /// All light.
    Whole,
    /// As that, but lamps that mirrors or nothing show are left to sights, and it has met only mirrors so far.
    Sighted,
    /// Lamps that mirrors or nothing show.
    Sight,
    /// A guide has sent it (`vertices::anchors`), and it has met nothing but mirror and glass since.
    Probe,
}

impl Path {
    /// Whether it was sent to meet mirror or glass, and what it meets first is that or nothing.
    #[inline(always)]
    fn is_blind(&self) -> bool {
        self.kind == Kind::Probe && !is_only(self.direction_pdf)
    }
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

/// Two rays, from a path to a mirror sphere and on to a light, and what arrives if both are free.
#[derive(Clone, Copy, Debug)]
struct Detour {
    to_mirror: Ray,
    mirror: u32,
    to_light: Ray,
    light: u32,
    radiance: Vec3,
    /// Index of its path.
    index: u32,
}

/// How far paths get at a bounce.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Step {
    /// To the surface, and no further.
    Meet,
    /// They aim at lights from there.
    Aim,
    /// And go on.
    Scatter,
}

/// Paths that advance together. Its memory is used again from wave to wave.
#[derive(Debug, Default)]
pub(crate) struct Wave {
    paths: Vec<Path>,
    /// The next segment of each path.
    rays: Vec<Ray>,
    hits: Vec<Option<Hit>>,
    shadow_rays: Vec<ShadowRay>,
    detours: Vec<Detour>,
    /// Detours whose first ray is free.
    half_free: Vec<u32>,
    radiance: Vec<Vec3>,
    /// What paths that are followed further had found within the depth.
    within: Vec<Vec3>,
    caustics: Caustics,
    /// Light that the paths have run into, and left to light paths; all channels.
    left: f64,
    vertices: Vertices,
    reuse: Reuse,
    /// What paths that are followed further had shared within the depth.
    later_within: Vec<Vec3>,
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
            kind: Kind::Whole,
        });
        self.rays.push(ray);
        self.radiance.push(Vec3::ZERO);
    }

    /// Adds sights of the path that was added last.
    pub fn push_sights(&mut self, rays: impl ExactSizeIterator<Item = Ray>) {
        let Some(path) = self.paths.last_mut() else {
            return;
        };
        path.kind = Kind::Sighted;
        let sight = Path {
            throughput: Vec3::splat(1.0 / rays.len() as f32),
            kind: Kind::Sight,
            ..*path
        };
        for ray in rays {
            self.paths.push(sight);
            self.rays.push(ray);
        }
    }

    /// Forgets all paths.
    pub fn clear(&mut self) {
        self.paths.clear();
        self.rays.clear();
        self.radiance.clear();
        self.reuse.clear();
    }

    /// Lets the paths from the last group on, up to number `count`, share what they find, if the
    /// method does.
    pub fn end_group(&mut self, count: usize) {
        self.reuse.end_group(count);
    }

    /// Makes ready for caustics, if they are traced.
    fn begin_caustics(&mut self, transport: &Transport<'_>) {
        self.caustics.clear();
        if transport.traces_light() {
            self.caustics.begin(self.radiance.len());
        }
    }

    /// The radiance of the paths, in the order in which they were added, W/(m²·sr).
    pub(crate) fn radiance(&self) -> &[Vec3] {
        &self.radiance
    }

    /// What has anchors that light paths may be joined to, and the radiance of the paths.
    fn caustics_and_radiance(&mut self) -> (&Caustics, &mut [Vec3]) {
        (&self.caustics, &mut self.radiance)
    }

    /// Follows all paths to their ends, at most to the depth, and returns the radiance that each
    /// brings back, W/(m²·sr); `rays` counts the rays cast. `None` if `cancel` was set meanwhile.
    ///
    /// With `followed`, the paths go on beyond the depth, and what they find there and before is
    /// counted, but not in the radiance or the rays.
    pub(crate) fn trace(
        &mut self,
        transport: &Transport<'_>,
        cancel: &AtomicBool,
        rays: &mut u64,
        watch: &mut Stopwatch,
        mut followed: Option<&mut Followed>,
    ) -> Option<&[Vec3]> {
        let Transport { scene, depth, .. } = *transport;
        let is_followed = followed.is_some();
        // Light counted so far, by paths of how many segments it is found, and what follows.
        let mut counted = 0.0;
        let mut count = |segments: u32, wave: &Self| {
            if let Some(followed) = &mut followed {
                let light = wave.radiance.iter().map(|r| f64::from(r.element_sum()));
                let light = wave.left + light.sum::<f64>() + wave.reuse.light();
                followed.add(segments, light - counted, segments > depth);
                counted = light;
            }
        };
        self.within.clear();
        self.begin_caustics(transport);
        self.left = 0.0;
        if transport.method == Method::Reuse && self.reuse.has_groups() {
            self.reuse.extend(self.radiance.len());
        }
        for bounce in 0..if is_followed { UNLIMITED } else { depth } {
            if self.paths.is_empty() {
                break;
            }
            if cancel.load(Ordering::Relaxed) {
                return None;
            }
            let is_beyond = bounce >= depth;
            let stage = |stage| if is_beyond { Stage::Measuring } else { stage };
            let step = match () {
                () if is_followed => Step::Scatter,
                () if bounce + 1 == depth => Step::Meet,
                () if bounce + 2 == depth && !transport.plan.has(Part::LastSegment) => Step::Aim,
                () => Step::Scatter,
            };
            if !is_beyond {
                *rays += self.rays.len() as u64;
            }
            scene.intersect_all(&self.rays, &mut self.hits);
            watch.lap(stage(Stage::Traversal));
            self.shade(transport, bounce, step);
            count(bounce + 1, self);
            if bounce + 1 == depth && is_followed {
                self.within.clone_from(&self.radiance);
                self.later_within.clone_from(&self.reuse.later);
            }
            watch.lap(stage(Stage::Shading));
            if cancel.load(Ordering::Relaxed) {
                return None;
            }
            let is_beyond = bounce + 1 >= depth;
            if !is_beyond {
                *rays += self.shadow_rays.len() as u64;
            }
            let (shadow_rays, radiance) = (&self.shadow_rays, &mut self.radiance);
            let reuse = &mut self.reuse;
            scene.geometry().occluded_many(
                shadow_rays,
                |shadow| (shadow.ray, shadow.light),
                |i, shaded| {
                    if !shaded {
                        let ray = &shadow_rays[i];
                        *reuse.aimed(radiance, ray.index, bounce) += ray.radiance;
                    }
                },
            );
            count(bounce.saturating_add(2), self);
            if transport.detours(bounce) {
                *rays += self.take_detours(transport, bounce);
                count(bounce + 3, self);
            }
            watch.lap(if is_beyond {
                Stage::Measuring
            } else {
                Stage::ShadowRays
            });
        }
        // Empty, too, if all paths ended before.
        if !self.within.is_empty() {
            std::mem::swap(&mut self.radiance, &mut self.within);
            std::mem::swap(&mut self.reuse.later, &mut self.later_within);
        }
        if self.reuse.is_on() {
            *rays += self.reuse.share(transport, &mut self.radiance);
            watch.lap(Stage::Reuse);
        }
        self.caustics.join_branches(&mut self.radiance);
        Some(&self.radiance)
    }

    /// Adds the light that arrives by way of mirror spheres; returns the number of rays cast.
    fn take_detours(&mut self, transport: &Transport<'_>, bounce: u32) -> u64 {
        let (reuse, radiance) = (&mut self.reuse, &mut self.radiance);
        let (detours, half_free) = (&self.detours, &mut self.half_free);
        half_free.clear();
        let geometry = transport.scene.geometry();
        geometry.occluded_many(
            detours,
            |detour| (detour.to_mirror, detour.mirror),
            |i, shaded| {
                if !shaded {
                    half_free.push(i as u32);
                }
            },
        );
        let detour = |i: &u32| &detours[*i as usize];
        geometry.occluded_many(
            half_free,
            |i| (detour(i).to_light, detour(i).light),
            |i, shaded| {
                if !shaded {
                    let detour = detour(&half_free[i]);
                    *reuse.aimed(radiance, detour.index, bounce) += detour.radiance;
                }
            },
        );
        (detours.len() + half_free.len()) as u64
    }

    /// Adds the light that the paths have run into, aims at lights, and sends the paths on, as far
    /// as the `step` goes; those that end are taken out.
    fn shade(&mut self, transport: &Transport<'_>, bounce: u32, step: Step) {
        transport.scene.geometry().kernel().run(Shade {
            wave: self,
            transport,
            bounce,
            step,
        });
    }

    #[inline(always)]
    fn shade_all(&mut self, transport: &Transport<'_>, bounce: u32, step: Step) {
        self.shadow_rays.clear();
        self.detours.clear();
        let (aims, detours) = (transport.aims(), transport.detours(bounce));
        let was_detour = bounce > 0 && transport.detours(bounce - 1);
        let (anchors, had_anchors) = (
            transport.anchors(bounce),
            bounce > 0 && transport.anchors(bounce - 1),
        );
        let mut kept = 0;
        for first in (0..self.paths.len()).step_by(GROUP) {
            self.meet(transport, first, bounce, step == Step::Meet);
            if step == Step::Meet {
                continue;
            }
            let vertices = &mut self.vertices;
            if aims && vertices.any_diffuse {
                vertices.aim(transport, bounce, &mut self.shadow_rays);
                if detours {
                    vertices.aim_by_mirrors(transport, bounce, &mut self.detours);
                }
                if anchors {
                    vertices.anchor(
                        transport,
                        bounce,
                        &self.hits[first..],
                        &self.reuse,
                        &mut self.caustics,
                    );
                }
            }
            if step == Step::Aim {
                continue;
            }
            let arriving = &self.rays[first..];
            let caustics = &mut self.caustics;
            vertices.scatter(transport, bounce, was_detour);
            if had_anchors {
                vertices.weigh_against_probes(transport, bounce, arriving, caustics);
                vertices.share_from_anchors(bounce, arriving, caustics);
            } else if bounce == 0 && caustics.are_traced() {
                vertices.share_with_light_paths(transport, caustics);
            }
            if caustics.are_traced() {
                vertices.branch(caustics);
            }
            if self.reuse.is_on() {
                vertices.offer(&mut self.reuse, bounce);
            }
            for lane in 0..vertices.count {
                if vertices.direction_pdf[lane] > 0.0 {
                    self.paths[kept] = vertices.path(lane);
                    self.rays[kept] = vertices.ray(lane);
                    kept += 1;
                }
            }
        }
        self.paths.truncate(kept);
        self.rays.truncate(kept);
        if self.caustics.are_traced() {
            self.caustics.send(&mut self.paths, &mut self.rays);
            let count = self.caustics.count();
            self.radiance.resize(count, Vec3::ZERO);
            if self.reuse.is_on() {
                self.reuse.extend(count);
                let probes = self.paths[kept..]
                    .iter()
                    .filter(|path| path.kind == Kind::Probe);
                probes.for_each(|probe| self.reuse.stays(probe.index, bounce));
            }
        }
    }
}

/// [`Wave::shade`] for a kernel.
struct Shade<'a, 'b> {
    wave: &'a mut Wave,
    transport: &'a Transport<'b>,
    bounce: u32,
    step: Step,
}

impl Task for Shade<'_, '_> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self) {
        self.wave.shade_all(self.transport, self.bounce, self.step);
    }
}

/// Weight of a sample drawn with density `a` where `b` could have drawn it too:
/// a²/(a² + b²), in a form that neither overflows nor divides 0 by 0 (Veach & Guibas 1995).
#[inline(always)]
pub(crate) fn power_heuristic(a: f32, b: f32) -> f32 {
    let (r, is_more) = if a >= b {
        (b / a, true)
    } else {
        (a / b, false)
    };
    let r2 = r * r;
    (if is_more { 1.0 } else { r2 }) / (1.0 + r2)
}
