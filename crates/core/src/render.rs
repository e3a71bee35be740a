//! The composition root: all that decides a picture.

use std::sync::atomic::AtomicBool;

use crate::camera::Camera;
use crate::film::Film;
use crate::filter::FilterSampler;
use crate::integrator::Transport;
use crate::plan::{Part, Plan};
use crate::scene::Scene;
use crate::settings::{AccelKind, Method, RenderSettings, SamplerKind};
use crate::work::Work;
use outlines::Outlines;

pub mod autopsy;
mod outlines;
mod tiles;

/// A scene, a camera and settings: all that decides a picture.
#[derive(Clone, Debug)]
pub struct View {
    /// What is seen.
    pub scene: std::sync::Arc<Scene>,
    /// From where.
    pub camera: Camera,
    /// How. Another size, filter or method takes another view.
    pub settings: RenderSettings,
    filter: FilterSampler,
    plan: Plan,
    outlines: std::sync::Arc<Outlines>,
}

impl View {
    /// The scene as its description wants to be seen.
    pub fn of(scene: std::sync::Arc<Scene>) -> Result<Self, String> {
        let desc = scene.desc();
        let (camera, settings) = (desc.camera, desc.render);
        Self::new(scene, &camera, settings)
    }

    /// A scene from some camera with some settings; the error is one line.
    pub fn new(
        scene: std::sync::Arc<Scene>,
        camera: &crate::scene::CameraDesc,
        settings: RenderSettings,
    ) -> Result<Self, String> {
        if let Some(problem) = settings.problem() {
            return Err(problem);
        }
        let camera = Camera::new(camera, settings.width, settings.height)?;
        let plan = Plan::new(scene.census(), scene.geometry(), &settings);
        Ok(Self {
            scene,
            camera,
            settings,
            filter: FilterSampler::new(settings.filter),
            plan,
            outlines: std::sync::Arc::new(Outlines::new([settings.width, settings.height])),
        })
    }

    /// The same picture found another way.
    pub fn found_by(&self, method: Method, sampler: SamplerKind) -> Self {
        let mut view = self.clone();
        (view.settings.method, view.settings.sampler) = (method, sampler);
        view.plan = Plan::new(self.scene.census(), self.scene.geometry(), &view.settings);
        view
    }

    /// Which parts of the model it has.
    pub fn plan(&self) -> Plan {
        self.plan
    }

    /// The same picture made with one part more of the model; the error is one line.
    pub fn with(&self, part: Part) -> Result<Self, String> {
        let mut view = self.clone();
        if part == Part::Tree && !self.plan.has(part) {
            let scene = self.scene.with_accel(AccelKind::Bvh);
            view.scene = scene.map_err(|e| e.to_string())?;
        }
        view.plan = self.plan.with(part);
        Ok(view)
    }

    /// The same picture by another plan, whether it needs more or not.
    #[cfg(test)]
    pub(crate) fn planned(&self, plan: Plan) -> Self {
        Self {
            plan,
            ..self.clone()
        }
    }

    /// The same picture made with every part of the model; the error is one line.
    pub fn full(&self) -> Result<Self, String> {
        Part::ALL
            .into_iter()
            .try_fold(self.clone(), |view, part| view.with(part))
    }

    /// An empty film for this view.
    pub fn film(&self) -> Film {
        let film = Film::new(self.settings.width, self.settings.height, &self.filter);
        if self.unguided().traces_light() {
            film.with_splats()
        } else {
            film
        }
    }

    /// What its paths have in common.
    fn transport(&self) -> Transport<'_> {
        let mut transport = self.unguided();
        if transport.traces_light() {
            transport.guide = self.scene.guide(&transport);
        }
        transport
    }

    /// The same without the guide, which may have to be made.
    fn unguided(&self) -> Transport<'_> {
        Transport {
            scene: &self.scene,
            plan: self.plan,
            method: self.settings.method,
            depth: self.settings.depth,
            camera: &self.camera,
            margin: self.filter.radius(),
            guide: None,
        }
    }

    /// Brings every tile of `film` up to `samples` samples per pixel, on the threads of the current
    /// rayon pool. Returns early when `cancel` is set: blocks of tiles in work are dropped, finished ones
    /// stay, and a later call goes on from there.
    pub fn render(&self, film: &Film, samples: u64, cancel: &AtomicBool) -> Work {
        let tiles: Vec<usize> = (0..film.tiles()).collect();
        self.render_tiles(film, &tiles, samples, cancel)
    }
}
