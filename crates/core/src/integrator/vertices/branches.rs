//! Branches: at glass, camera paths that have met nothing but mirror and glass go both ways.
//!
//! What glass shows by reflections within it is little of its light, a few hundredths, but
//! may be the focus of a lamp. Left to chance, one path in many would bring all of it at once. Here
//! the path goes on the way that chance has drawn, and a branch the other, each with its share of
//! the light; from a diffuse surface on, where anchors see to such light, chance decides again.
//! (Arvo & Kirk 1990, Particle Transport and Image Synthesis.)

use super::Vertices;
use crate::bsdf::{Bsdf, through_glass};
use crate::integrator::caustics::Caustics;
use crate::integrator::{Kind, ONLY, Path};
use crate::math::Ray;
use crate::planted::{self, Bug};

/// Shares of the light of a pixel below are left to chance, so that a path has a hundred branches
/// at most; a tenth of it brings nothing more (measured: docs/speed-and-accuracy.md).
const LEAST: f32 = 0.01;

impl Vertices {
    /// Divides the paths that have just been drawn a way at glass.
    #[inline(always)]
    pub fn branch(&mut self, caustics: &mut Caustics) {
        for (lane, _, front, bsdf) in &self.others {
            let (lane, index) = (*lane, self.indices[*lane]);
            let Bsdf::Glass(ior) = *bsdf else {
                continue;
            };
            if self.direction_pdf[lane] == 0.0
                || self.kinds[lane] == Kind::Probe
                || !caustics.is_untouched(index)
            {
                continue;
            }
            let n = self.n.get(lane);
            let ways = through_glass(ior, self.wo.get(lane), n, *front);
            let throughput = self.throughput.get(lane);
            // Not to depend on the way that was drawn.
            let least = ways[0].1.min(ways[1].1);
            if throughput.max_element() * least < LEAST {
                continue;
            }
            let is_reflected = self.wi.get(lane).dot(n) > 0.0;
            let [(_, share), (wi, other)] = if is_reflected {
                ways
            } else {
                let [reflected, refracted] = ways;
                [refracted, reflected]
            };
            if !planted::has(Bug::BranchesCountedTwice) {
                self.throughput.set(lane, share * throughput);
            }
            let branch = Path {
                sampler: self.samplers.get(lane),
                throughput: other * throughput,
                direction_pdf: ONLY,
                index,
                kind: Kind::Whole,
            };
            let wi = wi.normalize();
            let origin = self.points.get(lane).leave(wi);
            caustics.branches.push((branch, Ray::new(origin, wi)));
        }
    }
}
