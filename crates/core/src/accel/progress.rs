//! How far a build is, told while it runs, and its end before time.

use std::ops::ControlFlow;
use std::sync::atomic::{AtomicBool, AtomicU8, AtomicUsize, Ordering};

/// Who is told how much of a build is done, in percent, and says whether to go on.
type Report<'a> = &'a (dyn Fn(u8) -> ControlFlow<()> + Sync);

/// The progress of a build that several threads share.
pub struct Progress<'a> {
    report: Report<'a>,
    done: AtomicUsize,
    told: AtomicU8,
    is_stopped: AtomicBool,
}

/// What finishing a part that one thread builds alone costs for each of its primitives, where
/// one pass over a primitive that divides a larger part costs 1; a rough share, for a bar.
const ALONE: usize = 8;

/// How much there is to do, of which parts of up to `serial` primitives are built alone.
#[derive(Clone, Copy)]
pub(super) struct Task {
    total: usize,
    serial: usize,
}

impl Task {
    /// Over so many primitives.
    pub fn new(primitives: usize, serial: usize) -> Self {
        let levels = (primitives / serial).max(1).ilog2() as usize;
        Self {
            total: primitives.saturating_mul(levels + ALONE).max(1),
            serial,
        }
    }
}

impl<'a> Progress<'a> {
    /// Nothing is done yet.
    pub fn new(report: Report<'a>) -> Self {
        Self {
            report,
            done: AtomicUsize::new(0),
            told: AtomicU8::new(0),
            is_stopped: AtomicBool::new(false),
        }
    }

    /// Of what nobody watches.
    pub fn unwatched() -> Self {
        Self::new(&|_| ControlFlow::Continue(()))
    }

    /// Whether it is to be ended before time.
    pub(crate) fn is_stopped(&self) -> bool {
        self.is_stopped.load(Ordering::Relaxed)
    }

    /// Takes note that a part of so many primitives is divided, or built if one thread does that
    /// alone. Whether to go on; if not, what is built means nothing.
    pub(super) fn pass(&self, task: Task, primitives: usize) -> bool {
        if self.is_stopped() {
            return false;
        }
        let weight = if primitives <= task.serial { ALONE } else { 1 };
        let more = primitives * weight;
        let done = (self.done.fetch_add(more, Ordering::Relaxed) + more).min(task.total);
        // Parts that divide badly are met more often than was thought.
        let percent = (done as f64 / task.total as f64 * 99.0) as u8;
        if self.told.fetch_max(percent, Ordering::Relaxed) < percent
            && (self.report)(percent).is_break()
        {
            self.is_stopped.store(true, Ordering::Relaxed);
        }
        !self.is_stopped()
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Mutex;

    use super::*;
    use crate::accel::{Bvh, KdTree};
    use crate::lab::random::Rng;
    use crate::math::Aabb;
    use crate::simd::Kernel;

    /// Builds both trees, and gives what was told until the build was over; told `last`, it is to
    /// be ended.
    fn percents(last: u8) -> [Vec<u8>; 2] {
        let mut rng = Rng(7);
        let boxes: Vec<Aabb> = (0..60_000)
            .map(|_| {
                let p = rng.cube();
                Aabb::of_points([p, p + 0.01 * rng.cube()])
            })
            .collect();
        let watch = |build: &dyn Fn(&Progress<'_>)| {
            let told = Mutex::new(vec![]);
            let report = |percent| {
                told.lock().map(|mut told| told.push(percent)).ok();
                match percent < last {
                    true => ControlFlow::Continue(()),
                    false => ControlFlow::Break(()),
                }
            };
            build(&Progress::new(&report));
            told.into_inner().unwrap_or_default()
        };
        [
            watch(&|progress| {
                let bounds = |id: u32| boxes[id as usize];
                let memory = &mut Bvh::memory(boxes.len());
                Bvh::build_watched(boxes.len(), bounds, memory, Kernel::detect(), progress);
            }),
            watch(&|progress| {
                let clip = |id: u32, cell: &Aabb| boxes[id as usize].intersection(*cell);
                KdTree::build_watched(&boxes, clip, progress);
            }),
        ]
    }

    #[test]
    fn builds_tell_how_far_they_are() {
        for told in percents(u8::MAX) {
            let most = told.iter().copied().max();
            assert!(
                told.len() > 4 && most > Some(80) && most < Some(100),
                "{told:?}"
            );
        }
    }

    #[test]
    fn builds_end_when_nobody_wants_them() {
        // Each thread may be about to tell.
        let most = 1 + rayon::current_num_threads();
        for told in percents(30) {
            let late = told.iter().filter(|percent| **percent >= 30).count();
            assert!((1..=most).contains(&late), "{told:?}");
        }
    }
}
