//! Caustics: light followed from the lamps by way of mirror and glass to what the camera sees
//! (Arvo 1986, Backward Ray Tracing).
//!
//! Where mirrors and glass show such surfaces, light paths are joined to anchors (`vertices::anchors`).
//!
//! There is one for every second of the camera paths of a sample ([`column`]), and it brings light to the anchors of two.
//! A light path leaves a lamp towards something specular ([`crate::light`]), goes on by chance as
//! camera paths do, and at each diffuse surface is joined to the camera, if that sees it. It
//! counts only light that has left its lamp by way of mirror or glass; the rest is aimed at from
//! the camera's side, as is light by way of one mirror sphere.
//!
//! Camera paths find the same light by running into it: from the camera to a diffuse surface, and
//! in the end from a diffuse surface by way of mirror or glass to the lamp. Both count, weighted
//! by the power heuristic. Of the densities of such a path nearly all is the same from either
//! end: cosines at diffuse surfaces, distances, the choices at mirror and glass. What is left is,
//! at the lamp, the density g of the point and the direction over that of a direction by the
//! cosine; at the first surface, the pixels that its area takes up and the chance of the diffuse
//! lobe. Light paths thus find it [`Transport::light_share`] · g times as often. (A weight needs
//! only be the same from both ends; roulette, which is not, is left out of it.)

use std::f32::consts::{FRAC_1_PI, PI};
use std::ops::Range;
use std::sync::atomic::{AtomicBool, Ordering};

use glam::Vec3;

use super::caustics::Caustics;
use super::vertices::Vertices;
use super::{AIMED_AT, Kind, Path, Transport, Wave, is_only, power_heuristic};
use crate::film::APART;
use crate::geometry::Hit;
use crate::light::Mark;
use crate::math::{GROUP, Ray};
use crate::sampler::{Dim, Sampler};
use crate::simd::{Lanes, Task};
use crate::work::{Stage, Stopwatch};

mod marks;

/// Of each two neighbours of a group in a row of pixels, [`APART`] from each other, the first has light paths: its
/// number among those of the row.
pub(crate) fn column(x: u32) -> Option<u32> {
    let has = (x / APART).is_multiple_of(2);
    has.then(|| x / (2 * APART) * APART + x % APART)
}

/// How many of the pixels of a row have light paths.
pub(crate) fn columns(width: u32) -> u32 {
    width / (2 * APART) * APART + (width % (2 * APART)).min(APART)
}

/// What is not counted as an obstacle between two surfaces, or one and the camera: nothing.
pub(super) const NOTHING: u32 = u32::MAX;

/// Light that the camera sees.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Arrival {
    /// Index of the first camera path of its light path.
    pub index: u32,
    /// Where in the picture, pixels from the upper left.
    pub at: [f32; 2],
    /// Over all pixels and camera paths the mean of these, times the pixel filter, is radiance.
    pub radiance: Vec3,
}

/// An arrival, if nothing stands between.
#[derive(Clone, Copy, Debug)]
struct Connection {
    ray: Ray,
    arrival: Arrival,
}

/// Light that an anchor gets, if nothing stands between.
#[derive(Clone, Copy, Debug)]
struct Link {
    ray: Ray,
    /// The anchor's primitive, which is not asked.
    prim: u32,
    radiance: Vec3,
    /// Index of its camera path.
    index: u32,
}

/// What light paths are for.
enum To<'a> {
    /// To be joined to the camera, and to the anchors of camera paths.
    Camera(&'a Caustics),
    /// To leave marks.
    Marks(&'a mut Vec<Mark>),
}

/// Light paths that advance together. Its memory is used again from wave to wave.
#[derive(Debug, Default)]
pub(crate) struct LightWave {
    paths: Vec<Path>,
    rays: Vec<Ray>,
    hits: Vec<Option<Hit>>,
    /// Of each path: the density at the lamp, and the light that it has left it with. Not part
    /// of the throughput, by which roulette judges a path.
    emissions: Vec<(f32, Vec3)>,
    /// Of each path, the camera paths whose anchors it is joined to.
    owners: Vec<Range<u32>>,
    connections: Vec<Connection>,
    links: Vec<Link>,
    arrivals: Vec<Arrival>,
    vertices: Vertices,
}

impl LightWave {
    /// Forgets all paths.
    pub fn clear(&mut self) {
        self.paths.clear();
        self.rays.clear();
        self.emissions.clear();
        self.owners.clear();
        self.arrivals.clear();
    }

    /// Adds a path for some camera paths. Paths are numbered in the order in which they are added.
    #[inline]
    pub fn push(&mut self, transport: &Transport<'_>, sampler: Sampler, owners: Range<u32>) {
        let index = self.emissions.len() as u32;
        self.emissions.push((0.0, Vec3::ZERO));
        self.owners.push(owners);
        let scene = transport.scene;
        let Some((light, from, _)) = scene.lights().sample_area(
            || sampler.get_1d(Dim::LightPick(0)),
            || sampler.get_2d(Dim::LightPoint(0)),
        ) else {
            return;
        };
        let Some((dir, direction_pdf)) = scene.casters().sample(
            &from,
            || sampler.get_1d(Dim::ReflectionPick(0)),
            || sampler.get_2d(Dim::ReflectionPoint(0)),
        ) else {
            return;
        };
        let pdf = transport.emission_pdf(light, &from, dir);
        self.emissions[index as usize] = (pdf, scene.material(light).emission * (PI / pdf));
        self.paths.push(Path {
            sampler,
            throughput: Vec3::ONE,
            direction_pdf,
            index,
            kind: Kind::Whole,
        });
        self.rays.push(Ray::new(from.leave(dir), dir));
    }

    /// Follows all paths to their ends, at most as far as the depth allows, and returns what
    /// arrives at the camera; what arrives at the anchors of their camera paths is added to the radiance of
    /// these. `rays` counts the rays cast. `None` if `cancel` was set meanwhile.
    pub fn trace(
        &mut self,
        transport: &Transport<'_>,
        camera_paths: &mut Wave,
        cancel: &AtomicBool,
        rays: &mut u64,
        watch: &mut Stopwatch,
    ) -> Option<&[Arrival]> {
        let scene = transport.scene;
        let (caustics, radiance) = camera_paths.caustics_and_radiance();
        // The last segment is the one to the camera.
        for bounce in 0..transport.depth.saturating_sub(1) {
            if self.paths.is_empty() {
                break;
            }
            if cancel.load(Ordering::Relaxed) {
                return None;
            }
            *rays += self.rays.len() as u64;
            scene.intersect_all(&self.rays, &mut self.hits);
            watch.lap(Stage::Traversal);
            scene.geometry().kernel().run(Shade {
                wave: self,
                transport,
                bounce,
                to: To::Camera(caustics),
            });
            watch.lap(Stage::Shading);
            *rays += (self.connections.len() + self.links.len()) as u64;
            let (connections, arrivals) = (&self.connections, &mut self.arrivals);
            scene.geometry().occluded_many(
                connections,
                |connection| (connection.ray, NOTHING),
                |i, shaded| {
                    if !shaded {
                        arrivals.push(connections[i].arrival);
                    }
                },
            );
            let links = &self.links;
            scene.geometry().occluded_many(
                links,
                |link| (link.ray, link.prim),
                |i, shaded| {
                    if !shaded {
                        radiance[links[i].index as usize] += links[i].radiance;
                    }
                },
            );
            watch.lap(Stage::ShadowRays);
        }
        Some(&self.arrivals)
    }

    #[inline(always)]
    fn shade_all(&mut self, transport: &Transport<'_>, bounce: u32, mut to: To<'_>) {
        let scene = transport.scene;
        // What has left the lamp by way of the outside of one mirror sphere is marked AIMED_AT.
        let by_mirror_sphere = bounce == 0 && !scene.mirror_spheres().is_empty();
        let is_last = matches!(to, To::Camera(_)) && bounce + 2 >= transport.depth;
        self.connections.clear();
        self.links.clear();
        let mut kept = 0;
        for first in (0..self.paths.len()).step_by(GROUP) {
            self.meet(transport, first);
            match &mut to {
                To::Camera(caustics) if bounce > 0 => {
                    self.connect(transport);
                    self.link(transport, bounce, caustics);
                }
                To::Camera(_) => {}
                To::Marks(marks) => self.mark(first, marks),
            }
            if is_last {
                continue;
            }
            let vertices = &mut self.vertices;
            vertices.scatter(transport, bounce, by_mirror_sphere);
            vertices.carry_flux();
            for lane in 0..vertices.count {
                let pdf = vertices.direction_pdf[lane];
                let is_ours = match bounce {
                    0 => is_only(pdf),
                    1 => pdf > 0.0 && (is_only(pdf) || vertices.arriving_pdf[lane] != AIMED_AT),
                    _ => pdf > 0.0,
                };
                if is_ours {
                    self.paths[kept] = vertices.path(lane);
                    self.rays[kept] = vertices.ray(lane);
                    kept += 1;
                }
            }
        }
        self.paths.truncate(kept);
        self.rays.truncate(kept);
    }

    /// Gathers the vertices of the paths from `first` on, as many as make a group.
    #[inline(always)]
    fn meet(&mut self, transport: &Transport<'_>, first: usize) {
        let scene = transport.scene;
        let end = (first + GROUP).min(self.paths.len());
        let (paths, rays) = (&self.paths[first..end], &self.rays[first..end]);
        let vertices = &mut self.vertices;
        vertices.gather(scene, paths, rays, &self.hits[first..end], |_| ());
        for lane in 0..vertices.count {
            let i = vertices.source(lane);
            if let Some(hit) = &self.hits[first + i] {
                let point = vertices.points.get(lane);
                let front = rays[i].dir.dot(point.n) < 0.0;
                let n = if front { point.n } else { -point.n };
                let bsdf = scene.material(hit.prim).bsdf(|| scene.primitives().uv(hit));
                vertices.set_surface(lane, hit.prim, n, front, bsdf);
            }
        }
    }

    /// Joins the diffuse surfaces of the vertices to the camera.
    #[inline(always)]
    fn connect(&mut self, transport: &Transport<'_>) {
        let vertices = &self.vertices;
        for lane in 0..vertices.count {
            let diffuse = vertices.diffuse.get(lane);
            if diffuse == Vec3::ZERO || vertices.arriving_pdf[lane] == AIMED_AT {
                continue;
            }
            let (point, n) = (vertices.points.get(lane), vertices.n.get(lane));
            let diffuse_share = vertices.diffuse_share[lane];
            let Some((share, at)) = transport.light_share(&point, n, diffuse_share) else {
                continue;
            };
            let index = vertices.indices[lane];
            let (pdf, light) = self.emissions[index as usize];
            let weight = power_heuristic(share * pdf, 1.0) / (share * diffuse_share);
            let eye = transport.camera.eye();
            let origin = point.leave(eye - point.p);
            let way = eye - origin;
            let distance = way.length();
            let f = diffuse * FRAC_1_PI;
            self.connections.push(Connection {
                ray: Ray {
                    origin,
                    dir: way / distance,
                    t_max: distance,
                },
                arrival: Arrival {
                    index: self.owners[index as usize].start,
                    at,
                    radiance: vertices.throughput.get(lane) * f * light * weight,
                },
            });
        }
    }

    /// Joins the diffuse surfaces of the vertices to the anchors of camera paths.
    #[inline(always)]
    fn link(&mut self, transport: &Transport<'_>, bounce: u32, caustics: &Caustics) {
        let vertices = &self.vertices;
        for lane in 0..vertices.count {
            let (diffuse, index) = (vertices.diffuse.get(lane), vertices.indices[lane]);
            if diffuse == Vec3::ZERO || vertices.arriving_pdf[lane] == AIMED_AT {
                continue;
            }
            let (point, n) = (vertices.points.get(lane), vertices.n.get(lane));
            let (pdf, light) = self.emissions[index as usize];
            let owners = self.owners[index as usize].clone();
            let anchors = |owner| {
                caustics
                    .anchors_of(owner)
                    .map(move |anchor| (owner, anchor))
            };
            for (owner, anchor) in owners.flat_map(anchors) {
                let way = anchor.point.p - point.p;
                let square = way.length_squared();
                let toward = way / square.sqrt();
                let (cos, anchor_cos) = (n.dot(toward), -anchor.n.dot(toward));
                let is_within = anchor.bounce + bounce + 3 <= transport.depth;
                if !(is_within && cos > 0.0 && anchor_cos > 0.0) {
                    continue;
                }
                let geometry = cos * anchor_cos / square;
                let shares = anchor.diffuse_share * vertices.diffuse_share[lane];
                let weight = power_heuristic(pdf, shares * FRAC_1_PI * geometry);
                let f = anchor.f * diffuse * FRAC_1_PI;
                self.links.push(Link {
                    ray: point.ray_to(&anchor.point, toward),
                    prim: anchor.prim,
                    radiance: vertices.throughput.get(lane) * f * light * (weight * geometry),
                    index: owner,
                });
            }
        }
    }
}

/// [`LightWave::shade_all`] for a kernel.
struct Shade<'a, 'b> {
    wave: &'a mut LightWave,
    transport: &'a Transport<'b>,
    bounce: u32,
    to: To<'a>,
}

impl Task for Shade<'_, '_> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self) {
        self.wave.shade_all(self.transport, self.bounce, self.to);
    }
}
