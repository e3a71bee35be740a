//! What single words of the command line may be: the first check of each value.

use std::ops::Range;
use std::str::FromStr;

use clap::builder::{PossibleValuesParser, TypedValueParser};
use glam::Vec3;
use lightbox_core::settings::{MAX_SEED, MAX_SIZE, parse_depth};

/// Most samples and slices: as far as scene files, parts and the scripts of `submit` can count.
const MAX_COUNT: u64 = i64::MAX as u64;

/// Accepts the names of some values, and shows them in the help.
pub(super) fn named<T>(
    all: &[T],
    name: fn(T) -> &'static str,
) -> impl TypedValueParser<Value = T> + use<T>
where
    T: Copy + FromStr<Err = String> + Send + Sync + 'static,
{
    PossibleValuesParser::new(all.iter().map(|value| name(*value))).try_map(|name| name.parse())
}

pub(super) fn size(text: &str) -> Result<[u32; 2], String> {
    let pixels = |text: &str| text.parse().ok().filter(|n| (1..=MAX_SIZE).contains(n));
    let size = text
        .split_once('x')
        .and_then(|(width, height)| Some([pixels(width)?, pixels(height)?]));
    size.ok_or_else(|| format!("write WxH, each from 1 to {MAX_SIZE} pixels, for example 640x480"))
}

pub(super) fn depth(text: &str) -> Result<u32, String> {
    match parse_depth(text)? {
        0 => Err("use 1 (emitters only) or more, or \"unlimited\"".into()),
        depth => Ok(depth),
    }
}

pub(super) fn count(text: &str) -> Result<u64, String> {
    let number = text.parse().ok().filter(|n| (1..=MAX_COUNT).contains(n));
    number.ok_or_else(|| format!("use a whole number from 1 to {MAX_COUNT}"))
}

pub(super) fn seed(text: &str) -> Result<u64, String> {
    let seed = text.parse().ok().filter(|seed| *seed <= MAX_SEED);
    seed.ok_or_else(|| format!("use a whole number from 0 to {MAX_SEED}"))
}

pub(super) fn positive(text: &str) -> Result<f64, String> {
    let number = text
        .parse()
        .ok()
        .filter(|x: &f64| *x > 0.0 && x.is_finite());
    number.ok_or_else(|| "use a positive number".into())
}

pub(super) fn samples(text: &str) -> Result<Range<u64>, String> {
    let index = |text: &str| text.parse().ok().filter(|i| *i <= MAX_COUNT);
    text.split_once("..")
        .and_then(|(start, end)| Some(index(start)?..index(end)?))
        .filter(|samples| !samples.is_empty())
        .ok_or_else(|| "write A..B with A less than B, for example 64..128".into())
}

pub(super) fn finite(text: &str) -> Result<f32, String> {
    text.parse()
        .ok()
        .filter(|x: &f32| x.is_finite())
        .ok_or_else(|| "use a finite number".into())
}

pub(super) fn field_of_view(text: &str) -> Result<f32, String> {
    let fov = text
        .parse()
        .ok()
        .filter(|fov: &f32| *fov > 0.0 && *fov < 180.0);
    fov.ok_or_else(|| "use more than 0 and less than 180 degrees".into())
}

pub(super) fn point(text: &str) -> Result<Vec3, String> {
    let numbers: Result<Vec<f32>, String> = text
        .split(',')
        .map(|number| finite(number.trim()))
        .collect();
    match numbers.as_deref() {
        Ok(&[x, y, z]) => Ok(Vec3::new(x, y, z)),
        _ => Err("write three numbers with commas between them, for example 0,1.5,-2".into()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_survive_the_way_through_text() {
        for x in [
            0.1f32,
            -0.0,
            f32::MIN_POSITIVE,
            1e-45,
            16_777_217.0,
            -f32::MAX,
        ] {
            let v = Vec3::new(x, -x, 1.0 / 3.0);
            let read = point(&format!("{},{},{}", v.x, v.y, v.z)).unwrap();
            assert_eq!(
                read.to_array().map(f32::to_bits),
                v.to_array().map(f32::to_bits)
            );
        }
    }

    #[test]
    fn values_out_of_range_are_refused() {
        for text in [
            "", "abc", "0x10", "10x0", "99999x1", "10", "10x10x10", "-1x5", "1.5x2",
        ] {
            assert!(size(text).is_err(), "{text}");
        }
        assert_eq!(size("16384x1"), Ok([16384, 1]));
        for text in ["", "1,2", "1,2,3,4", "nan,0,0", "1,,2", "inf,0,0"] {
            assert!(point(text).is_err(), "{text}");
        }
        for text in ["0", "-1", "nan", "inf", "x"] {
            assert!(positive(text).is_err(), "{text}");
        }
        for text in [
            "",
            "5",
            "5..",
            "..5",
            "5..5",
            "6..5",
            "-1..5",
            "0..=5",
            "0..9223372036854775808",
        ] {
            assert!(samples(text).is_err(), "{text}");
        }
        assert_eq!(samples("64..128"), Ok(64..128));
        for text in ["0", "-1", "1.5", "9223372036854775808"] {
            assert!(count(text).is_err(), "{text}");
        }
        assert_eq!(count("9223372036854775807"), Ok(MAX_COUNT));
        assert!(depth("0").is_err() && depth("unlimited").is_ok());
    }
}
