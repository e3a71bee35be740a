//! The headless harness: shipped scenes and pictures of them.

pub mod properties;

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

pub use lightbox_core::lab::trial::{picture, view};
use lightbox_core::scene::{Source, load, parse};
use lightbox_core::{Film, Scene, SceneDesc, View};

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

/// Builds a scene.
pub fn built(source: &Source) -> Arc<Scene> {
    built_as(source, source.desc.clone())
}

/// Builds a scene that has been edited since it was read.
pub fn built_as(source: &Source, desc: SceneDesc) -> Arc<Scene> {
    let scene = source.build_edited(desc, &lightbox_core::scene::unwatched);
    Arc::new(scene.unwrap_or_else(|e| panic!("{e}")))
}

/// Builds a scene from the text of its file.
pub fn written(text: &str) -> Arc<Scene> {
    let path = Path::new("scene.toml");
    let desc = parse(text, path).unwrap_or_else(|e| panic!("{e}"));
    built(&Source::from_desc(desc, path))
}

/// Renders a view to its sample count.
pub fn film(view: &View) -> Film {
    let film = view.film();
    view.render(&film, view.settings.samples, &AtomicBool::new(false));
    film
}

/// Runs `f` on a pool of some threads.
pub fn on_threads<T: Send>(threads: usize, f: impl FnOnce() -> T + Send) -> T {
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(threads)
        .build()
        .expect("a thread pool");
    pool.install(f)
}
