//! Cameras of any kind.

use lightbox_core::Camera;
use lightbox_core::scene::CameraDesc;
use lightbox_core::settings::MAX_SIZE;

use super::draw::Draw;

/// Any numbers give an error of one line, or a camera whose rays are finite, of unit length, start
/// at the eye, and span the field of view at right angles.
pub fn camera(bytes: &[u8]) {
    let mut draw = Draw::new(bytes);
    let wild = draw.below(2) == 0;
    let mut point = || {
        if wild {
            draw.any_point()
        } else {
            draw.point(20)
        }
    };
    let (eye, target, up) = (point(), point(), point());
    let fov = match draw.below(4) {
        0 => draw.any(),
        _ => draw.unit() * 180.0,
    };
    let desc = CameraDesc {
        eye,
        target,
        up,
        fov,
    };
    let [width, height] = [0; 2].map(|_| match draw.below(4) {
        0 => MAX_SIZE,
        _ => 1 + draw.word() % 64,
    });
    let camera = match Camera::new(&desc, width, height) {
        Ok(camera) => camera,
        Err(message) => {
            assert!(!message.is_empty() && !message.contains('\n'), "{message}");
            return;
        }
    };
    let forward = camera.forward().as_dvec3();
    assert!(
        (forward.length() - 1.0).abs() < 1e-6,
        "{desc:?}: {camera:?}"
    );
    let (w, h) = (width as f32, height as f32);
    // Directions through points of the picture, (0, 0) to (w, h).
    let through = |x: f32, y: f32| {
        let ray = camera.ray([0, 0], [x - 0.5, y - 0.5]);
        assert_eq!(ray.origin, eye);
        assert!((ray.dir.length() - 1.0).abs() < 1e-6, "{desc:?}: {ray:?}");
        ray.dir.as_dvec3()
    };
    for (x, y) in [(0.0, 0.0), (w, 0.0), (0.0, h), (w, h)] {
        through(x, y);
    }
    let (middle, top, left) = (
        through(0.5 * w, 0.5 * h),
        through(0.5 * w, 0.0),
        through(0.0, 0.5 * h),
    );
    // Far off the axis, the middle is the difference of large numbers.
    let aspect = f64::from(w) / f64::from(h);
    let half = f64::from(fov).to_radians() * 0.5;
    let error = 2e-6 * (1.0 + half.tan() * (1.0 + aspect));
    if error > 1e-3 {
        return;
    }
    assert!(
        (middle - forward).length() < error,
        "{desc:?}: {middle} and {forward}"
    );
    assert!(
        (top.dot(forward) - half.cos()).abs() < error,
        "{desc:?}: {top}"
    );
    assert!(
        (left.dot(forward) - (half.tan() * aspect).atan().cos()).abs() < error,
        "{desc:?}: {left}"
    );
    let (up, right) = (
        top - forward * top.dot(forward),
        forward * left.dot(forward) - left,
    );
    assert!(up.dot(right).abs() < error, "{desc:?}: {up} and {right}");
    // A right-handed picture.
    assert!(
        right.cross(up).dot(forward) < error,
        "{desc:?}: {up} and {right}"
    );
}
