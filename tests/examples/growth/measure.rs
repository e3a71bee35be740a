//! Running the program and measuring a whole process of it.

use std::fs;
use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::Instant;

use crate::sizes::Size;

/// What a process has cost.
#[derive(Clone, Copy, Debug)]
pub struct Cost {
    /// From start to end, seconds.
    pub wall: f64,
    /// Of the processors, seconds.
    pub cpu: f64,
    /// Most memory at a time, bytes.
    pub memory: f64,
}

/// Runs of some size, each with what it has cost.
pub type Runs = Vec<(Size, Cost)>;

/// The program beside this one.
pub fn program() -> Result<PathBuf, String> {
    let here = std::env::current_exe().map_err(|e| e.to_string())?;
    let folder = here.ancestors().nth(2).unwrap_or(Path::new("."));
    let program = folder.join("lightbox");
    if program.exists() {
        return Ok(program);
    }
    let missing = program.display();
    Err(format!("{missing}: is missing; cargo build --release"))
}

/// The scene with so many triangles, as a file in a folder.
fn scene(size: &Size, folder: &Path) -> Result<PathBuf, String> {
    let path = folder.join(format!("{}.toml", size.triangles));
    let million = lightbox_tests::scenes_folder().join("million.toml");
    let text = fs::read_to_string(million).map_err(|e| e.to_string())?;
    let text = text.replace("1_000_000", &size.triangles.to_string());
    fs::write(&path, text).map_err(|e| e.to_string())?;
    Ok(path)
}

/// Renders a picture of some size with a process of its own.
pub fn run(program: &Path, size: &Size) -> Result<Cost, String> {
    let folder = tempfile::tempdir().map_err(|e| e.to_string())?;
    let [told, picture] = ["told", "a.exr"].map(|name| folder.path().join(name));
    let mut command = Command::new("/usr/bin/time");
    command.args(["--quiet", "-f", "%U %S %M", "-o"]).arg(&told);
    command.arg(program).arg("render");
    command.arg(scene(size, folder.path())?);
    let Size {
        width,
        height,
        samples,
        threads,
        ..
    } = size;
    for (option, value) in [
        ("--size", format!("{width}x{height}")),
        ("--spp", samples.to_string()),
        ("--threads", threads.to_string()),
    ] {
        command.arg(option).arg(value);
    }
    command.arg("-o").arg(picture).stdout(Stdio::null());
    let start = Instant::now();
    let status = command
        .status()
        .map_err(|e| format!("/usr/bin/time cannot be run ({e}); install GNU time"))?;
    let wall = start.elapsed().as_secs_f64();
    let told = fs::read_to_string(&told).map_err(|e| e.to_string())?;
    let told: Vec<f64> = told
        .split_whitespace()
        .filter_map(|x| x.parse().ok())
        .collect();
    match *told {
        [user, system, kilobytes] if status.success() => Ok(Cost {
            wall,
            cpu: user + system,
            memory: 1024.0 * kilobytes,
        }),
        _ => Err(format!("{size}: the render has failed")),
    }
}

/// Adds a run to a file of all of them.
pub fn keep(path: &Path, size: &Size, cost: &Cost) -> Result<(), String> {
    let mut file = fs::OpenOptions::new();
    let file = file.append(true).create(true).open(path);
    let mut file = file.map_err(|e| format!("{}: {e}", path.display()))?;
    let Size {
        width,
        height,
        samples,
        triangles,
        threads,
    } = size;
    let Cost { wall, cpu, memory } = cost;
    let line =
        format!("{width},{height},{samples},{triangles},{threads},{wall:.3},{cpu:.2},{memory}\n");
    file.write_all(line.as_bytes()).map_err(|e| e.to_string())
}

/// The least of all runs of a size: what other programs have added to it is least there.
pub fn least(path: &Path, size: &Size) -> Result<Option<Cost>, String> {
    let text = fs::read_to_string(path).map_err(|e| format!("{}: {e}", path.display()))?;
    let runs = text.lines().filter_map(|line| {
        let numbers: Vec<f64> = line.split(',').filter_map(|x| x.parse().ok()).collect();
        let (of, cost) = numbers.split_at_checked(5)?;
        let same = of
            .iter()
            .zip(size.numbers())
            .all(|(a, b)| *a == f64::from(b));
        let &[wall, cpu, memory] = cost else {
            return None;
        };
        same.then_some(Cost { wall, cpu, memory })
    });
    Ok(runs.reduce(|a, b| Cost {
        wall: a.wall.min(b.wall),
        cpu: a.cpu.min(b.cpu),
        memory: a.memory.min(b.memory),
    }))
}
