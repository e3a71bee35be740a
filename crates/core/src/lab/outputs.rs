//! What leaves the film: colours, files, and the sizes that they can have.

use glam::Vec3;

use super::{Bound, Figure};
use crate::color::{ToneCurve, ToneMap, linear_from_srgb, srgb_from_linear};
use crate::settings::{MAX_PIXELS, MAX_SIZE};
use crate::{Image, RenderSettings, image_io};

pub(super) fn colors() -> Vec<Figure> {
    let lost = (0..=255u8).filter(|v| srgb_from_linear(linear_from_srgb(*v)) != *v);
    let edge = 0.003_130_8f32;
    let table = [
        (-0.1, 0),
        (f32::NAN, 0),
        (f32::NEG_INFINITY, 0),
        (-0.0, 0),
        (edge.next_down(), 10),
        (edge, 10),
        (edge.next_up(), 10),
        (1.0, 255),
        (300.0, 255),
        (f32::INFINITY, 255),
    ];
    let wrong = table
        .iter()
        .filter(|(x, shown)| srgb_from_linear(*x) != *shown);
    let naive = |x: f32| {
        let y = if x <= 0.003_130_8 {
            12.92 * x
        } else {
            1.055 * x.powf(1.0 / 2.4) - 0.055
        };
        // As C converts: the low byte of the integer.
        (y * 255.0 + 0.5) as i32 as u8
    };
    let wrong_naive = table.iter().filter(|(x, shown)| naive(*x) != *shown);
    let filmic = ToneMap {
        curve: ToneCurve::Filmic,
        ..ToneMap::default()
    };
    let unclamped = [f32::MAX, f32::INFINITY]
        .iter()
        .filter(|x| filmic.apply(Vec3::splat(**x)) != [255; 3]);
    vec![
        Figure {
            what: "sRGB values of 256 that do not survive the round trip",
            naive: None,
            lightbox: lost.count() as f64,
            bound: Bound::Exactly(0.0),
        },
        Figure {
            what: "values of 10 out of range that show wrongly",
            naive: Some(wrong_naive.count() as f64),
            lightbox: (wrong.count() + unclamped.count()) as f64,
            bound: Bound::Exactly(0.0),
        },
    ]
}

pub(super) fn files() -> Vec<Figure> {
    let odd = [
        65_505.0,
        1e39_f64 as f32,
        f32::NAN,
        -f32::NAN,
        f32::MAX,
        f32::MIN_POSITIVE,
        1e-42,
        -0.0,
        0.1,
    ];
    let pixels: Vec<Vec3> = (0..63)
        .map(|i| Vec3::new(odd[i % 9], odd[(i / 7) % 9], odd[(i * 5 + 3) % 9]))
        .collect();
    let image = Image {
        width: 9,
        height: 7,
        pixels,
    };
    let numbers = || image.pixels.iter().flat_map(|p| p.to_array());
    let read_back = image_io::encode_exr(&image, "")
        .and_then(|bytes| image_io::decode(&bytes).map_err(|e| e.to_string()));
    let differ = match &read_back {
        Ok(back) if (back.width, back.height) == (image.width, image.height) => {
            let back = back.pixels.iter().flat_map(|p| p.to_array());
            numbers()
                .zip(back)
                .filter(|(a, b)| a.to_bits() != b.to_bits())
                .count()
        }
        _ => usize::MAX,
    };
    // What half floats cannot hold: beyond 65504, below 2⁻²⁴, or more than 11 digits.
    let lost = numbers().filter(|x| {
        let fits = x.abs() <= 65_504.0 && (x.abs() >= 6.0e-8 || *x == 0.0);
        !fits || x.to_bits() & 0x1fff != 0
    });
    let png = image_io::encode_png(&image, ToneMap::default(), "")
        .and_then(|bytes| image_io::decode(&bytes).map_err(|e| e.to_string()));
    let black_or_white = png.map_or(usize::MAX, |png| {
        let expected = image
            .pixels
            .iter()
            .map(|p| ToneMap::default().apply(*p).map(linear_from_srgb));
        png.pixels
            .iter()
            .zip(expected)
            .filter(|(a, b)| a.to_array() != *b)
            .count()
    });
    vec![
        Figure {
            what: "numbers of 189 that an EXR file changes (naive: half floats)",
            naive: Some(lost.count() as f64),
            lightbox: differ as f64,
            bound: Bound::Exactly(0.0),
        },
        Figure {
            what: "pixels of a PNG file that are not what the screen shows",
            naive: None,
            lightbox: black_or_white as f64,
            bound: Bound::Exactly(0.0),
        },
    ]
}

pub(super) fn sizes() -> Vec<Figure> {
    let settings = |width, height| RenderSettings {
        width,
        height,
        ..RenderSettings::default()
    };
    let bad = [
        (0, 0),
        (0, 8),
        (8, 0),
        (65_536, 65_536),
        (MAX_SIZE + 1, 1),
        (MAX_SIZE, MAX_SIZE),
        (u32::MAX, u32::MAX),
    ];
    let accepted = bad
        .iter()
        .filter(|(w, h)| settings(*w, *h).problem().is_none());
    // Bytes of an RGBA picture of floats in 32 bits, as against 64.
    let wrapped = bad.iter().filter(|(w, h)| {
        let bytes = w.wrapping_mul(*h).wrapping_mul(16);
        u64::from(bytes) != u64::from(*w).wrapping_mul(u64::from(*h)).wrapping_mul(16)
    });
    let good = [
        (1, 1),
        (1, MAX_SIZE),
        (MAX_SIZE, 1),
        (MAX_SIZE, (MAX_PIXELS / u64::from(MAX_SIZE)) as u32),
    ];
    let refused = good
        .iter()
        .filter(|(w, h)| settings(*w, *h).problem().is_some());
    vec![
        Figure {
            what: "impossible sizes accepted (naive: that wrap in 32 bits)",
            naive: Some(wrapped.count() as f64),
            lightbox: accepted.count() as f64,
            bound: Bound::Exactly(0.0),
        },
        Figure {
            what: "possible sizes refused",
            naive: None,
            lightbox: refused.count() as f64,
            bound: Bound::Exactly(0.0),
        },
    ]
}
