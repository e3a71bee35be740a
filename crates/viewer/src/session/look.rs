//! What a picture is shown as.

use lightbox_core::color::ToneMap;

use crate::aov::Aov;

/// What pixels show, and how light gets to the screen.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Look {
    /// From light to screen.
    pub tone: ToneMap,
    /// What pixels show.
    pub aov: Aov,
}
