//! Parts: the sums of some samples of a picture in a file, exact, so that any split of the work
//! over machines and sittings adds up to the bits of one run. A render to be resumed is kept in
//! the same kind of file.
//!
//! A file begins with the line `lightbox part 2`, 2 being the version of the layout. Then come
//! records: the head, in TOML ([`Head`]), and the tiles in the film's order. A record is its
//! length (u32, little-endian), a checksum (u64, XXH3 of the bytes, seeded with the record's
//! number) and its bytes.
//!
//! Adding up holds a stretch of tiles at a time, whatever the number of files, and opens one
//! file at a time.

mod file;
mod sum;
#[cfg(test)]
mod test;

use std::io::{BufWriter, Write as _};
use std::ops::Range;
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};
use twox_hash::XxHash3_64;

use crate::color::ToneMap;
use crate::film::Film;
use crate::fingerprint;
use crate::image_io::{cannot_write, check_place, write_aside};
use crate::render::View;
use crate::scene::SceneDesc;
use crate::settings::{RenderSettings, UNLIMITED};

pub use file::{read_head, resume};
pub use sum::{Parts, Sum};

/// What the name of a part ends in.
pub(crate) const EXTENSION: &str = "part";

/// First line of a file.
const MAGIC: &str = "lightbox part 2\n";

/// Longest head, bytes: a file must not fill the memory.
const LONGEST_HEAD: usize = 1 << 26;

/// What a part says of itself.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Head {
    /// The program and its version: another may trace other bits.
    made_by: String,
    /// Of all that decides the picture, in hexadecimal.
    fingerprint: String,
    /// First sample index of each run of samples and the one after its last.
    samples: Vec<[u64; 2]>,
    /// Whether some tiles have more samples than all of them do.
    unfinished: bool,
    /// Whether tiles hold light that other tiles' samples have brought.
    #[serde(default)]
    splats: bool,
    /// Seconds of tracing.
    pub seconds: f64,
    /// The file of the scene, or its built-in name, as it was given.
    pub path: PathBuf,
    /// How the picture is to be shown.
    pub tone: ToneMap,
    /// The scene with camera and settings; files that it names are absolute.
    pub scene: SceneDesc,
}

impl Head {
    /// The head for what `film` holds of a view.
    pub fn new(view: &View, tone: ToneMap, film: &Film, seconds: f64) -> Self {
        let path = view.scene.path();
        let scene = SceneDesc {
            render: view.settings,
            ..view.scene.desc().detached(path)
        };
        Self {
            made_by: format!("lightbox {}", env!("CARGO_PKG_VERSION")),
            fingerprint: format!("{:032x}", fingerprint::of(view)),
            samples: Vec::new(),
            unfinished: true,
            splats: film.takes_splats(),
            seconds,
            path: path.to_owned(),
            tone,
            scene,
        }
        .renewed(film, seconds)
    }

    /// The head for what the film holds by now.
    pub fn renewed(&self, film: &Film, seconds: f64) -> Self {
        let samples = film.samples();
        Self {
            samples: vec![[film.first(), samples]],
            unfinished: samples < film.most_samples(),
            seconds,
            ..self.clone()
        }
    }

    /// The runs of samples that it holds of every pixel, in rising order.
    pub fn samples(&self) -> impl Iterator<Item = Range<u64>> {
        self.samples.iter().map(|[start, end]| *start..*end)
    }

    /// Samples per pixel that it holds.
    pub fn samples_per_pixel(&self) -> u64 {
        self.samples().map(|run| run.end - run.start).sum()
    }

    fn first(&self) -> u64 {
        self.samples.first().map_or(0, |run| run[0])
    }

    fn end(&self) -> u64 {
        self.samples.last().map_or(0, |run| run[1])
    }

    /// Why samples of `self` and of `other` do not belong to one picture, if so.
    fn differs(&self, other: &Self) -> Option<String> {
        if self.made_by != other.made_by {
            let (a, b) = (&self.made_by, &other.made_by);
            return Some(format!("{a} instead of {b}"));
        }
        if self.fingerprint == other.fingerprint {
            return None;
        }
        let [a, b] = [&self.scene.render, &other.scene.render];
        let size = |r: &RenderSettings| format!("{}x{}", r.width, r.height);
        let depth = |r: &RenderSettings| match r.depth {
            UNLIMITED => "unlimited".into(),
            depth => depth.to_string(),
        };
        let words = [
            ("size", size(a), size(b)),
            ("seed", a.seed.to_string(), b.seed.to_string()),
            ("depth", depth(a), depth(b)),
            ("filter", a.filter.to_string(), b.filter.to_string()),
            ("method", a.method.to_string(), b.method.to_string()),
            ("sampler", a.sampler.to_string(), b.sampler.to_string()),
        ];
        let differing = words.into_iter().find(|(_, a, b)| a != b);
        Some(match differing {
            Some((what, a, b)) => format!("{what} {a} instead of {b}"),
            None if self.scene.camera != other.scene.camera => "another camera".into(),
            None => "other shapes, materials or textures".into(),
        })
    }

    /// What is wrong with it, though its bytes are as written.
    fn problem(&self) -> bool {
        let runs = &self.samples;
        self.scene.render.problem().is_some()
            || runs.is_empty()
            || runs.iter().any(|[start, end]| start > end)
            || runs.windows(2).any(|pair| pair[0][1] >= pair[1][0])
    }
}

/// Whether a name is that of a part.
pub fn is_part(path: &Path) -> bool {
    path.extension()
        .is_some_and(|e| e.eq_ignore_ascii_case(EXTENSION))
}

/// Checks that a part can be written to `path`, before any work is done for it; the error is one
/// line.
pub fn check_writable(path: &Path) -> Result<(), String> {
    if !is_part(path) {
        return Err(format!(
            "{}: a part holds samples, not a picture; name it *.{EXTENSION}",
            path.display()
        ));
    }
    check_place(path)
}

/// Writes what a film holds. Samples that come in the meantime wait. The error is one line.
pub fn write(path: &Path, head: &Head, film: &Film) -> Result<(), String> {
    write_records(path, head, |write| {
        let _still = film.stand_still();
        let mut bytes = Vec::new();
        for i in 0..film.tiles() {
            bytes.clear();
            film.pack_tile(i, &mut bytes);
            write(&bytes)?;
        }
        Ok(())
    })
}

/// A function that writes the next record.
type WriteRecord<'a> = dyn FnMut(&[u8]) -> Result<(), String> + 'a;

fn write_records(
    path: &Path,
    head: &Head,
    tiles: impl FnOnce(&mut WriteRecord) -> Result<(), String>,
) -> Result<(), String> {
    let head = toml::to_string(head).map_err(|e| {
        format!(
            "{}: the scene cannot be written with it ({e}); give its files names in UTF-8",
            path.display()
        )
    })?;
    write_aside(path, |file| {
        let mut file = BufWriter::new(file);
        file.write_all(MAGIC.as_bytes())
            .map_err(|e| cannot_write(path, &e))?;
        let mut number = 0;
        let mut write = |bytes: &[u8]| {
            let checksum = XxHash3_64::oneshot_with_seed(number, bytes);
            number += 1;
            file.write_all(&(bytes.len() as u32).to_le_bytes())
                .and_then(|()| file.write_all(&checksum.to_le_bytes()))
                .and_then(|()| file.write_all(bytes))
                .map_err(|e| cannot_write(path, &e))
        };
        write(head.as_bytes())?;
        tiles(&mut write)?;
        file.flush().map_err(|e| cannot_write(path, &e))
    })
}
