//! What the engine tells the window.

use std::sync::Arc;

use lightbox_core::SceneDesc;
use lightbox_core::color::ToneMap;
use lightbox_core::film::Lost;
use lightbox_core::forecast::Forecast;
use lightbox_core::plan::Part;
use lightbox_core::scene::{Phase, Scene};

use super::budget::Budget;
use super::history::Point;
use super::patches::Patches;
use super::reference::Reference;
use crate::aov::Aov;
use crate::savings::Savings;
use crate::spent::Spent;

/// A picture ready to be shown.
#[derive(Debug)]
pub struct Snapshot {
    /// Pixels across and down.
    pub size: [usize; 2],
    /// Its pixels as they go to the graphics card: made where there is time for it.
    pub patches: Patches,
    /// Pixels across and down of the picture that it stands for.
    pub picture: [usize; 2],
    /// Where any of it is a preview: how many pixels of the picture one of the preview's covers,
    /// across and down; 1 while a view is being drawn.
    pub preview: Option<u32>,
    /// Of a picture as it was: when.
    pub past: Option<Point>,
    /// What pixels show.
    pub aov: Aov,
    /// Unlike that of any other snapshot.
    pub number: u64,
}

impl Snapshot {
    /// sRGB bytes, row by row from the top.
    pub fn rgb(&self) -> Vec<u8> {
        self.patches.rgb()
    }
}

/// What the engine is doing.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Activity {
    /// There is no scene yet.
    #[default]
    Empty,
    /// Samples are being added.
    Rendering,
    /// Asked to rest before the picture is done.
    Paused,
    /// Every sample asked for has been taken.
    Done,
}

/// A line for the user.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Notice {
    /// One line.
    pub text: String,
    /// Whether something failed.
    pub is_error: bool,
}

/// The state of the engine, for display.
#[derive(Clone, Debug, Default)]
pub struct Status {
    /// What it is doing.
    pub activity: Activity,
    /// The scene being opened or rebuilt in the background, and how far that is.
    pub loading: Option<(String, Phase)>,
    /// The same, of a file that is being opened only.
    pub opening: Option<(String, Phase)>,
    /// The scene being rendered.
    pub scene: Option<Arc<Scene>>,
    /// Its description with the newest edits: what panels start from.
    pub desc: Arc<SceneDesc>,
    /// Whether the scene differs from its file in more than camera and settings.
    pub is_edited: bool,
    /// How the file wants to be shown: known of a saved picture.
    pub tone: Option<ToneMap>,
    /// Rises when another file has been opened.
    pub opened: u64,
    /// Samples per pixel in the picture.
    pub samples: u64,
    /// Seconds spent tracing the picture.
    pub seconds: f64,
    /// Rays cast for it.
    pub rays: u64,
    /// Paths traced for it.
    pub paths: u64,
    /// Estimated relative error of the picture (noise, not bias).
    pub noise: Option<f64>,
    /// Relative error of the picture against the reference.
    pub true_error: Option<f64>,
    /// What counts as right.
    pub reference: Option<Arc<Reference>>,
    /// Samples that were not numbers.
    pub invalid: u64,
    /// Light that the depth leaves out, as far as that is known.
    pub lost: Option<Lost>,
    /// The least depth that would lose less than a tenth of the noise.
    pub enough_depth: Option<u32>,
    /// What the picture is made without.
    pub left_out: Vec<Part>,
    /// Whether it is being measured what that saves.
    pub is_measuring: bool,
    /// What that saves, once it was measured.
    pub savings: Option<Savings>,
    /// Where the time went.
    pub spent: Spent,
    /// When the picture is done.
    pub budget: Budget,
    /// How far that is, 0 to 1.
    pub share: f64,
    /// What it will take.
    pub forecast: Option<Forecast>,
    /// What was foretold first.
    pub promise: Option<Forecast>,
    /// Worker threads.
    pub threads: usize,
}

impl Status {
    /// Seconds until done, as far as can be told.
    pub fn eta(&self) -> Option<f64> {
        Some((self.forecast?.seconds.value - self.seconds).max(0.0))
    }
}
