//! Pictures of rays that leave surfaces: how open the space around each point is.

use glam::{DVec3, Vec3};

use super::input::cast;
use super::pictures::{HOLE, SIZE, draw, look};
use super::random::Rng;
use super::{Side, naive, rooms};
use crate::Image;
use crate::geometry::Geometry;
use crate::math::{Frame, Ray, warp};
use crate::settings::AccelKind;

/// Rays from what a pixel sees.
const RAYS: usize = 48;

/// Place, direction and half width of the view: all of a room of size 2.
const FROM_THE_BACK: (Vec3, Vec3, f32) =
    (Vec3::new(0.0, 0.2, 0.9), Vec3::new(0.0, -0.2, -1.0), 1.0);

/// How much of the room is within half its size of what is seen: dark in corners. A ray that
/// starts on the wrong side, or finds its own surface, shows.
fn open_space(
    room: &Geometry,
    (scale, offset): (f32, Vec3),
    (eye, ahead, half_width): (Vec3, Vec3, f32),
    side: Side,
) -> Image {
    draw(|pixel, at| {
        let ray = look(
            offset + scale * eye,
            [Vec3::X, Vec3::Y, ahead],
            at,
            half_width,
        );
        let Some(hit) = cast(room, &ray) else {
            return HOLE;
        };
        let point = room.primitives().surface_point(&ray, &hit);
        let n = if point.n.dot(ray.dir) < 0.0 {
            point.n
        } else {
            -point.n
        };
        let mut rng = Rng(u64::from(pixel[0] * SIZE + pixel[1]));
        let mut color = Vec3::ZERO;
        for _ in 0..RAYS {
            let w = warp::cosine_hemisphere([rng.unit(), rng.unit()]);
            let w = Frame::around(n).world_from_local(w).normalize();
            let origin = match side {
                Side::Naive => naive::leave(ray.at(hit.t), n, w, 1e-4),
                Side::Lightbox => point.leave(w),
            };
            color += match cast(room, &Ray::new(origin, w)) {
                None => HOLE,
                Some(hit) => Vec3::splat((hit.t / scale).min(1.0)),
            };
        }
        color / RAYS as f32
    })
}

/// I01: a room of size 2 at 10⁵.
pub(super) fn far_room(side: Side) -> Image {
    let offset = DVec3::new(1e5, -1e5, 1e5).as_vec3();
    let room = rooms::room(1.0, offset, AccelKind::Auto);
    open_space(&room, (1.0, offset), FROM_THE_BACK, side)
}

/// I02: a room of size 2 · 10⁻⁴.
pub(super) fn small_room(side: Side) -> Image {
    let room = rooms::room(1e-4, Vec3::ZERO, AccelKind::Auto);
    open_space(&room, (1e-4, Vec3::ZERO), FROM_THE_BACK, side)
}

/// I03: where a ball touches the floor of a room of size 2 · 10⁻³.
pub(super) fn touching_ball(side: Side) -> Image {
    let room = rooms::touching_room(1e-3, Vec3::ZERO);
    let view = (Vec3::new(0.0, -0.8, 0.95), Vec3::new(0.0, -0.2, -1.0), 0.5);
    open_space(&room, (1e-3, Vec3::ZERO), view, side)
}
