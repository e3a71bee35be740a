//! Paths followed again, step by step: the same paths as `Wave::trace` follows, with the same
//! light to the last bit, and what each step has found.

use std::sync::atomic::{AtomicBool, Ordering};

use glam::Vec3;

use super::{Kind, Step, Transport, Wave};
use crate::plan::Part;
pub(crate) use tale::Tale;
pub use tale::{Aim, Segment};

mod tale;

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
    /// `tale`, if there is one, the segments of the only path. `None` if `cancel` was set meanwhile.
    pub(crate) fn replay(
        &mut self,
        transport: &Transport<'_>,
        cancel: &AtomicBool,
        mut found: impl FnMut(Found<'_>),
        mut tale: Option<&mut Tale>,
    ) -> Option<&[Vec3]> {
        self.within.clear();
        self.begin_caustics(transport);
        self.left = 0.0;
        let mut before = self.radiance.clone();
        for bounce in 0..transport.depth {
            if self.paths.is_empty() {
                break;
            }
            if cancel.load(Ordering::Relaxed) {
                return None;
            }
            let step = step(transport, bounce);
            let mut tell = |wave: &Self, strategy, segments| {
                let mut after = wave.radiance.clone();
                wave.caustics.join_branches(&mut after);
                found(Found {
                    strategy,
                    segments,
                    before: &before,
                    after: &after,
                });
                before = after;
            };
            transport.scene.intersect_all(&self.rays, &mut self.hits);
            if let Some(tale) = &mut tale {
                tale.begin_step(self, bounce);
            }
            self.shade(transport, bounce, step);
            if let Some(tale) = &mut tale {
                tale.tell_met(self);
            }
            tell(self, Strategy::Met, bounce + 1);
            let free = self.take_shadow_rays(transport);
            tell(self, Strategy::Aimed, bounce + 2);
            let aimed = tale.is_some().then(|| self.radiance.clone());
            if transport.detours(bounce) {
                self.take_detours(transport, bounce);
                tell(self, Strategy::ByMirror, bounce + 3);
            }
            if let (Some(tale), Some(aimed)) = (&mut tale, aimed) {
                tale.tell_aims(self, &free, &aimed);
            }
        }
        self.caustics.join_branches(&mut self.radiance);
        Some(&self.radiance)
    }

    /// Follows all paths as [`Wave::trace`] does, and gives the number of segments of each and its
    /// branches: to the lamp or the background, to where it was given up, or to the depth, but no
    /// more than `most` of each.
    pub(crate) fn lengths(&mut self, transport: &Transport<'_>, most: u32) -> Vec<u32> {
        let mut lengths = vec![0; self.radiance.len()];
        self.begin_caustics(transport);
        for bounce in 0..transport.depth.min(most) {
            if self.paths.is_empty() {
                break;
            }
            for path in self.paths.iter().filter(|path| path.kind != Kind::Sight) {
                lengths[self.caustics.owner(path.index) as usize] += 1;
            }
            transport.scene.intersect_all(&self.rays, &mut self.hits);
            self.shade(transport, bounce, step(transport, bounce));
        }
        lengths
    }

    /// Adds the light that shadow rays have brought; whether each was free.
    fn take_shadow_rays(&mut self, transport: &Transport<'_>) -> Vec<bool> {
        let rays = &self.shadow_rays;
        let mut free = vec![false; rays.len()];
        transport.scene.geometry().occluded_many(
            rays,
            |shadow| (shadow.ray, shadow.light),
            |i, shaded| free[i] = !shaded,
        );
        for (ray, _) in rays.iter().zip(&free).filter(|(_, free)| **free) {
            self.radiance[ray.index as usize] += ray.radiance;
        }
        free
    }
}
