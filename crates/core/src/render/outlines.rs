//! Outlines of lamps: where one passes through a pixel, a sample looks at it with more camera rays.
//!
//! A lamp is a hundred times as bright as what is beside it, so that the pixels which its outline crosses are the
//! noisiest of a picture, and no way to find light helps there: what counts is how much of a pixel the lamp covers.
//! So a sample leaves lamps that it sees there, straight or by mirrors, to [`SIGHTS`] rays of their own, which end at
//! whatever is no mirror. Which pixels these are is told by rays through the corners of all pixels, once for each
//! view; an outline that they miss is found as any other light. Not with `naive`, which stays what its name says, nor
//! with filters that have negative lobes, whose samples are of two kinds.

use std::sync::OnceLock;

use glam::{Vec2, Vec3};

use super::View;
use crate::bsdf::{Bsdf, BsdfSample};
use crate::film::TILE;
use crate::math::Ray;
use crate::sampler::{Dim, Sampler};
use crate::scene::Scene;
use crate::settings::Method;

/// Camera rays for lamps of each sample of a pixel on an outline.
const SIGHTS: u32 = 8;

/// By way of so many mirrors outlines are looked for.
const MIRRORS: u32 = 3;

/// The pixels of a picture that outlines of lamps cross.
#[derive(Debug)]
pub(super) struct Outlines {
    /// Tiles across.
    across: u32,
    /// Of each tile, whether each of its pixels is one, row by row; empty if none is.
    tiles: Box<[OnceLock<Box<[bool]>>]>,
}

impl Outlines {
    /// Of pictures of a width and height, not yet looked for.
    pub fn new(size: [u32; 2]) -> Self {
        let [across, down] = size.map(|n| n.div_ceil(TILE));
        Self {
            across,
            tiles: (0..across * down).map(|_| OnceLock::new()).collect(),
        }
    }
}

/// Whether a pixel is on an outline, by what is [`View::outlined`] of its tile.
pub(super) fn is_on_outline(outlined: &[bool], pixel: [u32; 2]) -> bool {
    let [x, y] = pixel.map(|n| n % TILE);
    outlined.get((y * TILE + x) as usize) == Some(&true)
}

impl View {
    /// The rays to which a sample of a pixel leaves lamps.
    pub(super) fn sights(
        &self,
        pixel: [u32; 2],
        sampler: Sampler,
    ) -> impl ExactSizeIterator<Item = Ray> {
        sampler.split(SIGHTS).map(move |sampler| {
            let (offset, _) = self.filter.sample(sampler.get_2d(Dim::Sights));
            self.camera.ray(pixel, offset)
        })
    }

    /// For each pixel of the tile of one, row by row, whether samples of it leave lamps to [`View::sights`]; empty if
    /// of none.
    pub(super) fn outlined(&self, pixel: [u32; 2]) -> &[bool] {
        if self.settings.method == Method::Naive || self.filter.strata() > 1 {
            return &[];
        }
        let [column, row] = pixel.map(|n| n / TILE);
        let tile = &self.outlines.tiles[(row * self.outlines.across + column) as usize];
        tile.get_or_init(|| self.look_for_outlines([column * TILE, row * TILE]))
    }

    fn look_for_outlines(&self, first: [u32; 2]) -> Box<[bool]> {
        // Beyond the corners of the pixels as far as the filter reaches.
        let reach = (self.filter.radius() - 0.5).max(0.0).ceil() as usize;
        let (tile, side) = (TILE as usize, TILE as usize + 1 + 2 * reach);
        let corners = (0..side * side).map(|corner| {
            let offset = [corner % side, corner / side].map(|n| n as f32 - reach as f32 - 0.5);
            self.camera.ray(first, offset)
        });
        let light = lamps(&self.scene, corners.collect());
        if light.iter().all(|l| *l == light[0]) {
            return Box::default();
        }
        let is_outlined = |pixel: usize| {
            let corner = pixel / tile * side + pixel % tile;
            let mut rows = light[corner..].chunks(side).take(2 + 2 * reach);
            rows.any(|row| row[..2 + 2 * reach].iter().any(|l| *l != light[corner]))
        };
        (0..tile * tile).map(is_outlined).collect()
    }
}

/// The light of lamps that each ray comes to, straight or by mirrors.
fn lamps(scene: &Scene, mut rays: Vec<Ray>) -> Vec<Vec3> {
    let mut light = vec![Vec3::ZERO; rays.len()];
    // Of each ray, what number it had at first, and how much of the light mirrors have left.
    let mut sources: Vec<(usize, Vec3)> = (0..rays.len()).map(|i| (i, Vec3::ONE)).collect();
    let mut hits = Vec::new();
    for _ in 0..=MIRRORS {
        scene.intersect_all(&rays, &mut hits);
        let mut kept = 0;
        for i in 0..rays.len() {
            let (Some(hit), ray, (source, throughput)) = (&hits[i], rays[i], sources[i]) else {
                continue;
            };
            let material = scene.material(hit.prim);
            let bsdf = material.bsdf(|| Vec2::ZERO);
            if !(material.emits() || matches!(bsdf, Bsdf::Mirror(_))) {
                continue;
            }
            let point = scene.primitives().surface_point(&ray, hit);
            let front = ray.dir.dot(point.n) < 0.0;
            if front {
                light[source] += throughput * material.emission;
            }
            let n = if front { point.n } else { -point.n };
            let next = match bsdf {
                Bsdf::Mirror(_) => bsdf.sample(-ray.dir, n, front, || 0.0, || [0.0; 2]),
                _ => None,
            };
            if let Some(BsdfSample { wi, weight, .. }) = next {
                rays[kept] = Ray::new(point.leave(wi), wi);
                sources[kept] = (source, weight * throughput);
                kept += 1;
            }
        }
        rays.truncate(kept);
        sources.truncate(kept);
    }
    light
}
