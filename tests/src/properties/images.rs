//! Pictures in files.

use glam::Vec3;
use lightbox_core::Image;
use lightbox_core::color::{ToneCurve, ToneMap, linear_from_srgb};
use lightbox_core::image_io;

use super::draw::Draw;

/// Pixels of any value: written or refused in one line; EXR gives the same bits back, PNG the
/// bytes of the tone map.
pub fn images(bytes: &[u8]) {
    let mut draw = Draw::new(bytes);
    let [width, height] = [0; 2].map(|_| draw.below(10) as u32);
    let pixels: Vec<Vec3> = (0..width * height).map(|_| draw.any_point()).collect();
    let image = Image {
        width,
        height,
        pixels,
    };
    let tone = ToneMap {
        exposure: draw.any(),
        offset: draw.any(),
        curve: draw.of(&ToneCurve::ALL),
    };
    let folder = tempfile::tempdir().expect("a folder");
    for name in ["picture.exr", "picture.png"] {
        let path = folder.path().join(name);
        if let Err(message) = image_io::write(&path, &image, tone, "replay") {
            assert!(!message.contains('\n'), "{message}");
            assert!(width * height == 0, "{width}x{height}: {message}");
            continue;
        }
        let back = image_io::read(&path).unwrap_or_else(|e| panic!("{width}x{height}: {e}"));
        assert_eq!([back.width, back.height], [width, height]);
        for (wrote, read) in image.pixels.iter().zip(&back.pixels) {
            if name.ends_with("exr") {
                let bits = |v: &Vec3| v.to_array().map(f32::to_bits);
                assert_eq!(bits(wrote), bits(read));
            } else {
                assert_eq!(
                    Vec3::from_array(tone.apply(*wrote).map(linear_from_srgb)),
                    *read
                );
            }
        }
    }
}
