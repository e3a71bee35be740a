//! Defects to plant on purpose, so that a test can see the lab's cases fail. The feature
//! `planted` makes them possible; without it `has` is a constant and nothing of them is left in
//! the binary.

#[cfg(feature = "planted")]
use std::sync::atomic::{AtomicU8, Ordering};

/// A defect.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub enum Bug {
    /// Light aimed at is not dimmed by the cosine at the surface.
    CosineDropped = 1,
    /// The density of light samples is told 2 % too high.
    PdfTimes1_02,
    /// Light run into counts from the back of lamps instead of the front.
    OneSidedFlagFlipped,
    /// Paths that survive roulette are not weighted up.
    RouletteWeightOmitted,
    /// Emission at the last segment of a path counts twice.
    LastBounceEmissionDoubled,
    /// Light seen in a mirror is weighted as if it could have been aimed at.
    MirrorWeighted,
    /// Random numbers are divided by 2³², which rounds the highest up to 1.
    UReachesOne,
    /// All dimensions of a sample share their numbers.
    DimensionsShared,
    /// Rays start a hundred times further off the surface.
    EpsilonTimes100,
    /// Edges do not belong to their triangles.
    StrictEdges,
    /// The root of a sphere is chosen by the sign of the product of both, ahead or not.
    SeedRootRule,
    /// Samples that are no radiance enter the film.
    InvalidSamplesKept,
    /// Light that is aimed at by way of a mirror sphere counts where it is run into, too.
    DetoursCountedTwice,
    /// Light that light paths find counts fully where camera paths run into it, too.
    CausticsCountedTwice,
    /// Light that probes find counts fully where camera paths run into it, too.
    ProbesCountedTwice,
    /// The weight of what a probe finds leaves out that roulette might have ended the path.
    RouletteChanceOmitted,
    /// Lamps that are left to sights count where the path runs into them, too.
    SightedTwice,
    /// Where a path goes both ways at glass, it keeps all of the light.
    BranchesCountedTwice,
    /// Reused light is shared without the cosine at the surface that it leaves.
    ReusedCosineDropped,
    /// Reused light is shared with what does not see it.
    ReusedUnseen,
}

/// The planted defect; 0 for none.
#[cfg(feature = "planted")]
static PLANTED: AtomicU8 = AtomicU8::new(0);

/// Plants a defect in the whole process, in place of the one before.
#[cfg(feature = "planted")]
pub fn plant(bug: Option<Bug>) {
    PLANTED.store(bug.map_or(0, |bug| bug as u8), Ordering::SeqCst);
}

/// Whether a defect is planted.
#[cfg(feature = "planted")]
#[inline(always)]
pub(crate) fn has(bug: Bug) -> bool {
    PLANTED.load(Ordering::Relaxed) == bug as u8
}

/// Whether a defect is planted: never.
#[cfg(not(feature = "planted"))]
#[inline(always)]
pub(crate) const fn has(_: Bug) -> bool {
    false
}
