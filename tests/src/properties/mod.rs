//! Properties that must hold for any input, drawn from a string of bytes. The fuzz targets look
//! for bytes that break one; the ordinary tests try the corpus, what is close to it, and some
//! random strings.

mod accelerators;
mod bsdfs;
mod camera;
mod draw;
mod files;
mod film;
mod images;
mod intersectors;
mod lights;

use std::path::Path;

pub use accelerators::accelerators;
pub use bsdfs::bsdfs;
pub use camera::camera;
pub use draw::Draw;
pub use files::{obj, scene};
pub use film::film;
pub use images::images;
pub use intersectors::intersectors;
pub use lights::lights;

use crate::random::Pcg;

/// Prints the input in hand when a property fails, so that it can be kept.
struct Report<'a>(&'a [u8]);

impl Drop for Report<'_> {
    fn drop(&mut self) {
        if std::thread::panicking() {
            eprintln!("the property fails for the bytes {:02x?}", self.0);
        }
    }
}

/// Tries a property on every file of its corpus in `fuzz/corpus`, on `variations` of each, and on
/// as many random strings.
pub fn check(name: &str, variations: usize, property: fn(&[u8])) {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("../fuzz/corpus")
        .join(name);
    let mut files: Vec<_> = std::fs::read_dir(&folder)
        .unwrap_or_else(|e| panic!("{}: {e}", folder.display()))
        .map(|entry| entry.expect("a folder entry").path())
        .collect();
    files.sort();
    let corpus: Vec<Vec<u8>> = files
        .iter()
        .map(|file| std::fs::read(file).expect("a file of the corpus"))
        .collect();
    let try_one = |bytes: &[u8]| {
        let _report = Report(bytes);
        property(bytes);
    };
    let mut random = Pcg::new(name.len() as u64);
    for seed in &corpus {
        try_one(seed);
        for _ in 0..variations {
            try_one(&random.vary(seed, &corpus));
        }
    }
    for _ in 0..variations * corpus.len() {
        let length = random.below(600);
        try_one(&random.string(length));
    }
}
