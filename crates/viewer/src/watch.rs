//! Notices when another program has written a file that the scene was read from.

use std::path::{Path, PathBuf};
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
use std::time::{Duration, SystemTime};

/// How often the files are looked at. One that was written is told of a look later: a program may
/// be in the midst of writing it.
const EVERY: Duration = Duration::from_millis(700);

/// When a file was written last, and its size; `None` if it is not there.
type Stamp = Option<(SystemTime, u64)>;

fn stamp(path: &Path) -> Stamp {
    let meta = std::fs::metadata(path).ok()?;
    Some((meta.modified().ok()?, meta.len()))
}

/// Looks at some files in the background.
pub struct Watch {
    files: Sender<Vec<PathBuf>>,
    changed: Receiver<PathBuf>,
}

impl Watch {
    /// Starts looking, at nothing yet; `wake` is called when a file has changed.
    pub fn new(wake: impl Fn() + Send + 'static) -> Result<Self, String> {
        let (files, wanted) = channel();
        let (told, changed) = channel();
        std::thread::Builder::new()
            .name("lightbox-watch".into())
            .spawn(move || look(&wanted, &told, &wake))
            .map_err(|e| format!("cannot start a thread ({e})"))?;
        Ok(Self { files, changed })
    }

    /// Looks at these files from now on, as they are now.
    pub fn follow(&self, files: Vec<PathBuf>) {
        // Fails only when the thread has panicked: then nothing is noticed.
        let _ = self.files.send(files);
        while self.changed.try_recv().is_ok() {} // Of the files before.
    }

    /// A file that was written since.
    pub fn changed(&self) -> Option<PathBuf> {
        self.changed.try_recv().ok()
    }
}

/// A file, its stamp at the last look, and the stamp that is known of.
type Watched = (PathBuf, Stamp, Stamp);

fn look(wanted: &Receiver<Vec<PathBuf>>, told: &Sender<PathBuf>, wake: &impl Fn()) {
    let mut files: Vec<Watched> = Vec::new();
    loop {
        // Without a file there is nothing to wake up for.
        let next = if files.is_empty() {
            wanted.recv().map_err(|_| RecvTimeoutError::Disconnected)
        } else {
            wanted.recv_timeout(EVERY)
        };
        match next {
            Ok(paths) => {
                let now = |path: PathBuf| {
                    let stamp = stamp(&path);
                    (path, stamp, stamp)
                };
                files = paths.into_iter().map(now).collect();
            }
            Err(RecvTimeoutError::Timeout) => {
                for path in files.iter_mut().filter_map(changed) {
                    let _ = told.send(path); // Fails only when the window has gone.
                    wake();
                }
            }
            Err(RecvTimeoutError::Disconnected) => return,
        }
    }
}

/// Whether a file is another than the known one and was written to its end.
fn changed((path, seen, known): &mut Watched) -> Option<PathBuf> {
    let now = stamp(path);
    let is_still = now == *seen;
    *seen = now;
    // A file that is being replaced is not there for a moment.
    if now.is_none() || !is_still || now == *known {
        return None;
    }
    *known = now;
    Some(path.clone())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_written_file_is_told_of_once_and_when_it_is_whole() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a");
        std::fs::write(&path, "1").unwrap();
        let mut file = (path.clone(), stamp(&path), stamp(&path));
        assert_eq!(changed(&mut file), None);
        std::fs::write(&path, "12").unwrap();
        assert_eq!(changed(&mut file), None, "it may be written still");
        assert_eq!(changed(&mut file), Some(path.clone()));
        assert_eq!(changed(&mut file), None);
        std::fs::remove_file(&path).unwrap();
        assert_eq!([changed(&mut file), changed(&mut file)], [None, None]);
        std::fs::write(&path, "123").unwrap();
        assert_eq!(changed(&mut file), None);
        assert_eq!(changed(&mut file), Some(path));
    }
}
