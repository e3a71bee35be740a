//! How light is looked for.

use std::f32::consts::PI;

use glam::Vec3;

use super::light_paths::columns;
use crate::camera::Camera;
use crate::geometry::SurfacePoint;
use crate::light::Guide;
use crate::plan::Plan;
use crate::scene::Scene;
use crate::settings::Method;

/// How light is looked for: what all paths of a render have in common.
#[derive(Clone, Copy, Debug)]
pub struct Transport<'a> {
    /// Where.
    pub scene: &'a Scene,
    /// Which parts of the model the scene needs.
    pub plan: Plan,
    /// How light is found.
    pub method: Method,
    /// Most segments of a path.
    pub depth: u32,
    /// Who looks.
    pub camera: &'a Camera,
    /// How far beyond the border of the picture light still counts in a pixel.
    pub margin: f32,
    /// Where caustics come from, if there are any.
    pub(crate) guide: Option<&'a Guide>,
}

impl Transport<'_> {
    /// Whether paths aim at lights at all.
    #[inline(always)]
    pub(super) fn aims(&self) -> bool {
        self.method != Method::Naive && !self.scene.lights().is_empty()
    }

    /// Whether light that several methods find is shared by weights.
    #[inline(always)]
    pub(super) fn weights(&self) -> bool {
        matches!(self.method, Method::Mis | Method::Caustics | Method::Reuse)
    }

    /// Whether paths aim at lights by way of mirror spheres from their surface at a bounce: a
    /// detour of two segments, all within the depth. Paths that are followed beyond it run into
    /// such light instead.
    #[inline(always)]
    pub(super) fn detours(&self, bounce: u32) -> bool {
        self.aims()
            && !self.scene.mirror_spheres().is_empty()
            && bounce.saturating_add(3) <= self.depth
    }

    /// Whether paths may drop anchors at a bounce: light may come to these in two segments more.
    #[inline(always)]
    pub(super) fn anchors(&self, bounce: u32) -> bool {
        self.traces_light() && bounce > 0 && bounce.saturating_add(3) <= self.depth
    }

    /// Whether caustics are traced from the lights.
    #[inline(always)]
    pub(crate) fn traces_light(&self) -> bool {
        matches!(self.method, Method::Caustics | Method::Reuse) && self.scene.casts_caustics()
    }

    /// How many light paths come by a diffuse surface that the camera sees for each camera path
    /// that goes on from there diffusely, with a density of 1 at the lamp; and where it is seen.
    /// `None` where the camera does not see it. `share` is the chance of the diffuse lobe.
    #[inline]
    pub(super) fn light_share(
        &self,
        point: &SurfacePoint,
        n: Vec3,
        share: f32,
    ) -> Option<(f32, [f32; 2])> {
        let (at, pixels) = self.camera.place(point.p, self.margin)?;
        let cos = n.dot((self.camera.eye() - point.p).normalize());
        let [width, height] = self.camera.size();
        let light_paths = columns(width) as f32 * height as f32;
        (cos > 0.0).then(|| (light_paths / (share * pixels * cos), at))
    }

    /// The density g, per unit of area, with which light leaves a point of a lamp in some direction.
    #[inline]
    pub(super) fn emission_pdf(&self, prim: u32, point: &SurfacePoint, dir: Vec3) -> f32 {
        let area_pdf = self.scene.lights().area_pdf(prim);
        let pdf = self.scene.casters().pdf(point, dir);
        area_pdf * pdf * PI / dir.dot(point.n)
    }
}
