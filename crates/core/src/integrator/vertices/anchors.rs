//! Caustics that mirrors and glass show.
//!
//! Light from a lamp by way of mirror or glass to a diffuse surface, which the camera sees by way of
//! mirror or glass again, is nothing that light paths can bring to a pinhole. But where a camera
//! path comes to such a surface, it drops an anchor. Light paths are joined to anchors as they are to
//! the camera, wherever they come to diffuse surfaces; and for light that comes to the anchor itself by
//! way of mirror or glass, a probe is sent from it to where the guide says such light comes from.
//! A probe is a path that ends where it would have to scatter diffusely.
//!
//! Camera paths find both kinds of light by running into it, so all is weighted. Up to the surface after
//! the anchor a camera path has the density per area p = pdf · cos / d² there, where light paths have
//! 1, but for what is the same from either end (see `light_paths`): if it goes on diffusely
//! from there, the rest of its light is shared with light paths as if the anchor were the camera.
//! Probes and paths differ in nothing but the density of their direction: the balance heuristic.

use std::f32::consts::FRAC_1_PI;

use glam::Vec3;

use super::Vertices;
use crate::geometry::{Hit, SurfacePoint};
use crate::integrator::reuse::Reuse;
use crate::integrator::{Path, Transport, is_only};
use crate::math::Ray;
use crate::planted::{self, Bug};
use crate::sampler::Dim;

/// No anchor.
const NONE: u32 = u32::MAX;

/// A diffuse surface that a camera path has come to by way of mirror and glass.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Anchor {
    pub point: SurfacePoint,
    /// Primitive id.
    pub prim: u32,
    /// Unit normal on the path's side.
    pub n: Vec3,
    /// Throughput of the path, times f.
    pub f: Vec3,
    pub diffuse_share: f32,
    pub bounce: u32,
    /// The one before of the same path, or [`NONE`].
    before: u32,
}

/// The anchors of the paths of a wave.
#[derive(Debug, Default)]
pub(crate) struct Anchors {
    all: Vec<Anchor>,
    /// Of each path, its last, or [`NONE`].
    last: Vec<u32>,
    /// Sent from them, and not yet on their way.
    pub(in crate::integrator) probes: Vec<(Path, Ray)>,
}

impl Anchors {
    /// Makes ready for a number of paths.
    pub fn begin(&mut self, paths: usize) {
        self.all.clear();
        self.last.clear();
        self.last.resize(paths, NONE);
    }

    /// Those of a path, the last first.
    #[inline(always)]
    pub fn of(&self, path: u32) -> impl Iterator<Item = &Anchor> {
        let at = |i: &u32| self.all.get(*i as usize);
        let last = self.last.get(path as usize).and_then(at);
        std::iter::successors(last, move |anchor| at(&anchor.before))
    }

    /// Whether a path has dropped an anchor at a bounce or later.
    #[inline(always)]
    fn is_since(&self, path: u32, bounce: u32) -> bool {
        self.of(path).next().is_some_and(|a| a.bounce >= bounce)
    }

    fn push(&mut self, path: u32, mut anchor: Anchor) {
        let last = &mut self.last[path as usize];
        anchor.before = std::mem::replace(last, self.all.len() as u32);
        self.all.push(anchor);
    }
}

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
        light_shares: &[f32],
        reuse: &Reuse,
        anchors: &mut Anchors,
    ) {
        for lane in 0..self.count {
            let (diffuse, index) = (self.diffuse.get(lane), self.indices[lane]);
            if diffuse == Vec3::ZERO
                || light_shares[index as usize] > 0.0
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
            let anchor = Anchor {
                point,
                prim,
                n,
                f,
                diffuse_share,
                bounce,
                before: NONE,
            };
            anchors.push(index, anchor);
            let Some(guide) = transport.guide else {
                continue;
            };
            let sampler = self.samplers.get(lane);
            let origin = point.leave(n);
            let pick = sampler.get_1d(Dim::GuidePick(bounce));
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
            } else {
                diffuse_share * cos * FRAC_1_PI
            };
            let probe = Path {
                sampler,
                throughput: f * (cos / (pdf + by_path)),
                direction_pdf: pdf,
                index,
                is_probe: true,
            };
            anchors.probes.push((probe, Ray::new(origin, dir)));
        }
    }

    /// Weighs light that paths may yet run into by the mirror or glass that they have met from an
    /// anchor, as probes may have found it. `rays` are those on which the paths came.
    #[inline(always)]
    pub fn weigh_against_probes(
        &self,
        transport: &Transport<'_>,
        bounce: u32,
        anchors: &Anchors,
        rays: &[Ray],
        weights: &mut [f32],
    ) {
        for (lane, ..) in &self.others {
            let (pdf, index) = (self.arriving_pdf[*lane], self.indices[*lane]);
            if is_only(pdf) || self.is_probe[*lane] {
                continue;
            }
            weights[index as usize] = match transport.guide {
                Some(guide) if anchors.is_since(index, bounce - 1) => {
                    let ray = &rays[self.source(*lane)];
                    pdf / (pdf + guide.pdf(ray.origin, ray.dir))
                }
                _ => 1.0,
            };
        }
    }

    /// Sets the shares of paths that go on diffusely from a surface that they have come to straight
    /// from an anchor, on `rays`.
    #[inline(always)]
    pub fn share_from_anchors(
        &self,
        bounce: u32,
        anchors: &Anchors,
        rays: &[Ray],
        shares: &mut [f32],
    ) {
        for lane in 0..self.count {
            let (pdf, arriving) = (self.direction_pdf[lane], self.arriving_pdf[lane]);
            let index = self.indices[lane];
            let is_diffuse = pdf > 0.0 && !is_only(pdf) && !is_only(arriving);
            if is_diffuse && shares[index as usize] == 0.0 && anchors.is_since(index, bounce - 1) {
                let from = rays[self.source(lane)].origin;
                let square = from.distance_squared(self.points.get(lane).p);
                let cos = self.n.get(lane).dot(self.wo.get(lane));
                // Finite, or it would make no weight of a density of 0.
                let share = square / (arriving * cos * self.diffuse_share[lane]);
                shares[index as usize] = share.min(f32::MAX);
            }
        }
    }
}
