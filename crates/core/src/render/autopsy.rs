//! One pixel looked into: its samples again, one by one, and what each strategy has found in them.
//!
//! A sample is a pure function of pixel, index and seed, so nothing has to be kept of it. With
//! [`Method::Reuse`](crate::Method::Reuse) these are the pixel's own paths, before it shares with others.

use std::ops::Range;
use std::sync::atomic::AtomicBool;

use glam::Vec3;

use super::View;
use super::tiles::WAVE;
use crate::color::luminance;
use crate::film::TileRect;
use crate::integrator::Wave;
use crate::integrator::replay::{Found, Segment, Strategy, Tale};
use crate::sampler::{Dim, Sampler};

/// Numbers of segments that are told apart; the last stands for all above it too.
pub const LENGTHS: usize = 64;

/// What something has brought to samples, in luminance.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Tally {
    /// Of those to which it has brought something.
    count: f64,
    mean: f64,
    /// About the mean, as a difference of E[x²] and E[x]² would cancel.
    squares: f64,
}

impl Tally {
    pub(crate) fn add(&mut self, x: f64) {
        self.append(Self {
            count: 1.0,
            mean: x,
            squares: 0.0,
        });
    }

    /// After Chan, Golub & LeVeque 1983, Algorithms for computing the sample variance.
    fn append(&mut self, other: Self) {
        let count = self.count + other.count;
        if count == 0.0 {
            return;
        }
        let (off, share) = (other.mean - self.mean, other.count / count);
        self.mean += off * share;
        self.squares += other.squares + off * off * self.count * share;
        self.count = count;
    }

    /// Mean over `n` samples, W/(m²·sr).
    pub fn mean(&self, n: usize) -> f64 {
        self.mean * self.count / n as f64
    }

    /// Variance over `n` samples, of one of them.
    pub fn variance(&self, n: usize) -> f64 {
        let mut all = *self;
        all.append(Self {
            count: (n as f64 - self.count).max(0.0),
            ..Self::default()
        });
        all.squares / n as f64
    }
}

/// What the samples of one pixel have found, by their camera paths: light that light paths bring
/// has no sample of its own there.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Autopsy {
    /// Radiance of each sample in order, as the film gets it, or shares it.
    pub radiances: Vec<Vec3>,
    /// Luminance of what each sample has found, by the number of segments less 1 and by strategy.
    pub found: Vec<[Tally; Strategy::ALL.len()]>,
}

impl Autopsy {
    /// Adds the samples that come next.
    pub fn append(&mut self, next: Self) {
        self.radiances.extend(next.radiances);
        if self.found.len() < next.found.len() {
            self.found.resize(next.found.len(), Default::default());
        }
        for (mine, more) in self.found.iter_mut().zip(next.found) {
            for (a, b) in mine.iter_mut().zip(more) {
                a.append(b);
            }
        }
    }

    fn add(&mut self, found: &Found<'_>) {
        let length = (found.segments as usize).clamp(1, LENGTHS) - 1;
        let steps = found.before.iter().zip(found.after);
        for (before, after) in steps.filter(|(before, after)| before != after) {
            if self.found.len() <= length {
                self.found.resize(length + 1, Default::default());
            }
            let more = (after.as_dvec3() - before.as_dvec3()).as_vec3();
            self.found[length][found.strategy as usize].add(f64::from(luminance(more)));
        }
    }
}

impl View {
    /// Traces some samples of a pixel again; `None` if `cancel` was set meanwhile.
    pub fn autopsy(
        &self,
        pixel: [u32; 2],
        samples: Range<u64>,
        cancel: &AtomicBool,
    ) -> Option<Autopsy> {
        let mut wave = Wave::default();
        for sample in samples {
            self.begin_sample(&mut wave, pixel, sample);
        }
        let mut autopsy = Autopsy::default();
        let radiances =
            wave.replay(&self.transport(), cancel, |found| autopsy.add(&found), None)?;
        autopsy.radiances.extend_from_slice(radiances);
        Some(autopsy)
    }

    /// The camera path of a sample of a pixel, then its branches, and its radiance as the film gets it,
    /// or shares it.
    pub fn path(&self, pixel: [u32; 2], sample: u64) -> (Vec<Segment>, Vec3) {
        let (mut tale, never) = (Tale::default(), AtomicBool::new(false));
        let mut wave = Wave::default();
        self.begin_sample(&mut wave, pixel, sample);
        let radiances = wave.replay(&self.transport(), &never, |_| (), Some(&mut tale));
        let radiance = radiances.and_then(|r| r.first()).copied();
        (tale.into_segments(), radiance.unwrap_or_default())
    }

    /// Mean number of segments of the camera paths, with their branches, of the first `samples` samples of each of some
    /// pixels, row by row; of each path counted up to [`LENGTHS`].
    pub fn path_lengths(&self, rect: TileRect, samples: u32) -> Vec<f32> {
        let samples = samples.max(1);
        let pixels: Vec<[u32; 2]> = rect.pixels().collect();
        let mut wave = Wave::default();
        let mut means = Vec::with_capacity(pixels.len());
        for pixels in pixels.chunks((WAVE / samples as usize).max(1)) {
            wave.clear();
            for pixel in pixels {
                for sample in 0..samples {
                    self.begin_sample(&mut wave, *pixel, u64::from(sample));
                }
            }
            let lengths = wave.lengths(&self.transport(), LENGTHS as u32);
            let sums = lengths.chunks(samples as usize);
            means.extend(sums.map(|l| l.iter().sum::<u32>() as f32 / samples as f32));
        }
        means
    }

    /// Adds the camera path of a sample.
    fn begin_sample(&self, wave: &mut Wave, pixel: [u32; 2], sample: u64) {
        let sampler = Sampler::new(self.settings.sampler, self.settings.seed, pixel, sample);
        let (offset, _) = self.filter.sample(sampler.get_2d(Dim::Pixel));
        self.begin(wave, pixel, sampler, offset, self.outlined(pixel));
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;
    use std::sync::Arc;

    use super::*;
    use crate::render::outlines::is_on_outline;
    use crate::work::Stopwatch;
    use crate::{Method, RenderSettings, scene};

    fn view(scene: &str, method: Method, depth: u32) -> View {
        let path = format!("builtin:{scene}.toml");
        let source = scene::load(Path::new(&path)).expect("a scene");
        let built = Arc::new(source.build(&scene::unwatched).expect("a scene"));
        let settings = RenderSettings {
            width: 24,
            height: 18,
            method,
            depth,
            ..source.desc.render
        };
        View::new(built, &source.desc.camera, settings).expect("a view")
    }

    /// Views by every method, with diffuse, mirror, blended and glass surfaces.
    fn views() -> impl Iterator<Item = View> {
        let scenes = [
            "cornell-box",
            "sphere-mirror",
            "teddy-mirror",
            "glass-sphere",
        ];
        let scenes = scenes
            .into_iter()
            .filter(|name| scene::BUILTIN.iter().any(|b| b.contains(name)));
        scenes.flat_map(|scene| {
            let methods = Method::ALL.iter();
            methods.flat_map(move |method| [1, 2, 5, 16].map(|depth| view(scene, *method, depth)))
        })
    }

    #[test]
    fn samples_are_those_of_the_film_to_the_last_bit() {
        let never = AtomicBool::new(false);
        for view in views() {
            for pixel in [[12, 9], [3, 16], [20, 2], [11, 13]] {
                let mut wave = Wave::default();
                for sample in 5..69 {
                    view.begin_sample(&mut wave, pixel, sample);
                }
                let mut watch = Stopwatch::start();
                let traced = wave.trace(&view.transport(), &never, &mut 0, &mut watch, None);
                let autopsy = view.autopsy(pixel, 5..69, &never).expect("not cancelled");
                assert_eq!(traced, Some(&autopsy.radiances[..]), "{:?}", view.settings);
            }
        }
    }

    #[test]
    fn what_was_found_adds_up() {
        let never = AtomicBool::new(false);
        let mut by_strategy = [0.0; 3];
        for view in views() {
            let mut autopsy = Autopsy::default();
            for first in [0, 64] {
                let next = view.autopsy([12, 12], first..first + 64, &never);
                autopsy.append(next.expect("not cancelled"));
            }
            let all: f64 = autopsy
                .radiances
                .iter()
                .map(|r| f64::from(luminance(*r)))
                .sum();
            let found: f64 = autopsy
                .found
                .iter()
                .flatten()
                .map(|tally| tally.mean(1))
                .sum();
            assert!((all - found).abs() <= 1e-5 * all, "{all} {found}");
            assert!(autopsy.found.len() <= view.settings.depth as usize);
            for tallies in &autopsy.found {
                for (all, tally) in by_strategy.iter_mut().zip(tallies) {
                    *all += tally.mean(1);
                }
            }
            if view.settings.method == Method::Naive {
                assert!(
                    autopsy
                        .found
                        .iter()
                        .all(|tallies| tallies[1].mean(1) == 0.0)
                );
            }
        }
        assert!(by_strategy.iter().all(|sum| *sum > 0.0), "{by_strategy:?}");
    }

    #[test]
    fn lengths_are_those_of_the_paths() {
        let rect = TileRect {
            x: 9,
            y: 4,
            width: 7,
            height: 9,
        };
        for view in views() {
            let lengths = view.path_lengths(rect, 5);
            for ([x, y], mean) in rect.pixels().zip(&lengths).step_by(4) {
                let paths = (0..5).map(|sample| view.path([x, y], sample).0.len());
                assert_eq!(*mean, paths.sum::<usize>() as f32 / 5.0);
            }
            assert_eq!(lengths.len(), 63);
        }
    }

    /// Between mirrors that take nothing away, paths end by roulette only.
    #[test]
    fn long_paths_are_counted_to_an_end() {
        let box_of_mirrors = Path::new("builtin:lab/mirror-box.toml");
        let mut source = scene::load(box_of_mirrors).expect("a scene");
        for material in &mut source.desc.materials {
            (material.mirror, material.mirror_color) = (1.0, Vec3::ONE);
            material.emission = Vec3::ZERO;
        }
        let built = source.build(&scene::unwatched).expect("a scene");
        let view = View::of(Arc::new(built)).expect("a view");
        assert_eq!(view.settings.depth, crate::settings::UNLIMITED);
        let lengths = view.path_lengths(view.film().tile_rect(0), 1);
        let longest = lengths.iter().fold(0.0f32, |a, b| a.max(*b));
        assert_eq!(longest, LENGTHS as f32, "{lengths:?}");
    }

    /// Nothing but camera paths casts rays if light is only met.
    #[test]
    fn lengths_add_up_to_the_rays_of_a_picture() {
        for scene in ["cornell-box", "sphere-mirror"] {
            let view = view(scene, Method::Naive, 16);
            let film = view.film();
            let rays = view.render(&film, 4, &AtomicBool::new(false)).rays;
            let [width, height] = film.size();
            let all = TileRect {
                x: 0,
                y: 0,
                width,
                height,
            };
            let lengths = view.path_lengths(all, 4);
            let sum: f64 = lengths.iter().map(|mean| 4.0 * f64::from(*mean)).sum();
            assert_eq!(sum.round() as u64, rays);
        }
    }

    #[test]
    fn a_path_leads_from_the_eye_from_surface_to_surface() {
        let (mut detours, mut branches) = (0, 0);
        for view in views() {
            for sample in 0..32 {
                let (segments, radiance) = view.path([12, 12], sample);
                let autopsy = view.autopsy([12, 12], sample..sample + 1, &AtomicBool::new(false));
                let autopsy = autopsy.expect("not cancelled");
                assert_eq!(autopsy.radiances, [radiance]);
                // The steps tell the same of each strategy as the sums do.
                for strategy in Strategy::ALL {
                    let sums = autopsy
                        .found
                        .iter()
                        .map(|row| row[strategy as usize].mean(1));
                    let aims = segments.iter().flat_map(|segment| &segment.aims);
                    let of_it = aims.filter(|aim| aim.is_free && aim.strategy == strategy);
                    let mut steps: Vec3 = of_it.map(|aim| aim.radiance).sum();
                    if strategy == Strategy::Met {
                        steps += segments.iter().map(|segment| segment.met).sum::<Vec3>();
                    }
                    let (sums, steps) = (sums.sum::<f64>(), f64::from(luminance(steps)));
                    let limit = 1e-4 * f64::from(luminance(radiance));
                    assert!(
                        (sums - steps).abs() <= limit,
                        "{strategy:?}: {sums} {steps}"
                    );
                }
                let most = segments.iter().map(|segment| segment.number).max();
                assert!((1..=view.settings.depth).contains(&most.expect("a segment")));
                assert_eq!(segments[0].from, view.camera.eye());
                assert_eq!(segments[0].throughput, Vec3::ONE);
                for (i, segment) in segments.iter().enumerate().skip(1) {
                    // The one before, or of a branch any that it may have left.
                    let begin = if segment.is_branch { 0 } else { i - 1 };
                    let mut before = segments[begin..i].iter();
                    branches += u32::from(segment.is_branch);
                    assert!(before.any(|before| {
                        let (end, _) = before.end.unwrap_or((Vec3::INFINITY, 0));
                        segment.number == before.number + 1
                            && end.distance(segment.from) <= 1e-4 * end.length().max(1.0)
                    }));
                }
                let mut sum = Vec3::ZERO;
                for segment in &segments {
                    let emits = |(_, prim)| view.scene.material(prim).emits();
                    if !segment.end.is_none_or(emits)
                        && !is_on_outline(view.outlined([12, 12]), [12, 12])
                    {
                        assert_eq!(segment.met, Vec3::ZERO);
                    }
                    sum += segment.met;
                    detours += segment.aims.iter().filter(|aim| aim.by.is_some()).count();
                    let free = segment.aims.iter().filter(|aim| aim.is_free);
                    sum += free.map(|aim| aim.radiance).sum::<Vec3>();
                }
                assert!(
                    (sum - radiance).length() <= 1e-4 * radiance.length(),
                    "{sum} {radiance}"
                );
            }
        }
        assert!(detours > 100 && branches > 30, "{detours} {branches}");
    }
}
