//! What can be wrong with input: one line that says where and what to do.

use std::fmt;
use std::path::{Path, PathBuf};

/// A scene, mesh, material or image that cannot be used. Displays as `path:line: message`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SceneError {
    /// The file at fault; empty for text that came from no file.
    pub path: PathBuf,
    /// Line in that file, counted from 1, where one can be named.
    pub line: Option<usize>,
    /// What is wrong and what to write or do instead; one line, no full stop.
    pub message: String,
    /// The part of a description at fault, from which a scene file's reader finds the line.
    pub(crate) place: Option<Place>,
}

/// A value of a [`super::SceneDesc`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Place {
    /// Name of the table in a scene file.
    pub table: &'static str,
    /// Which of an array of tables.
    pub index: usize,
    /// Key in the table.
    pub key: &'static str,
}

/// Something odd that did not stop a scene from loading. Displays as one line.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct SceneWarning {
    /// The file; empty for what came from no file.
    pub path: PathBuf,
    /// First line where it was seen, counted from 1.
    pub line: Option<usize>,
    /// How often it was seen.
    pub count: usize,
    /// What was odd and what was done about it.
    pub message: String,
}

impl SceneError {
    /// An error about a file as a whole.
    pub(crate) fn in_file(path: &Path, message: impl Into<String>) -> Self {
        Self {
            path: path.to_owned(),
            line: None,
            message: message.into(),
            place: None,
        }
    }

    /// An error about one line of a file.
    pub(crate) fn at_line(path: &Path, line: usize, message: impl Into<String>) -> Self {
        Self {
            path: path.to_owned(),
            line: Some(line),
            message: message.into(),
            place: None,
        }
    }
}

impl SceneError {
    /// An error about a value of a description.
    pub(crate) fn at_place(
        table: &'static str,
        index: usize,
        key: &'static str,
        message: impl Into<String>,
    ) -> Self {
        let place = Some(Place { table, index, key });
        Self {
            path: PathBuf::new(),
            line: None,
            message: message.into(),
            place,
        }
    }
}

fn write_place(f: &mut fmt::Formatter<'_>, path: &Path, line: Option<usize>) -> fmt::Result {
    if path.as_os_str().is_empty() {
        return Ok(());
    }
    write!(f, "{}:", path.display())?;
    if let Some(line) = line {
        write!(f, "{line}:")?;
    }
    f.write_str(" ")
}

impl fmt::Display for SceneError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write_place(f, &self.path, self.line)?;
        f.write_str(&self.message)
    }
}

impl std::error::Error for SceneError {}

impl SceneWarning {
    /// A warning about one thing in a description, or about the scene as a whole.
    pub(crate) fn general(message: impl Into<String>) -> Self {
        Self {
            path: PathBuf::new(),
            line: None,
            count: 1,
            message: message.into(),
        }
    }
}

impl fmt::Display for SceneWarning {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write_place(f, &self.path, self.line)?;
        f.write_str(&self.message)?;
        if self.count > 1 {
            write!(f, " ({} times)", self.count)?;
        }
        Ok(())
    }
}
