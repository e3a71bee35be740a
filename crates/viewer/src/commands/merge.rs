//! `lightbox merge`: from parts to a picture, or to a larger part.

use std::borrow::Cow;

use lightbox_core::film::Lost;
use lightbox_core::image_io::{self, Format};
use lightbox_core::part::{self, Parts};
use serde::Serialize;

use super::{json_line, print_invalid};
use crate::args::MergeArgs;
use crate::{replay, saved};

/// The report of `--json`.
#[derive(Serialize)]
struct Report<'a> {
    output: Cow<'a, str>,
    parts: usize,
    width: u32,
    height: u32,
    /// Runs of sample indices: the first, and the one after the last.
    samples: Vec<[u64; 2]>,
    spp: u64,
    paths: u64,
    rays: u64,
    /// Of tracing, in all parts together.
    seconds: f64,
    noise: Option<f64>,
    invalid_samples: u64,
    /// Light that the depth leaves out.
    lost_to_depth: Option<Lost>,
}

/// Adds parts up and writes the sum. The report is one line, as is the error.
pub fn run(args: &MergeArgs) -> Result<String, String> {
    let output = &args.output;
    let sum = if part::is_part(output) {
        part::check_writable(output)?;
        Parts::open(&args.parts)?.write(output)?
    } else {
        if Format::of(output).is_err() {
            return Err(format!(
                "{}: unknown kind of file; name it *.png, *.exr or *.part",
                output.display()
            ));
        }
        image_io::check_writable(output)?;
        let (sum, image) = Parts::open(&args.parts)?.develop()?;
        // As `render` writes it.
        let (head, samples) = (&sum.head, sum.head.samples_per_pixel());
        let mut line = replay::line(&head.path, &head.scene, samples);
        line += &replay::tone_options(head.tone);
        let text = saved::text(&line, head.scene.clone(), samples, &head.path, head.tone);
        image_io::write(output, &image, head.tone, &text)?;
        sum
    };
    let (invalid_samples, places) = &sum.invalid;
    print_invalid(*invalid_samples, places);
    let settings = sum.head.scene.render;
    let report = Report {
        output: output.to_string_lossy(),
        parts: args.parts.len(),
        width: settings.width,
        height: settings.height,
        samples: sum.head.samples().map(|run| [run.start, run.end]).collect(),
        spp: sum.head.samples_per_pixel(),
        paths: sum.paths,
        rays: sum.rays,
        seconds: sum.head.seconds,
        noise: sum.error.map(|e| e.noise()),
        invalid_samples: *invalid_samples,
        lost_to_depth: sum.error.and_then(|e| sum.light.lost(e.mean)),
    };
    if args.json {
        return json_line(&report);
    }
    let Report {
        output,
        parts,
        width,
        height,
        spp,
        seconds,
        ..
    } = &report;
    let parts = match parts {
        1 => "1 part".to_owned(),
        n => format!("{n} parts"),
    };
    let noise = report
        .noise
        .map(|noise| format!(", noise {noise:.3e}"))
        .unwrap_or_default();
    Ok(format!(
        "{output}: {width}x{height}, {spp} spp of {parts}, traced in {seconds:.2} s{noise}\n"
    ))
}
