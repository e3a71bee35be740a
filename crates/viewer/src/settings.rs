//! What is remembered from one start to the next, beside what egui remembers by itself: the window's
//! place, widths, folded sections, theme and scale.

use std::path::{Path, PathBuf};

use lightbox_core::scene::BUILTIN;
use serde::{Deserialize, Serialize};

use crate::bookmarks::Bookmarks;

/// Most files that are remembered.
const FILES: usize = 10;

/// Key in eframe's storage.
const KEY: &str = "lightbox";

/// What is remembered.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct Settings {
    /// Files opened last, the newest first.
    pub files: Vec<Remembered>,
    /// Whether the user has moved the camera once: then there is no need to say how.
    pub is_acquainted: bool,
    /// Whether the error chart is open.
    pub is_chart_open: bool,
    /// Whether the plan is open.
    pub is_plan_open: bool,
    /// Whether orbits go over the poles.
    pub free_orbit: bool,
    /// Threads that trace; 0: as many as is usual.
    pub threads: usize,
}

/// A file, and what belongs to it.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct Remembered {
    /// Absolute.
    pub path: PathBuf,
    /// Places of the camera to go back to.
    pub bookmarks: Bookmarks,
}

impl Settings {
    /// Those of the last time, or none.
    pub fn load(storage: Option<&dyn eframe::Storage>) -> Self {
        storage
            .and_then(|storage| eframe::get_value(storage, KEY))
            .unwrap_or_default()
    }

    /// Keeps them for the next time.
    pub fn store(&self, storage: &mut dyn eframe::Storage) {
        eframe::set_value(storage, KEY, self);
    }

    /// Puts a file first; the bookmarks that it has.
    pub fn opened(&mut self, path: &Path) -> Bookmarks {
        let path = absolute(path);
        let known = self.files.iter().position(|f| f.path == path);
        let file = known.map(|i| self.files.remove(i)).unwrap_or(Remembered {
            path,
            ..Remembered::default()
        });
        let bookmarks = file.bookmarks;
        self.files.insert(0, file);
        self.files.truncate(FILES);
        bookmarks
    }

    /// Takes down the bookmarks of the file that is open.
    pub fn keep(&mut self, bookmarks: Bookmarks) {
        if let Some(file) = self.files.first_mut() {
            file.bookmarks = bookmarks;
        }
    }

    /// Files on disk that were open before the one that is.
    pub fn recent(&self) -> impl Iterator<Item = &Path> {
        let before = self.files.iter().skip(1).map(|f| f.path.as_path());
        before.filter(|path| !is_builtin(path))
    }
}

fn is_builtin(path: &Path) -> bool {
    BUILTIN.iter().any(|name| path == Path::new(name))
}

/// Names of what is built in stay what they are.
fn absolute(path: &Path) -> PathBuf {
    if is_builtin(path) {
        return path.to_owned();
    }
    std::path::absolute(path).unwrap_or_else(|_| path.to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_newest_files_come_first_and_keep_their_bookmarks() {
        let mut settings = Settings::default();
        let set = |digit| {
            let mut bookmarks = Bookmarks::default();
            bookmarks.set(digit, &Default::default());
            bookmarks
        };
        settings.opened(Path::new("/a.toml"));
        settings.keep(set(3));
        settings.opened(Path::new(BUILTIN[0]));
        settings.keep(set(4));
        assert_eq!(settings.opened(Path::new("/b.obj")), Bookmarks::default());
        assert_eq!(
            settings.recent().collect::<Vec<_>>(),
            [Path::new("/a.toml")]
        );
        assert_eq!(settings.opened(Path::new("/a.toml")), set(3));
        assert_eq!(settings.opened(Path::new(BUILTIN[0])), set(4));
        let recent: Vec<_> = settings.recent().collect();
        assert_eq!(recent, [Path::new("/a.toml"), Path::new("/b.obj")]);
        for i in 0..30 {
            settings.opened(Path::new(&format!("/{i}.toml")));
        }
        assert_eq!(settings.recent().count(), FILES - 1);
    }
}
