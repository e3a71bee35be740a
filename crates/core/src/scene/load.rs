//! From files to descriptions: TOML scenes, bare OBJ meshes and the built-in scenes.

use std::borrow::Cow;
use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use serde::Deserialize;
use toml::de::{DeTable, DeValue};

use super::builtin;
use super::check::check;
use super::desc::{MeshDesc, SceneDesc};
use super::error::{SceneError, SceneWarning};
use super::obj::ObjMesh;
use super::rewrite::rewritten;
use super::{MeshCache, Scene, Watcher, stage};
use crate::image_io::write_aside;

/// A description with the file it came from.
#[derive(Clone, Debug)]
pub struct Source {
    /// The description as read.
    pub desc: SceneDesc,
    /// The file, or a built-in scene's name; what paths in the description are relative to.
    pub path: PathBuf,
    /// Text of a TOML file, to find lines in.
    text: Option<String>,
    /// Meshes that had to be read already.
    meshes: MeshCache,
}

/// Reads a scene file (TOML), an OBJ mesh, or a built-in scene by its name. A mesh with lights of
/// its own is shown as it is; any other is put into a box under a light.
pub fn load(path: &Path) -> Result<Source, SceneError> {
    let is_obj = path
        .extension()
        .is_some_and(|e| e.eq_ignore_ascii_case("obj"));
    if is_obj {
        let mesh = Arc::new(read_mesh(path)?);
        let file = path.file_name().map(PathBuf::from);
        let desc = stage::around_mesh(
            &mesh,
            MeshDesc {
                file,
                ..stage::mesh_desc(path)
            },
        );
        let mut meshes = MeshCache::default();
        meshes.insert(&desc.meshes[0], mesh);
        return Ok(Source {
            desc,
            path: path.to_owned(),
            text: None,
            meshes,
        });
    }
    let bytes = read(path)?;
    let text = String::from_utf8(bytes.into_owned()).map_err(|_| {
        SceneError::in_file(
            path,
            "is neither a TOML scene (not UTF-8 text) nor named *.obj",
        )
    })?;
    let desc = parse(&text, path)?;
    Ok(Source {
        desc,
        path: path.to_owned(),
        text: Some(text),
        meshes: MeshCache::default(),
    })
}

impl Source {
    /// A description that came from no file; `path` is what its paths are relative to.
    pub fn from_desc(desc: SceneDesc, path: &Path) -> Self {
        Self {
            desc,
            path: path.to_owned(),
            text: None,
            meshes: MeshCache::default(),
        }
    }

    /// Builds the scene as described; the watcher is told what is being done.
    pub fn build(&self, watcher: Watcher<'_>) -> Result<Scene, SceneError> {
        self.build_edited(self.desc.clone(), watcher)
    }

    /// Builds the scene from an edited description of the same file.
    pub fn build_edited(&self, desc: SceneDesc, watcher: Watcher<'_>) -> Result<Scene, SceneError> {
        let textures = super::assemble::Textures::default();
        Scene::build(desc, &self.path, &self.meshes, textures, watcher).map_err(|e| self.locate(e))
    }

    /// Gives an error about a value its file and line.
    fn locate(&self, mut error: SceneError) -> SceneError {
        if let (Some(place), true) = (error.place, error.path.as_os_str().is_empty()) {
            error.path.clone_from(&self.path);
            let text = self.text.as_deref().unwrap_or_default();
            if let Ok(table) = DeTable::parse(text) {
                let table = table.get_ref();
                let value = if place.table.is_empty() {
                    table.get(place.key)
                } else {
                    table.get(place.table)
                };
                let value = match value.map(|v| (v, v.get_ref())) {
                    Some((_, DeValue::Array(tables))) if !place.table.is_empty() => {
                        tables.get(place.index)
                    }
                    other => other.map(|(v, _)| v),
                };
                let value = match value.map(|v| v.get_ref()) {
                    Some(DeValue::Table(table)) => table.get(place.key).or(value),
                    _ => value,
                };
                error.line = value.map(|v| line_of(text, v.span().start));
            }
        }
        error
    }
}

/// Line number, from 1, of a byte.
fn line_of(text: &str, byte: usize) -> usize {
    1 + text.bytes().take(byte).filter(|b| *b == b'\n').count()
}

/// Writes a scene file that reads back as this description, whole or not at all: not if nothing could read it
/// back either. The error is one line. `from` is the file that the description came from: relative to it are the files that are
/// named, and if it is a scene file, what was not edited stays as it is written there, comments
/// included.
pub fn save(path: &Path, desc: &SceneDesc, from: &Path) -> Result<(), String> {
    let cannot = |why: &dyn std::fmt::Display| {
        format!("{}: the scene cannot be written ({why})", path.display())
    };
    check(desc).map_err(|e| {
        let path = path.display();
        format!(
            "{path}: not written, as it could not be read again: {}",
            e.message
        )
    })?;
    let folder = |path: &Path| builtin::absolute(path.with_file_name(""));
    let desc = if folder(path) == folder(from) {
        desc.clone()
    } else {
        desc.detached(from)
    };
    let is_scene = from.extension().is_some_and(|e| e == "toml");
    let bytes = is_scene.then(|| read(from).ok()).flatten();
    let text = bytes.and_then(|bytes| rewritten(std::str::from_utf8(&bytes).ok()?, &desc));
    let text = match text {
        Some(text) => text,
        None => toml::to_string(&desc).map_err(|e| cannot(&e))?,
    };
    write_aside(path, |file| {
        file.write_all(text.as_bytes()).map_err(|e| cannot(&e))
    })
}

/// Parses a TOML scene; `path` is for messages.
pub fn parse(text: &str, path: &Path) -> Result<SceneDesc, SceneError> {
    let error = |e: toml::de::Error| {
        let message = remedy(e.message());
        match e.span() {
            Some(span) => SceneError::at_line(path, line_of(text, span.start), message),
            None => SceneError::in_file(path, message),
        }
    };
    let document = toml::Deserializer::parse(text).map_err(error)?;
    SceneDesc::deserialize(document).map_err(error)
}

const WHOLE: &str = "expected a whole number from 0 on that is not too large";

/// One line out of serde's words, with the nearest right name where a name is wrong.
fn remedy(message: &str) -> String {
    let line = message.lines().collect::<Vec<_>>().join(" ");
    // Types of the program are no words of a scene file.
    let line = [
        (
            "a sequence of 3 f32 values",
            "three numbers, as in [1, 0.5, 0]",
        ),
        ("expected f32", "expected a number"),
        ("expected u32", WHOLE),
        ("expected u64", WHOLE),
        ("struct RenderSettings", "a table, [render]"),
        ("struct CameraDesc", "a table, [camera]"),
    ]
    .iter()
    .fold(line, |line, (from, to)| line.replace(from, to));
    let (Some(rest), Some((_, expected))) = (
        line.strip_prefix("unknown field `"),
        line.split_once("expected "),
    ) else {
        return line;
    };
    let field = rest.split('`').next().unwrap_or_default();
    let names: Vec<&str> = expected.split('`').skip(1).step_by(2).collect();
    format!("unknown key \"{field}\"{}", suggest_key(field, &names))
}

fn suggest_key(field: &str, names: &[&str]) -> String {
    crate::suggest::among(field, names)
}

/// The bytes of a file or of a built-in one.
pub(super) fn read(path: &Path) -> Result<Cow<'static, [u8]>, SceneError> {
    if let Some(bytes) = builtin::get(path) {
        return Ok(Cow::Borrowed(bytes));
    }
    std::fs::read(path)
        .map(Cow::Owned)
        .map_err(|e| SceneError::in_file(path, cannot_read(&e)))
}

fn cannot_read(e: &std::io::Error) -> String {
    match e.kind() {
        std::io::ErrorKind::NotFound => "no such file; check the path".into(),
        std::io::ErrorKind::IsADirectory => {
            "is a folder; name a .toml scene or an .obj mesh in it".into()
        }
        _ => format!("cannot be read ({e})"),
    }
}

/// Reads an OBJ mesh or a built-in one.
pub(super) fn read_mesh(path: &Path) -> Result<ObjMesh, SceneError> {
    super::obj::parse(&read(path)?, path)
}

impl Source {
    /// What was odd in the files read so far.
    pub fn warnings(&self) -> Vec<SceneWarning> {
        self.meshes
            .iter()
            .flat_map(|mesh| mesh.warnings.iter().cloned())
            .collect()
    }
}
