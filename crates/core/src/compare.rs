//! How far apart two pictures are.

use glam::{DVec3, Vec3};
use serde::Serialize;

use crate::film::Image;

/// Differences of an image from a reference.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[non_exhaustive]
pub struct Comparison {
    /// Mean over pixels and channels of (x−ref)²/(ref²+0.01).
    #[serde(rename = "relMSE")]
    pub rel_mse: f64,
    /// Root of the mean squared difference.
    pub rmse: f64,
    /// Mean of the image over mean of the reference, per channel.
    pub mean_ratio: [f64; 3],
    /// The pixel with the largest relative squared error, from the upper left.
    pub worst_pixel: [u32; 2],
    /// Its share of `rel_mse`, in [0, 1].
    pub worst_share: f64,
}

/// Relative squared error of a pixel, added up over its channels: (x−ref)²/(ref²+0.01).
pub fn relative_square(x: Vec3, reference: Vec3) -> f64 {
    let (x, r) = (x.as_dvec3(), reference.as_dvec3());
    let d = x - r;
    (d * d / (r * r + 0.01)).element_sum()
}

/// Whether a reference can be compared with pictures of some width and height; the error is one
/// line.
pub fn check_size([width, height]: [u32; 2], reference: &Image) -> Result<(), String> {
    if [width, height] == [reference.width, reference.height] {
        return Ok(());
    }
    Err(format!(
        "the image is {width}x{height} but the reference {}x{}; render both at one size",
        reference.width, reference.height
    ))
}

/// Compares two images of one size; the error is one line.
pub fn compare(image: &Image, reference: &Image) -> Result<Comparison, String> {
    check_size([image.width, image.height], reference)?;
    let (mut relative, mut square) = (0.0, 0.0);
    let (mut sum, mut reference_sum) = (DVec3::ZERO, DVec3::ZERO);
    let mut worst = (0, 0.0);
    for (i, (x, r)) in image.pixels.iter().zip(&reference.pixels).enumerate() {
        let pixel = relative_square(*x, *r);
        let (x, r) = (x.as_dvec3(), r.as_dvec3());
        relative += pixel;
        square += (x - r).length_squared();
        sum += x;
        reference_sum += r;
        // Not a number is worst of all.
        if !(pixel <= worst.1) {
            worst = (i, pixel);
        }
    }
    let n = 3.0 * image.pixels.len() as f64;
    let (x, y) = (worst.0 as u32 % image.width, worst.0 as u32 / image.width);
    Ok(Comparison {
        rel_mse: relative / n,
        rmse: (square / n).sqrt(),
        mean_ratio: (sum / reference_sum).to_array(),
        worst_pixel: [x, y],
        worst_share: if relative > 0.0 {
            worst.1 / relative
        } else {
            0.0
        },
    })
}
