//! Which renders are measured.

use std::fmt;

/// The size of a render: the boulder in its box.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Size {
    pub width: u32,
    pub height: u32,
    /// Per pixel.
    pub samples: u32,
    /// Of the boulder.
    pub triangles: u32,
    pub threads: u32,
}

impl fmt::Display for Size {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [width, height, samples, triangles, threads] = self.numbers();
        write!(f, "{width}×{height} | {samples} | {triangles} | {threads}")
    }
}

impl Size {
    /// All of it.
    pub fn numbers(&self) -> [u32; 5] {
        let Self {
            width,
            height,
            samples,
            triangles,
            threads,
        } = *self;
        [width, height, samples, triangles, threads]
    }

    pub fn pixels(&self) -> f64 {
        f64::from(self.width) * f64::from(self.height)
    }

    pub fn paths(&self) -> f64 {
        self.pixels() * f64::from(self.samples)
    }

    /// Those of the box are few enough to forget.
    pub fn triangles(&self) -> f64 {
        f64::from(self.triangles)
    }

    pub fn threads(&self) -> f64 {
        f64::from(self.threads)
    }
}

/// Triangles of a boulder whose edges are divided in `n`.
pub const fn boulder(n: u32) -> u32 {
    20 * n * n
}

/// The machine has no more processors.
pub const THREADS: [u32; 2] = [1, 2];

/// The size that others differ from in one number.
pub const BASE: Size = Size {
    width: 512,
    height: 512,
    samples: 4,
    triangles: boulder(71),
    threads: 1,
};

/// Sizes that differ in one number.
pub struct Sweep {
    /// What grows.
    pub name: &'static str,
    pub sizes: Vec<Size>,
    /// The number that grows.
    pub at: fn(&Size) -> f64,
}

/// What the model is fitted to, at each of [`THREADS`]: three sweeps.
pub fn sweeps() -> [Sweep; 3] {
    let samples = [1, 2, 4, 8, 16, 32].map(|samples| Size { samples, ..BASE });
    let edges = [192, 320, 512, 800, 1200];
    let resolutions = edges.map(|edge| Size {
        width: edge,
        height: edge,
        ..BASE
    });
    let triangles = [7, 22, 71, 158, 224, 447].map(|n| Size {
        triangles: boulder(n),
        ..BASE
    });
    [
        Sweep {
            name: "samples per pixel",
            sizes: samples.into(),
            at: |size| f64::from(size.samples),
        },
        Sweep {
            name: "pixels",
            sizes: resolutions.into(),
            at: Size::pixels,
        },
        Sweep {
            name: "triangles",
            sizes: triangles.into(),
            at: Size::triangles,
        },
    ]
}

/// Two large numbers at a time, which the sweeps never have.
pub fn corners() -> Vec<Size> {
    let large = Size {
        width: 2048,
        height: 2048,
        samples: 1,
        triangles: boulder(224),
        ..BASE
    };
    vec![
        large,
        Size {
            width: 1024,
            height: 1024,
            triangles: boulder(447),
            ..large
        },
        Size {
            samples: 16,
            triangles: boulder(224),
            ..BASE
        },
        Size {
            samples: 16,
            triangles: boulder(447),
            ..BASE
        },
        Size {
            width: 256,
            height: 256,
            samples: 48,
            triangles: boulder(7),
            ..BASE
        },
        // More triangles than pixels.
        Size {
            width: 256,
            height: 256,
            samples: 12,
            triangles: boulder(224),
            ..BASE
        },
        Size {
            width: 224,
            height: 224,
            samples: 32,
            triangles: boulder(447),
            ..BASE
        },
        Size {
            width: 128,
            height: 128,
            samples: 64,
            triangles: boulder(158),
            ..BASE
        },
    ]
}

/// What the model foretells: pixels and triangles are none of those that it was fitted to; in the
/// last four pixels, samples, triangles, and pixels and triangles are more than in any of those.
pub fn unseen() -> Vec<Size> {
    let size = |edge, samples, n, threads| Size {
        width: edge,
        height: edge,
        samples,
        triangles: boulder(n),
        threads,
    };
    vec![
        size(400, 12, 12, 1),
        size(400, 24, 39, 2),
        size(700, 5, 122, 1),
        size(700, 10, 122, 2),
        size(960, 3, 316, 2),
        size(960, 3, 39, 1),
        size(250, 40, 316, 1),
        size(1400, 3, 12, 2),
        size(2880, 1, 39, 2),
        size(250, 100, 12, 1),
        size(400, 10, 632, 2),
        size(2450, 1, 548, 2),
        size(180, 24, 400, 1),
        size(300, 24, 200, 2),
    ]
}
