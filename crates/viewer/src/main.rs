//! `lightbox`: the viewer, or a command without a window.

use std::io::{ErrorKind, Write as _};
use std::path::PathBuf;
use std::process::ExitCode;

use clap::Parser as _;
use lightbox::args::{self, Args};
use lightbox::commands::{self, Outcome};
use lightbox_core::simd::Kernel;

fn main() -> ExitCode {
    let args = Args::try_parse().unwrap_or_else(|e| args::exit(e));
    let result = Kernel::wished().and_then(|_| match args.command {
        Some(command) => commands::run(&command),
        None => view(args.scene),
    });
    let told = result.and_then(|outcome| {
        let mut out = std::io::stdout();
        match out
            .write_all(outcome.report.as_bytes())
            .and_then(|()| out.flush())
        {
            // Who reads no further has read what was wanted.
            Err(e) if e.kind() != ErrorKind::BrokenPipe => {
                Err(format!("standard output: cannot be written ({e})"))
            }
            _ => Ok(ExitCode::from(outcome.status)),
        }
    });
    told.unwrap_or_else(|error| {
        // If nobody listens, the status still tells.
        let _ = writeln!(std::io::stderr(), "error: {error}");
        ExitCode::FAILURE
    })
}

fn view(scene: Option<PathBuf>) -> Result<Outcome, String> {
    let scene = scene
        .map(|scene| commands::scene_path(&scene))
        .transpose()?;
    lightbox::app::run(scene)?;
    Ok(Outcome::default())
}
