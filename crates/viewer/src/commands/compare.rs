//! `lightbox compare`: how far a picture is from a reference.

use lightbox_core::compare::compare;
use lightbox_core::image_io;

use super::{json_line, table};
use crate::args::CompareArgs;

/// Compares two pictures; returns the report. The error is one line.
pub fn run(args: &CompareArgs) -> Result<String, String> {
    let image = image_io::read(&args.image)?;
    let reference = image_io::read(&args.reference)?;
    let comparison =
        compare(&image, &reference).map_err(|e| format!("{}: {e}", args.image.display()))?;
    if args.json {
        return json_line(&comparison);
    }
    let [r, g, b] = comparison.mean_ratio;
    let [x, y] = comparison.worst_pixel;
    Ok(table(&[
        ("relMSE", format!("{:.6e}", comparison.rel_mse)),
        ("RMSE", format!("{:.6e}", comparison.rmse)),
        ("mean ratio", format!("{r:.6} {g:.6} {b:.6}")),
        (
            "worst pixel",
            format!(
                "{x},{y} ({:.1} % of relMSE)",
                100.0 * comparison.worst_share
            ),
        ),
    ]))
}
