//! Adding parts up.

use std::ops::Range;
use std::path::{Path, PathBuf};

use rayon::prelude::*;

use super::file::{PartFile, stretches};
use super::{Head, write_records};
use crate::film::{Developed, ErrorEstimate, INVALID_KEPT, Image, InvalidSample, Light, Tile};
use crate::settings::RenderSettings;

/// Parts of one picture, checked to belong together and not to overlap.
#[derive(Debug)]
pub struct Parts {
    files: Vec<PartFile>,
    /// Of all of them.
    head: Head,
    /// Why they are no whole picture, if so.
    gap: Option<String>,
}

/// What parts add up to, beside the picture.
#[derive(Clone, Debug)]
pub struct Sum {
    /// Of all parts.
    pub head: Head,
    /// Paths traced.
    pub paths: u64,
    /// Rays cast.
    pub rays: u64,
    /// Estimated error.
    pub error: Option<ErrorEstimate>,
    /// Samples left out, as [`crate::Film::invalid`].
    pub invalid: (u64, Vec<InvalidSample>),
    /// As [`crate::Film::light`].
    pub light: Light,
}

impl Parts {
    /// Opens parts, in any order. The error is one line that names the file at fault.
    pub fn open(paths: &[PathBuf]) -> Result<Self, String> {
        let files = paths.iter().map(|path| PartFile::open(path));
        let files = files.collect::<Result<Vec<_>, _>>()?;
        let Some(reference) = files.first() else {
            return Err("no parts; name at least one".into());
        };
        for PartFile { path, head, .. } in &files {
            let path = path.display();
            if let Some(what) = head.differs(&reference.head) {
                let reference = reference.path.display();
                return Err(format!(
                    "{path}: is of another picture than {reference} ({what}); leave it out or render it again"
                ));
            }
            if head.unfinished {
                return Err(unfinished(&path.to_string()));
            }
            if head.samples_per_pixel() == 0 {
                return Err(format!("{path}: holds no samples; leave it out"));
            }
        }
        let runs = files.iter().enumerate();
        let runs = runs.flat_map(|(i, file)| file.head.samples().map(move |run| (run, i)));
        let mut runs: Vec<(Range<u64>, usize)> = runs.collect();
        runs.sort_by_key(|(run, i)| (run.start, run.end, *i));
        let name = |i: usize| files[i].path.display();
        let mut joined: Vec<[u64; 2]> = Vec::new();
        let mut gap = None;
        let mut before: Option<usize> = None;
        for (run, i) in &runs {
            let end = joined.last().map_or(0, |run| run[1]);
            if run.start < end {
                let both = run.start..run.end.min(end);
                return Err(format!(
                    "{}: holds samples {both:?}, as does {}; leave one of them out",
                    name(*i),
                    name(before.unwrap_or(*i))
                ));
            }
            if run.start > end {
                gap.get_or_insert_with(|| {
                    format!(
                        "{}: samples {end}..{} are missing before it; name the part that holds them",
                        name(*i),
                        run.start
                    )
                });
            }
            match joined.last_mut() {
                Some(last) if last[1] == run.start => last[1] = run.end,
                _ => joined.push([run.start, run.end]),
            }
            before = Some(*i);
        }
        // That with the first sample has the word about all that parts may differ in.
        let leader = runs.first().map_or(reference, |(_, i)| &files[*i]);
        let head = Head {
            samples: joined,
            seconds: files.iter().map(|file| file.head.seconds).sum(),
            ..leader.head.clone()
        };
        Ok(Self { files, head, gap })
    }

    /// The picture that the parts add up to: that of one run over all samples, bit for bit. The
    /// error is one line: samples are missing, or a file is damaged.
    pub fn develop(mut self) -> Result<(Sum, Image), String> {
        if let Some(gap) = self.gap.take() {
            return Err(gap);
        }
        let mut image = self.files[0].film().develop();
        let sum = self.add_up(|_, developed| {
            developed.iter().for_each(|tile| image.place(tile));
            Ok(())
        })?;
        Ok((sum, image))
    }

    /// Writes the sum of the parts as a part, which may have gaps. The error is one line.
    pub fn write(self, path: &Path) -> Result<Sum, String> {
        let head = self.head.clone();
        let mut sum = None;
        write_records(path, &head, |write| {
            let mut bytes = Vec::new();
            sum = Some(self.add_up(|tiles, _| {
                tiles.iter().try_for_each(|tile| {
                    bytes.clear();
                    tile.pack(&mut bytes);
                    write(&bytes)
                })
            })?);
            Ok(())
        })?;
        sum.ok_or_else(|| format!("{}: was not written", path.display()))
    }

    /// Adds up stretch by stretch.
    fn add_up(
        mut self,
        mut stretch_done: impl FnMut(&[Tile], &[Developed]) -> Result<(), String>,
    ) -> Result<Sum, String> {
        let film = self.files[0].film();
        let RenderSettings { width, height, .. } = self.head.scene.render;
        let pixels = u64::from(width) * u64::from(height);
        for samples in self.head.samples() {
            film.count_light_paths(&samples, pixels);
        }
        let (mut rays, mut invalid_count, mut invalid) = (0, 0, Vec::new());
        let (mut errors, mut light) = (Vec::new(), Light::default());
        for stretch in stretches(&film) {
            let mut tiles: Vec<Tile> = stretch.map(|i| film.empty_tile(i)).collect();
            for file in &mut self.files {
                let [_, most] = file.add_to(&mut tiles)?;
                if most > file.head.end() {
                    return Err(unfinished(&file.path.display().to_string()));
                }
            }
            let developed: Vec<Developed> = tiles
                .par_iter()
                .filter_map(|tile| film.developed(tile))
                .collect();
            stretch_done(&tiles, &developed)?;
            errors.par_extend(tiles.par_iter().map(|tile| film.error_of(tile)));
            for tile in &tiles {
                light.add(tile);
                rays += tile.rays;
                invalid_count += tile.invalid().0;
                invalid.extend_from_slice(tile.invalid().1);
            }
        }
        self.files.iter().try_for_each(PartFile::close)?;
        invalid.truncate(INVALID_KEPT);
        Ok(Sum {
            paths: self.head.samples_per_pixel() * pixels,
            rays,
            error: ErrorEstimate::of(errors),
            invalid: (invalid_count, invalid),
            light,
            head: self.head,
        })
    }
}

fn unfinished(path: &str) -> String {
    format!("{path}: the render is not finished; run its command again with --checkpoint {path}")
}
