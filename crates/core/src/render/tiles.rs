//! Rendering tiles: their samples advance in waves, whatever tiles they are of.

use std::sync::atomic::{AtomicBool, Ordering};

use rayon::prelude::*;

use super::View;
use super::outlines::is_on_outline;
use crate::film::{APART, Film, Followed, Splat, TILE, Tile, TileRect, is_followed};
use crate::integrator::light_paths::{LightWave, column, columns};
use crate::integrator::reuse::MOST;
use crate::integrator::{Transport, Wave};
use crate::sampler::{Dim, Sampler};
use crate::settings::RenderSettings;
use crate::work::{Stage, Stopwatch, Work};

/// Paths that advance together: as many as rays that go through the tree in one batch.
pub(super) const WAVE: usize = 4096;

/// Each thread has so many blocks of tiles to render at least, if there are as many tiles, so that all of
/// them end together.
const SHARES: usize = 4;

/// A sample on its way: in which tile of the bench, where it lies there, and what is drawn for it.
struct Place {
    tile: usize,
    pixel: [u32; 2],
    sample: u64,
    sampler: Sampler,
    offset: [f32; 2],
    stratum: usize,
}

impl Place {
    /// The pixel counted from the picture's corner.
    fn pixel_of(&self, rect: &TileRect) -> [u32; 2] {
        let [x, y] = self.pixel;
        [rect.x + x, rect.y + y]
    }
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

/// What a thread needs to render some tiles.
struct Bench {
    wave: Wave,
    light_wave: LightWave,
    places: Vec<Place>,
    /// One for each tile.
    batches: Vec<Tile>,
    rays: u64,
    watch: Stopwatch,
}

impl View {
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
        // As many tiles together as fill a wave, but so that no thread is without work.
        let missing = tiles.iter().map(|&tile| film.missing(tile, samples));
        let paths = missing
            .max()
            .unwrap_or(0)
            .max(1)
            .saturating_mul(u64::from(TILE * TILE));
        let share = tiles.len() / (SHARES * rayon::current_num_threads());
        tiles
            .par_chunks(share.min((WAVE as u64 / paths) as usize).max(1))
            .with_max_len(1)
            .map(|tiles| self.render_block(film, tiles, samples, cancel))
            .reduce(Work::default, |a, b| a + b)
    }

    /// Renders some tiles, the paths of all of them in the same waves.
    fn render_block(
        &self,
        film: &Film,
        tiles: &[usize],
        samples: u64,
        cancel: &AtomicBool,
    ) -> Work {
        // Before the batches are made: clearing them for each tile that is left would take longest.
        if cancel.load(Ordering::Relaxed) {
            return Work::default();
        }
        let watch = Stopwatch::start();
        let (batches, firsts): (Vec<_>, Vec<_>) = tiles.iter().map(|&i| film.batch(i)).unzip();
        let depth = self.settings.depth;
        let follows = |rect: &TileRect, sample: &u64| is_followed(rect, *sample, depth);
        let rects: Vec<TileRect> = batches.iter().map(|batch| batch.rect).collect();
        let mut work = Work::default();
        let mut bench = Bench {
            wave: Wave::default(),
            light_wave: LightWave::default(),
            places: Vec::with_capacity(WAVE),
            batches,
            rays: 0,
            watch,
        };
        for (tile, (rect, &first)) in rects.iter().zip(&firsts).enumerate() {
            for sample in (first..samples).filter(|sample| follows(rect, sample)) {
                let mut followed = Followed::default();
                let mut todo = groups().map(|group| (tile, group, sample));
                let paths = self.render_wave(&mut bench, &mut todo, cancel, Some(&mut followed));
                let Some(paths) = paths else {
                    return Work::default();
                };
                bench.batches[tile].add_followed(paths, &followed);
                work.paths += paths;
            }
        }
        let others = |tile: usize| {
            let rect = &rects[tile];
            (firsts[tile]..samples).filter(move |sample| !follows(rect, sample))
        };
        let mut todo = (0..tiles.len())
            .flat_map(|tile| groups().map(move |group| (tile, group)))
            .flat_map(|(tile, group)| others(tile).map(move |sample| (tile, group, sample)))
            .peekable();
        while todo.peek().is_some() {
            let Some(paths) = self.render_wave(&mut bench, &mut todo, cancel, None) else {
                return Work::default();
            };
            work.paths += paths;
        }
        work.rays = bench.rays;
        let batches = tiles.iter().zip(&bench.batches).zip(firsts);
        let batches = batches.map(|((&tile, batch), first)| (tile, batch, first));
        film.merge_all(
            batches.filter(|(_, _, first)| samples > *first),
            samples,
            bench.rays,
        );
        bench.watch.lap(Stage::Filter);
        work.times = bench.watch.times;
        work
    }

    /// Adds samples of groups of pixels, each of a tile of the bench, to the batches, as many as make a
    /// wave, and returns how many; `None` if `cancel` was set meanwhile.
    fn render_wave(
        &self,
        bench: &mut Bench,
        todo: &mut impl Iterator<Item = (usize, [u32; 2], u64)>,
        cancel: &AtomicBool,
        followed: Option<&mut Followed>,
    ) -> Option<u64> {
        let Bench {
            wave,
            places,
            batches,
            rays,
            watch,
            ..
        } = bench;
        let RenderSettings {
            sampler: kind,
            seed,
            ..
        } = self.settings;
        wave.clear();
        places.clear();
        while places.len() + MOST <= WAVE
            && let Some((tile, group, sample)) = todo.next()
        {
            let rect = &batches[tile].rect;
            places.extend(members(rect, group).map(|[x, y]| {
                let sampler = Sampler::new(kind, seed, [rect.x + x, rect.y + y], sample);
                let (offset, stratum) = self.filter.sample(sampler.get_2d(Dim::Pixel));
                Place {
                    tile,
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
        for places in places.chunk_by(|a, b| a.tile == b.tile) {
            let rect = &batches[places[0].tile].rect;
            let outlined = self.outlined([rect.x, rect.y]);
            for place in places {
                let pixel = place.pixel_of(rect);
                self.begin(wave, pixel, place.sampler, place.offset, outlined);
            }
        }
        watch.lap(Stage::Camera);
        let transport = self.transport();
        wave.trace(&transport, cancel, rays, watch, followed)?;
        if transport.traces_light() {
            self.render_light_wave(bench, &transport, cancel)?;
        }
        for (place, radiance) in bench.places.iter().zip(bench.wave.radiance()) {
            let radiance = *radiance;
            let batch = &mut bench.batches[place.tile];
            batch.add(place.pixel, place.sample, place.stratum, radiance);
        }
        bench.watch.lap(Stage::Filter);
        Some(bench.places.len() as u64)
    }

    /// Adds the camera path of a sample of a pixel, of whose tile some pixels are `outlined`, to a wave.
    pub(super) fn begin(
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
            batches,
            rays,
            watch,
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
            let [across, down] = place.pixel_of(&batches[place.tile].rect);
            let sample = place.sample;
            let Some(column) = column(across) else {
                continue;
            };
            // All light paths of a half make up one sequence: lamps know no pixels.
            let pixel = u64::from(down) * columns + u64::from(column);
            let number = (sample >> 1).wrapping_mul(columns * u64::from(height)) + pixel;
            let sampler = Sampler::new(kind, seed, [u32::MAX; 2], number << 1 | sample & 1);
            // The next of the group in the row, if there is one.
            let [x, y] = place.pixel;
            let is_joined = |next: &Place| {
                (next.tile, next.pixel, next.sample) == (place.tile, [x + APART, y], sample)
            };
            let is_one = !places.get(i as usize + 1).is_some_and(is_joined);
            light_wave.push(transport, sampler, i..i + 2 - u32::from(is_one));
        }
        watch.lap(Stage::Camera);
        let arrivals = light_wave.trace(transport, wave, cancel, rays, watch)?;
        let (radius, size) = (self.filter.radius(), [width, height]);
        for arrival in arrivals {
            let Place {
                tile,
                pixel,
                sample,
                ..
            } = places[arrival.index as usize];
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
                batches[tile].add_splat(pixel, sample, splat);
            }
        }
        watch.lap(Stage::Filter);
        Some(())
    }
}
