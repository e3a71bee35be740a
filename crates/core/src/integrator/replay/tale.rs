//! What became of one path, segment by segment.

use glam::Vec3;

use super::Strategy;
use crate::integrator::{Kind, Wave};
use crate::math::Ray;

/// Light that a path has looked for.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct Aim {
    /// How it was looked for: aimed at, or by way of a mirror too.
    pub strategy: Strategy,
    /// The point on a mirror by way of which.
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

/// A segment of a path or of one of its branches, and what was found at its end.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Segment {
    /// How many there are from the camera to its end.
    pub number: u32,
    /// Whether it is the first of a branch, the other way at glass or a probe, which has left the path or another branch
    /// before.
    pub is_branch: bool,
    /// Where it starts.
    pub from: Vec3,
    /// Unit direction.
    pub dir: Vec3,
    /// Where it ends, and on which primitive; `None` if it leaves the scene.
    pub end: Option<(Vec3, u32)>,
    /// The share of what is found at its end that the camera gets.
    pub throughput: Vec3,
    /// Light of the surface there, or of the background, W/(m²·sr), and what sights saw of lamps so far away.
    pub met: Vec3,
    /// Lamps aimed at from there.
    pub aims: Vec<Aim>,
}

/// What the only path of a wave and its branches have found.
#[derive(Default)]
pub(crate) struct Tale {
    /// Those of each path and branch, with its number, in the order in which they came to their ends.
    segments: Vec<(u32, Segment)>,
    /// The first of this step.
    first: usize,
    /// What each path and branch had found before this step.
    had: Vec<Vec3>,
}

impl Tale {
    /// The segments, those of the path first, then those of each branch.
    pub fn into_segments(mut self) -> Vec<Segment> {
        self.segments.sort_by_key(|(index, _)| *index);
        self.segments
            .into_iter()
            .map(|(_, segment)| segment)
            .collect()
    }

    /// Tells where the paths of a wave have come to.
    pub fn begin_step(&mut self, wave: &Wave, bounce: u32) {
        self.first = self.segments.len();
        self.had.clone_from(&wave.radiance);
        for ((path, ray), hit) in wave.paths.iter().zip(&wave.rays).zip(&wave.hits) {
            if path.kind == Kind::Sight {
                continue;
            }
            let end = hit.map(|hit| (ray.at(hit.t), hit.prim));
            let segment = Segment {
                number: bounce + 1,
                is_branch: !self.segments.iter().any(|(i, _)| *i == path.index) && bounce > 0,
                from: ray.origin,
                dir: ray.dir,
                end,
                throughput: path.throughput,
                met: Vec3::ZERO,
                aims: Vec::new(),
            };
            self.segments.push((path.index, segment));
        }
    }

    /// Tells what the paths have just run into.
    pub fn tell_met(&mut self, wave: &Wave) {
        for (index, segment) in &mut self.segments[self.first..] {
            let i = *index as usize;
            segment.met = wave.radiance[i] - self.had[i];
        }
    }

    /// Tells which lamps were just aimed at; `free` says which shadow rays were, `aimed` is what each path
    /// had found before the detours.
    pub fn tell_aims(&mut self, wave: &Wave, free: &[bool], aimed: &[Vec3]) {
        let end = |ray: &Ray| ray.at(ray.t_max);
        for (index, segment) in &mut self.segments[self.first..] {
            let i = *index as usize;
            let rays = wave.shadow_rays.iter().zip(free);
            for (ray, is_free) in rays.filter(|(ray, _)| ray.index == *index) {
                segment.aims.push(Aim {
                    strategy: Strategy::Aimed,
                    by: None,
                    to: end(&ray.ray),
                    light: ray.light,
                    radiance: ray.radiance,
                    is_free: *is_free,
                });
            }
            // There is one at most.
            let detours = wave.detours.iter().filter(|detour| detour.index == *index);
            segment.aims.extend(detours.map(|detour| Aim {
                strategy: Strategy::ByMirror,
                by: Some(end(&detour.to_mirror)),
                to: end(&detour.to_light),
                light: detour.light,
                radiance: detour.radiance,
                is_free: wave.radiance[i] != aimed[i],
            }));
        }
    }
}
