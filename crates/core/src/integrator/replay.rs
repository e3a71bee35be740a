//! Paths followed again, step by step: the same paths as `Wave::trace` follows, with the same
//! light to the last bit, and what each step has found.

use std::sync::atomic::{AtomicBool, Ordering};

use glam::Vec3;

use super::{Step, Transport, Wave};
use crate::plan::Part;

/// How light was found.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Strategy {
    /// The path ran into a lamp, or left for the background.
    Met,
    /// A point of a lamp was aimed at.
    Aimed,
    /// A point of a lamp was aimed at by way of a mirror sphere.
    ByMirror,
}

impl Strategy {
    /// Every strategy, in the order in which a path tries them.
    pub const ALL: [Self; 3] = [Self::Met, Self::Aimed, Self::ByMirror];
}

/// Light that a path has looked for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Aim {
    /// The point on a mirror or glass by way of which.
    pub by: Option<Vec3>,
    /// The point on the lamp.
    pub to: Vec3,
    /// Primitive id of the lamp.
    pub light: u32,
    /// What the camera gets of it if nothing stands between, W/(m²·sr).
    pub radiance: Vec3,
    /// Whether nothing does.
    pub is_free: bool,
}

/// A segment of a path, and what was found at its end.
#[derive(Clone, Debug, PartialEq)]
pub struct Segment {
    /// Where it starts.
    pub from: Vec3,
    /// Unit direction.
    pub dir: Vec3,
    /// Where it ends, and on which primitive; `None` if it leaves the scene.
    pub end: Option<(Vec3, u32)>,
    /// The share of what is found at its end that the camera gets.
    pub throughput: Vec3,
    /// Light of the surface there, or of the background, W/(m²·sr).
    pub met: Vec3,
    /// Lamps aimed at from there, and those that probes have found.
    pub aims: Vec<Aim>,
}

/// What a step of a wave has found.
pub(crate) struct Found<'a> {
    pub strategy: Strategy,
    /// Number of segments of the paths of light, from the camera to the lamp.
    pub segments: u32,
    /// Of each path, what the camera has got before the step and after.
    pub before: &'a [Vec3],
    pub after: &'a [Vec3],
}

/// How far paths get at a bounce.
fn step(transport: &Transport<'_>, bounce: u32) -> Step {
    match transport.depth - bounce {
        1 => Step::Meet,
        2 if !transport.plan.has(Part::LastSegment) => Step::Aim,
        _ => Step::Scatter,
    }
}

impl Wave {
    /// Follows all paths as [`Wave::trace`] does. `found` is told what each step has brought, and
    /// `segments`, if there is one, takes those of the only path. `None` if `cancel` was set meanwhile.
    pub(crate) fn replay(
        &mut self,
        transport: &Transport<'_>,
        cancel: &AtomicBool,
        mut found: impl FnMut(Found<'_>),
        mut segments: Option<&mut Vec<Segment>>,
    ) -> Option<&[Vec3]> {
        self.within.clear();
        self.begin_caustics(transport);
        self.left = 0.0;
        let mut before = self.radiance.clone();
        let mut sent = Vec::new();
        for bounce in 0..transport.depth {
            if self.paths.is_empty() {
                break;
            }
            if cancel.load(Ordering::Relaxed) {
                return None;
            }
            let step = step(transport, bounce);
            let mut tell = |wave: &Self, strategy, segments| {
                let after = &wave.radiance;
                found(Found {
                    strategy,
                    segments,
                    before: &before,
                    after,
                });
                before.clone_from(after);
            };
            transport.scene.intersect_all(&self.rays, &mut self.hits);
            let is_followed = !self.paths[0].is_probe;
            if let Some(segments) = &mut segments
                && is_followed
            {
                segments.push(self.segment());
            }
            let had = self.radiance.first().copied();
            match &mut segments {
                Some(segments) => {
                    self.shade_and_tell_probes(transport, bounce, step, segments, &mut sent);
                }
                None => self.shade(transport, bounce, step),
            }
            tell(self, Strategy::Met, bounce + 1);
            let free = self.take_shadow_rays(transport);
            tell(self, Strategy::Aimed, bounce + 2);
            let aimed = self.radiance.first().copied();
            if transport.detours(bounce) {
                self.take_detours(transport, bounce);
                tell(self, Strategy::ByMirror, bounce + 3);
            }
            if let (Some(segments), Some(had), Some(aimed)) = (&mut segments, had, aimed)
                && let Some(segment) = segments.last_mut()
                && is_followed
            {
                self.tell_aims(segment, &free, aimed);
                let met = |free: &Aim| {
                    if free.is_free && free.by.is_none() {
                        free.radiance
                    } else {
                        Vec3::ZERO
                    }
                };
                segment.met = aimed - had - segment.aims.iter().map(met).sum::<Vec3>();
            }
        }
        Some(&self.radiance)
    }

    /// Follows all paths as [`Wave::trace`] does, and gives the number of segments of each: to the
    /// lamp or the background, to where it was given up, or to the depth, but no more than `most`.
    pub(crate) fn lengths(&mut self, transport: &Transport<'_>, most: u32) -> Vec<u32> {
        let mut lengths = vec![0; self.radiance.len()];
        self.begin_caustics(transport);
        for bounce in 0..transport.depth.min(most) {
            if self.paths.is_empty() {
                break;
            }
            for path in self.paths.iter().filter(|path| !path.is_probe) {
                lengths[path.index as usize] += 1;
            }
            transport.scene.intersect_all(&self.rays, &mut self.hits);
            self.shade(transport, bounce, step(transport, bounce));
        }
        lengths
    }

    /// Shades. Each probe of the only path gets a radiance of its own, and light that it has found is
    /// told at the end of the segment from which it was `sent`, with where it has come to first.
    fn shade_and_tell_probes(
        &mut self,
        transport: &Transport<'_>,
        bounce: u32,
        step: Step,
        segments: &mut [Segment],
        sent: &mut Vec<(usize, Option<Vec3>)>,
    ) {
        let paths = self.paths.iter().zip(&self.rays).zip(&self.hits);
        let ends: Vec<(usize, Vec3, u32)> = paths
            .filter(|((path, _), _)| path.is_probe)
            .filter_map(|((path, ray), hit)| {
                hit.map(|hit| (path.index as usize, ray.at(hit.t), hit.prim))
            })
            .collect();
        for (index, end, _) in &ends {
            sent[index - 1].1.get_or_insert(*end);
        }
        self.shade(transport, bounce, step);
        for (index, to, light) in ends {
            let (segment, by) = sent[index - 1];
            let radiance = std::mem::take(&mut self.radiance[index]);
            if radiance != Vec3::ZERO {
                segments[segment].aims.push(Aim {
                    by,
                    to,
                    light,
                    radiance,
                    is_free: true,
                });
            }
        }
        for path in self
            .paths
            .iter_mut()
            .filter(|path| path.is_probe && path.index == 0)
        {
            sent.push((bounce as usize, None));
            self.radiance.push(Vec3::ZERO);
            path.index = sent.len() as u32;
        }
    }

    /// The segment that the first path is on.
    fn segment(&self) -> Segment {
        let (ray, hit, path) = (&self.rays[0], &self.hits[0], &self.paths[0]);
        Segment {
            from: ray.origin,
            dir: ray.dir,
            end: hit.map(|hit| (ray.at(hit.t), hit.prim)),
            throughput: path.throughput,
            met: Vec3::ZERO,
            aims: Vec::new(),
        }
    }

    /// Adds the light that shadow rays have brought; whether each was free.
    fn take_shadow_rays(&mut self, transport: &Transport<'_>) -> Vec<bool> {
        let rays = &self.shadow_rays;
        let mut free = vec![false; rays.len()];
        transport.scene.geometry().occluded_many(
            rays.len(),
            |i| (rays[i].ray, rays[i].light),
            |i, shaded| free[i] = !shaded,
        );
        for (ray, _) in rays.iter().zip(&free).filter(|(_, free)| **free) {
            self.radiance[ray.index as usize] += ray.radiance;
        }
        free
    }

    /// Adds the lamps that were just aimed at from the end of the only path's segment; `aimed` is
    /// what it had found before the detours.
    fn tell_aims(&self, segment: &mut Segment, free: &[bool], aimed: Vec3) {
        let end = |ray: &crate::math::Ray| ray.at(ray.t_max);
        let straight = self.shadow_rays.iter().zip(free).map(|(ray, free)| Aim {
            by: None,
            to: end(&ray.ray),
            light: ray.light,
            radiance: ray.radiance,
            is_free: *free,
        });
        segment.aims.extend(straight);
        // There is one at most.
        let detours = self.detours.iter().map(|detour| Aim {
            by: Some(end(&detour.to_mirror)),
            to: end(&detour.to_light),
            light: detour.light,
            radiance: detour.radiance,
            is_free: self.radiance[0] != aimed,
        });
        segment.aims.extend(detours);
    }
}
