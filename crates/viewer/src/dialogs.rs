//! Native file dialogs, each on a thread of its own: the window goes on meanwhile.

use std::path::{Path, PathBuf};
use std::sync::mpsc::{Receiver, Sender, channel};
use std::time::{Duration, Instant};

use lightbox_core::math::Aabb;
use lightbox_core::scene::obj;

/// An answer that comes sooner than this was not given by a person.
const TOO_SOON: Duration = Duration::from_millis(150);

/// Extensions of files that can be opened: scenes, meshes, saved pictures, kept samples.
pub const OPENS: [&str; 5] = ["toml", "obj", "png", "exr", "part"];

/// How a dialog ended.
#[derive(Clone, Debug, PartialEq)]
pub enum Answer {
    /// Open this.
    Open(PathBuf),
    /// Save under this name.
    Save(PathBuf),
    /// Add this mesh, around which is this box.
    Mesh(PathBuf, Aabb),
    /// Compare with this.
    Reference(PathBuf),
    /// Save a race in this folder.
    Race(PathBuf),
    /// The user thought better of it.
    Cancelled,
    /// What was chosen cannot be used, or the desktop has no dialog to offer: one line that says what
    /// to do instead.
    Unavailable(String),
}

/// At most one dialog, and its answer.
pub struct Dialogs {
    answers: Receiver<Answer>,
    sender: Sender<Answer>,
    is_open: bool,
}

impl Default for Dialogs {
    fn default() -> Self {
        let (sender, answers) = channel();
        Self {
            answers,
            sender,
            is_open: false,
        }
    }
}

impl Dialogs {
    /// Asks for a file to open.
    pub fn open(&mut self, ctx: &egui::Context) {
        let dialog = rfd::FileDialog::new()
            .set_title("Open a scene, a mesh or a saved picture")
            .add_filter("scenes, meshes and saved pictures", &OPENS);
        let without = Answer::Unavailable(
            "no file dialog answered; drop the file on this window, or start with `lightbox FILE`"
                .into(),
        );
        self.ask(ctx, without, move || dialog.pick_file().map(Answer::Open));
    }

    /// Asks for a mesh to add to the scene.
    pub fn mesh(&mut self, ctx: &egui::Context) {
        let dialog = rfd::FileDialog::new()
            .set_title("Add a mesh to the scene")
            .add_filter("meshes", &["obj"]);
        let without = Answer::Unavailable(
            "no file dialog answered; write [[mesh]] with file = \"….obj\" into the scene file"
                .into(),
        );
        self.ask(ctx, without, move || dialog.pick_file().map(measured));
    }

    /// Measures a mesh file that is to be added: it may be large.
    pub fn measure(&mut self, ctx: &egui::Context, file: PathBuf) {
        let (sender, ctx) = (self.sender.clone(), ctx.clone());
        let run = move || {
            let _ = sender.send(measured(file)); // Fails only when the window has gone.
            ctx.request_repaint();
        };
        let thread = std::thread::Builder::new().name("lightbox-measure".into());
        if let Err(e) = thread.spawn(run) {
            let text = format!("cannot start a thread ({e})");
            let _ = self.sender.send(Answer::Unavailable(text));
        }
    }

    /// Asks for a picture to compare with.
    pub fn reference(&mut self, ctx: &egui::Context) {
        let dialog = rfd::FileDialog::new()
            .set_title("Compare with a picture that counts as right")
            .add_filter("linear light", &["exr"]);
        let without = Answer::Unavailable(
            "no file dialog answered; keep a long render of this picture as the reference instead"
                .into(),
        );
        self.ask(ctx, without, move || {
            dialog.pick_file().map(Answer::Reference)
        });
    }

    /// Asks where to save a file; `extension` is added to a name without one. On a desktop without
    /// dialogs the file goes to the folder that lightbox was started in.
    pub fn save(&mut self, ctx: &egui::Context, name: &str, extension: &'static str) {
        let title = match extension {
            "toml" => "Save the scene",
            "part" => "Save the samples",
            _ => "Save the picture",
        };
        let dialog = rfd::FileDialog::new()
            .set_title(title)
            .set_file_name(name)
            .add_filter(extension, &[extension]);
        let without = Answer::Save(free_path(
            &std::env::current_dir().unwrap_or_default(),
            name,
        ));
        let named = move |path: PathBuf| {
            if path.extension().is_some() {
                path
            } else {
                path.with_extension(extension)
            }
        };
        self.ask(ctx, without, move || {
            dialog.save_file().map(|path| Answer::Save(named(path)))
        });
    }

    /// Asks for the folder that the files of a race go to. On a desktop without dialogs it is a new
    /// one, where lightbox was started.
    pub fn race(&mut self, ctx: &egui::Context) {
        let dialog = rfd::FileDialog::new().set_title("Save chart, table and maps in a folder");
        let without = Answer::Race(free_path(
            &std::env::current_dir().unwrap_or_default(),
            "race",
        ));
        self.ask(ctx, without, move || dialog.pick_folder().map(Answer::Race));
    }

    fn ask(
        &mut self,
        ctx: &egui::Context,
        without: Answer,
        dialog: impl FnOnce() -> Option<Answer> + Send + 'static,
    ) {
        if self.is_open {
            return;
        }
        let (sender, ctx) = (self.sender.clone(), ctx.clone());
        let run = move || {
            let start = Instant::now();
            let can_ask = can_ask();
            let answer = can_ask.then(dialog).flatten().unwrap_or_else(|| {
                if !can_ask || start.elapsed() < TOO_SOON {
                    without
                } else {
                    Answer::Cancelled
                }
            });
            // Fails only when the window has gone.
            let _ = sender.send(answer);
            ctx.request_repaint();
        };
        self.is_open = std::thread::Builder::new()
            .name("lightbox-dialog".into())
            .spawn(run)
            .is_ok();
    }

    /// Whether one waits to be answered.
    pub fn is_open(&self) -> bool {
        self.is_open
    }

    /// The answer, once there is one.
    pub fn answer(&mut self) -> Option<Answer> {
        let answer = self.answers.try_recv().ok()?;
        self.is_open = false;
        Some(answer)
    }
}

/// The box around a mesh file, or why there is none.
fn measured(file: PathBuf) -> Answer {
    match obj::load(&file) {
        Ok(mesh) => Answer::Mesh(file, mesh.bounds()),
        Err(e) => Answer::Unavailable(e.to_string()),
    }
}

/// Whether the desktop has anything that shows file dialogs: on Linux a session bus, on which a
/// portal may be, or zenity.
fn can_ask() -> bool {
    if cfg!(not(target_os = "linux")) {
        return true;
    }
    let variable = |name| std::env::var_os(name).filter(|value| !value.is_empty());
    let bus =
        variable("XDG_RUNTIME_DIR").is_some_and(|folder| Path::new(&folder).join("bus").exists());
    let zenity = variable("PATH").is_some_and(|path| {
        std::env::split_paths(&path).any(|folder| folder.join("zenity").exists())
    });
    variable("DBUS_SESSION_BUS_ADDRESS").is_some() || bus || zenity
}

/// The name in a folder, numbered if it is taken: nobody has agreed to overwrite a file.
fn free_path(folder: &Path, name: &str) -> PathBuf {
    let (stem, extension) = name.split_at(name.rfind('.').unwrap_or(name.len()));
    let numbered = (2..).map(|i| format!("{stem}-{i}{extension}"));
    let mut paths = std::iter::once(name.to_owned())
        .chain(numbered)
        .map(|name| folder.join(name));
    paths.find(|path| !path.exists()).unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_are_not_overwritten_unasked() {
        let folder = tempfile::tempdir().unwrap();
        for names in [
            ["a.b.png", "a.b-2.png", "a.b-3.png"],
            ["race", "race-2", "race-3"],
        ] {
            for expected in names {
                let path = free_path(folder.path(), names[0]);
                assert_eq!(path, folder.path().join(expected));
                std::fs::write(path, "").unwrap();
            }
        }
    }
}
