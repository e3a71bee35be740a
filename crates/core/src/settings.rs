//! What the user can set about a render: one struct shared by scene files, command line and UI.

use std::fmt;
use std::str::FromStr;

use serde::{Deserialize, Serialize};

use crate::filter::Filter;

/// Depth without limit: paths end by Russian roulette, absorption or escape only.
pub const UNLIMITED: u32 = u32::MAX;

/// Largest width or height of a picture, pixels.
pub const MAX_SIZE: u32 = 16_384;

/// Largest seed: what a scene file's integers hold.
pub const MAX_SEED: u64 = i64::MAX as u64;

/// Largest number of pixels of a picture: its film then takes about 8 GB.
pub(crate) const MAX_PIXELS: u64 = 1 << 26;

/// How a scene is rendered. The image is a pure function of scene, camera and these.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct RenderSettings {
    /// Picture width, pixels, 1 to [`MAX_SIZE`].
    pub width: u32,
    /// Picture height, pixels, 1 to [`MAX_SIZE`].
    pub height: u32,
    /// Samples per pixel at which the render is done, at least 1.
    pub samples: u64,
    /// Most segments of a path from the camera: 1 sees emitters only, 2 adds direct light.
    #[serde(with = "depth_text")]
    pub depth: u32,
    /// Pixel filter.
    pub filter: Filter,
    /// How light is found.
    pub method: Method,
    /// How rays find surfaces.
    pub accel: AccelKind,
    /// Where the random numbers come from.
    pub sampler: SamplerKind,
    /// Chooses the random numbers, at most [`MAX_SEED`].
    pub seed: u64,
    /// Whether to go without nothing, not even what the scene does not need (see
    /// [`crate::plan`]): the same picture, later.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub full_model: bool,
}

impl Default for RenderSettings {
    fn default() -> Self {
        Self {
            width: 512,
            height: 512,
            samples: 256,
            depth: 16,
            filter: Filter::default(),
            method: Method::Reuse,
            accel: AccelKind::Auto,
            sampler: SamplerKind::Sobol,
            seed: 0,
            full_model: false,
        }
    }
}

impl RenderSettings {
    /// The accelerator to build: in the full model a tree, however few primitives there are.
    pub(crate) fn built_accel(&self) -> AccelKind {
        match self.accel {
            AccelKind::Auto if self.full_model => AccelKind::Bvh,
            accel => accel,
        }
    }

    /// What is wrong with the numbers, if anything: one line that says what to use instead.
    pub fn problem(&self) -> Option<String> {
        for (name, value) in [("width", self.width), ("height", self.height)] {
            if !(1..=MAX_SIZE).contains(&value) {
                return Some(format!("{name} is {value}; use 1 to {MAX_SIZE} pixels"));
            }
        }
        if u64::from(self.width) * u64::from(self.height) > MAX_PIXELS {
            let megapixels = MAX_PIXELS >> 20;
            return Some(format!(
                "{}x{} is too large; use at most {megapixels} megapixels",
                self.width, self.height
            ));
        }
        if self.samples == 0 {
            return Some("samples is 0; use at least 1".into());
        }
        if self.depth == 0 {
            return Some("depth is 0; use 1 (emitters only) or more, or \"unlimited\"".into());
        }
        if self.seed > MAX_SEED {
            return Some(format!("seed is {}; use 0 to {MAX_SEED}", self.seed));
        }
        None
    }
}

/// Defines an enum whose variants have fixed names in files, on the command line and in the UI.
macro_rules! named_enum {
    ($(#[$meta:meta])* $name:ident, $what:literal { $($(#[$doc:meta])* $variant:ident = $text:literal,)+ }) => {
        $(#[$meta])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
        #[serde(try_from = "String", into = "&'static str")]
        pub enum $name { $($(#[$doc])* $variant,)+ }

        impl $name {
            /// Every variant, in the order of menus.
            pub const ALL: &[Self] = &[$(Self::$variant),+];

            /// The name in files, on the command line and in the UI.
            pub fn name(self) -> &'static str {
                match self { $(Self::$variant => $text),+ }
            }
        }

        impl TryFrom<String> for $name {
            type Error = String;
            fn try_from(text: String) -> Result<Self, String> {
                text.parse()
            }
        }

        impl From<$name> for &'static str {
            fn from(value: $name) -> Self {
                value.name()
            }
        }

        impl fmt::Display for $name {
            fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.pad(self.name())
            }
        }

        impl FromStr for $name {
            type Err = String;
            fn from_str(text: &str) -> Result<Self, String> {
                let names: Vec<_> = Self::ALL.iter().map(|v| v.name()).collect();
                Self::ALL.iter().copied().find(|v| v.name() == text).ok_or_else(|| {
                    format!("unknown {} \"{text}\"{}", $what, crate::suggest::among(text, &names))
                })
            }
        }
    };
}

named_enum! {
    /// How a path finds light.
    #[non_exhaustive]
    Method, "method" {
        /// Sample the BSDF only and hope to hit a light.
        Naive = "naive",
        /// Next-event estimation: sample the lights only, except through mirror and glass.
        Nee = "nee",
        /// Both, weighted by the power heuristic (Veach & Guibas 1995).
        Mis = "mis",
        /// The same, and light traced from the lamps by way of mirror and glass to what the
        /// camera sees; where nothing is specular it is `mis`.
        Caustics = "caustics",
        /// The same, and pixels share the light that their paths find from the second surface on.
        Reuse = "reuse",
    }
}

named_enum! {
    /// How rays find surfaces; every choice gives the same hits, bit for bit.
    #[non_exhaustive]
    AccelKind, "accelerator" {
        /// The wide tree unless there are very few primitives.
        Auto = "auto",
        /// Test every primitive.
        Brute = "brute",
        /// A kd-tree built by the surface area heuristic.
        KdTree = "kdtree",
        /// A tree of boxes, eight to a node.
        Bvh = "bvh",
    }
}

named_enum! {
    /// Where the random numbers come from.
    #[non_exhaustive]
    SamplerKind, "sampler" {
        /// Owen-scrambled Sobol points, padded two dimensions at a time.
        Sobol = "sobol",
        /// Independent uniform numbers.
        Independent = "independent",
    }
}

/// Parses a depth: a number of segments or "unlimited".
pub fn parse_depth(text: &str) -> Result<u32, String> {
    match text {
        "unlimited" => Ok(UNLIMITED),
        _ => text.parse().map_err(|_| {
            format!(
                "depth \"{text}\" is neither \"unlimited\" nor a whole number from 0 on that is not too large"
            )
        }),
    }
}

mod depth_text {
    use serde::{Deserialize, Deserializer, Serializer};

    #[derive(Deserialize)]
    #[serde(
        untagged,
        expecting = "a depth is a whole number from 0 on that is not too large, or \"unlimited\""
    )]
    enum Depth {
        Segments(u32),
        Text(String),
    }

    #[expect(
        clippy::trivially_copy_pass_by_ref,
        reason = "the signature serde asks for"
    )]
    pub fn serialize<S: Serializer>(depth: &u32, to: S) -> Result<S::Ok, S::Error> {
        if *depth == super::UNLIMITED {
            to.serialize_str("unlimited")
        } else {
            to.serialize_u32(*depth)
        }
    }

    pub fn deserialize<'de, D: Deserializer<'de>>(from: D) -> Result<u32, D::Error> {
        match Depth::deserialize(from)? {
            Depth::Segments(n) => Ok(n),
            Depth::Text(text) => super::parse_depth(&text).map_err(serde::de::Error::custom),
        }
    }
}
