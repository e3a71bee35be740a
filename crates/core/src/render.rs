//! The composition root: tiles, pixels, samples.

use std::sync::atomic::{AtomicBool, Ordering};

use rayon::prelude::*;

use crate::camera::Camera;
use crate::film::{APART, Film, Followed, Splat, Tile, TileRect, is_followed};
use crate::filter::FilterSampler;
use crate::integrator::light_paths::{LightWave, column, columns};
use crate::integrator::reuse::MOST;
use crate::integrator::{Transport, Wave};
use crate::plan::{Part, Plan};
use crate::sampler::{Dim, Sampler};
use crate::scene::Scene;
use crate::settings::{AccelKind, Method, RenderSettings, SamplerKind};
use crate::work::{Stage, Stopwatch, Work};
use outlines::{Outlines, is_on_outline};

pub mod autopsy;
mod outlines;

/// Paths that advance together: as many as rays that go through the tree in one batch.
const WAVE: usize = 4096;

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

/// A sample on its way: where it lies in the tile, and what is drawn for it.
struct Place {
    pixel: [u32; 2],
    sample: u64,
    sampler: Sampler,
    offset: [f32; 2],
    stratum: usize,
}

/// Groups of pixels of a tile that may share light, every [`APART`]th across and down; each is named by
/// its first pixel.
fn groups() -> impl Iterator<Item = [u32; 2]> + Clone {
    (0..APART).flat_map(|y| (0..APART).map(move |x| [x, y]))
}

/// The pixels of a group, counted from the tile's corner.
fn members(rect: &TileRect, [x, y]: [u32; 2]) -> impl Iterator<Item = [u32; 2]> + use<> {
    let (width, height) = (rect.width, rect.height);
    let row = move |y| (x..width).step_by(APART as usize).map(move |x| [x, y]);
    (y..height).step_by(APART as usize).flat_map(row)
}

/// What a thread needs to render a tile.
struct Bench {
    wave: Wave,
    light_wave: LightWave,
    places: Vec<Place>,
    batch: Tile,
    watch: Stopwatch,
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
    /// rayon pool. Returns early when `cancel` is set: tiles in work are dropped, finished ones
    /// stay, and a later call goes on from there.
    pub fn render(&self, film: &Film, samples: u64, cancel: &AtomicBool) -> Work {
        let tiles: Vec<usize> = (0..film.tiles()).collect();
        self.render_tiles(film, &tiles, samples, cancel)
    }

    /// [`View::render`] for some tiles only, counted from the centre of the picture outwards; those
    /// that come first are begun first. Not generic: what it calls is compiled with this crate, in one
    /// unit, or shading takes four times as long.
    pub fn render_tiles(
        &self,
        film: &Film,
        tiles: &[usize],
        samples: u64,
        cancel: &AtomicBool,
    ) -> Work {
        tiles
            .par_iter()
            .with_max_len(1)
            .map(|&tile| self.render_tile(film, tile, samples, cancel))
            .reduce(Work::default, |a, b| a + b)
    }

    fn render_tile(&self, film: &Film, tile: usize, samples: u64, cancel: &AtomicBool) -> Work {
        // Before the batch is made: clearing it for each tile that is left would take longest.
        if cancel.load(Ordering::Relaxed) {
            return Work::default();
        }
        let watch = Stopwatch::start();
        let (batch, first) = film.batch(tile);
        let (rect, depth) = (batch.rect, self.settings.depth);
        let mut work = Work::default();
        let mut bench = Bench {
            wave: Wave::default(),
            light_wave: LightWave::default(),
            places: Vec::with_capacity(WAVE),
            batch,
            watch,
        };
        for sample in (first..samples).filter(|sample| is_followed(&rect, *sample, depth)) {
            let mut followed = Followed::default();
            let mut todo = groups().map(|group| (group, sample));
            let Some(paths) = self.render_wave(&mut bench, &mut todo, cancel, Some(&mut followed))
            else {
                return Work::default();
            };
            bench.batch.add_followed(paths, &followed);
            work.paths += paths;
        }
        let others = (first..samples).filter(|sample| !is_followed(&rect, *sample, depth));
        let mut todo = groups()
            .flat_map(|group| others.clone().map(move |sample| (group, sample)))
            .peekable();
        while todo.peek().is_some() {
            let Some(paths) = self.render_wave(&mut bench, &mut todo, cancel, None) else {
                return Work::default();
            };
            work.paths += paths;
        }
        if samples > first {
            film.merge(tile, &bench.batch, first, samples);
        }
        bench.watch.lap(Stage::Filter);
        (work.rays, work.times) = (bench.batch.rays, bench.watch.times);
        work
    }

    /// Adds samples of groups of pixels to the batch, as many as make a wave, and returns how many;
    /// `None` if `cancel` was set meanwhile.
    fn render_wave(
        &self,
        bench: &mut Bench,
        todo: &mut impl Iterator<Item = ([u32; 2], u64)>,
        cancel: &AtomicBool,
        followed: Option<&mut Followed>,
    ) -> Option<u64> {
        let Bench {
            wave,
            places,
            batch,
            watch,
            ..
        } = bench;
        let RenderSettings {
            sampler: kind,
            seed,
            ..
        } = self.settings;
        let (left, top) = (batch.rect.x, batch.rect.y);
        wave.clear();
        places.clear();
        let outlined = self.outlined([left, top]);
        while places.len() + MOST <= WAVE
            && let Some((group, sample)) = todo.next()
        {
            places.extend(members(&batch.rect, group).map(|[x, y]| {
                let sampler = Sampler::new(kind, seed, [left + x, top + y], sample);
                let (offset, stratum) = self.filter.sample(sampler.get_2d(Dim::Pixel));
                Place {
                    pixel: [x, y],
                    sample,
                    sampler,
                    offset,
                    stratum,
                }
            }));
            wave.end_group(places.len());
        }
        watch.lap(Stage::Filter);
        for place in &*places {
            let [x, y] = place.pixel;
            let pixel = [left + x, top + y];
            self.begin(wave, pixel, place.sampler, place.offset, outlined);
        }
        watch.lap(Stage::Camera);
        let transport = self.transport();
        wave.trace(&transport, cancel, &mut batch.rays, watch, followed)?;
        if transport.traces_light() {
            self.render_light_wave(bench, &transport, cancel)?;
        }
        for (place, radiance) in bench.places.iter().zip(bench.wave.radiance()) {
            let radiance = *radiance;
            let batch = &mut bench.batch;
            batch.add(place.pixel, place.sample, place.stratum, radiance);
        }
        bench.watch.lap(Stage::Filter);
        Some(bench.places.len() as u64)
    }

    /// Adds the camera path of a sample of a pixel, of whose tile some pixels are `outlined`, to a wave.
    fn begin(
        &self,
        wave: &mut Wave,
        pixel: [u32; 2],
        sampler: Sampler,
        offset: [f32; 2],
        outlined: &[bool],
    ) {
        wave.push(self.camera.ray(pixel, offset), sampler);
        if is_on_outline(outlined, pixel) {
            wave.push_sights(self.sights(pixel, sampler));
        }
    }

    /// Traces the light paths of a wave; `None` if `cancel` was set meanwhile.
    fn render_light_wave(
        &self,
        bench: &mut Bench,
        transport: &Transport<'_>,
        cancel: &AtomicBool,
    ) -> Option<()> {
        let Bench {
            wave,
            light_wave,
            places,
            batch,
            watch,
            ..
        } = bench;
        let RenderSettings {
            width,
            height,
            sampler: kind,
            seed,
            ..
        } = self.settings;
        let columns = u64::from(columns(width));
        light_wave.clear();
        for (i, place) in (0..).zip(&*places) {
            let ([x, y], sample) = (place.pixel, place.sample);
            let Some(column) = column(batch.rect.x + x) else {
                continue;
            };
            // All light paths of a half make up one sequence: lamps know no pixels.
            let pixel = u64::from(batch.rect.y + y) * columns + u64::from(column);
            let number = (sample >> 1).wrapping_mul(columns * u64::from(height)) + pixel;
            let sampler = Sampler::new(kind, seed, [u32::MAX; 2], number << 1 | sample & 1);
            // The next of the group in the row, if there is one.
            let is_joined = |next: &Place| next.pixel == [x + APART, y] && next.sample == sample;
            let is_one = !places.get(i as usize + 1).is_some_and(is_joined);
            light_wave.push(transport, sampler, i..i + 2 - u32::from(is_one));
        }
        watch.lap(Stage::Camera);
        let arrivals = light_wave.trace(transport, wave, cancel, &mut batch.rays, watch)?;
        let (radius, size) = (self.filter.radius(), [width, height]);
        for arrival in arrivals {
            let Place { pixel, sample, .. } = places[arrival.index as usize];
            // Pixels whose centres are within the radius.
            let reach = |axis: usize| {
                let at = arrival.at[axis] - 0.5;
                let end = (at + radius + 1.0).floor().clamp(0.0, size[axis] as f32);
                (at - radius).ceil().max(0.0) as u32..end as u32
            };
            for (x, y) in reach(1).flat_map(|y| reach(0).map(move |x| (x, y))) {
                let [at_x, at_y] = arrival.at;
                let offset = [at_x - (x as f32 + 0.5), at_y - (y as f32 + 0.5)];
                let splat = Splat {
                    pixel: [x, y],
                    half: (sample & 1) as u8,
                    radiance: arrival.radiance * self.filter.weight(offset),
                };
                batch.add_splat(pixel, sample, splat);
            }
        }
        watch.lap(Stage::Filter);
        Some(())
    }
}
