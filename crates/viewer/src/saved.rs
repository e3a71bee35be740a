//! Saved pictures open like scenes: beside the pixels they carry the command that makes them
//! again, on the first line, and below it the scene as it was, edits included.

use std::path::Path;

use lightbox_core::SceneDesc;
use lightbox_core::color::ToneMap;
use lightbox_core::image_io::{Format, read_text};
use lightbox_core::part;
use lightbox_core::scene::Source;
use serde::{Deserialize, Serialize};

/// What a picture shows and how, as TOML.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Saved {
    tone: ToneMap,
    scene: SceneDesc,
}

/// The text for a picture of `samples` samples per pixel, made by the command `line`. Files are
/// relative to that of the scene at `path`.
pub fn text(line: &str, mut desc: SceneDesc, samples: u64, path: &Path, tone: ToneMap) -> String {
    desc.render.samples = samples;
    let scene = desc.detached(path);
    match toml::to_string(&Saved { tone, scene }) {
        Ok(scene) => format!("{line}\n{scene}"),
        // A file's name is not UTF-8: the picture is worth more than the scene.
        Err(_) => line.to_owned(),
    }
}

/// Reads a scene, a mesh, or the scene in a saved picture or part and the tone map it was saved with.
/// The error is one line.
pub fn load(path: &Path) -> Result<(Source, Option<ToneMap>), String> {
    if part::is_part(path) {
        let head = part::read_head(path)?;
        return Ok((Source::from_desc(head.scene, path), Some(head.tone)));
    }
    if Format::of(path).is_err() {
        let source = lightbox_core::scene::load(path).map_err(|e| e.to_string())?;
        return Ok((source, None));
    }
    let text = read_text(path)?.unwrap_or_default();
    let Some((_, scene)) = text.split_once('\n') else {
        return Err(format!(
            "{}: a picture without a scene in it; open one that lightbox has saved, a .toml scene or an .obj mesh",
            path.display()
        ));
    };
    let Saved { tone, scene } = toml::from_str(scene).map_err(|e| {
        let reason = e.message().lines().next().unwrap_or_default();
        format!(
            "{}: the scene in this picture cannot be read ({reason}); open the scene it was made from",
            path.display()
        )
    })?;
    Ok((Source::from_desc(scene, path), Some(tone)))
}
