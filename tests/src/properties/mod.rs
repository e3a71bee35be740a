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

use lightbox_core::lab::random::Rng;

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
    let mut random = Rng::new(name.len() as u64);
    for seed in &corpus {
        try_one(seed);
        for _ in 0..variations {
            try_one(&vary(&mut random, seed, &corpus));
        }
    }
    for _ in 0..variations * corpus.len() {
        let length = random.below(600);
        try_one(&(0..length).map(|_| random.bits() as u8).collect::<Vec<_>>());
    }
}

/// A string with a few bytes changed, cut off, or replaced by a part of another string.
fn vary(random: &mut Rng, seed: &[u8], others: &[Vec<u8>]) -> Vec<u8> {
    let mut bytes = seed.to_vec();
    for _ in 0..=random.below(4) {
        let at = random.below(bytes.len() + 1);
        match random.below(4) {
            0 => bytes.truncate(at),
            1 => {
                let other = &others[random.below(others.len())];
                let (from, to) = (random.below(other.len() + 1), random.below(other.len() + 1));
                let part = &other[from.min(to)..from.max(to)];
                let end = (at + part.len()).min(bytes.len());
                bytes.splice(at..end, part.iter().copied());
            }
            _ if at < bytes.len() => bytes[at] = random.bits() as u8,
            _ => {}
        }
    }
    bytes
}
