//! Acceptance tests of the command line, on the binary itself.

mod advise;
mod checkpoint;
#[cfg(target_os = "linux")]
mod interrupt;
mod parts;
mod pictures;
mod race;
mod refusals;
mod reports;
mod stops;
#[cfg(unix)]
mod submit;

use std::ffi::OsStr;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use lightbox_core::Image;
use serde_json::Value;
use tempfile::TempDir;

fn lightbox() -> Command {
    Command::new(env!("CARGO_BIN_EXE_lightbox"))
}

fn run<S: AsRef<OsStr>>(args: impl IntoIterator<Item = S>) -> Output {
    lightbox().args(args).output().expect("the binary starts")
}

fn stderr(output: &Output) -> String {
    String::from_utf8(output.stderr.clone()).expect("UTF-8")
}

fn stdout(output: &Output) -> String {
    String::from_utf8(output.stdout.clone()).expect("UTF-8")
}

/// Standard output of a run that succeeds.
fn ok<S: AsRef<OsStr>>(args: impl IntoIterator<Item = S>) -> String {
    let output = run(args);
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    stdout(&output)
}

/// The one JSON object that a run prints.
fn json<S: AsRef<OsStr>>(args: impl IntoIterator<Item = S>) -> Value {
    let text = ok(args);
    assert_eq!(text.lines().count(), 1, "{text}");
    serde_json::from_str(&text).unwrap_or_else(|e| panic!("{e}: {text}"))
}

/// `lightbox render` of a shipped scene with the words of `options`.
fn render(scene: &str, options: &str, output: &Path) -> Value {
    let options = options.split_whitespace().map(OsStr::new);
    json(
        ["render", scene]
            .map(OsStr::new)
            .into_iter()
            .chain(options)
            .chain(["--json".as_ref(), "-o".as_ref(), output.as_os_str()]),
    )
}

/// A picture's bits, so that NaN compares too.
fn bits(image: &Image) -> Vec<[u32; 3]> {
    image
        .pixels
        .iter()
        .map(|p| p.to_array().map(f32::to_bits))
        .collect()
}

struct Folder(TempDir);

impl Folder {
    fn new() -> Self {
        Self(TempDir::new().expect("a folder for the test"))
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    fn write(&self, name: &str, text: &str) -> PathBuf {
        let path = self.path(name);
        std::fs::write(&path, text).expect("a file for the test");
        path
    }

    fn files(&self) -> Vec<String> {
        let entries = std::fs::read_dir(self.0.path()).expect("the folder");
        let mut names: Vec<_> = entries
            .map(|entry| entry.expect("an entry").file_name())
            .map(|name| name.into_string().expect("UTF-8"))
            .collect();
        names.sort();
        names
    }
}

/// The text beside a picture's pixels begins with the replay line.
fn replay_line(path: &Path) -> String {
    text(path).lines().next().expect("a line").to_owned()
}

/// The text in a PNG, from its iTXt chunk, or of an EXR, from its attribute.
fn text(path: &Path) -> String {
    let bytes = std::fs::read(path).expect("a picture");
    let between = |start: usize, length: usize| {
        String::from_utf8(bytes[start..][..length].to_vec()).expect("UTF-8")
    };
    let find = |needle: &[u8]| {
        bytes
            .windows(needle.len())
            .position(|w| w == needle)
            .expect("metadata")
    };
    if path.extension().is_some_and(|e| e == "png") {
        let chunk = find(b"iTXtlightbox\0");
        let length = bytes[chunk - 4..chunk].try_into().expect("4 bytes");
        let length = u32::from_be_bytes(length) as usize;
        // Key, compression flag and method, language, translated key; each text ends with a zero.
        let head = b"lightbox\0\0\0\0\0".len();
        between(chunk + 4 + head, length - head)
    } else {
        let head = b"lightbox\0string\0";
        let size = find(head) + head.len();
        let length = bytes[size..size + 4].try_into().expect("4 bytes");
        let length = u32::from_le_bytes(length) as usize;
        between(size + 4, length)
    }
}

/// Runs a replay line in a shell.
fn replay(line: &str, output: &Path) {
    let words = line
        .strip_prefix("lightbox ")
        .expect("the line begins with the program's name");
    let script = format!("\"$0\" {words} -o \"$1\"");
    let replay = Command::new("sh")
        .args(["-c", &script, env!("CARGO_BIN_EXE_lightbox")])
        .arg(output)
        .output()
        .expect("a shell");
    assert!(replay.status.success(), "{line}\n{}", stderr(&replay));
}

const TRIANGLE: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
