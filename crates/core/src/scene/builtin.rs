//! Scenes inside the binary: they open with no file at hand, from any folder.

use std::path::{Path, PathBuf};

/// What paths of built-in files begin with.
const PREFIX: &str = "builtin:";

/// Paths of the built-in scenes; the first one opens when none is named.
pub const NAMES: &[&str] = &[
    "builtin:teddy-diffuse.toml",
    "builtin:teddy-mirror.toml",
    "builtin:sphere-mirror.toml",
    "builtin:cornell-box.toml",
    "builtin:glass-sphere.toml",
    "builtin:white-furnace.toml",
    "builtin:million.toml",
];

macro_rules! file {
    ($name:literal) => {
        (
            $name,
            include_bytes!(concat!(env!("LIGHTBOX_SCENES"), "/", $name)).as_slice(),
        )
    };
}

/// Paths of the scenes of the stability lab, which the ordinary list leaves out.
pub const LAB: &[&str] = &[
    "builtin:lab/albedo-one.toml",
    "builtin:lab/closed-box.toml",
    "builtin:lab/depth.toml",
    "builtin:lab/distant-sphere.toml",
    "builtin:lab/far-room.toml",
    "builtin:lab/lamp-in-ceiling.toml",
    "builtin:lab/measured-cornell-box.toml",
    "builtin:lab/mirror-box.toml",
    "builtin:lab/mirror-only.toml",
    "builtin:lab/planet.toml",
    "builtin:lab/small-room.toml",
    "builtin:lab/stairs.toml",
    "builtin:lab/touching-ball.toml",
    "builtin:lab/touching-light.toml",
    "builtin:lab/unseen-light.toml",
];

const FILES: &[(&str, &[u8])] = &[
    file!("teddy-diffuse.toml"),
    file!("teddy-mirror.toml"),
    file!("sphere-mirror.toml"),
    file!("cornell-box.toml"),
    file!("glass-sphere.toml"),
    file!("white-furnace.toml"),
    file!("million.toml"),
    file!("meshes/teddy.obj"),
    file!("lab/albedo-one.toml"),
    file!("lab/closed-box.toml"),
    file!("lab/depth.toml"),
    file!("lab/distant-sphere.toml"),
    file!("lab/far-room.toml"),
    file!("lab/lamp-in-ceiling.toml"),
    file!("lab/measured-cornell-box.toml"),
    file!("lab/mirror-box.toml"),
    file!("lab/mirror-only.toml"),
    file!("lab/planet.toml"),
    file!("lab/small-room.toml"),
    file!("lab/stairs.toml"),
    file!("lab/touching-ball.toml"),
    file!("lab/touching-light.toml"),
    file!("lab/unseen-light.toml"),
];

/// The bytes of a built-in file.
pub(super) fn get(path: &Path) -> Option<&'static [u8]> {
    let name = path.to_str()?.strip_prefix(PREFIX)?;
    FILES
        .iter()
        .find(|(file, _)| *file == name)
        .map(|(_, bytes)| *bytes)
}

/// The path of `file` as named in the scene at `path`: relative to its folder, unless it is
/// absolute or built in.
pub(super) fn beside(path: &Path, file: &Path) -> PathBuf {
    if file.to_str().is_some_and(|f| f.starts_with(PREFIX)) {
        return file.to_owned();
    }
    if path.to_str().is_some_and(|p| p.starts_with(PREFIX)) {
        return format!("{PREFIX}{}", file.display()).into();
    }
    path.with_file_name("").join(file)
}

/// The same path for a reader in any folder.
pub(super) fn absolute(path: PathBuf) -> PathBuf {
    if path.to_str().is_some_and(|p| p.starts_with(PREFIX)) {
        return path;
    }
    std::path::absolute(&path).unwrap_or(path)
}
