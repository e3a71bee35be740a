//! One picture from its first preview on: previews, passes cut into slices of time, and what is
//! shown of them. Runs on the threads of the engine's pool.

mod drawing;

use std::ops::Range;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use lightbox_core::compare::{check_size, relative_square};
use lightbox_core::film::{Developed, ErrorEstimate, Light, Lost, TileError};
use lightbox_core::forecast::Span;
use lightbox_core::image_io::tone_mapped;
use lightbox_core::scene::CameraDesc;
use lightbox_core::work::Work;
use lightbox_core::{Film, Image, RenderSettings, View};
use rayon::prelude::*;

use super::budget::Budget;
use super::history::Point;
use super::keeper::Taken;
use super::look::Look;
use super::preview::{Governor, enlarge};
use super::{Patches, Reference, Region, Snapshot};
use crate::aov::Aov;
use crate::pace::{FIRST_CHECK, Limits, Progress};
use crate::spent::{NEGLIGIBLE, Spent};
use drawing::{paint, put};

/// How long a slice of samples should take: long enough to be cheap, short enough that the
/// window stays fresh. A wish interrupts it anyway.
const SLICE: Duration = Duration::from_millis(50);

/// Showing a slice may take one part in this many of its time.
const SHOWING: u32 = 8;

/// Least tiles of a slice for each thread: at its end, threads wait for the last one.
const TILES: usize = 4;

/// A picture in the making.
pub(super) struct Picture {
    pub view: View,
    /// What `view` was made from.
    pub camera: CameraDesc,
    pub film: Arc<Film>,
    /// How far it is; samples and noise as of the end of a pass.
    pub progress: Progress,
    /// Where it ends.
    pub limits: Limits,
    /// Whether passes are of one sample per pixel each.
    pub one_by_one: bool,
    pub work: Work,
    /// Preview scales still to be shown before the film is filled; the last is shown next.
    previews: Vec<u32>,
    /// The last preview and its scale: stands where the film has no samples yet.
    backdrop: Option<(Image, u32)>,
    /// The pass brings every tile up to this many samples per pixel.
    goal: u64,
    /// The tiles as a pass goes through them.
    order: Arc<[usize]>,
    /// How many of them the pass has done.
    next_tile: usize,
    /// What is shown; empty until the film is shown first.
    shown: Patches,
    /// The view that was shown last, and how many tiles are there of it, as `order` has them.
    drawn: (Aov, usize),
    /// Whether this pass measures the error of each tile it draws.
    measures: bool,
    /// Samples per pixel of the last pass that did.
    measured: u64,
    /// What each tile tells of the error.
    errors: Vec<Option<TileError>>,
    /// What the picture is compared with, if it has the picture's size.
    reference: Option<Arc<Reference>>,
    /// Each tile's share of the error against it.
    true_errors: Vec<Option<f64>>,
    /// Whether anything of it was shown.
    is_shown: bool,
    /// How long it took to show the last slice.
    showing: Duration,
    /// Where the light comes from, as of the last pass that measured it.
    light: Light,
    /// Time spent on measuring and on display, that of all threads together.
    overhead: [Duration; 2],
}

impl Picture {
    pub fn new(view: View, camera: CameraDesc, governor: &Governor) -> Self {
        let (film, samples) = (Arc::new(view.film()), view.settings.samples);
        Self {
            previews: governor.scales(view.settings.width, view.settings.height),
            order: (0..film.tiles()).collect(),
            next_tile: film.tiles(),
            measures: false,
            measured: 0,
            errors: vec![None; film.tiles()],
            reference: None,
            true_errors: vec![None; film.tiles()],
            view,
            camera,
            film,
            progress: Progress::default(),
            limits: Budget::Samples.limits(samples),
            one_by_one: false,
            work: Work::default(),
            backdrop: None,
            goal: 0,
            shown: Patches::default(),
            drawn: (Aov::COLOR, 0),
            is_shown: false,
            showing: Duration::ZERO,
            light: Light::default(),
            overhead: [Duration::ZERO; 2],
        }
    }

    /// Goes on from samples that there are already.
    pub fn take_up(&mut self, Taken { film, seconds }: Taken) {
        [self.work.paths, self.work.rays] = film.work();
        (self.progress.seconds, self.progress.samples) = (seconds, film.samples());
        self.film = Arc::new(film);
        self.previews.clear();
    }

    /// Goes through the tiles of a region first from now on: left, top, right and bottom in shares of
    /// the picture.
    pub fn prefer(&mut self, region: Option<Region>) {
        let size = self.film.size();
        let is_within = |tile: usize| {
            let rect = self.film.tile_rect(tile);
            let [[x0, x1], [y0, y1]] = [
                [rect.x, rect.x + rect.width].map(|x| x as f32 / size[0] as f32),
                [rect.y, rect.y + rect.height].map(|y| y as f32 / size[1] as f32),
            ];
            region.is_some_and(|[left, top, right, bottom]| {
                x0 < right && left < x1 && y0 < bottom && top < y1
            })
        };
        let all = 0..self.film.tiles();
        let (first, rest): (Vec<_>, Vec<_>) = all.clone().partition(|tile| is_within(*tile));
        self.order = first.into_iter().chain(rest).collect();
        self.drawn.1 = if self.is_drawn() { all.end } else { 0 };
        // A pass under way goes through all once more; what it has done takes no time.
        if self.next_tile < all.end {
            self.next_tile = 0;
        }
    }

    /// Whether there are previews still to be shown.
    pub fn has_previews(&self) -> bool {
        !self.previews.is_empty()
    }

    /// Whether some pixels have more samples than others.
    pub fn is_in_pass(&self) -> bool {
        self.next_tile < self.film.tiles()
    }

    /// Whether it is as good as asked for. A pass is always finished, so that every pixel
    /// has as many.
    pub fn is_done(&self) -> bool {
        !self.is_in_pass() && self.limits.next(&self.progress).is_err()
    }

    /// Whether its error is that of all its samples.
    pub fn is_measured(&self) -> bool {
        self.film.samples() == self.measured
    }

    /// Estimated error of what is shown, as of the last pass that measured it.
    pub fn error(&self) -> Option<ErrorEstimate> {
        ErrorEstimate::of(self.errors.iter().copied())
    }

    /// Light that the depth leaves out.
    pub fn lost(&self) -> Option<Lost> {
        self.light.lost(self.error()?.mean)
    }

    /// The least depth that would lose less than a tenth of the noise.
    pub fn enough_depth(&self) -> Option<u32> {
        let error = self.error()?;
        self.light
            .least_depth(NEGLIGIBLE * error.noise(), error.mean)
    }

    /// Where the time went.
    pub fn spent(&self, opening: [f64; 2]) -> Spent {
        Spent::new(opening, &self.work.times, self.overhead)
    }

    /// Compares the picture with a reference from now on, tile by tile as they are measured.
    pub fn refer(&mut self, reference: Option<Arc<Reference>>) {
        self.true_errors.fill(None);
        self.reference = reference.filter(|r| check_size(self.film.size(), &r.image).is_ok());
    }

    /// Relative error of what is shown against the reference.
    pub fn true_error(&self) -> Option<f64> {
        let sum: f64 = self.true_errors.iter().copied().sum::<Option<f64>>()?;
        let [width, height] = self.film.size();
        Some((sum / (3.0 * f64::from(width) * f64::from(height))).sqrt())
    }

    /// How good the picture is, if every pixel has as many samples and was measured with them.
    pub fn point(&self) -> Option<Point> {
        let samples = self.film.samples();
        let is_even = self.next_tile == self.film.tiles();
        let error = self.error();
        (is_even && self.is_measured() && samples > 0 && !self.shown.is_empty()).then(|| Point {
            samples,
            seconds: self.progress.seconds,
            rays: self.work.rays,
            noise: error.as_ref().map(Span::noise_of),
            error: self.true_error(),
        })
    }

    /// The next coarse picture; nothing if it was interrupted. The first one after a wish never
    /// is: if each new wish did so, a drag would show nothing until it ends.
    pub fn preview(
        &mut self,
        governor: &mut Governor,
        cancel: &AtomicBool,
        look: Look,
    ) -> Option<Snapshot> {
        let scale = self.previews.pop()?;
        let settings = RenderSettings {
            width: self.view.settings.width.div_ceil(scale),
            height: self.view.settings.height.div_ceil(scale),
            ..self.view.settings
        };
        let view = View::new(self.view.scene.clone(), &self.camera, settings).ok()?;
        let film = view.film();
        let never = AtomicBool::new(false);
        let cancel = if self.is_shown { cancel } else { &never };
        let size = film.size().map(|n| n as usize);
        let patches = if look.aov.needs_no_samples() {
            let all: Vec<_> = (0..film.tiles()).collect();
            let drawn = paint(look, &self.scope(look), &view, &film, &all, cancel)?;
            let mut patches = Patches::black(size);
            put(&mut patches, drawn);
            let [width, height] = self.film.size();
            // What is drawn in its place may take a while.
            self.drawn = (look.aov, 0);
            let enlarged = enlarge(&patches.rgb(), scale, width, height);
            self.shown = Patches::from_rgb(self.size(), &enlarged);
            patches
        } else {
            let start = Instant::now();
            let work = view.render(&film, 1, cancel);
            if film.samples() == 0 {
                return None;
            }
            governor.measured(start.elapsed(), work.paths);
            let image = film.develop();
            let patches = Patches::from_rgb(size, &tone_mapped(&image, look.tone));
            self.backdrop = Some((image, scale));
            self.shown = Patches::default();
            patches
        };
        self.is_shown = true;
        Some(Snapshot {
            size,
            patches,
            picture: self.size(),
            preview: Some(scale),
            past: None,
            aov: look.aov,
            number: 0,
        })
    }

    /// Adds samples for about [`SLICE`]; nothing to show if it was interrupted.
    pub fn slice(
        &mut self,
        governor: &mut Governor,
        cancel: &AtomicBool,
        look: Look,
    ) -> Option<Snapshot> {
        let have = self.film.samples();
        let next = self.next_tiles(have, governor);
        let order = self.order.clone();
        let tiles = &order[next.clone()];
        // Without a preview this is the first picture after a wish, see there.
        let is_first = have == 0 && !self.is_shown;
        let never = AtomicBool::new(false);
        let cancel = if is_first { &never } else { cancel };
        let start = Instant::now();
        let work = self.view.render_tiles(&self.film, tiles, self.goal, cancel);
        let took = start.elapsed();
        self.progress.seconds += took.as_secs_f64();
        self.work = self.work + work;
        if cancel.load(Ordering::Relaxed) {
            return None;
        }
        if is_first {
            governor.measured(took, work.paths);
        }
        self.next_tile = next.end;
        let start = Instant::now();
        // Surfaces stand there already.
        let is_drawn = !look.aov.needs_no_samples();
        if is_drawn {
            self.draw(tiles, look, &never);
        }
        self.overhead[1] += start.elapsed() * rayon::current_num_threads() as u32;
        // Splats come to tiles until the pass ends.
        if self.measures && !self.film.takes_splats() {
            self.measure(tiles);
        }
        if self.next_tile == self.film.tiles() {
            self.pass_done(look);
        }
        let snapshot = is_drawn.then(|| self.snapshot(look));
        self.showing = start.elapsed();
        snapshot
    }

    fn pass_done(&mut self, look: Look) {
        self.progress.samples = self.film.samples();
        let all = self.order.clone();
        let is_last = self.limits.next(&self.progress).is_err();
        let is_changed = self.film.takes_splats();
        if is_last && is_changed && !look.aov.needs_no_samples() {
            self.draw(&all, look, &AtomicBool::new(false));
        }
        // The last picture is measured in any case.
        if (is_last && !self.measures) || (self.measures && is_changed) {
            self.measure(&all);
            self.measures = true;
        }
        if self.measures {
            self.light = self.film.light();
            self.measured = self.progress.samples;
            if self.measured >= self.progress.next_check {
                self.progress.checked(self.error().map(|e| e.noise()));
            }
        }
    }

    /// Measures the error of some tiles.
    fn measure(&mut self, tiles: &[usize]) {
        let begin = Instant::now();
        let (film, reference) = (&self.film, self.reference.as_deref());
        let errors: Vec<_> = tiles
            .par_iter()
            .map(|i| {
                let compare = |r: &Reference| Some(square(&film.develop_tile(*i)?, &r.image));
                (film.tile_error(*i), reference.and_then(compare))
            })
            .collect();
        for (i, errors) in tiles.iter().zip(errors) {
            (self.errors[*i], self.true_errors[*i]) = errors;
        }
        self.overhead[0] += begin.elapsed() * rayon::current_num_threads() as u32;
    }

    /// The tiles of the next slice; starts a pass where one has ended.
    fn next_tiles(&mut self, have: u64, governor: &Governor) -> Range<usize> {
        let tiles = self.film.tiles();
        let [width, height] = self.film.size();
        let pixels = f64::from(width) * f64::from(height);
        let cost = match self.work.paths {
            0 => governor.cost(),
            paths => self.progress.seconds / paths as f64,
        };
        let paths = SLICE.max(self.showing * SHOWING).as_secs_f64() / cost;
        // One that was interrupted before any of its tiles was there has not begun.
        let is_even = || self.film.most_samples() == have;
        if self.next_tile == tiles || (self.one_by_one && is_even()) {
            // Doubling at most, so that one slow sample at the start does not set the pace.
            let most = if self.one_by_one { 1 } else { have.max(1) };
            let more = ((paths / pixels) as u64).clamp(1, most);
            let limit = self.limits.next(&self.progress).unwrap_or(have);
            self.goal = (have + more).min(limit);
            self.next_tile = 0;
            // At the checks of a limit and as rarely as those, before them rarer still: measuring
            // takes as long as a few hundredths of a sample.
            let more = match self.measured {
                0..2 => 1,
                few @ 2..FIRST_CHECK => (few / 2).max(2),
                many => many / 8,
            };
            self.measures =
                self.goal >= self.measured + more || self.goal >= self.progress.next_check;
        }
        let share = paths / (pixels * (self.goal - have) as f64);
        let count = (tiles as f64 * share) as usize;
        let least = TILES * rayon::current_num_threads();
        self.next_tile..tiles.min(self.next_tile.saturating_add(count.max(least)))
    }

    fn size(&self) -> [usize; 2] {
        self.film.size().map(|n| n as usize)
    }
}

/// Sum over pixels and channels of a tile of the relative squared error.
fn square(tile: &Developed, reference: &Image) -> f64 {
    let rect = tile.rect;
    let rows = tile.pixels.chunks_exact(rect.width as usize);
    (rect.y..)
        .zip(rows)
        .flat_map(|(y, row)| {
            let start = (y * reference.width + rect.x) as usize;
            row.iter().zip(&reference.pixels[start..])
        })
        .map(|(x, r)| relative_square(*x, *r))
        .sum()
}

#[cfg(test)]
mod test;
