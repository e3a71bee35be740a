//! No more than the scene needs: which parts of the model a render goes without.
//!
//! A part is left out where the census of the scene and the settings show that it cannot change a
//! bit of the picture, and is in this list only because leaving it out was measured to save time
//! (docs/plan.md). The plan is made once per view; rays and paths do not ask again.

use serde::Serialize;

use crate::geometry::Geometry;
use crate::scene::Census;
use crate::settings::{AccelKind, Method, RenderSettings};

/// A part of the model that some scenes do not need.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
#[non_exhaustive]
pub enum Part {
    /// A tree over the primitives. Not needed if they are so few that testing all of them takes
    /// no longer.
    Tree,
    /// The choice of a light and of a way to sample it. Not needed if there is one light.
    LightChoice,
    /// The last segment of paths. Not needed by the method `nee` if no path meets mirror or
    /// glass and the background is black: light that it runs into does not count.
    LastSegment,
}

impl Part {
    /// Every part.
    pub const ALL: [Self; 3] = [Self::Tree, Self::LightChoice, Self::LastSegment];

    /// What it is, in a word or two.
    pub fn name(self) -> &'static str {
        match self {
            Self::Tree => "tree",
            Self::LightChoice => "choice of light",
            Self::LastSegment => "last segment",
        }
    }
}

/// Which parts of the model a render has.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Plan {
    /// By [`Part`]: whether it is left out.
    without: [bool; Part::ALL.len()],
}

impl Plan {
    /// Every part.
    pub(crate) const FULL: Self = Self {
        without: [false; Part::ALL.len()],
    };

    /// The parts that the picture needs; all of them if the settings ask for the full model.
    pub(crate) fn new(census: &Census, geometry: &Geometry, settings: &RenderSettings) -> Self {
        if settings.full_model {
            return Self::FULL;
        }
        let without = Part::ALL.map(|part| match part {
            Part::Tree => settings.accel == AccelKind::Auto && geometry.accel() == AccelKind::Brute,
            Part::LightChoice => census.lights.total() == 1,
            Part::LastSegment => {
                settings.method == Method::Nee
                    && census.materials.specular() == 0
                    && !census.background
            }
        });
        Self { without }
    }

    /// Whether a render has this part.
    #[inline(always)]
    pub(crate) fn has(&self, part: Part) -> bool {
        !self.without[part as usize]
    }

    /// The parts that are left out.
    pub fn left_out(&self) -> impl Iterator<Item = Part> {
        Part::ALL.into_iter().filter(|part| !self.has(*part))
    }

    /// The same with one part more.
    pub(crate) fn with(mut self, part: Part) -> Self {
        self.without[part as usize] = false;
        self
    }
}

#[cfg(test)]
pub(crate) mod test;
