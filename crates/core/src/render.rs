//! The composition root: tiles, pixels, samples.

use std::sync::atomic::{AtomicBool, Ordering};

use rayon::prelude::*;

use crate::camera::Camera;
use crate::film::Film;
use crate::filter::FilterSampler;
use crate::integrator;
use crate::sampler::{Dim, Sampler};
use crate::scene::Scene;
use crate::settings::RenderSettings;

/// A scene, a camera and settings: all that decides a picture.
#[derive(Clone, Debug)]
pub struct View {
    /// What is seen.
    pub scene: std::sync::Arc<Scene>,
    /// From where.
    pub camera: Camera,
    /// How.
    pub settings: RenderSettings,
    filter: FilterSampler,
}

/// Work done by [`View::render`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Work {
    /// Paths traced from the camera.
    pub paths: u64,
    /// Rays cast.
    pub rays: u64,
}

impl std::ops::Add for Work {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        Self {
            paths: self.paths + other.paths,
            rays: self.rays + other.rays,
        }
    }
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
        Ok(Self {
            scene,
            camera,
            settings,
            filter: FilterSampler::new(settings.filter),
        })
    }

    /// An empty film for this view.
    pub fn film(&self) -> Film {
        Film::new(self.settings.width, self.settings.height, &self.filter)
    }

    /// Brings every tile of `film` up to `samples` samples per pixel, on the threads of the current
    /// rayon pool. Returns early when `cancel` is set: tiles in work are dropped, finished ones
    /// stay, and a later call goes on from there.
    pub fn render(&self, film: &Film, samples: u64, cancel: &AtomicBool) -> Work {
        (0..film.tiles())
            .into_par_iter()
            .with_max_len(1)
            .map(|tile| self.render_tile(film, tile, samples, cancel))
            .reduce(Work::default, |a, b| a + b)
    }

    fn render_tile(&self, film: &Film, tile: usize, samples: u64, cancel: &AtomicBool) -> Work {
        let (mut batch, first) = film.batch(tile);
        let (rect, mut work) = (batch.rect, Work::default());
        for y in 0..rect.height {
            for x in 0..rect.width {
                if cancel.load(Ordering::Relaxed) {
                    return Work::default();
                }
                for sample in first..samples {
                    let pixel = [rect.x + x, rect.y + y];
                    let sampler =
                        Sampler::new(self.settings.sampler, self.settings.seed, pixel, sample);
                    let (offset, stratum) = self.filter.sample(sampler.get_2d(Dim::Pixel));
                    let ray = self.camera.ray(pixel, offset);
                    let RenderSettings { method, depth, .. } = self.settings;
                    let radiance = integrator::radiance(
                        &self.scene,
                        method,
                        depth,
                        ray,
                        &sampler,
                        &mut work.rays,
                    );
                    batch.add([x, y], sample, stratum, radiance);
                    work.paths += 1;
                }
            }
        }
        if samples > first {
            film.merge(tile, &batch, first, samples);
        }
        work
    }
}
