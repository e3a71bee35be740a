//! The headless harness: scenes from text, radiance through a single pixel, statistics.
//!
//! Statistical tests have fixed seeds, so they are deterministic: green stays green until the
//! code or a seed changes. The chance of a false alarm, which matters only then, is
//! [`FAMILY_ALPHA`] over all of them together (Šidák's correction over [`FAMILY_SIZE`]).

pub mod stats;

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use glam::Vec3;
use lightbox_core::scene::{Source, load};
use lightbox_core::{Film, Image, RenderSettings, Scene, View};

pub use stats::{FAMILY_ALPHA, FAMILY_SIZE, Replicates};

/// The folder of the shipped scenes.
pub fn scenes_folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../scenes")
}

/// The shipped scene files.
pub fn shipped_scenes() -> Vec<PathBuf> {
    let mut files: Vec<PathBuf> = std::fs::read_dir(scenes_folder())
        .expect("the scenes folder is part of the checkout")
        .map(|entry| entry.expect("a folder entry").path())
        .filter(|path| path.extension().is_some_and(|e| e == "toml"))
        .collect();
    files.sort();
    files
}

/// Reads a shipped scene by its file name without extension.
pub fn shipped(name: &str) -> Source {
    load(&scenes_folder().join(name).with_extension("toml")).unwrap_or_else(|e| panic!("{e}"))
}

/// Builds a scene from TOML text.
pub fn scene(text: &str) -> Scene {
    let path = scenes_folder().join("in-a-test.toml");
    let desc = lightbox_core::scene::parse(text, &path).unwrap_or_else(|e| panic!("{e}"));
    Source::from_desc(desc, &path)
        .build(&|_| ())
        .unwrap_or_else(|e| panic!("{e}"))
}

/// A view of a scene as its description wants it, with changed settings.
pub fn view(scene: &Arc<Scene>, change: impl FnOnce(&mut RenderSettings)) -> View {
    let mut settings = scene.desc().render;
    change(&mut settings);
    View::new(scene.clone(), &scene.desc().camera, settings).unwrap_or_else(|e| panic!("{e}"))
}

/// Renders a view to its sample count.
pub fn film(view: &View) -> Film {
    let film = view.film();
    view.render(&film, view.settings.samples, &AtomicBool::new(false));
    film
}

/// The picture of a view.
pub fn picture(view: &View) -> Image {
    film(view).develop()
}

/// Mean of all pixels.
pub fn image_mean(image: &Image) -> Vec3 {
    let sum = image
        .pixels
        .iter()
        .map(|p| p.as_dvec3())
        .sum::<glam::DVec3>();
    (sum / image.pixels.len() as f64).as_vec3()
}

/// Means of the green channel of 32 pictures of a view with different seeds. Samples of a
/// low-discrepancy sampler are not independent of each other, but those of different seeds are, so
/// a t-test on these means is valid for every sampler.
pub fn replicates(scene: &Arc<Scene>, change: impl Fn(&mut RenderSettings)) -> Replicates {
    let means = (0..32).map(|seed| {
        let view = view(scene, |s| {
            change(s);
            s.seed = 1000 + seed;
        });
        let image = picture(&view);
        image.pixels.iter().map(|p| f64::from(p.y)).sum::<f64>() / image.pixels.len() as f64
    });
    Replicates::new(means.collect())
}

/// Runs `f` on a pool of some threads.
pub fn on_threads<T: Send>(threads: usize, f: impl FnOnce() -> T + Send) -> T {
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(threads)
        .build()
        .expect("a thread pool");
    pool.install(f)
}
