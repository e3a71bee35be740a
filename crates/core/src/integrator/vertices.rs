//! Vertices of many paths side by side. What all of them do is written as loops over the lanes of
//! a group without branches or calls, which compile to SIMD code; what few of them do (mirror,
//! glass, blends) goes lane by lane.

use std::f32::consts::FRAC_1_PI;

use glam::Vec3;

use super::caustics::Caustics;
use super::reuse::{Reuse, Surface};
use super::{AIMED_AT, Kind, ONLY, Path, ShadowRay, Transport, is_only, power_heuristic};
use crate::bsdf::{Bsdf, diffuse_direction};
use crate::geometry::{Hit, Place, SurfacePoint, SurfacePoints};
use crate::light::LightSamples;
use crate::math::{Floats, GROUP, Ray, Vectors};
use crate::plan::Part;
use crate::planted::{self, Bug};
use crate::sampler::{Dim, Samplers};
use crate::scene::Scene;

mod anchors;
mod branches;
mod detours;

/// Bounces that every path takes before Russian roulette may end it.
const ROULETTE_FROM: u32 = 3;

/// Throughput from which on roulette leaves a path alone but for [`SURVIVAL`]: what it ends below
/// saves less time than it adds noise if this is higher (measured: docs/speed-and-accuracy.md).
const BRIGHT: f32 = 1.0 / 3.0;

/// Bounds on the probability that a path survives roulette: below, weights would explode; above,
/// a path between perfect mirrors would never end.
const SURVIVAL: (f32, f32) = (0.05, 0.95);

/// A group of path vertices. Lanes from `count` on hold what was there before.
#[derive(Debug)]
pub(super) struct Vertices {
    /// Lanes in use.
    pub count: usize,
    /// Which of the paths offered each lane is.
    sources: [u32; GROUP],
    /// Where its radiance is added up.
    pub indices: [u32; GROUP],
    samplers: Samplers,
    kinds: [Kind; GROUP],
    pub throughput: Vectors,
    /// Away from the surface, to where the path comes from.
    wo: Vectors,
    triangles: [Vectors; 3],
    barycentrics: [Floats; 2],
    /// Points that are not on triangles.
    elsewhere: Vec<(usize, SurfacePoint)>,
    pub points: SurfacePoints,
    /// Primitive of the surface.
    prims: [u32; GROUP],
    /// Unit normal on the side of `wo`.
    pub n: Vectors,
    /// Diffuse reflectance, and the probability that a path goes on that way.
    pub diffuse: Vectors,
    pub diffuse_share: Floats,
    /// Whether any of them is not black.
    pub any_diffuse: bool,
    /// Lanes that are not purely diffuse: primitive, whether `wo` is on the front, and the rest.
    others: Vec<(usize, u32, bool, Bsdf)>,
    lights: LightSamples,
    emission: Vectors,
    /// Where the path goes on, from where, and the density of that direction; 0 if nowhere.
    wi: Vectors,
    origin: Vectors,
    /// f·|cos θ|/pdf.
    weight: Vectors,
    pub direction_pdf: Floats,
    /// The density of the direction in which the path came.
    pub arriving_pdf: Floats,
    shadow_origin: Vectors,
    shadow_dir: Vectors,
    shadow_radiance: Vectors,
    /// 0 where there is no shadow ray.
    shadow_distance: Floats,
}

impl Default for Vertices {
    fn default() -> Self {
        let vectors = Vectors::default();
        let floats = [0.0; GROUP];
        Self {
            count: 0,
            sources: [0; GROUP],
            indices: [0; GROUP],
            samplers: Samplers::default(),
            kinds: [Kind::Whole; GROUP],
            throughput: vectors,
            wo: vectors,
            triangles: [vectors; 3],
            barycentrics: [floats; 2],
            elsewhere: Vec::new(),
            points: SurfacePoints::default(),
            prims: [0; GROUP],
            n: vectors,
            diffuse: vectors,
            diffuse_share: floats,
            any_diffuse: false,
            others: Vec::new(),
            lights: LightSamples::default(),
            emission: vectors,
            wi: vectors,
            origin: vectors,
            weight: vectors,
            direction_pdf: floats,
            arriving_pdf: floats,
            shadow_origin: vectors,
            shadow_dir: vectors,
            shadow_radiance: vectors,
            shadow_distance: floats,
        }
    }
}

/// The chance of a path that goes on to survive roulette, from [`ROULETTE_FROM`] on.
#[inline(always)]
fn survival(throughput: Vec3) -> f32 {
    (throughput.max_element() / BRIGHT).clamp(SURVIVAL.0, SURVIVAL.1)
}

impl Vertices {
    /// Empties all lanes.
    #[inline(always)]
    fn clear(&mut self) {
        self.count = 0;
        self.any_diffuse = false;
        self.elsewhere.clear();
        self.others.clear();
    }

    /// Adds the place where a path, the one of number `source`, has run into something.
    #[inline(always)]
    fn push(&mut self, source: usize, path: &Path, ray: &Ray, place: Place) {
        let lane = self.count % GROUP;
        self.count += 1;
        self.sources[lane] = source as u32;
        self.indices[lane] = path.index;
        self.samplers.set(lane, &path.sampler);
        self.kinds[lane] = path.kind;
        self.throughput.set(lane, path.throughput);
        self.arriving_pdf[lane] = path.direction_pdf;
        self.wo.set(lane, -ray.dir);
        match place {
            Place::OnTriangle(triangle, [b1, b2]) => {
                for (corners, corner) in self.triangles.iter_mut().zip(triangle) {
                    corners.set(lane, corner);
                }
                (self.barycentrics[0][lane], self.barycentrics[1][lane]) = (b1, b2);
            }
            Place::At(point) => self.elsewhere.push((lane, point)),
        }
    }

    /// Gathers the places where paths have run into something, computed; `missed` takes those that
    /// have not.
    #[inline(always)]
    pub fn gather(
        &mut self,
        scene: &Scene,
        paths: &[Path],
        rays: &[Ray],
        hits: &[Option<Hit>],
        mut missed: impl FnMut(&Path),
    ) {
        self.clear();
        for (i, hit) in hits.iter().enumerate() {
            match hit {
                Some(hit) if paths[i].is_blind() && !scene.shows_caustics(hit.prim) => {}
                Some(hit) => {
                    let place = scene.primitives().place(&rays[i], hit);
                    self.push(i, &paths[i], &rays[i], place);
                }
                None => missed(&paths[i]),
            }
        }
        self.locate();
    }

    /// Number of the path in a lane.
    #[inline(always)]
    pub fn source(&self, lane: usize) -> usize {
        self.sources[lane] as usize
    }

    /// Computes the points on the surfaces.
    #[inline(always)]
    fn locate(&mut self) {
        let [a, b, c] = &self.triangles;
        let [b1, b2] = &self.barycentrics;
        for lane in 0..GROUP {
            let triangle = [a.get(lane), b.get(lane), c.get(lane)];
            let point = SurfacePoint::of_triangle(triangle, [b1[lane], b2[lane]]);
            self.points.set(lane, &point);
        }
        for (lane, point) in &self.elsewhere {
            self.points.set(*lane, point);
        }
    }

    /// Sets what the surface of a lane is like, and the side from which it is seen.
    #[inline(always)]
    pub fn set_surface(&mut self, lane: usize, prim: u32, n: Vec3, front: bool, bsdf: Bsdf) {
        self.prims[lane] = prim;
        self.n.set(lane, n);
        let diffuse = bsdf.diffuse();
        self.diffuse.set(lane, diffuse);
        self.diffuse_share[lane] = bsdf.diffuse_share();
        self.any_diffuse |= diffuse != Vec3::ZERO;
        if !matches!(bsdf, Bsdf::Diffuse(_)) {
            self.others.push((lane, prim, front, bsdf));
        }
    }

    /// Aims at one point of one light from each lane that scatters diffusely: the light that would
    /// reach it from there and leave along the path, over the probability of the choice.
    #[inline(always)]
    pub fn aim(&mut self, transport: &Transport<'_>, bounce: u32, rays: &mut Vec<ShadowRay>) {
        let (scene, is_mis) = (transport.scene, transport.weights());
        let is_one = !transport.plan.has(Part::LightChoice);
        let (samplers, lights) = (&self.samplers, &mut self.lights);
        let p = &self.points.p;
        scene
            .lights()
            .sample_many(p, self.count, samplers, bounce, is_one, lights);
        for lane in 0..self.count {
            let emission = scene.material(lights.prims[lane]).emission;
            self.emission.set(lane, emission);
        }
        for lane in 0..GROUP {
            let (point, light) = (self.points.get(lane), lights.points.get(lane));
            let (n, pdf) = (self.n.get(lane), lights.pdf[lane]);
            let toward = (light.p - point.p).normalize();
            let cos = n.dot(toward);
            let direction_pdf = self.diffuse_share[lane] * cos * FRAC_1_PI;
            let weight = if is_mis {
                power_heuristic(pdf, direction_pdf)
            } else {
                1.0
            };
            let counted = if planted::has(Bug::CosineDropped) {
                1.0
            } else {
                cos
            };
            let f = self.diffuse.get(lane) * FRAC_1_PI;
            let arriving = f * self.emission.get(lane) * (weight * counted / pdf);
            let ray = point.ray_to(&light, toward);
            self.shadow_origin.set(lane, ray.origin);
            self.shadow_dir.set(lane, ray.dir);
            let radiance = self.throughput.get(lane) * arriving;
            self.shadow_radiance.set(lane, radiance);
            let counts = (cos > 0.0) & (pdf > 0.0) & (pdf < f32::INFINITY);
            self.shadow_distance[lane] = if counts { ray.t_max } else { 0.0 };
        }
        for lane in 0..self.count {
            let distance = self.shadow_distance[lane];
            // No primitive shines on itself, whatever side of it rounding puts a point on its back.
            let is_own = lights.prims[lane] == self.prims[lane];
            if distance > 0.0 && !is_own && self.diffuse.get(lane) != Vec3::ZERO {
                rays.push(ShadowRay {
                    ray: Ray {
                        origin: self.shadow_origin.get(lane),
                        dir: self.shadow_dir.get(lane),
                        t_max: distance,
                    },
                    light: lights.prims[lane],
                    radiance: self.shadow_radiance.get(lane),
                    index: self.indices[lane],
                });
            }
        }
    }

    /// Draws where the paths go from their surfaces, and whether. `was_detour` says that diffuse
    /// surfaces at the bounce before have aimed at lights by way of mirror spheres.
    #[inline(always)]
    pub fn scatter(&mut self, transport: &Transport<'_>, bounce: u32, was_detour: bool) {
        let primitives = transport.scene.primitives();
        if self.others.len() < self.count {
            self.scatter_diffuse(bounce);
        }
        for (lane, prim, front, bsdf) in &self.others {
            let (lane, sampler) = (*lane, self.samplers.get(*lane));
            let lobe = || sampler.get_1d(Dim::Lobe(bounce));
            let u = || sampler.get_2d(Dim::BsdfDirection(bounce));
            self.direction_pdf[lane] = 0.0;
            let (wo, n) = (self.wo.get(lane), self.n.get(lane));
            if !matches!(bsdf, Bsdf::Mirror(_)) && self.kinds[lane] == Kind::Sighted {
                self.kinds[lane] = Kind::Whole;
            }
            if let Some(sample) = bsdf.sample(wo, n, *front, lobe, u) {
                let is_specular = sample.specular && !planted::has(Bug::MirrorWeighted);
                let is_aimed_at = was_detour
                    && !is_only(self.arriving_pdf[lane])
                    && (*front && primitives.is_sphere(*prim))
                    && bsdf.mirror() != Vec3::ZERO;
                self.direction_pdf[lane] = match is_specular {
                    false
                        if self.kinds[lane] == Kind::Probe && !is_only(self.arriving_pdf[lane]) =>
                    {
                        0.0
                    }
                    true if is_aimed_at => AIMED_AT,
                    true => ONLY,
                    false => sample.pdf,
                };
                self.wi.set(lane, sample.wi);
                self.weight.set(lane, sample.weight);
            }
        }
        for lane in 0..GROUP {
            let origin = self.points.get(lane).leave(self.wi.get(lane));
            self.origin.set(lane, origin);
            let throughput = self.throughput.get(lane) * self.weight.get(lane);
            self.throughput.set(lane, throughput);
        }
        if bounce >= ROULETTE_FROM {
            self.play_roulette(bounce);
        }
    }

    /// Makes light paths of paths that have just been drawn a way. Camera paths carry basic radiance, L/n², which
    /// refraction does not change; the flux that goes with it is n² times as much in the new medium (Veach 1997, §5.2).
    #[inline(always)]
    pub fn carry_flux(&mut self) {
        for (lane, _, front, bsdf) in &self.others {
            let Bsdf::Glass(ior) = *bsdf else {
                continue;
            };
            // `n` is on the side that the path comes from.
            if self.wi.get(*lane).dot(self.n.get(*lane)) < 0.0 {
                let scale = if *front { 1.0 / (ior * ior) } else { ior * ior };
                let throughput = scale * self.throughput.get(*lane);
                self.throughput.set(*lane, throughput);
            }
        }
    }

    /// Sets the shares of paths that go on diffusely from their first surfaces.
    #[inline(always)]
    pub fn share_with_light_paths(&self, transport: &Transport<'_>, caustics: &mut Caustics) {
        let shares = &mut caustics.light_shares;
        for lane in 0..self.count {
            let pdf = self.direction_pdf[lane];
            if pdf > 0.0 && !is_only(pdf) {
                let (point, n) = (self.points.get(lane), self.n.get(lane));
                let share = transport.light_share(&point, n, self.diffuse_share[lane]);
                shares[self.indices[lane] as usize] = share.map_or(0.0, |(share, _)| share);
            }
        }
    }

    /// Paths that go on diffusely from here for the first time may share what they find, and leave
    /// their throughput here.
    #[inline(always)]
    pub fn offer(&mut self, reuse: &mut Reuse, bounce: u32) {
        for lane in 0..self.count {
            let index = self.indices[lane];
            if self.direction_pdf[lane] > 0.0
                && self.diffuse_share[lane] == 1.0
                && reuse.is_unbound(index)
            {
                let first = Surface {
                    point: self.points.get(lane),
                    n: self.n.get(lane),
                };
                reuse.leaves(index, bounce, first, self.throughput.get(lane));
                self.throughput.set(lane, Vec3::ONE);
            }
        }
    }

    #[inline(always)]
    fn scatter_diffuse(&mut self, bounce: u32) {
        let [x, y] = self.samplers.get_2d(Dim::BsdfDirection(bounce));
        for lane in 0..GROUP {
            let (wi, pdf) = diffuse_direction(self.n.get(lane), [x[lane], y[lane]]);
            self.wi.set(lane, wi);
            let weight = self.diffuse.get(lane);
            let is_black = (weight.x == 0.0) & (weight.y == 0.0) & (weight.z == 0.0);
            self.direction_pdf[lane] = if is_black { 0.0 } else { pdf };
            self.weight.set(lane, weight);
        }
    }

    #[inline(always)]
    fn play_roulette(&mut self, bounce: u32) {
        let u = self.samplers.get_1d(Dim::Roulette(bounce));
        for (lane, u) in u.into_iter().enumerate() {
            let throughput = self.throughput.get(lane);
            let survival = survival(throughput);
            // A probe was sent to where it is bright.
            let is_probe =
                (self.kinds[lane] == Kind::Probe) & (self.diffuse.get(lane) == Vec3::ZERO);
            let survival = if is_probe { SURVIVAL.1 } else { survival };
            if u >= survival {
                self.direction_pdf[lane] = 0.0;
            }
            if !planted::has(Bug::RouletteWeightOmitted) {
                self.throughput.set(lane, throughput / survival);
            }
        }
    }

    /// The path of a lane as it goes on.
    #[inline(always)]
    pub fn path(&self, lane: usize) -> Path {
        Path {
            sampler: self.samplers.get(lane),
            throughput: self.throughput.get(lane),
            direction_pdf: self.direction_pdf[lane],
            index: self.indices[lane],
            kind: if is_only(self.direction_pdf[lane]) {
                self.kinds[lane]
            } else {
                Kind::Whole
            },
        }
    }

    /// Its next segment.
    #[inline(always)]
    pub fn ray(&self, lane: usize) -> Ray {
        Ray::new(self.origin.get(lane), self.wi.get(lane))
    }
}
