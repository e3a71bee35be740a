//! Marks for the guide: where light falls on diffuse surfaces by way of mirror and glass.

use glam::Vec3;

use super::{LightWave, Shade};
use crate::color::luminance;
use crate::integrator::{AIMED_AT, Transport, is_only};
use crate::light::{Guide, Mark};
use crate::sampler::Sampler;
use crate::settings::SamplerKind;

/// Light paths that leave marks. Eight times as many take 50 ms and guide no better.
const PATHS: u64 = 1 << 13;

/// Most of its segments.
const DEPTH: u32 = 16;

/// Light paths that advance together.
const WAVE: u64 = 4096;

impl Guide {
    /// Where caustics come from in the scene of a transport. Nothing else of it matters.
    pub fn of(transport: &Transport<'_>) -> Option<Self> {
        let scene = transport.scene;
        let (mut wave, mut marks) = (LightWave::default(), Vec::new());
        for first in (0..PATHS).step_by(WAVE as usize) {
            wave.clear();
            for i in first..first + WAVE {
                // Of one half, so that they are one sequence.
                let sampler = Sampler::new(SamplerKind::Sobol, 0, [u32::MAX; 2], 2 * i);
                wave.push(transport, sampler, 0..0);
            }
            for bounce in 0..DEPTH {
                if wave.paths.is_empty() {
                    break;
                }
                scene.intersect_all(&wave.rays, &mut wave.hits);
                scene.geometry().kernel().run(Shade {
                    wave: &mut wave,
                    transport,
                    bounce,
                    to: super::To::Marks(&mut marks),
                });
            }
        }
        Self::new(marks)
    }
}

impl LightWave {
    /// Marks the vertices of the paths from `first` on that are diffuse.
    #[inline(always)]
    pub(super) fn mark(&self, first: usize, marks: &mut Vec<Mark>) {
        let vertices = &self.vertices;
        for lane in 0..vertices.count {
            let pdf = vertices.arriving_pdf[lane];
            if vertices.diffuse.get(lane) == Vec3::ZERO || !is_only(pdf) || pdf == AIMED_AT {
                continue;
            }
            let (_, light) = self.emissions[vertices.indices[lane] as usize];
            marks.push(Mark {
                // As the origin of a ray that leaves from there.
                p: vertices.points.get(lane).leave(vertices.n.get(lane)),
                from: self.rays[first + vertices.source(lane)].origin,
                weight: luminance(vertices.throughput.get(lane) * light),
            });
        }
    }
}
