//! Aiming at lights by way of mirror spheres.

use std::f32::consts::FRAC_1_PI;

use glam::Vec3;

use super::Vertices;
use crate::geometry::SurfacePoint;
use crate::integrator::{Detour, Transport};
use crate::light::Reflection;
use crate::math::Ray;
use crate::sampler::Dim;
use crate::scene::MirrorSphere;

/// How often light is aimed at by way of mirrors from surfaces that the camera does not see itself:
/// it takes as long as all else there, and the picture hangs on it little. A quarter costs 6 % in
/// relMSE and saves 28 % of the time (`sphere-mirror`).
const INDIRECT: f32 = 0.25;

impl Vertices {
    /// Aims at one point of one light by one mirror sphere from each lane that scatters diffusely.
    #[inline(always)]
    pub fn aim_by_mirrors(
        &mut self,
        transport: &Transport<'_>,
        bounce: u32,
        detours: &mut Vec<Detour>,
    ) {
        let scene = transport.scene;
        let mirrors = scene.mirror_spheres();
        let count = mirrors.len();
        let share = if bounce == 0 { 1.0 } else { INDIRECT };
        let weight = FRAC_1_PI * count as f32 / share;
        for lane in 0..self.count {
            let diffuse = self.diffuse.get(lane);
            if diffuse == Vec3::ZERO {
                continue;
            }
            let sampler = self.samplers.get(lane);
            // One number decides whether, and what is left of it the sphere, and of that the light.
            let (mut i, mut pick) = (0, 0.0);
            if share < 1.0 || count > 1 || scene.lights().len() > 1 {
                let u = sampler.get_1d(Dim::ReflectionPick(bounce)) / share;
                if u >= 1.0 {
                    continue;
                }
                let u = u * count as f32;
                i = (u as usize).min(count - 1);
                pick = u - i as f32;
            }
            let point = self.points.get(lane);
            let n = self.n.get(lane);
            let mirror = &mirrors[i];
            if mirror.prim == self.prims[lane] {
                continue; // Its own sphere, on whose other side rounding may put the point.
            }
            let up = (mirror.sphere.center - point.p).dot(n);
            if !(up > -mirror.sphere.radius) {
                continue; // Wholly below the horizon.
            }
            let u = || sampler.get_2d(Dim::ReflectionPoint(bounce));
            let Some((light, at, pdf)) = scene.lights().sample_area(|| pick, u) else {
                return;
            };
            let Some((density, rays)) = connect(&point, n, mirror, &at) else {
                continue;
            };
            let emission = scene.material(light).emission;
            let f = diffuse * mirror.reflectance * weight;
            detours.push(Detour {
                to_mirror: rays[0],
                mirror: mirror.prim,
                to_light: rays[1],
                light,
                radiance: self.throughput.get(lane) * f * emission * (density / pdf),
                index: self.indices[lane],
            });
        }
    }
}

/// The rays from a surface with normal `n` to a mirror sphere and on to a light; and the solid
/// angle for each unit of the light's area, times the cosine at the surface. `None` if one end
/// does not face the other.
#[inline(always)]
fn connect(
    from: &SurfacePoint,
    n: Vec3,
    mirror: &MirrorSphere,
    light: &SurfacePoint,
) -> Option<(f32, [Ray; 2])> {
    let reflection = Reflection::between(&mirror.sphere, from.p.as_dvec3(), light.p.as_dvec3())?;
    let sphere = &mirror.sphere;
    let place = sphere.center.as_dvec3() + f64::from(sphere.radius) * reflection.n;
    let mirrored = SurfacePoint::of_sphere(sphere, place.as_vec3());
    let (forth, on) = (
        (place - from.p.as_dvec3()).normalize(),
        (light.p.as_dvec3() - place).normalize(),
    );
    let cos = n.as_dvec3().dot(forth);
    let cos_light = -light.n.as_dvec3().dot(on);
    if !(cos > 0.0 && cos_light > 0.0) {
        return None;
    }
    let rays = [
        from.ray_to(&mirrored, forth.as_vec3()),
        mirrored.ray_to(light, on.as_vec3()),
    ];
    Some(((cos * cos_light * reflection.density) as f32, rays))
}
