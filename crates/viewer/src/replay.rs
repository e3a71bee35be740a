//! The replay line: the command that makes a picture again, bit for bit.

use std::ops::Range;
use std::path::Path;

use glam::Vec3;
use lightbox_core::SceneDesc;
use lightbox_core::color::ToneMap;
use lightbox_core::settings::UNLIMITED;

/// The command, for a shell, that makes the picture of `samples` samples per pixel again; all it
/// lacks is where to write it. `scene` is the file with the scene in it: after edits to materials
/// or shapes, a saved picture.
pub fn line(scene: &Path, desc: &SceneDesc, samples: u64) -> String {
    format!(
        "lightbox {}",
        words(scene, desc, &format!("--spp {samples}"))
    )
}

/// [`line()`] for somebody to paste: with a picture named after the scene to write to.
pub fn command(scene: &Path, desc: &SceneDesc, samples: u64) -> String {
    let name = crate::model::scene_name(scene);
    let output = file(Path::new(&format!("{name}-{samples}spp.png")));
    format!("{} -o {output}", line(scene, desc, samples))
}

/// The command that makes a part with these samples again.
pub fn slice(scene: &Path, desc: &SceneDesc, samples: Range<u64>) -> String {
    let samples = format!("--part --samples {samples:?}");
    format!("lightbox {}", words(scene, desc, &samples))
}

/// What follows the program's name; `samples` is the options that say which samples.
pub fn words(scene: &Path, desc: &SceneDesc, samples: &str) -> String {
    let (r, c) = (&desc.render, &desc.camera);
    // Rust writes floats with as many digits as it takes to read the same bits back.
    let point = |v: Vec3| format!("{},{},{}", v.x, v.y, v.z);
    let depth = if r.depth == UNLIMITED {
        "unlimited".into()
    } else {
        r.depth.to_string()
    };
    format!(
        "render {} --size {}x{} {samples} --depth {depth} --filter {} --method {} --accel {} \
         --sampler {} --seed {} --eye={} --target={} --up={} --fov={}",
        file(scene),
        r.width,
        r.height,
        r.filter,
        r.method,
        r.accel,
        r.sampler,
        r.seed,
        point(c.eye),
        point(c.target),
        point(c.up),
        c.fov
    )
}

/// What to append to the line of a PNG: nothing if it is shown in the usual way.
pub fn tone_options(tone: ToneMap) -> String {
    if tone == ToneMap::default() {
        return String::new();
    }
    tone_words(tone)
}

/// The options of a tone map, each after a space.
pub fn tone_words(tone: ToneMap) -> String {
    let ToneMap {
        exposure,
        offset,
        curve,
    } = tone;
    format!(" --exposure={exposure} --tone {curve} --offset={offset}")
}

/// A file as a word of a POSIX shell that is no option.
pub fn file(path: &Path) -> String {
    let path = path.display().to_string();
    match path.starts_with('-') {
        true => quoted(&format!("./{path}")),
        false => quoted(&path),
    }
}

/// One word of a POSIX shell.
pub fn quoted(word: &str) -> String {
    let is_plain = |c: char| c.is_ascii_alphanumeric() || "_-./:,+=@%".contains(c);
    if !word.is_empty() && word.chars().all(is_plain) {
        return word.to_owned();
    }
    format!("'{}'", word.replace('\'', r"'\''"))
}

#[cfg(test)]
mod tests {
    use super::{file, quoted};

    #[test]
    fn words_are_quoted_where_a_shell_would_touch_them() {
        assert_eq!(
            quoted("builtin:cornell-box.toml"),
            "builtin:cornell-box.toml"
        );
        assert_eq!(quoted("a b/$HOME.obj"), "'a b/$HOME.obj'");
        assert_eq!(quoted("it's"), r"'it'\''s'");
        assert_eq!(file("-a.toml".as_ref()), "./-a.toml");
    }
}
