//! How the error fell: the curve of the picture in the making, those of pictures before it, and
//! some of the pictures as they were.

use std::path::PathBuf;
use std::sync::Arc;

use lightbox_core::compare::{check_size, relative_square};
use lightbox_core::forecast::Span;
use lightbox_core::{Image, SceneDesc};

use super::Reference;

/// Most bytes of kept pictures, all curves together.
const PICTURE_BYTES: usize = 256 << 20;

/// Most curves beside the present one; the oldest goes first.
const EARLIER: usize = 8;

/// Points of a curve lie at least this factor of samples apart, but for the newest.
const SPACING: f64 = 1.09;

/// Seconds of tracing from which on an unfinished picture's curve is worth keeping.
const WORTH_KEEPING: f64 = 1.0;

/// A moment of a picture: every pixel has as many samples.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Point {
    /// Samples per pixel.
    pub samples: u64,
    /// Seconds of tracing.
    pub seconds: f64,
    /// Rays cast.
    pub rays: u64,
    /// Estimated relative error (noise, not bias) with its band.
    pub noise: Option<Span>,
    /// Relative error against the reference.
    pub error: Option<f64>,
}

/// The curve of one picture.
#[derive(Clone, Debug)]
pub struct Run {
    /// Unlike that of any other run.
    pub id: u64,
    /// What it shows, and how; but for the number of samples.
    pub desc: Arc<SceneDesc>,
    /// The scene's file.
    pub path: PathBuf,
    /// Moments in order of samples.
    pub points: Vec<Point>,
    /// Moments of which the picture is kept, in order of samples.
    pub pictures: Vec<(Point, Arc<Image>)>,
    /// Samples from which on the next picture is kept.
    next_picture: u64,
    /// From one kept picture to the next, samples grow by this factor.
    growth: u64,
}

/// Where to look back to: a kept picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Moment {
    /// [`Run::id`].
    pub run: u64,
    /// Samples per pixel.
    pub samples: u64,
}

/// The curves of a session.
#[derive(Clone, Debug, Default)]
pub struct History {
    /// Pictures that came before, oldest first.
    pub earlier: Vec<Arc<Run>>,
    /// The picture in the making.
    pub present: Option<Run>,
    runs: u64,
}

impl History {
    /// Starts a curve. The one before is kept if it was worth the while.
    pub(crate) fn begin(&mut self, desc: Arc<SceneDesc>, path: PathBuf, was_done: bool) {
        if let Some(run) = self.present.take()
            && run.points.len() > 1
            && (was_done
                || run
                    .points
                    .last()
                    .is_some_and(|p| p.seconds >= WORTH_KEEPING))
        {
            self.earlier.push(Arc::new(run));
            let surplus = self.earlier.len().saturating_sub(EARLIER);
            self.earlier.drain(..surplus);
        }
        self.runs += 1;
        self.present = Some(Run {
            id: self.runs,
            desc,
            path,
            points: Vec::new(),
            pictures: Vec::new(),
            next_picture: 2, // The noise of one sample is not known.
            growth: 2,
        });
    }

    /// Adds a moment of the present picture; `develop` is called if its picture is to be kept.
    pub(super) fn record(&mut self, point: Point, develop: impl FnOnce() -> Image) {
        let Some(run) = &mut self.present else { return };
        let is_superseded = match &*run.points {
            [.., last] if last.samples == point.samples => true, // Drawn once more.
            [.., before, last] => (last.samples as f64) < before.samples as f64 * SPACING,
            _ => false,
        };
        if is_superseded {
            run.points.pop();
        }
        run.points.push(point);
        if point.samples >= run.next_picture {
            run.pictures.push((point, Arc::new(develop())));
            run.next_picture = point.samples.saturating_mul(run.growth);
            self.forget(PICTURE_BYTES);
        }
    }

    /// Drops pictures until they fit: those of old runs first, then every second of the present.
    fn forget(&mut self, limit: usize) {
        while self.runs_in_order().map(Run::bytes).sum::<usize>() > limit {
            if let Some(run) = self.earlier.iter_mut().find(|r| !r.pictures.is_empty()) {
                Arc::make_mut(run).pictures.clear();
                continue;
            }
            let Some(run) = &mut self.present else { return };
            if run.pictures.len() < 3 {
                run.pictures.clear();
                continue;
            }
            let mut index = 0;
            run.pictures.retain(|_| {
                index += 1;
                index % 2 == 1
            });
            run.growth = run.growth.saturating_mul(run.growth);
            if let Some((last, _)) = run.pictures.last() {
                run.next_picture = last.samples.saturating_mul(run.growth);
            }
        }
    }

    /// Drops all but the present curve.
    pub(super) fn clear(&mut self) {
        self.earlier.clear();
    }

    /// Measures what is kept against a reference, or none; points without a picture lose theirs.
    pub(super) fn refer(&mut self, reference: Option<&Reference>) {
        let earlier = self.earlier.iter_mut().map(Arc::make_mut);
        for run in earlier.chain(&mut self.present) {
            for point in &mut run.points {
                point.error = None;
            }
            let Some(reference) = reference else { continue };
            for (point, image) in &mut run.pictures {
                point.error = error(image, &reference.image);
                if let Some(same) = run.points.iter_mut().find(|p| p.samples == point.samples) {
                    same.error = point.error;
                }
            }
        }
    }

    /// A kept picture.
    pub(super) fn picture(&self, moment: Moment) -> Option<&(Point, Arc<Image>)> {
        let run = self.runs_in_order().find(|r| r.id == moment.run)?;
        run.pictures
            .iter()
            .find(|(p, _)| p.samples == moment.samples)
    }

    /// All curves, oldest first.
    pub fn runs_in_order(&self) -> impl Iterator<Item = &Run> {
        self.earlier.iter().map(|r| &**r).chain(&self.present)
    }
}

impl Run {
    fn bytes(&self) -> usize {
        let pixels = self.pictures.iter().map(|(_, image)| image.pixels.len());
        pixels.sum::<usize>() * size_of::<glam::Vec3>()
    }
}

/// Relative error of a picture against a reference of the same size.
fn error(image: &Image, reference: &Image) -> Option<f64> {
    check_size([image.width, image.height], reference).ok()?;
    let pixels = image.pixels.iter().zip(&reference.pixels);
    let sum: f64 = pixels.map(|(x, r)| relative_square(*x, *r)).sum();
    Some((sum / (3 * image.pixels.len()) as f64).sqrt())
}

#[cfg(test)]
mod tests {
    use glam::Vec3;

    use super::*;

    fn image(pixels: u32) -> Image {
        Image {
            width: pixels,
            height: 1,
            pixels: vec![Vec3::ONE; pixels as usize],
        }
    }

    fn point(samples: u64) -> Point {
        Point {
            samples,
            seconds: samples as f64 * 0.01,
            rays: samples * 10,
            noise: Some(Span::exact(1.0 / samples as f64)),
            error: None,
        }
    }

    fn begin(history: &mut History, was_done: bool) {
        history.begin(Arc::default(), PathBuf::new(), was_done);
    }

    fn run(history: &mut History, samples: u64, pixels: u32) {
        for samples in 1..=samples {
            history.record(point(samples), || image(pixels));
        }
    }

    #[test]
    fn curves_thin_out_but_end_at_the_newest_moment() {
        let mut history = History::default();
        begin(&mut history, false);
        run(&mut history, 1000, 1);
        let run = history.present.as_ref().expect("a curve");
        let samples: Vec<u64> = run.points.iter().map(|p| p.samples).collect();
        assert!(samples.len() < 80, "{samples:?}");
        assert_eq!((samples[0], samples[samples.len() - 1]), (1, 1000));
        let pairs = samples[..samples.len() - 1].windows(2);
        for pair in pairs {
            assert!(pair[1] as f64 >= pair[0] as f64 * SPACING, "{pair:?}");
        }
        let pictures: Vec<u64> = run.pictures.iter().map(|(p, _)| p.samples).collect();
        assert_eq!(pictures, [2, 4, 8, 16, 32, 64, 128, 256, 512]);
    }

    #[test]
    fn what_was_shown_for_a_moment_only_leaves_no_curve() {
        let mut history = History::default();
        begin(&mut history, false);
        run(&mut history, 50, 1); // Half a second, not done.
        begin(&mut history, false);
        assert_eq!(history.earlier.len(), 0);
        run(&mut history, 50, 1);
        begin(&mut history, true); // Done.
        run(&mut history, 100, 1);
        begin(&mut history, false); // A second.
        assert_eq!(history.earlier.len(), 2);
        for _ in 0..20 {
            run(&mut history, 2, 1);
            begin(&mut history, true);
        }
        assert_eq!(history.earlier.len(), EARLIER);
        assert_eq!(history.earlier[0].id, 16);
        history.clear();
        assert_eq!(history.runs_in_order().count(), 1);
    }

    #[test]
    fn pictures_stay_within_their_memory() {
        let mut history = History::default();
        begin(&mut history, false);
        run(&mut history, 64, 10);
        begin(&mut history, true);
        run(&mut history, 64, 10);
        let bytes = |h: &History| h.runs_in_order().map(Run::bytes).collect::<Vec<_>>();
        assert_eq!(bytes(&history), [720, 720]);
        history.forget(1439);
        assert_eq!(bytes(&history), [0, 720]);
        history.forget(719);
        let present = history.present.as_ref().expect("a curve");
        let left: Vec<u64> = present.pictures.iter().map(|(p, _)| p.samples).collect();
        assert_eq!(left, [2, 8, 32]);
        assert_eq!((present.growth, present.next_picture), (4, 128));
        history.forget(100);
        assert_eq!(bytes(&history), [0, 0]);
    }

    #[test]
    fn a_reference_measures_what_is_kept_if_it_has_the_same_size() {
        let mut history = History::default();
        begin(&mut history, false);
        run(&mut history, 5, 3);
        let reference = |pixels| Reference {
            image: Arc::new(Image {
                pixels: vec![Vec3::splat(2.0); pixels as usize],
                ..image(pixels)
            }),
            name: String::new(),
            stream: None,
        };
        let errors = |h: &History| {
            let run = h.present.as_ref().expect("a curve");
            run.points.iter().map(|p| p.error).collect::<Vec<_>>()
        };
        history.refer(Some(&reference(3)));
        let expected = Some((1.0f64 / 4.01).sqrt());
        assert_eq!(errors(&history), [None, expected, None, expected, None]);
        history.refer(Some(&reference(2)));
        assert_eq!(errors(&history), [None; 5]);
    }
}
