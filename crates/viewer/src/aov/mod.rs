//! What the pixels of the picture can show (arbitrary output variables, AOVs): one table with the
//! name, the key, the colours and their legend. To add one is to add a row.

mod colors;
mod costs;
mod samples;
mod surface;

use std::collections::HashMap;
use std::sync::OnceLock;

use egui::{Key, Modifiers};
use glam::Vec3;
use lightbox_core::color::ToneMap;
use lightbox_core::film::TileRect;
use lightbox_core::surfaces::Surface;
use lightbox_core::{Film, RenderSettings, Scene, View};

use crate::session::Reference;

pub use colors::{ERRORS, error_color};

/// One of the things that pixels can show.
#[derive(Clone, Copy)]
pub struct Aov(&'static Row);

/// A row of the table.
struct Row {
    name: &'static str,
    keys: (Modifiers, Key),
    tip: &'static str,
    paint: Paint,
    legend: fn(&Scope<'_>) -> Legend,
}

/// sRGB, pixel by pixel.
type Colors = Vec<[u8; 3]>;

/// How pixels get their colours.
enum Paint {
    /// Of those of a tile, from the samples there are; `None` where they tell nothing yet.
    Samples(fn(&Scope<'_>, &Film, usize) -> Option<Colors>),
    /// Of one, from the surface that its centre shows: no samples are needed.
    Surface(fn(&Scope<'_>, &Surface) -> [u8; 3]),
    /// Of those of a rectangle, from rays that are cast for it alone: no samples are needed either.
    Query {
        colors: fn(&Scope<'_>, &View, TileRect) -> Colors,
        /// The same of one pixel, in words.
        reading: fn(&View, [u32; 2]) -> String,
    },
}

/// What the colours mean.
pub enum Legend {
    /// Just what they are.
    None,
    /// They lie along a scale.
    Scale {
        /// The colour at a share of the way.
        color: fn(f32) -> [u8; 3],
        /// What stands at its ends.
        ends: [String; 2],
    },
    /// Each stands for something of its own.
    Swatches(Vec<([u8; 3], String)>),
    /// In words.
    Words(&'static str),
}

/// What colours and legends depend on, beside the pixel.
pub struct Scope<'a> {
    scene: &'a Scene,
    /// Least and largest distance at which the camera can see something.
    distances: [f32; 2],
    settings: &'a RenderSettings,
    tone: ToneMap,
    reference: Option<&'a Reference>,
    /// The first slot with the same material as each slot; found when it is asked for.
    first_slots: OnceLock<Vec<u32>>,
}

impl<'a> Scope<'a> {
    /// For a picture from `eye` with some settings.
    pub fn new(
        scene: &'a Scene,
        eye: Vec3,
        settings: &'a RenderSettings,
        tone: ToneMap,
        reference: Option<&'a Reference>,
    ) -> Self {
        let bounds = scene.geometry().bounds();
        let near = eye.distance(eye.clamp(bounds.min.min(bounds.max), bounds.max));
        let far = (eye - bounds.min).abs().max((eye - bounds.max).abs());
        Self {
            scene,
            distances: [near, far.length()],
            settings,
            tone,
            reference,
            first_slots: OnceLock::new(),
        }
    }

    fn first_slots(&self) -> &[u32] {
        self.first_slots.get_or_init(|| {
            let mut first = HashMap::new();
            let slots = self.scene.material_names().iter().zip(0..);
            slots
                .map(|(name, slot)| *first.entry(name).or_insert(slot))
                .collect()
        })
    }
}

const PLAIN: Modifiers = Modifiers::NONE;
const SHIFT: Modifiers = Modifiers::SHIFT;

/// Everything that pixels can show; light comes first.
static ROWS: [Row; 15] = [
    Row {
        name: "colour",
        keys: (PLAIN, Key::C),
        tip: "show the light",
        paint: Paint::Samples(samples::color),
        legend: |_| Legend::None,
    },
    Row {
        name: "noise",
        keys: (PLAIN, Key::F6),
        tip: "show the relative standard error of each pixel, pooled with its neighbours",
        paint: Paint::Samples(samples::noise),
        legend: |_| samples::noise_legend(),
    },
    Row {
        name: "samples",
        keys: (SHIFT, Key::F6),
        tip: "show the samples of each pixel",
        paint: Paint::Samples(samples::count),
        legend: samples::count_legend,
    },
    Row {
        name: "difference",
        keys: (PLAIN, Key::F7),
        tip: "show how much brighter or darker than the reference each pixel is",
        paint: Paint::Samples(samples::difference),
        legend: samples::difference_legend,
    },
    Row {
        name: "invalid samples",
        keys: (SHIFT, Key::F7),
        tip: "show pixels with samples that were no numbers, and were left out",
        paint: Paint::Samples(samples::invalid),
        legend: |_| samples::invalid_legend(),
    },
    Row {
        name: "false colour",
        keys: (PLAIN, Key::F8),
        tip: "show brightness as colour",
        paint: Paint::Samples(samples::false_color),
        legend: samples::false_color_legend,
    },
    Row {
        name: "clipped",
        keys: (PLAIN, Key::U),
        tip: "show what is too bright or too dark for the screen",
        paint: Paint::Samples(samples::clipped),
        legend: |_| samples::clipped_legend(),
    },
    Row {
        name: "traversal cost",
        keys: (SHIFT, Key::F8),
        tip: "show how many nodes and shapes a ray through each pixel visits to find its surface",
        paint: Paint::Query {
            colors: costs::traversal,
            reading: costs::traversal_reading,
        },
        legend: |_| costs::traversal_legend(),
    },
    Row {
        name: "path length",
        keys: (SHIFT, Key::F9),
        tip: "show how many segments the paths of each pixel have, on average",
        paint: Paint::Query {
            colors: costs::path_length,
            reading: costs::path_length_reading,
        },
        legend: costs::path_length_legend,
    },
    Row {
        name: "depth",
        keys: (PLAIN, Key::F9),
        tip: "show the distance from the camera",
        paint: Paint::Surface(surface::depth),
        legend: surface::depth_legend,
    },
    Row {
        name: "normal",
        keys: (PLAIN, Key::F10),
        tip: "show where the fronts of surfaces face",
        paint: Paint::Surface(surface::normal),
        legend: |_| surface::normal_legend(),
    },
    Row {
        name: "front and back",
        keys: (SHIFT, Key::F10),
        tip: "show which side of surfaces is seen",
        paint: Paint::Surface(surface::facing),
        legend: |_| surface::facing_legend(),
    },
    Row {
        name: "albedo",
        keys: (PLAIN, Key::F11),
        tip: "show the share of light that surfaces give back",
        paint: Paint::Surface(|_, surface| surface::albedo(surface)),
        legend: |_| Legend::None,
    },
    Row {
        name: "object",
        keys: (PLAIN, Key::F12),
        tip: "show each object in a colour of its own",
        paint: Paint::Surface(surface::object),
        legend: surface::object_legend,
    },
    Row {
        name: "material",
        keys: (SHIFT, Key::F12),
        tip: "show each material in a colour of its own",
        paint: Paint::Surface(surface::material),
        legend: surface::material_legend,
    },
];

impl Aov {
    /// The light.
    pub const COLOR: Self = Self(&ROWS[0]);

    /// Where samples were no numbers.
    pub const INVALID: Self = Self(&ROWS[4]);

    /// Everything, in the order of menus.
    pub fn all() -> impl DoubleEndedIterator<Item = Self> {
        ROWS.iter().map(Self)
    }

    /// The name in the window.
    pub fn name(self) -> &'static str {
        self.0.name
    }

    /// The key that shows it.
    pub fn keys(self) -> (Modifiers, Key) {
        self.0.keys
    }

    /// What the key does.
    pub fn tip(self) -> &'static str {
        self.0.tip
    }

    /// What the colours mean.
    pub fn legend(self, scope: &Scope<'_>) -> Legend {
        (self.0.legend)(scope)
    }

    /// Whether it is there without samples.
    pub fn needs_no_samples(self) -> bool {
        !matches!(self.0.paint, Paint::Samples(_))
    }

    /// What it tells of a pixel, where that is not told in every view.
    pub fn reading(self, view: impl FnOnce() -> Option<View>, pixel: [u32; 2]) -> Option<String> {
        match self.0.paint {
            Paint::Query { reading, .. } => Some(reading(&view()?, pixel)),
            Paint::Samples(_) | Paint::Surface(_) => None,
        }
    }

    /// sRGB of the pixels of a tile; `None` before its first samples, if it takes samples. Light
    /// is shown where they tell nothing else yet.
    pub fn tile(
        self,
        scope: &Scope<'_>,
        view: &View,
        film: &Film,
        i: usize,
    ) -> Option<(TileRect, Colors)> {
        let rect = film.tile_rect(i);
        let rgb = match self.0.paint {
            Paint::Samples(paint) => {
                paint(scope, film, i).or_else(|| samples::color(scope, film, i))?
            }
            Paint::Surface(paint) => {
                let color = |s: &Option<Surface>| s.map_or([0; 3], |s| paint(scope, &s));
                view.surfaces(rect).iter().map(color).collect()
            }
            Paint::Query { colors, .. } => colors(scope, view, rect),
        };
        Some((rect, rgb))
    }
}

impl Default for Aov {
    fn default() -> Self {
        Self::COLOR
    }
}

impl PartialEq for Aov {
    fn eq(&self, other: &Self) -> bool {
        std::ptr::eq(self.0, other.0)
    }
}

impl Eq for Aov {}

impl std::fmt::Debug for Aov {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(self.0.name)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_two_have_a_name_or_a_key_in_common() {
        let rows: Vec<Aov> = Aov::all().collect();
        for (i, a) in rows.iter().enumerate() {
            let is_alike = |b: &&Aov| a.name() == b.name() || a.keys() == b.keys();
            assert_eq!(rows.iter().position(|b| is_alike(&b)), Some(i), "{a:?}");
        }
    }
}
