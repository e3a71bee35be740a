//! Camera moves that are no orbit: to look around, to fly, to tumble, to look along an axis. Plain
//! functions as in [`orbit`](crate::orbit).

use glam::{DQuat, Vec3};
use lightbox_core::scene::CameraDesc;

use crate::orbit::{axes, moved, turned};

/// Turns the camera on its eye by angles in radians: `yaw` to the right, `pitch` down. Stops short
/// of the poles.
pub fn looked(camera: &CameraDesc, yaw: f32, pitch: f32) -> CameraDesc {
    // What an orbit does to the eye, seen from the eye.
    let orbited = turned(camera, yaw, pitch);
    CameraDesc {
        eye: camera.eye,
        target: camera.eye + (orbited.target - orbited.eye),
        ..*camera
    }
}

/// Moves the camera by scene units to the right, up and forwards; up is the axis that orbits turn
/// around.
pub fn flown(camera: &CameraDesc, way: Vec3) -> CameraDesc {
    let Some(axes) = axes(camera) else {
        return *camera;
    };
    let way = way.as_dvec3();
    let shift = axes.right * way.x + axes.pole * way.y + axes.forward * way.z;
    moved(camera, shift)
}

/// [`turned`] without poles: what is up in the picture turns with it.
pub fn tumbled(camera: &CameraDesc, yaw: f32, pitch: f32) -> CameraDesc {
    let Some(axes) = axes(camera) else {
        return *camera;
    };
    let turn = DQuat::from_axis_angle(axes.up, -f64::from(yaw))
        * DQuat::from_axis_angle(axes.right, -f64::from(pitch));
    let eye = camera.target.as_dvec3() - turn * axes.forward * axes.distance;
    CameraDesc {
        eye: eye.as_vec3(),
        up: (turn * axes.up).as_vec3(),
        ..*camera
    }
}

/// The view of the target from this direction, from as far as before.
pub fn seen_from(camera: &CameraDesc, direction: Vec3) -> CameraDesc {
    let distance = camera.eye.distance(camera.target);
    CameraDesc {
        eye: camera.target + direction * distance,
        ..*camera
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::orbit::projected;
    use crate::orbit::tests::FRESH;

    #[test]
    fn a_look_to_the_right_and_down_moves_things_left_and_up() {
        let front = Vec3::ZERO;
        let right = looked(&FRESH, 0.1, 0.0);
        assert!(projected(&right, front).unwrap().0[0] < -0.03, "{right:?}");
        let down = looked(&FRESH, 0.0, 0.1);
        assert!(projected(&down, front).unwrap().0[1] < -0.03, "{down:?}");
        for camera in [right, down, looked(&FRESH, 0.3, 10.0)] {
            assert_eq!(camera.eye, FRESH.eye);
            assert!((camera.eye.distance(camera.target) - 4.0).abs() < 1e-5);
        }
    }

    #[test]
    fn one_flies_along_the_view_and_straight_up() {
        let camera = looked(&FRESH, 0.3, -0.4);
        let flown = flown(&camera, Vec3::new(0.0, 2.0, 0.0));
        assert!(flown.eye.distance(camera.eye + 2.0 * Vec3::Y) < 1e-6);
        let ahead = super::flown(&camera, Vec3::new(0.0, 0.0, 1.5));
        let forward = (camera.target - camera.eye).normalize();
        assert!(ahead.eye.distance(camera.eye + 1.5 * forward) < 1e-6);
        assert!((ahead.target - ahead.eye).distance(camera.target - camera.eye) < 1e-6);
        let aside = super::flown(&FRESH, Vec3::new(1.0, 0.0, 0.0));
        assert!(aside.eye.distance(Vec3::new(1.0, 0.0, 4.0)) < 1e-6);
    }

    #[test]
    fn a_tumble_goes_over_the_poles_and_around() {
        let mut camera = FRESH;
        for _ in 0..8 {
            let before = camera;
            camera = tumbled(&camera, 0.0, std::f32::consts::TAU / 8.0);
            let step = camera.eye.distance(before.eye);
            assert!(
                (step - 8.0 * (std::f32::consts::PI / 8.0).sin()).abs() < 1e-4,
                "{step}"
            );
        }
        assert!(camera.eye.distance(FRESH.eye) < 1e-5 && camera.up.distance(Vec3::Y) < 1e-5);
        // A small one is an orbit.
        let (a, b) = (tumbled(&FRESH, 0.1, 0.0), turned(&FRESH, 0.1, 0.0));
        assert!(a.eye.distance(b.eye) < 1e-6);
        let (a, b) = (tumbled(&FRESH, 0.0, 0.1), turned(&FRESH, 0.0, 0.1));
        assert!(a.eye.distance(b.eye) < 1e-6);
    }

    #[test]
    fn views_along_the_axes_keep_the_distance() {
        for axis in [Vec3::X, Vec3::NEG_Y, Vec3::Z] {
            let camera = seen_from(&FRESH, axis);
            assert!(camera.eye.distance(4.0 * axis) < 1e-6);
            // At a pole too, there is a way on.
            let on = turned(&camera, 0.2, 0.0);
            assert!(on.eye.is_finite());
        }
    }
}
