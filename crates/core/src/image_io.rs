//! Pictures in files: PNG as shown, EXR as measured (32-bit float, linear sRGB). Both carry a
//! text: the replay line, with which the picture can be made again, bit for bit, and what it shows.
//! Files are written aside and renamed, so that a crash never leaves half a picture under the name.

use std::fs;
use std::io::{BufRead, BufWriter, Seek, Write as _};
use std::path::{Path, PathBuf};

use exr::prelude::{
    AttributeValue, Encoding, Image as ExrImage, Layer, LayerAttributes, LineOrder,
    SpecificChannels, Text, WritableImage as _,
};
use glam::Vec3;

use crate::color::ToneMap;
use crate::film::Image;

/// Longest text read from a compressed chunk, bytes: a file must not fill the memory.
const TEXT_LIMIT: usize = 1 << 26;

/// Key of the text in PNG text chunks and EXR attributes.
const TEXT_KEY: &str = "lightbox";

/// File formats, by extension.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Format {
    /// 8 bits per channel, sRGB, tone-mapped.
    Png,
    /// 32-bit float, linear.
    Exr,
}

impl Format {
    /// The format of a path; the error is one line.
    pub fn of(path: &Path) -> Result<Self, String> {
        let extension = path.extension().map(|e| e.to_string_lossy().to_lowercase());
        match extension.as_deref() {
            Some("png") => Ok(Self::Png),
            Some("exr") => Ok(Self::Exr),
            _ => Err(format!(
                "{}: unknown kind of picture; name it *.png or *.exr",
                path.display()
            )),
        }
    }
}

/// Checks that a picture can be written to `path`, before any work is done for it.
pub fn check_writable(path: &Path) -> Result<(), String> {
    Format::of(path)?;
    check_place(path)
}

/// Renaming would replace what is write-protected too.
fn check_unprotected(path: &Path) -> Result<(), String> {
    match path.metadata() {
        Ok(metadata) if metadata.permissions().readonly() => Err(format!(
            "{}: is write-protected; name another file, or allow that it is written",
            path.display()
        )),
        _ => Ok(()),
    }
}

/// Checks that some file can be written to `path`.
pub(crate) fn check_place(path: &Path) -> Result<(), String> {
    if path.is_dir() {
        return Err(format!(
            "{}: is a folder; name a file in it",
            path.display()
        ));
    }
    check_unprotected(path)?;
    let aside = beside(path);
    fs::File::create(&aside).map_err(|e| cannot_write(path, &e))?;
    fs::remove_file(&aside).map_err(|e| cannot_write(path, &e))
}

/// Writes a picture as PNG or EXR, by extension, with a text. The tone map is for PNG.
pub fn write(path: &Path, image: &Image, tone: ToneMap, text: &str) -> Result<(), String> {
    if image.pixels.is_empty() {
        return Err(format!("{}: the picture has no pixels", path.display()));
    }
    let bytes = match Format::of(path)? {
        Format::Png => encode_png(image, tone, text),
        Format::Exr => encode_exr(image, text),
    };
    let bytes = bytes.map_err(|e| format!("{}: cannot be encoded ({e})", path.display()))?;
    write_aside(path, |file| {
        file.write_all(&bytes).map_err(|e| cannot_write(path, &e))
    })
}

/// Has a file written under another name, synced and renamed: under its own name it is whole or
/// not there, whenever the process or the machine stops.
pub(crate) fn write_aside(
    path: &Path,
    write: impl FnOnce(&mut fs::File) -> Result<(), String>,
) -> Result<(), String> {
    check_unprotected(path)?;
    let (aside, place) = (beside(path), followed(path));
    let written = fs::File::create(&aside)
        .map_err(|e| cannot_write(path, &e))
        .and_then(|mut file| {
            write(&mut file)?;
            file.sync_all()
                .and_then(|()| fs::rename(&aside, &place))
                .and_then(|()| sync_folder(&place))
                .map_err(|e| cannot_write(path, &e))
        });
    written.inspect_err(|_| {
        // The name was never touched; what was written aside is of no use.
        let _ = fs::remove_file(&aside);
    })
}

/// Makes the name last too.
#[cfg(unix)]
fn sync_folder(path: &Path) -> std::io::Result<()> {
    fs::File::open(folder(path))?.sync_all()
}

/// Elsewhere a folder cannot be opened; the file system sees to it.
#[cfg(not(unix))]
fn sync_folder(_: &Path) -> std::io::Result<()> {
    Ok(())
}

pub(crate) fn cannot_write(path: &Path, e: &std::io::Error) -> String {
    format!(
        "{}: cannot be written ({e}); choose a folder that exists and that you may write to",
        path.display()
    )
}

/// The file that is written under this name: where it is a link, what that leads to, if that is a file or is
/// not there yet.
fn followed(path: &Path) -> PathBuf {
    // As many links as systems follow.
    let mut place = path.to_owned();
    for _ in 0..40 {
        let Ok(to) = fs::read_link(&place) else { break };
        place = place.with_file_name("").join(to);
    }
    match place.metadata() {
        Ok(metadata) if !metadata.is_file() => path.to_owned(),
        _ => place,
    }
}

/// A name in the same folder for the file in the making.
fn beside(path: &Path) -> PathBuf {
    let path = &followed(path);
    let mut name = aside_prefix(path);
    name.push(std::process::id().to_string());
    name.push(ASIDE_SUFFIX);
    path.with_file_name(name)
}

const ASIDE_SUFFIX: &str = ".aside";

fn aside_prefix(path: &Path) -> std::ffi::OsString {
    let mut name = std::ffi::OsString::from(".");
    name.push(path.file_name().unwrap_or_default());
    name.push(".");
    name
}

/// Removes what processes that were killed have left of a file in the making.
pub fn remove_asides(path: &Path) {
    let path = &followed(path);
    let prefix = aside_prefix(path);
    let (prefix, suffix) = (prefix.as_encoded_bytes(), ASIDE_SUFFIX.as_bytes());
    // Where it cannot be done, nothing is lost but the space.
    for entry in fs::read_dir(folder(path)).into_iter().flatten().flatten() {
        let name = entry.file_name();
        let name = name.as_encoded_bytes();
        let process = name
            .strip_prefix(prefix)
            .and_then(|n| n.strip_suffix(suffix));
        if process.is_some_and(|p| !p.is_empty() && p.iter().all(u8::is_ascii_digit)) {
            let _ = fs::remove_file(entry.path());
        }
    }
}

/// The folder that a file is in.
fn folder(path: &Path) -> &Path {
    let folder = path.parent().filter(|folder| *folder != Path::new(""));
    folder.unwrap_or(Path::new("."))
}

/// The image as a screen shows it: RGB, 8 bits, row by row.
pub fn tone_mapped(image: &Image, tone: ToneMap) -> Vec<u8> {
    image
        .pixels
        .iter()
        .flat_map(|rgb| tone.apply(*rgb))
        .collect()
}

pub(crate) fn encode_png(image: &Image, tone: ToneMap, text: &str) -> Result<Vec<u8>, String> {
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(BufWriter::new(&mut bytes), image.width, image.height);
    encoder.set_color(png::ColorType::Rgb);
    encoder.set_depth(png::BitDepth::Eight);
    encoder.set_source_srgb(png::SrgbRenderingIntent::RelativeColorimetric);
    encoder
        .add_itxt_chunk(TEXT_KEY.into(), text.into())
        .map_err(|e| e.to_string())?;
    let mut writer = encoder.write_header().map_err(|e| e.to_string())?;
    writer
        .write_image_data(&tone_mapped(image, tone))
        .map_err(|e| e.to_string())?;
    writer.finish().map_err(|e| e.to_string())?;
    Ok(bytes)
}

pub(crate) fn encode_exr(image: &Image, text: &str) -> Result<Vec<u8>, String> {
    let (width, height) = (image.width as usize, image.height as usize);
    let channels = SpecificChannels::rgb(|at: exr::math::Vec2<usize>| {
        let Vec3 { x, y, z } = image.pixels[at.y() * width + at.x()];
        (x, y, z)
    });
    let mut attributes = LayerAttributes::named("");
    attributes.layer_name = None;
    attributes.software_name = Some(Text::from("lightbox"));
    // As UTF-8: `Text::from` panics at what Latin-1 does not have.
    attributes.other.insert(
        Text::from(TEXT_KEY),
        AttributeValue::Text(Text::from_slice_unchecked(text.as_bytes())),
    );
    let layer = Layer::new(
        (width, height),
        attributes,
        Encoding {
            // Compressed in parallel; the same picture must give the same file.
            line_order: LineOrder::Increasing,
            ..Encoding::FAST_LOSSLESS
        },
        channels,
    );
    let mut bytes = std::io::Cursor::new(Vec::new());
    ExrImage::from_layer(layer)
        .write()
        .to_buffered(&mut bytes)
        .map_err(|e| e.to_string())?;
    Ok(bytes.into_inner())
}

/// Why a file cannot be read, in one line.
pub(crate) fn cannot_read(path: &Path, e: &std::io::Error) -> String {
    let path = path.display();
    match e.kind() {
        std::io::ErrorKind::NotFound => format!("{path}: no such file; check the path"),
        _ => format!("{path}: cannot be read ({e})"),
    }
}

/// The text that [`write()`] has put beside the pixels, if any. The error is one line.
pub fn read_text(path: &Path) -> Result<Option<String>, String> {
    let format = Format::of(path)?;
    let file = fs::File::open(path).map_err(|e| cannot_read(path, &e))?;
    let reader = std::io::BufReader::new(file);
    let text = match format {
        Format::Png => png_text(reader),
        Format::Exr => exr_text(reader),
    };
    text.map_err(|e| {
        format!(
            "{}: not a picture that can be read ({e}); use EXR or PNG",
            path.display()
        )
    })
}

fn png_text(reader: impl BufRead + Seek) -> Result<Option<String>, String> {
    let reader = png::Decoder::new(reader).read_info();
    let reader = reader.map_err(|e| e.to_string())?;
    let chunk = reader
        .info()
        .utf8_text
        .iter()
        .find(|chunk| chunk.keyword == TEXT_KEY);
    let text = chunk.cloned().map(|mut chunk| {
        chunk.decompress_text_with_limit(TEXT_LIMIT)?;
        chunk.get_text()
    });
    text.transpose().map_err(|e| e.to_string())
}

fn exr_text(reader: impl BufRead) -> Result<Option<String>, String> {
    let meta = exr::meta::MetaData::read_from_buffered(reader, false).map_err(|e| e.to_string())?;
    let attributes = meta.headers.first().map(|h| &h.own_attributes.other);
    let text = match attributes.and_then(|a| a.get(&Text::from(TEXT_KEY))) {
        Some(AttributeValue::Text(text)) => {
            Some(String::from_utf8_lossy(text.as_slice()).into_owned())
        }
        _ => None,
    };
    Ok(text)
}

/// Reads a picture: EXR as it is, PNG and other 8-bit formats decoded from sRGB to linear. The
/// error is one line.
pub fn read(path: &Path) -> Result<Image, String> {
    let bytes = fs::read(path).map_err(|e| cannot_read(path, &e))?;
    decode(&bytes).map_err(|e| {
        format!(
            "{}: not a picture that can be read ({e}); use EXR or PNG",
            path.display()
        )
    })
}

/// The picture in the bytes of a file.
pub(crate) fn decode(bytes: &[u8]) -> image::ImageResult<Image> {
    let decoded = image::load_from_memory(bytes)?;
    let is_float = matches!(
        decoded,
        image::DynamicImage::ImageRgb32F(_) | image::DynamicImage::ImageRgba32F(_)
    );
    let (width, height) = (decoded.width(), decoded.height());
    let pixels = if is_float {
        decoded
            .into_rgb32f()
            .pixels()
            .map(|p| Vec3::from_array(p.0))
            .collect()
    } else {
        decoded
            .into_rgb8()
            .pixels()
            .map(|p| Vec3::from_array(p.0.map(crate::color::linear_from_srgb)))
            .collect()
    };
    Ok(Image {
        width,
        height,
        pixels,
    })
}
