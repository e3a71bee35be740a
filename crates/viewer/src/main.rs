//! `lightbox`: the viewer, or a command without a window.

use std::io::Write as _;
use std::path::PathBuf;
use std::process::ExitCode;

use clap::Parser as _;
use lightbox::args::{self, Args};
use lightbox::commands::{self, Outcome};
use lightbox_core::simd::Kernel;

fn main() -> ExitCode {
    let told = match Args::try_parse() {
        Ok(args) => run(args),
        Err(e) => args::tell(e),
    };
    told.unwrap_or_else(|error| {
        // If nobody listens, the status still tells.
        let _ = writeln!(std::io::stderr(), "error: {error}");
        ExitCode::FAILURE
    })
}

fn run(args: Args) -> Result<ExitCode, String> {
    Kernel::wished()?;
    let outcome = match args.command {
        Some(command) => commands::run(&command)?,
        None => view(args.scene)?,
    };
    let mut out = std::io::stdout();
    let written = out
        .write_all(outcome.report.as_bytes())
        .and_then(|()| out.flush());
    commands::written(written)?;
    Ok(ExitCode::from(outcome.status))
}

fn view(scene: Option<PathBuf>) -> Result<Outcome, String> {
    let scene = scene
        .map(|scene| commands::scene_path(&scene))
        .transpose()?;
    lightbox::app::run(scene)?;
    Ok(Outcome::default())
}
