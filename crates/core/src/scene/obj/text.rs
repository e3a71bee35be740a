//! What OBJ and MTL texts have in common: lines, numbers, files they name, and warnings.

use std::borrow::Cow;
use std::path::{Path, PathBuf};

use crate::scene::error::SceneWarning;

/// Most different warnings that are listed; those beyond are counted together.
const LISTED: usize = 32;

/// Text of a file: a byte order mark is dropped, bytes that are not UTF-8 are replaced.
pub(super) fn decode(bytes: &[u8]) -> Cow<'_, str> {
    String::from_utf8_lossy(bytes.strip_prefix(b"\xEF\xBB\xBF").unwrap_or(bytes))
}

/// Lines with their numbers from 1, trimmed, joined where one ends in a backslash. Lines end in
/// LF, CR LF or CR. A comment is not continued: in practice it ends in a folder name.
pub(super) fn logical_lines(text: &str) -> impl Iterator<Item = (usize, Cow<'_, str>)> {
    let mut lines = text
        .split('\n')
        .flat_map(|line| line.strip_suffix('\r').unwrap_or(line).split('\r'))
        .map(str::trim)
        .zip(1..);
    std::iter::from_fn(move || {
        let (line, number) = lines.next()?;
        let Some(head) = line.strip_suffix('\\').filter(|_| !line.starts_with('#')) else {
            return Some((number, Cow::Borrowed(line)));
        };
        let mut joined = head.to_owned();
        for (line, _) in lines.by_ref() {
            joined.push(' ');
            let head = line.strip_suffix('\\');
            joined.push_str(head.unwrap_or(line));
            if head.is_none() {
                break;
            }
        }
        Some((number, Cow::Owned(joined)))
    })
}

/// The keyword of a line and the rest of it, which for names may hold spaces.
pub(super) fn keyword_and_rest(line: &str) -> (&str, &str) {
    match line.split_once(|c: char| c.is_ascii_whitespace()) {
        Some((keyword, rest)) => (keyword, rest.trim()),
        None => (line, ""),
    }
}

/// Arguments up to a comment.
pub(super) fn arguments(rest: &str) -> impl Iterator<Item = &str> {
    rest.split_ascii_whitespace()
        .take_while(|argument| !argument.starts_with('#'))
}

/// A number, or else what is wrong with it. May be infinite or NaN.
pub(super) fn float(argument: &str) -> Result<f32, String> {
    argument.parse().map_err(|_| {
        let remedy = if argument.contains(',') {
            "; write a decimal point, not a comma, and blanks between numbers"
        } else {
            ""
        };
        format!("{} is not a number{remedy}", quoted(argument))
    })
}

/// A finite number, or else what is wrong with it.
pub(super) fn finite(argument: &str) -> Result<f32, String> {
    match float(argument)? {
        value if value.is_finite() => Ok(value),
        _ => Err(format!(
            "{} is not a finite number of single precision",
            quoted(argument)
        )),
    }
}

/// Foreign text as it may stand in a message: short and on one line.
pub(super) fn quoted(text: &str) -> String {
    const SHOWN: usize = 60;
    let more = if text.chars().nth(SHOWN).is_some() {
        "…"
    } else {
        ""
    };
    let shown: String = text.chars().take(SHOWN).collect();
    format!("\"{}{more}\"", shown.escape_debug())
}

/// A file named in another one of `folder`. Files often come from another machine, so backslashes
/// separate folders too, and a file whose own folder is not here is looked for in `folder`.
pub(super) fn find_file(folder: &Path, name: &str) -> Option<PathBuf> {
    let name = name.trim_matches('"');
    let with_slashes = name.replace('\\', "/");
    let bare = Path::new(&with_slashes).file_name()?;
    [
        folder.join(name),
        folder.join(&with_slashes),
        folder.join(bare),
    ]
    .into_iter()
    .find(|path| path.is_file())
}

/// Warnings, equal ones counted.
#[derive(Default)]
pub(super) struct Warnings {
    listed: Vec<SceneWarning>,
    unlisted: usize,
}

impl Warnings {
    /// Notes what was seen on a line.
    pub(super) fn add(&mut self, path: &Path, line: usize, message: impl Into<String>) {
        self.add_counted(path, line, 1, message);
    }

    /// Notes what was seen `count` times, first on `line`.
    pub(super) fn add_counted(
        &mut self,
        path: &Path,
        line: usize,
        count: usize,
        message: impl Into<String>,
    ) {
        let message = message.into();
        let same = |w: &&mut SceneWarning| w.message == message && w.path == path;
        if let Some(known) = self.listed.iter_mut().find(same) {
            known.count += count;
        } else if self.listed.len() < LISTED {
            let (path, line) = (path.to_owned(), Some(line));
            self.listed.push(SceneWarning {
                path,
                line,
                count,
                message,
            });
        } else {
            self.unlisted += count;
        }
    }

    /// The warnings, in the order in which they first came up.
    pub(super) fn into_list(mut self, path: &Path) -> Vec<SceneWarning> {
        if self.unlisted > 0 {
            self.listed.push(SceneWarning {
                path: path.to_owned(),
                line: None,
                count: self.unlisted,
                message: "further warnings, not listed".into(),
            });
        }
        self.listed
    }
}
