//! The composition root: tiles, pixels, samples.

use std::ops::Range;
use std::sync::atomic::{AtomicBool, Ordering};

use rayon::prelude::*;

use crate::camera::Camera;
use crate::film::{Film, TileRect};
use crate::filter::FilterSampler;
use crate::integrator::Wave;
use crate::sampler::{Dim, Sampler};
use crate::scene::Scene;
use crate::settings::RenderSettings;

/// Paths that advance together: enough to share the cost of each step, few enough to stay in the
/// second cache.
const WAVE: usize = 1024;

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
        self.render_tiles(film, 0..film.tiles(), samples, cancel)
    }

    /// [`View::render`] for some tiles only, counted from the centre of the picture outwards.
    pub fn render_tiles(
        &self,
        film: &Film,
        tiles: Range<usize>,
        samples: u64,
        cancel: &AtomicBool,
    ) -> Work {
        tiles
            .into_par_iter()
            .with_max_len(1)
            .map(|tile| self.render_tile(film, tile, samples, cancel))
            .reduce(Work::default, |a, b| a + b)
    }

    fn render_tile(&self, film: &Film, tile: usize, samples: u64, cancel: &AtomicBool) -> Work {
        // Before the batch is made: clearing it for each tile that is left would take longest.
        if cancel.load(Ordering::Relaxed) {
            return Work::default();
        }
        let (mut batch, first) = film.batch(tile);
        let RenderSettings {
            method,
            depth,
            sampler: kind,
            seed,
            ..
        } = self.settings;
        let TileRect {
            x: left,
            y: top,
            width,
            height,
        } = batch.rect;
        let (mut wave, mut places) = (Wave::default(), Vec::with_capacity(WAVE));
        let mut work = Work::default();
        let mut todo = (0..height)
            .flat_map(|y| (0..width).map(move |x| [x, y]))
            .flat_map(|pixel| (first..samples).map(move |sample| (pixel, sample)))
            .peekable();
        while todo.peek().is_some() {
            wave.clear();
            places.clear();
            for ([x, y], sample) in todo.by_ref().take(WAVE) {
                let pixel = [left + x, top + y];
                let sampler = Sampler::new(kind, seed, pixel, sample);
                let (offset, stratum) = self.filter.sample(sampler.get_2d(Dim::Pixel));
                wave.push(self.camera.ray(pixel, offset), sampler);
                places.push(([x, y], sample, stratum));
            }
            let Some(radiance) = wave.trace(&self.scene, method, depth, cancel, &mut work.rays)
            else {
                return Work::default();
            };
            for ((pixel, sample, stratum), radiance) in places.iter().zip(radiance) {
                batch.add(*pixel, *sample, *stratum, *radiance);
            }
            work.paths += places.len() as u64;
        }
        if samples > first {
            batch.rays = work.rays;
            film.merge(tile, &batch, first, samples);
        }
        work
    }
}
