//! Reading parts.

use std::fs::File;
use std::io::{self, BufReader, Read as _, Seek as _, SeekFrom};
use std::ops::Range;
use std::path::{Path, PathBuf};

use rayon::prelude::*;
use twox_hash::XxHash3_64;

use super::{Head, LONGEST_HEAD, MAGIC};
use crate::color::ToneMap;
use crate::film::{Film, LONGEST_PACKED, Tile};
use crate::filter::FilterSampler;
use crate::image_io::{self, remove_asides};
use crate::render::View;

/// Tiles in memory at a time: some tens of megabytes.
const STRETCH: usize = 1024;

/// Reads the records of a file one by one.
struct Reader<'a> {
    path: &'a Path,
    file: BufReader<File>,
    place: Place,
}

/// A place in a file: the byte at which a record begins, and its number.
#[derive(Clone, Copy, Debug, Default)]
struct Place {
    byte: u64,
    record: u64,
}

impl<'a> Reader<'a> {
    fn open(path: &'a Path, place: Place) -> Result<Self, String> {
        let mut file = File::open(path).map_err(|e| cannot_read(path, &e))?;
        file.seek(SeekFrom::Start(place.byte))
            .map_err(|e| cannot_read(path, &e))?;
        let file = BufReader::new(file);
        Ok(Self { path, file, place })
    }

    fn take(&mut self, bytes: &mut [u8]) -> Result<(), String> {
        self.place.byte += bytes.len() as u64;
        let read = self.file.read_exact(bytes);
        read.map_err(|e| cannot_read(self.path, &e))
    }

    fn record(&mut self, longest: usize) -> Result<Vec<u8>, String> {
        let (mut length, mut checksum) = ([0; 4], [0; 8]);
        self.take(&mut length)?;
        self.take(&mut checksum)?;
        let length = u32::from_le_bytes(length) as usize;
        if length > longest {
            return Err(damaged(self.path));
        }
        let mut bytes = vec![0; length];
        self.take(&mut bytes)?;
        let expected = XxHash3_64::oneshot_with_seed(self.place.record, &bytes);
        self.place.record += 1;
        if u64::from_le_bytes(checksum) != expected {
            return Err(damaged(self.path));
        }
        Ok(bytes)
    }
}

fn cannot_read(path: &Path, e: &io::Error) -> String {
    let shown = path.display();
    match e.kind() {
        io::ErrorKind::UnexpectedEof => {
            format!("{shown}: is cut short; copy it or render it again")
        }
        io::ErrorKind::IsADirectory => format!("{shown}: is a folder; name the parts in it"),
        _ => image_io::cannot_read(path, e),
    }
}

fn damaged(path: &Path) -> String {
    format!("{}: is damaged; copy it or render it again", path.display())
}

/// A part whose head has been read.
#[derive(Debug)]
pub(super) struct PartFile {
    pub path: PathBuf,
    pub head: Head,
    /// Of the first tile not read yet.
    place: Place,
}

impl PartFile {
    pub fn open(path: &Path) -> Result<Self, String> {
        let mut reader = Reader::open(path, Place::default())?;
        let mut magic = [0; MAGIC.len()];
        let begins = reader.take(&mut magic);
        let same = magic
            .iter()
            .zip(MAGIC.bytes())
            .take_while(|(a, b)| **a == *b);
        match same.count() {
            n if n == MAGIC.len() => begins?,
            // All but the version and the end of the line.
            n if n + 2 == MAGIC.len() && begins.is_ok() => {
                return Err(format!(
                    "{}: was written by a lightbox of another version; render it again with this one",
                    path.display()
                ));
            }
            _ => {
                begins.or_else(|e| if path.is_file() { Ok(()) } else { Err(e) })?;
                return Err(format!(
                    "{}: is not a part; name files made by `lightbox render --part`",
                    path.display()
                ));
            }
        }
        let head = reader.record(LONGEST_HEAD)?;
        let head = str::from_utf8(&head).ok();
        let head: Option<Head> = head.and_then(|head| toml::from_str(head).ok());
        let head = head.filter(|head| !head.problem());
        let place = reader.place;
        Ok(Self {
            path: path.to_owned(),
            head: head.ok_or_else(|| damaged(path))?,
            place,
        })
    }

    /// An empty film of its size.
    pub fn film(&self) -> Film {
        let settings = &self.head.scene.render;
        let filter = FilterSampler::new(settings.filter);
        let film = Film::new(settings.width, settings.height, &filter);
        if self.head.splats {
            film.with_splats()
        } else {
            film
        }
    }

    /// Adds the next tiles to `sums`, and returns the lowest and highest of their
    /// [`Tile::samples`].
    pub fn add_to(&mut self, sums: &mut [Tile]) -> Result<[u64; 2], String> {
        let mut reader = Reader::open(&self.path, self.place)?;
        let records = sums.iter().map(|_| reader.record(LONGEST_PACKED));
        let records = records.collect::<Result<Vec<_>, _>>()?;
        self.place = reader.place;
        let held = sums
            .par_iter_mut()
            .zip(records)
            .map(|(sum, record)| sum.add_packed(&record).map(|samples| [samples; 2]))
            .reduce(
                || Some([u64::MAX, 0]),
                |a, b| Some([a?[0].min(b?[0]), a?[1].max(b?[1])]),
            );
        held.filter(|[least, _]| *least >= self.head.end())
            .ok_or_else(|| damaged(&self.path))
    }

    /// Checks that the file ends with the last tile.
    pub fn close(&self) -> Result<(), String> {
        let length = std::fs::metadata(&self.path).map_err(|e| cannot_read(&self.path, &e))?;
        if length.len() == self.place.byte {
            Ok(())
        } else {
            Err(damaged(&self.path))
        }
    }
}

/// Stretches of the tiles of a film.
pub(super) fn stretches(film: &Film) -> impl Iterator<Item = Range<usize>> + use<> {
    let tiles = film.tiles();
    let starts = (0..tiles).step_by(STRETCH);
    starts.map(move |start| start..tiles.min(start + STRETCH))
}

/// What the part at `path` says of itself; the error is one line.
pub fn read_head(path: &Path) -> Result<Head, String> {
    PartFile::open(path).map(|file| file.head)
}

/// Takes up a render of `view` from sample `first` on where the part at `path` left it: what it
/// holds, and the seconds of tracing so far. `None` if there is no such file. What a killed
/// process has left beside it goes. The error is one line.
pub fn resume(path: &Path, view: &View, first: u64) -> Result<Option<(Film, f64)>, String> {
    remove_asides(path);
    if !path.exists() {
        return Ok(None);
    }
    let mut file = PartFile::open(path)?;
    let film = view.film().starting_at(first);
    let wanted = Head::new(view, ToneMap::default(), &film, 0.0);
    let another = |what: &str| {
        Err(format!(
            "{}: holds another render ({what}); name another checkpoint or remove this one",
            path.display()
        ))
    };
    if let Some(what) = file.head.differs(&wanted) {
        return another(&what);
    }
    if file.head.samples.len() > 1 || file.head.first() != first {
        let runs: Vec<String> = file.head.samples().map(|run| format!("{run:?}")).collect();
        return another(&format!(
            "samples {} instead of those from {first} on",
            runs.join(" and ")
        ));
    }
    for stretch in stretches(&film) {
        let mut tiles: Vec<Tile> = stretch.clone().map(|i| film.empty_tile(i)).collect();
        file.add_to(&mut tiles)?;
        for (i, tile) in stretch.zip(tiles) {
            film.set_tile(i, tile);
        }
    }
    file.close()?;
    Ok(Some((film, file.head.seconds)))
}
