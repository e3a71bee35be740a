//! Camera moves as plain functions: orbit, pan, dolly, frame. No window, no events.

use std::f64::consts::FRAC_PI_2;
use std::ops::RangeInclusive;

use glam::{DQuat, DVec3, Vec3};
use lightbox_core::math::Aabb;
use lightbox_core::scene::CameraDesc;

/// Steepest angle between the view and the horizon: short of the poles, where up has no meaning.
const STEEPEST: f64 = FRAC_PI_2 - 0.01;

/// Share of the picture's smaller side that a framed object may fill.
const FRAMED: f64 = 0.9;

/// A camera's axes, unit length. In f64: eye and target may be close together and far away.
pub(crate) struct Axes {
    /// From eye to target.
    pub forward: DVec3,
    /// To the right in the picture.
    pub right: DVec3,
    /// Upwards in the picture.
    pub up: DVec3,
    /// The fixed axis that orbits turn around.
    pub pole: DVec3,
    /// From eye to target, scene units.
    pub distance: f64,
}

/// `None` for a camera that cannot take a picture.
pub(crate) fn axes(camera: &CameraDesc) -> Option<Axes> {
    let view = camera.target.as_dvec3() - camera.eye.as_dvec3();
    let (forward, pole) = (view.try_normalize()?, camera.up.as_dvec3().try_normalize()?);
    // At a pole, the same choice as the camera's.
    let side = forward.cross(pole);
    let side = if side.length() < 1e-6 {
        forward.cross(pole.any_orthonormal_vector())
    } else {
        side
    };
    let right = side.normalize();
    Some(Axes {
        forward,
        right,
        up: right.cross(forward),
        pole,
        distance: view.length(),
    })
}

/// Turns the camera around its target by angles in radians: `yaw` moves the scene's front to the
/// right in the picture, `pitch` moves it down. Stops short of the poles.
pub fn turned(camera: &CameraDesc, yaw: f32, pitch: f32) -> CameraDesc {
    let Some(axes) = axes(camera) else {
        return *camera;
    };
    let level = axes.pole.cross(axes.right);
    let slope = axes.forward.dot(axes.pole).clamp(-1.0, 1.0).asin();
    let slope = (slope - f64::from(pitch)).clamp(-STEEPEST, STEEPEST);
    let level = DQuat::from_axis_angle(axes.pole, -f64::from(yaw)) * level;
    let forward = slope.cos() * level + slope.sin() * axes.pole;
    let eye = camera.target.as_dvec3() - forward * axes.distance;
    CameraDesc {
        eye: eye.as_vec3(),
        ..*camera
    }
}

/// Moves the camera sideways so that what is seen at `depth` (along the optical axis, scene
/// units) moves by (`x`, `y`) picture heights to the right and down.
pub fn panned(camera: &CameraDesc, [x, y]: [f32; 2], depth: f32) -> CameraDesc {
    let Some(axes) = axes(camera) else {
        return *camera;
    };
    let height = 2.0 * f64::from(depth) * (0.5 * f64::from(camera.fov).to_radians()).tan();
    moved(
        camera,
        (axes.up * f64::from(y) - axes.right * f64::from(x)) * height,
    )
}

/// Moves the camera without turning it.
pub(crate) fn moved(camera: &CameraDesc, shift: DVec3) -> CameraDesc {
    CameraDesc {
        eye: (camera.eye.as_dvec3() + shift).as_vec3(),
        target: (camera.target.as_dvec3() + shift).as_vec3(),
        ..*camera
    }
}

/// Distances from a surface that a dolly keeps to, scene units.
pub fn reach(bounds: &Aabb, camera: &CameraDesc) -> RangeInclusive<f32> {
    let diagonal = bounds.diagonal();
    let size = if diagonal > 0.0 {
        diagonal
    } else {
        camera.eye.distance(camera.target)
    };
    // Closer than some 2⁻¹² of the coordinates, rounding of the eye would show as jitter.
    let coarseness = camera.eye.abs().max(camera.target.abs()).max_element() / 4096.0;
    let nearest = (size * 1e-3).max(coarseness);
    nearest..=(size * 100.0).max(nearest)
}

/// Changes the distance to `point` by `factor`; the point stays where it is in the picture.
/// Returns the camera and whether a limit stopped it.
pub fn dollied(
    camera: &CameraDesc,
    point: Vec3,
    factor: f32,
    reach: RangeInclusive<f32>,
) -> (CameraDesc, bool) {
    let Some(axes) = axes(camera) else {
        return (*camera, false);
    };
    let (nearest, farthest) = (f64::from(*reach.start()), f64::from(*reach.end()));
    let (point, eye) = (point.as_dvec3(), camera.eye.as_dvec3());
    let distance = point.distance(eye);
    if distance == 0.0 {
        return (*camera, true);
    }
    // A camera that is out of reach already may come back, but not go further.
    let wanted = distance * f64::from(factor);
    let allowed = wanted.clamp(nearest.min(distance), farthest.max(distance));
    let scale = allowed / distance;
    let eye = point + (eye - point) * scale;
    let target =
        eye + axes.forward * (axes.distance * scale).clamp(nearest, farthest.max(axes.distance));
    (
        CameraDesc {
            eye: eye.as_vec3(),
            target: target.as_vec3(),
            ..*camera
        },
        allowed != wanted,
    )
}

/// Moves the camera back or forth so that it sees all of a box, in a picture `aspect` times as
/// wide as high. An empty box changes nothing.
pub fn framed(camera: &CameraDesc, bounds: &Aabb, aspect: f32) -> CameraDesc {
    let Some(axes) = axes(camera) else {
        return *camera;
    };
    if bounds.is_empty() {
        return *camera;
    }
    let tangent = (0.5 * f64::from(camera.fov).to_radians()).tan() * f64::from(aspect.min(1.0));
    // The ball around the box fits into the cone of the smaller side.
    let radius = f64::from(0.5 * bounds.diagonal()).max(f64::from(*reach(bounds, camera).start()));
    let distance = radius / (tangent * FRAMED).atan().sin();
    let target = bounds.center();
    CameraDesc {
        eye: (target.as_dvec3() - axes.forward * distance).as_vec3(),
        target,
        ..*camera
    }
}

/// Turns the camera on its eye to look at a new pivot. A pivot at the eye changes nothing.
pub fn aimed(camera: &CameraDesc, pivot: Vec3) -> CameraDesc {
    let aimed = CameraDesc {
        target: pivot,
        ..*camera
    };
    if axes(&aimed).is_some() {
        aimed
    } else {
        *camera
    }
}

/// A camera on the way from one to another, `t` in [0, 1].
pub fn blended(from: &CameraDesc, to: &CameraDesc, t: f32) -> CameraDesc {
    let (Some(a), Some(b)) = (axes(from), axes(to)) else {
        return *to;
    };
    if t >= 1.0 {
        return *to;
    }
    let t = f64::from(t);
    // Turn and distance apart: a straight line between the eyes could pass through the target.
    let turn = DQuat::IDENTITY.slerp(DQuat::from_rotation_arc(a.forward, b.forward), t);
    let distance = a.distance * (b.distance / a.distance).powf(t);
    let target = from.target.as_dvec3().lerp(to.target.as_dvec3(), t);
    let eye = if from.eye == to.eye {
        to.eye.as_dvec3()
    } else {
        target - turn * a.forward * distance
    };
    let target = if from.eye == to.eye {
        eye + turn * a.forward * distance
    } else {
        target
    };
    CameraDesc {
        eye: eye.as_vec3(),
        target: target.as_vec3(),
        // Only a tumble has tilted it.
        up: from.up.lerp(to.up, t as f32).normalize_or(to.up),
        fov: from.fov + (to.fov - from.fov) * t as f32,
    }
}

/// Where a point is seen: picture heights to the right of and below the picture's centre, and
/// depth along the optical axis; `None` behind the camera.
pub fn projected(camera: &CameraDesc, point: Vec3) -> Option<([f32; 2], f32)> {
    let axes = axes(camera)?;
    let offset = point.as_dvec3() - camera.eye.as_dvec3();
    let depth = offset.dot(axes.forward);
    if depth <= 0.0 {
        return None;
    }
    let height = 2.0 * depth * (0.5 * f64::from(camera.fov).to_radians()).tan();
    let at = [
        offset.dot(axes.right) / height,
        -offset.dot(axes.up) / height,
    ];
    Some((at.map(|x| x as f32), depth as f32))
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;

    /// A camera that has not been moved yet.
    pub const FRESH: CameraDesc = CameraDesc {
        eye: Vec3::new(0.0, 0.0, 4.0),
        target: Vec3::ZERO,
        up: Vec3::Y,
        fov: 40.0,
    };

    fn close(a: Vec3, b: Vec3) -> bool {
        a.distance(b) < 1e-5 * (1.0 + b.length())
    }

    #[test]
    fn dragging_right_and_down_turns_the_front_right_and_down() {
        let right = turned(&FRESH, 0.1, 0.0);
        let front = Vec3::Z;
        assert!(projected(&right, front).unwrap().0[0] > 0.03, "{right:?}");
        let down = turned(&FRESH, 0.0, 0.1);
        assert!(projected(&down, front).unwrap().0[1] > 0.03, "{down:?}");
        for camera in [right, down] {
            assert_eq!(camera.target, FRESH.target);
            assert!((camera.eye.length() - 4.0).abs() < 1e-5);
        }
    }

    #[test]
    fn a_full_turn_comes_back() {
        let mut camera = FRESH;
        for _ in 0..8 {
            camera = turned(&camera, std::f32::consts::TAU / 8.0, 0.0);
        }
        assert!(close(camera.eye, FRESH.eye), "{camera:?}");
    }

    #[test]
    fn poles_are_survived() {
        for (pitch, up) in [(10.0, 1.0), (-10.0, -1.0)] {
            let top = turned(&FRESH, 0.0, pitch);
            assert!((top.eye.y * up - 4.0).abs() < 0.01, "{top:?}");
            // Turning still works there, and the way back is open.
            let around = turned(&top, 1.0, 0.0);
            assert!(around.eye.is_finite() && around.eye.distance(top.eye) > 1e-3);
            let back = turned(&around, 0.0, -0.5 * up);
            assert!(back.eye.y.abs() < 3.9, "{back:?}");
        }
        // A file may start at the pole itself.
        let start = CameraDesc {
            eye: Vec3::new(0.0, 4.0, 0.0),
            ..FRESH
        };
        let moved = turned(&start, 0.0, -0.5);
        assert!(
            moved.eye.is_finite() && moved.eye.y < 3.9 && moved.eye.y > 0.0,
            "{moved:?}"
        );
    }

    #[test]
    fn the_grabbed_point_follows_the_cursor_at_any_depth() {
        let camera = turned(&FRESH, 0.7, 0.3);
        for point in [Vec3::new(0.3, 0.2, 1.0), Vec3::new(-0.5, 0.4, -20.0)] {
            let (before, depth) = projected(&camera, point).unwrap();
            let (after, _) = projected(&panned(&camera, [0.25, -0.1], depth), point).unwrap();
            assert!(
                (after[0] - before[0] - 0.25).abs() < 1e-5,
                "{before:?} {after:?}"
            );
            assert!(
                (after[1] - before[1] + 0.1).abs() < 1e-5,
                "{before:?} {after:?}"
            );
        }
    }

    #[test]
    fn a_dolly_keeps_the_point_under_the_cursor() {
        let point = Vec3::new(0.8, -0.4, 0.5);
        let (before, _) = projected(&FRESH, point).unwrap();
        for factor in [0.5, 2.0] {
            let (camera, limited) = dollied(&FRESH, point, factor, 0.01..=100.0);
            let (after, _) = projected(&camera, point).unwrap();
            assert!((after[0] - before[0]).abs() < 1e-5 && (after[1] - before[1]).abs() < 1e-5);
            assert!((camera.eye.distance(point) / FRESH.eye.distance(point) - factor).abs() < 1e-5);
            assert!(!limited);
        }
    }

    #[test]
    fn a_dolly_stops_at_its_limits() {
        let bounds = Aabb {
            min: Vec3::splat(-1.0),
            max: Vec3::splat(1.0),
        };
        let mut camera = FRESH;
        for _ in 0..1000 {
            camera = dollied(
                &camera,
                Vec3::new(0.1, 0.1, 1.0),
                0.8,
                reach(&bounds, &camera),
            )
            .0;
        }
        let distance = camera.eye.distance(Vec3::new(0.1, 0.1, 1.0));
        assert!(
            (distance - 1e-3 * bounds.diagonal()).abs() < 1e-4,
            "{distance}"
        );
        assert!(
            camera.eye.distance(camera.target) > 1e-3,
            "the pivot must not fall into the eye: {camera:?}"
        );
        for _ in 0..1000 {
            camera = dollied(&camera, Vec3::ZERO, 1.25, reach(&bounds, &camera)).0;
        }
        assert!(
            camera.eye.length() < 101.0 * bounds.diagonal(),
            "{camera:?}"
        );
        // Out of reach, the way back is open and the way out is not.
        let far = CameraDesc {
            eye: Vec3::new(0.0, 0.0, 1e6),
            ..FRESH
        };
        assert!(
            dollied(&far, Vec3::ZERO, 0.5, reach(&bounds, &FRESH))
                .0
                .eye
                .z
                < 6e5
        );
        assert!(
            dollied(&far, Vec3::ZERO, 2.0, reach(&bounds, &FRESH))
                .0
                .eye
                .z
                <= 1e6
        );
    }

    #[test]
    fn a_framed_box_is_seen_whole_and_large() {
        let bounds = Aabb {
            min: Vec3::new(4.0, 5.0, 6.0),
            max: Vec3::new(5.0, 8.0, 7.0),
        };
        for aspect in [0.5, 1.0, 2.0] {
            let camera = framed(&turned(&FRESH, 0.4, 0.2), &bounds, aspect);
            let corners = [
                bounds.min,
                bounds.max,
                Vec3::new(5.0, 5.0, 6.0),
                Vec3::new(4.0, 8.0, 7.0),
            ];
            let seen: Vec<_> = corners
                .iter()
                .map(|c| projected(&camera, *c).unwrap().0)
                .collect();
            assert!(
                seen.iter()
                    .all(|[x, y]| x.abs() < 0.5 * aspect && y.abs() < 0.5),
                "{aspect}: {seen:?}"
            );
            assert!(
                seen.iter().any(|[_, y]| y.abs() > 0.2 * aspect.min(1.0)),
                "{aspect}: {seen:?}"
            );
        }
        assert_eq!(framed(&FRESH, &Aabb::EMPTY, 1.0), FRESH);
    }

    #[test]
    fn a_new_pivot_leaves_the_eye() {
        let camera = aimed(&FRESH, Vec3::new(1.0, 0.5, 0.0));
        assert_eq!(camera.eye, FRESH.eye);
        assert_eq!(
            projected(&camera, Vec3::new(1.0, 0.5, 0.0)).unwrap().0,
            [0.0, 0.0]
        );
        assert_eq!(aimed(&FRESH, FRESH.eye), FRESH);
    }

    #[test]
    fn a_blend_ends_where_it_should_and_keeps_the_eye_of_a_turn() {
        let to = aimed(&turned(&FRESH, 2.0, 0.4), Vec3::new(0.5, 0.0, 0.0));
        assert_eq!(blended(&FRESH, &to, 1.0), to);
        assert!(close(blended(&FRESH, &to, 0.0).eye, FRESH.eye));
        let turn = aimed(&FRESH, Vec3::new(1.0, 1.0, 0.0));
        assert_eq!(blended(&FRESH, &turn, 0.3).eye, FRESH.eye);
    }

    #[test]
    fn a_broken_camera_is_left_alone() {
        let broken = CameraDesc {
            eye: Vec3::ZERO,
            ..FRESH
        };
        assert_eq!(turned(&broken, 1.0, 1.0), broken);
        assert_eq!(panned(&broken, [1.0, 1.0], 1.0), broken);
        assert_eq!(dollied(&broken, Vec3::X, 0.5, 0.1..=1.0).0, broken);
    }
}
