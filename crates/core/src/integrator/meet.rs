//! Where paths run into something: the surfaces that they have come to, and light that they find there.

use glam::Vec3;

use super::reuse::Surface;
use super::{AIMED_AT, Kind, ONLY, Path, Transport, Wave, is_only, power_heuristic};
use crate::bsdf::Bsdf;
use crate::geometry::SurfacePoint;
use crate::math::{GROUP, Ray};
use crate::planted::{self, Bug};
use crate::settings::Method;

impl Transport<'_> {
    /// What light counts that a path has run into at a point of a primitive, on a ray, where light
    /// paths do not find it.
    #[inline(always)]
    fn weight_met(&self, path: &Path, ray: &Ray, prim: u32, point: &SurfacePoint) -> f32 {
        let pdf = path.direction_pdf;
        match self.method {
            _ if path.is_blind() => 0.0,
            _ if path.kind == Kind::Sighted => f32::from(planted::has(Bug::SightedTwice)),
            Method::Naive => 1.0,
            _ if pdf == AIMED_AT => f32::from(planted::has(Bug::DetoursCountedTwice)),
            _ if is_only(pdf) => 1.0,
            Method::Nee => 0.0,
            Method::Mis | Method::Caustics | Method::Reuse => {
                power_heuristic(pdf, self.scene.lights().pdf(ray.origin, prim, point.p))
            }
        }
    }
}

impl Wave {
    /// Gathers the vertices of the paths from `first` on, as many as make a group, and adds the
    /// light that these paths have run into.
    #[inline(always)]
    pub(super) fn meet(
        &mut self,
        transport: &Transport<'_>,
        first: usize,
        bounce: u32,
        is_last: bool,
    ) {
        let scene = transport.scene;
        let end = (first + GROUP).min(self.paths.len());
        let Self {
            paths,
            rays,
            hits,
            vertices,
            radiance,
            reuse,
            caustics,
            left,
            ..
        } = self;
        let (paths, rays, hits) = (&paths[first..end], &rays[first..end], &hits[first..end]);
        let is_on = reuse.is_on();
        vertices.gather(scene, paths, rays, hits, |path| {
            if !path.is_blind() && path.kind != Kind::Sight {
                let light = path.throughput * scene.background();
                reuse.meets(radiance, path.index, bounce, light, false);
            }
        });
        for lane in 0..vertices.count {
            let i = vertices.source(lane);
            let (Some(hit), path, ray) = (&hits[i], &paths[i], &rays[i]) else {
                continue;
            };
            let point = vertices.points.get(lane);
            let front = ray.dir.dot(point.n) < 0.0;
            let material = scene.material(hit.prim);
            let is_lit = front != planted::has(Bug::OneSidedFlagFlipped) && material.emits();
            let is_sight = path.kind == Kind::Sight;
            if is_lit && is_sight {
                radiance[path.index as usize] += path.throughput * material.emission;
            } else if is_lit {
                let index = path.index as usize;
                // What light paths do not reach beyond the depth is not left to them.
                let shares = bounce < transport.depth && path.direction_pdf == ONLY;
                let share = caustics.light_shares.get(index).copied();
                let share = share.filter(|share| shares && *share > 0.0);
                let by_light_paths =
                    share.map(|s| s * transport.emission_pdf(hit.prim, &point, -ray.dir));
                let weight = match by_light_paths {
                    Some(density) => {
                        let weight = power_heuristic(1.0, density);
                        let light = reuse.head(path.index) * path.throughput * material.emission;
                        *left += f64::from((1.0 - weight) * light.element_sum());
                        if planted::has(Bug::CausticsCountedTwice) {
                            1.0
                        } else {
                            weight
                        }
                    }
                    None => transport.weight_met(path, ray, hit.prim, &point),
                };
                let light = weight * path.throughput * material.emission;
                let is_doubled = is_last && planted::has(Bug::LastBounceEmissionDoubled);
                for _ in 0..1 + u32::from(is_doubled) {
                    // Its weight hangs on the first surface.
                    let is_own = by_light_paths.is_some();
                    reuse.meets(radiance, path.index, bounce, light, is_own);
                }
            }
            if !is_last {
                let n = if front { point.n } else { -point.n };
                let bsdf = material.bsdf(|| scene.primitives().uv(hit));
                let bsdf = match bsdf {
                    Bsdf::Mirror(_) => bsdf,
                    _ if is_sight => Bsdf::Diffuse(Vec3::ZERO),
                    _ => bsdf,
                };
                if is_on && !is_sight && !path.is_blind() && matches!(bsdf, Bsdf::Diffuse(_)) {
                    let second = Surface { point, n };
                    reuse.arrives(path.index, bounce, second, hit.prim);
                }
                vertices.set_surface(lane, hit.prim, n, front, bsdf);
                if path.is_blind() {
                    vertices.diffuse.set(lane, Vec3::ZERO);
                }
            }
        }
    }
}
