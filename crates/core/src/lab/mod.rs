//! The stability lab: cases in which ways of tracing light are known to fail, each with what a
//! naive method does, what lightbox does instead, and a probe that measures both.
//!
//! One table, [`cases`], serves the test suite (every probe must hold), the command
//! `lightbox lab` and the viewer's Lab panel. A verdict is never stated by a probe: it follows from
//! the measured figures and their bounds.

mod bsdfs;
mod cameras;
mod convergence;
mod figure;
mod films;
mod gallery;
pub(crate) mod input;
mod light_sampling;
mod lights;
mod mesh_materials;
mod meshes;
mod naive;
mod outputs;
mod paths;
mod pictures;
mod quads;
#[doc(hidden)]
pub mod random;
mod ray_ends;
mod room_pictures;
mod rooms;
mod samplers;
mod sessions;
mod slivers;
mod spawn;
mod specular;
mod sphere;
mod sphere_points;
#[doc(hidden)]
pub mod stats;
mod streams;
mod sums;
mod surfaces;
mod traversal;
mod tree_size;
mod trees;
#[doc(hidden)]
pub mod trial;
mod triangles;

use serde::Serialize;

use crate::Image;

pub use figure::{Bound, Figure, number};

/// The cases by area, in the order in which they are shown.
pub const AREAS: &[(&str, &[Case])] = &[
    ("Spheres", sphere::CASES),
    ("Triangles", triangles::CASES),
    ("Quads", quads::CASES),
    ("Meshes", surfaces::CASES),
    ("Building accelerators", trees::CASES),
    ("Walking accelerators", traversal::CASES),
    ("Leaving surfaces", spawn::CASES),
    ("Lights", lights::CASES),
    ("Scattering", bsdfs::CASES),
    ("Random numbers", samplers::CASES),
    ("Filters and files", films::CASES),
    ("Accumulation", sums::CASES),
    ("Paths", paths::CASES),
    ("Mesh files", meshes::CASES),
    ("Camera", cameras::CASES),
    ("Viewer", sessions::CASES),
];

/// A way to fail.
#[derive(Debug)]
pub struct Case {
    /// A letter for the area and a number, e.g. `S01`.
    pub id: &'static str,
    /// What the case is about, a few words.
    pub title: &'static str,
    /// The input that breaks naive methods, and how they fail.
    pub failure: &'static str,
    /// What lightbox does instead, with the method's source.
    pub cure: &'static str,
    /// How the case is held.
    pub check: Check,
    /// A built-in scene that shows the case, e.g. `builtin:lab/far-sphere.toml`.
    pub scene: Option<&'static str>,
    /// Draws the case, by the naive method and by lightbox.
    pub picture: Option<fn(Side) -> Image>,
}

/// How a case is held.
#[derive(Debug)]
pub enum Check {
    /// By measuring: a second at most on one core.
    Probe(fn() -> Vec<Figure>),
    /// By a test that needs more than this library: `folder/file.rs::name`, from the top of the
    /// project.
    Test(&'static str),
    /// Not at all, because lightbox has nothing that could fail: why.
    Absent(&'static str),
}

/// Whose picture of a case is drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Side {
    /// The naive method's.
    Naive,
    /// Lightbox's.
    Lightbox,
}

/// What is to be thought of a case.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Verdict {
    /// Every figure keeps its bound.
    Holds,
    /// Some figure does not.
    Fails,
    /// A test tells, in the test suite.
    ByTest,
    /// There is nothing that could fail.
    Absent,
}

impl Case {
    /// Measures; no figure unless the case is held by a probe. A probe that panics gives a figure
    /// that fails.
    pub fn measure(&self) -> Vec<Figure> {
        let Check::Probe(probe) = self.check else {
            return Vec::new();
        };
        std::panic::catch_unwind(probe).unwrap_or_else(|_| {
            vec![Figure {
                what: "panics of the probe",
                naive: None,
                lightbox: 1.0,
                bound: Bound::Exactly(0.0),
            }]
        })
    }

    /// What its figures, by [`Case::measure`], say about the case.
    pub fn verdict(&self, figures: &[Figure]) -> Verdict {
        match self.check {
            Check::Probe(_) if !figures.is_empty() && figures.iter().all(Figure::holds) => {
                Verdict::Holds
            }
            Check::Probe(_) => Verdict::Fails,
            Check::Test(_) => Verdict::ByTest,
            Check::Absent(_) => Verdict::Absent,
        }
    }
}

/// All cases in order.
pub fn cases() -> impl Iterator<Item = &'static Case> {
    AREAS.iter().flat_map(|(_, cases)| cases.iter())
}

/// The case of an id, in upper or lower case.
pub fn find(id: &str) -> Option<&'static Case> {
    cases().find(|case| case.id.eq_ignore_ascii_case(id))
}
