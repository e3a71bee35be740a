//! What a render has done: paths, rays, and where the time went.
//!
//! Time is taken per wave of a thousand paths, never per ray.

use std::time::Instant;

use serde::Serialize;

/// What a thread of a render is busy with.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum Stage {
    /// Choosing positions on the film, and adding what comes of them to it.
    Filter,
    /// Making rays from these positions.
    Camera,
    /// Finding what the segments of paths run into.
    Traversal,
    /// What happens there: light run into, light aimed at, where the path goes on.
    Shading,
    /// Finding what shades lights.
    ShadowRays,
    /// Sharing light between pixels.
    Reuse,
    /// Following some paths beyond the depth of the picture, to tell what that leaves out.
    Measuring,
}

impl Stage {
    /// Every stage.
    pub const ALL: [Self; 7] = [
        Self::Camera,
        Self::Traversal,
        Self::Shading,
        Self::ShadowRays,
        Self::Reuse,
        Self::Filter,
        Self::Measuring,
    ];
}

/// Time of all threads together, by stage.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Times {
    nanoseconds: [u64; Stage::ALL.len()],
    /// How often the clock was read.
    pub readings: u64,
}

impl Times {
    /// Seconds spent in a stage.
    pub fn seconds(&self, stage: Stage) -> f64 {
        self.nanoseconds[stage as usize] as f64 * 1e-9
    }

    /// Seconds spent in all of them.
    pub fn total(&self) -> f64 {
        Stage::ALL.iter().map(|stage| self.seconds(*stage)).sum()
    }
}

impl std::ops::AddAssign for Times {
    fn add_assign(&mut self, other: Self) {
        for (a, b) in self.nanoseconds.iter_mut().zip(other.nanoseconds) {
            *a += b;
        }
        self.readings += other.readings;
    }
}

/// Takes the times of a thread.
#[derive(Debug)]
pub(crate) struct Stopwatch {
    last: Instant,
    pub times: Times,
}

impl Stopwatch {
    pub fn start() -> Self {
        Self {
            last: Instant::now(),
            times: Times::default(),
        }
    }

    /// Books the time since it was last asked.
    #[inline]
    pub fn lap(&mut self, stage: Stage) {
        let now = Instant::now();
        self.times.nanoseconds[stage as usize] += (now - self.last).as_nanos() as u64;
        self.times.readings += 1;
        self.last = now;
    }
}

/// Work done by a render.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub struct Work {
    /// Paths traced from the camera.
    pub paths: u64,
    /// Rays cast for the picture.
    pub rays: u64,
    /// What they took.
    pub times: Times,
}

impl std::ops::Add for Work {
    type Output = Self;
    fn add(mut self, other: Self) -> Self {
        self.paths += other.paths;
        self.rays += other.rays;
        self.times += other.times;
        self
    }
}
