//! lightbox-core: a headless path tracer.
//!
//! # Architecture
//!
//! One chain, in which every module uses only those before it:
//!
//! ```text
//! scene file or OBJ → SceneDesc → Scene → Integrator → Tile → Film → Image → PNG | EXR | texture
//! ```
//!
//! - [`scene::load`] reads a TOML scene or an OBJ mesh into a [`SceneDesc`], plain data that can
//!   be edited and saved. [`scene::Source::build`] freezes it into a [`Scene`]: primitives,
//!   materials, lights and the accelerator, shared by `Arc`. [`Scene::edit`] takes an edited description and rebuilds only
//!   what it changed.
//! - [`geometry::Geometry`] casts rays at primitives, one or many in a call, through an
//!   accelerator ([`AccelKind`]: a wide tree of boxes, a kd-tree, or none) with the instructions that
//!   the machine has ([`simd`]). Each way gives the same hits, bit for bit.
//! - [`View::render`] is the composition root: for each tile, pixel and sample it draws a film
//!   position from the [`filter`], a ray from the [`Camera`], a radiance from the
//!   [`integrator`], and adds it to the tile; a finished tile is merged into the [`Film`]. Paths advance in waves of
//!   four thousand, of as many tiles as fill one. Where
//!   something mirrors or refracts, each sample also traces a path from a lamp, and what the
//!   camera sees of it lands in whatever pixel that is, or in its own where the camera sees it in
//!   a mirror. Pixels that outlines of lamps cross look at lamps with camera rays of their own.
//! - [`Film::develop`] turns sums into an [`Image`], [`color::ToneMap`] an image into what a
//!   screen shows, [`image_io`] writes files.
//! - A slice of the samples, rendered on another machine or in another sitting, is kept in a file
//!   of its own by [`part`], which also adds slices up.
//! - [`Film::error`] tells how far a picture is from the truth, [`agreement`] whether two pictures
//!   differ by more than noise, [`race`] which of several ways gets nearer in the same time.
//!
//! A sample is a pure function of (scene, camera, settings, pixel, sample index), and the film's
//! sums are exact, so the picture has the same bits at any number of threads, with any pauses,
//! in any batches, in one run or several.
//!
//! The library knows no window and no standard output. It reads the clock only to tell where time
//! went ([`work::Times`]); no sample depends on it.
//!
//! # Versions
//!
//! Numbers are those of semantic versioning. From 0.1.0 on, a patch release (0.1.x) takes nothing away and changes
//! no signature, and scene files and pictures that carry their scene are read as before. A minor release (0.x.0) may
//! do each of these; the changelog says which. Enums and reports that are likely to grow are `non_exhaustive`, and
//! grow in patch releases too.
//!
//! The bits of a picture are those of one version: the same on every machine, at any number of threads, with every
//! kernel, but another version, even a patch, may find the same light by other samples. Parts say which version
//! made them, and add up with those of the same version only.
//!
//! Not part of the promise is what is hidden in this documentation: `planted`, `bsdf`, `sampler` and parts of
//! `lab`, which are for the tests, examples and benches of this project. Any release may change them.
//!
//! # A picture
//!
//! The example `picture`:
//!
//! ```no_run
#![doc = include_str!("../examples/picture.rs")]
//! ```

// From the bottom up.
pub mod color;
pub mod filter;
pub mod math;
#[doc(hidden)]
pub mod planted;
#[doc(hidden)]
pub mod sampler;
pub mod settings;
pub mod simd;
pub mod suggest;
pub mod work;
// Surfaces.
mod accel;
#[doc(hidden)]
pub mod bsdf;
pub mod geometry;
pub mod material;
pub mod shape;
pub mod texture;
// The scene.
pub mod camera;
pub mod light;
pub mod scene;
// Transport and pictures.
pub mod agreement;
pub mod compare;
pub mod film;
mod fingerprint;
pub mod forecast;
pub mod image_io;
pub mod integrator;
pub mod part;
pub mod plan;
pub mod render;
pub mod surfaces;
// Methods against each other, and what breaks, measured.
pub mod lab;
pub mod race;

pub use camera::Camera;
pub use film::{Film, Image};
pub use filter::{Filter, FilterKind};
pub use render::View;
pub use scene::{Scene, SceneDesc, SceneError};
pub use settings::{AccelKind, Method, RenderSettings, SamplerKind};
