//! Renders a scene to a picture with the library, and tells how far it is and how noisy.
//!
//! `cargo run --release -p lightbox-core --example picture -- [SCENE [FILE.png]]`

use std::ops::ControlFlow;
use std::path::PathBuf;
use std::process::ExitCode;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use lightbox_core::color::ToneMap;
use lightbox_core::scene::{BUILTIN, load};
use lightbox_core::{View, image_io};

fn main() -> ExitCode {
    match run() {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::FAILURE
        }
    }
}

fn run() -> Result<(), String> {
    let mut args = std::env::args_os().skip(1).map(PathBuf::from);
    let path = args.next().unwrap_or_else(|| BUILTIN[0].into());
    let output = args.next().unwrap_or_else(|| "picture.png".into());
    image_io::check_writable(&output)?;

    // What the file says can be changed before it is built into a scene.
    let mut source = load(&path).map_err(|e| e.to_string())?;
    (source.desc.render.width, source.desc.render.height) = (256, 256);
    let scene = source.build(&|phase| {
        eprintln!("{phase:?}");
        ControlFlow::Continue(())
    });
    let view = View::of(Arc::new(scene.map_err(|e| e.to_string())?))?;

    // A film goes on from where it is; the steps do not change a bit of the picture.
    let (film, samples) = (view.film(), view.settings.samples);
    let cancel = AtomicBool::new(false);
    while film.samples() < samples {
        let work = view.render(&film, (film.samples() + 32).min(samples), &cancel);
        let (done, rays) = (film.samples(), work.rays);
        let error = film.error().map_or(f64::NAN, |error| error.noise());
        let percent = 100.0 * error;
        eprintln!("{done} of {samples} samples per pixel, {rays} more rays: error {percent:.1} %");
    }
    image_io::write(&output, &film.develop(), ToneMap::default(), "")
}
