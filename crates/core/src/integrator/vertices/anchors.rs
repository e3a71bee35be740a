//! Caustics that mirrors and glass show.
//!
//! Light from a lamp by way of mirror or glass to a diffuse surface, which the camera sees by way of
//! mirror or glass again, is nothing that light paths can bring to a pinhole. But where a camera
//! path comes to such a surface, it drops an anchor. Light paths are joined to anchors as they are to
//! the camera, wherever they come to diffuse surfaces; and for light that comes to the anchor itself by
//! way of mirror or glass, a probe is sent from it to where the guide says such light comes from: from the
//! lamp, or from where it has made something diffuse bright. A probe ends if what it meets first is no
//! mirror or glass; otherwise it goes on as any path, a branch with a number of its own, and drops anchors
//! too. Roulette, which judges by throughput, would end what was sent to where it is bright, so it leaves
//! probes alone until they come to something diffuse.
//!
//! Camera paths find both kinds of light by running into it, so all is weighted. Up to the surface after
//! the anchor a camera path has the density per area p = pdf · cos / d² there, where light paths have
//! 1, but for what is the same from either end (see `light_paths`): if it goes on diffusely
//! from there, the rest of its light is shared with light paths as if the anchor were the camera.
//! Probes and paths that meet mirror or glass next differ in nothing but the density of their direction, and in
//! roulette: the balance heuristic, over all that they find from there on.

use std::f32::consts::FRAC_1_PI;

use glam::Vec3;

use super::{ROULETTE_FROM, Vertices, survival};
use crate::geometry::Hit;
use crate::integrator::caustics::{Anchor, Caustics};
use crate::integrator::light_paths::NOTHING;
use crate::integrator::reuse::Reuse;
use crate::integrator::{Kind, Path, Transport, is_only};
use crate::math::Ray;
use crate::planted::{self, Bug};
use crate::sampler::Dim;

impl Vertices {
    /// Drops anchors from paths that share no light with light paths so far, where they have come to
    /// diffuse surfaces by mirror and glass, and sends a probe from each. `hits` are
    /// what the paths have run into.
    #[inline(always)]
    pub fn anchor(
        &self,
        transport: &Transport<'_>,
        bounce: u32,
        hits: &[Option<Hit>],
        reuse: &Reuse,
        caustics: &mut Caustics,
    ) {
        for lane in 0..self.count {
            let (diffuse, index) = (self.diffuse.get(lane), self.indices[lane]);
            if diffuse == Vec3::ZERO
                || caustics.light_shares[index as usize] > 0.0
                || !is_only(self.arriving_pdf[lane])
            {
                continue;
            }
            let Some(Hit { prim, .. }) = hits[self.source(lane)] else {
                continue;
            };
            let (point, n) = (self.points.get(lane), self.n.get(lane));
            let diffuse_share = self.diffuse_share[lane];
            let f = reuse.head(index) * self.throughput.get(lane) * diffuse * FRAC_1_PI;
            // The other half of a sphere can stand before its inside.
            let is_inside = n.dot(point.n) < 0.0 && transport.scene.primitives().is_sphere(prim);
            let anchor = Anchor {
                point,
                prim: if is_inside { NOTHING } else { prim },
                n,
                f,
                diffuse_share,
                bounce,
            };
            // If it goes on diffusely, for which that is certain.
            let chance = if bounce >= ROULETTE_FROM && diffuse_share == 1.0 {
                survival(self.throughput.get(lane) * diffuse)
            } else {
                1.0
            };
            // A probe is sent as often as a path would scatter diffusely.
            let sends = caustics.anchor(index, anchor, diffuse_share / chance);
            let Some(guide) = transport.guide.filter(|_| sends) else {
                continue;
            };
            let sampler = self.samplers.get(lane);
            let origin = point.leave(n);
            let pick = sampler.get_1d(Dim::GuidePick(bounce)) / diffuse_share;
            if pick >= 1.0 {
                continue;
            }
            let u = sampler.get_2d(Dim::GuideDirection(bounce));
            let Some((dir, pdf)) = guide.sample(origin, pick, u) else {
                continue;
            };
            let cos = n.dot(dir);
            if !(cos > 0.0) {
                continue;
            }
            let by_path = if planted::has(Bug::ProbesCountedTwice) {
                0.0
            } else if planted::has(Bug::RouletteChanceOmitted) {
                cos * FRAC_1_PI
            } else {
                chance * cos * FRAC_1_PI
            };
            let probe = Path {
                sampler,
                throughput: f * (cos / (diffuse_share * (pdf + by_path))),
                direction_pdf: pdf,
                index,
                kind: Kind::Probe,
            };
            caustics.probes.push((probe, Ray::new(origin, dir)));
        }
    }

    /// Weighs the paths that go on by the mirror or glass that they have come to from an anchor, as probes
    /// may have gone there too. `rays` are those on which the paths came.
    #[inline(always)]
    pub fn weigh_against_probes(
        &mut self,
        transport: &Transport<'_>,
        bounce: u32,
        rays: &[Ray],
        caustics: &Caustics,
    ) {
        let Some(guide) = transport.guide else {
            return;
        };
        for (lane, ..) in &self.others {
            let (pdf, index) = (self.arriving_pdf[*lane], self.indices[*lane]);
            let is_first = !is_only(pdf) && is_only(self.direction_pdf[*lane]);
            if is_first
                && self.kinds[*lane] != Kind::Probe
                && let Some(probes) = caustics.probes_since(index, bounce - 1)
            {
                let ray = &rays[self.source(*lane)];
                let weight = pdf / (pdf + probes * guide.pdf(ray.origin, ray.dir));
                self.throughput
                    .set(*lane, weight * self.throughput.get(*lane));
            }
        }
    }

    /// Sets the shares of paths that go on diffusely from a surface that they have come to straight
    /// from an anchor, on `rays`.
    #[inline(always)]
    pub fn share_from_anchors(&self, bounce: u32, rays: &[Ray], caustics: &mut Caustics) {
        for lane in 0..self.count {
            let (pdf, arriving) = (self.direction_pdf[lane], self.arriving_pdf[lane]);
            let index = self.indices[lane];
            let is_diffuse = pdf > 0.0 && !is_only(pdf) && !is_only(arriving);
            let is_first = caustics.light_shares[index as usize] == 0.0;
            if is_diffuse && is_first && caustics.is_anchored_since(index, bounce - 1) {
                let from = rays[self.source(lane)].origin;
                let square = from.distance_squared(self.points.get(lane).p);
                let cos = self.n.get(lane).dot(self.wo.get(lane));
                // Finite, or it would make no weight of a density of 0.
                let share = square / (arriving * cos * self.diffuse_share[lane]);
                caustics.light_shares[index as usize] = share.min(f32::MAX);
            }
        }
    }
}
