//! Where the time went, from opening a file to showing a picture.

use std::sync::OnceLock;
use std::time::{Duration, Instant};

use lightbox_core::scene::Phase;
use lightbox_core::work::{Stage, Times};
use serde::Serialize;

/// Share of the noise from which on lost light would show.
pub const NEGLIGIBLE: f64 = 0.1;

/// Seconds by what they were spent on. From `camera` on they are those of all threads together.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Spent {
    /// Reading and checking files.
    pub load: f64,
    /// Building the accelerator and what hangs on it.
    pub build: f64,
    /// Making rays.
    pub camera: f64,
    /// Finding what paths run into.
    pub traversal: f64,
    /// What happens there.
    pub shading: f64,
    /// Finding what shades lights.
    pub shadow_rays: f64,
    /// Sharing light between pixels.
    pub reuse: f64,
    /// Choosing positions on the film and adding samples to it.
    pub filter: f64,
    /// Estimating the error and the light lost, and reading the clock.
    pub measuring: f64,
    /// Developing the picture and handing it on.
    pub display: f64,
}

impl Spent {
    /// `load` and `build` are seconds; `times` are those of a render, `measuring` and `display` what
    /// threads had of that together.
    pub fn new(
        [load, build]: [f64; 2],
        times: &Times,
        [measuring, display]: [Duration; 2],
    ) -> Self {
        let clock = times.readings as f64 * seconds_per_reading();
        Self {
            load,
            build,
            camera: times.seconds(Stage::Camera),
            traversal: times.seconds(Stage::Traversal),
            shading: times.seconds(Stage::Shading),
            shadow_rays: times.seconds(Stage::ShadowRays),
            reuse: times.seconds(Stage::Reuse),
            filter: times.seconds(Stage::Filter),
            measuring: times.seconds(Stage::Measuring) + clock + measuring.as_secs_f64(),
            display: display.as_secs_f64(),
        }
    }

    /// What threads were busy with, and for how long.
    pub fn stages(&self) -> [(&'static str, f64); 8] {
        [
            ("camera", self.camera),
            ("traversal", self.traversal),
            ("shading", self.shading),
            ("shadow rays", self.shadow_rays),
            ("reuse", self.reuse),
            ("filter and film", self.filter),
            ("measuring", self.measuring),
            ("display", self.display),
        ]
    }

    /// Share of the threads' time that went into measuring.
    pub fn share_of_measuring(&self) -> f64 {
        let all: f64 = self.stages().iter().map(|(_, seconds)| seconds).sum();
        if all > 0.0 { self.measuring / all } else { 0.0 }
    }
}

/// Times the opening of a scene.
#[derive(Debug)]
pub struct Opening {
    start: Instant,
    build: OnceLock<Instant>,
}

impl Opening {
    /// Begins.
    pub fn start() -> Self {
        Self {
            start: Instant::now(),
            build: OnceLock::new(),
        }
    }

    /// Takes note of what building the scene is busy with.
    pub fn observe(&self, phase: Phase) {
        if let Phase::BuildingAccelerator { .. } = phase {
            self.build.get_or_init(Instant::now);
        }
    }

    /// Seconds of loading, and of building so far.
    pub fn seconds(&self) -> [f64; 2] {
        let build = *self.build.get().unwrap_or(&self.start);
        [build - self.start, build.elapsed()].map(|time| time.as_secs_f64())
    }
}

/// What it takes to read the clock.
fn seconds_per_reading() -> f64 {
    const READINGS: u32 = 64;
    let start = Instant::now();
    for _ in 1..READINGS {
        std::hint::black_box(Instant::now());
    }
    start.elapsed().as_secs_f64() / f64::from(READINGS)
}
