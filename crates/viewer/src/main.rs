//! `lightbox`: the viewer, or a command without a window.

use std::io::Write as _;
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
    let (line, status) = match result {
        Ok(Outcome { report, status }) => (report, ExitCode::from(status)),
        Err(error) => {
            // If nobody listens, the status still tells.
            let _ = writeln!(std::io::stderr(), "error: {error}");
            (String::new(), ExitCode::FAILURE)
        }
    };
    let _ = std::io::stdout().write_all(line.as_bytes());
    status
}

fn view(scene: Option<PathBuf>) -> Result<Outcome, String> {
    let scene = scene
        .map(|scene| commands::scene_path(&scene))
        .transpose()?;
    lightbox::app::run(scene)?;
    Ok(Outcome::default())
}
