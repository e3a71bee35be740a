//! Paths in closed rooms, from which no ray may escape, at every scale and offset.

use glam::Vec3;

use super::input::{NOTHING, cast};
use super::random::Rng;
use super::{Figure, naive, quads};
use crate::geometry::{Geometry, Primitives};
use crate::math::{Frame, Ray, warp};
use crate::settings::AccelKind;
use crate::shape::{Quad, Sphere};

/// How a start is found.
#[derive(Clone, Copy)]
enum Start {
    /// A fixed 10⁻⁴ along the normal.
    Fixed,
    Lightbox,
}

/// What went wrong on paths.
#[derive(Default)]
struct Faults {
    /// A flat primitive was found by a ray that left it.
    again: usize,
    /// A ray found nothing in a closed room.
    escaped: usize,
    /// Mean radiance in the room with walls that emit 1 and reflect half.
    radiance: f64,
}

const BOUNCES: i32 = 24;

/// Paths in a closed room from its middle; `f` is told of every hit distance.
fn walk(
    room: &Geometry,
    middle: Vec3,
    paths: usize,
    start: Start,
    mut f: impl FnMut(f32, u32),
) -> Faults {
    let mut rng = Rng(1);
    let mut faults = Faults::default();
    let flat = |id: u32| {
        !matches!(
            room.primitives().get(id),
            crate::geometry::Primitive::Sphere(_)
        )
    };
    for _ in 0..paths {
        let mut ray = Ray::new(middle, rng.direction());
        let mut left = NOTHING;
        let mut throughput = 1.0;
        for _ in 0..BOUNCES {
            let Some(hit) = cast(room, &ray) else {
                faults.escaped += 1;
                break;
            };
            f(hit.t, hit.prim);
            faults.again += usize::from(hit.prim == left && flat(left));
            faults.radiance += throughput;
            throughput *= 0.5;
            left = hit.prim;
            let point = room.primitives().surface_point(&ray, &hit);
            let n = if point.n.dot(ray.dir) < 0.0 {
                point.n
            } else {
                -point.n
            };
            let w = warp::cosine_hemisphere([rng.unit(), rng.unit()]);
            let w = Frame::around(n).world_from_local(w).normalize();
            ray = match start {
                Start::Fixed => Ray::new(naive::leave(ray.at(hit.t), n, w, 1e-4), w),
                Start::Lightbox => Ray::new(point.leave(w), w),
            };
        }
    }
    faults.radiance /= paths as f64;
    faults
}

/// A closed cube with a box and a ball in it, moved and scaled.
pub(super) fn room(scale: f32, offset: Vec3, accel: AccelKind) -> Geometry {
    let place = |p: Vec3| p * scale + offset;
    let mut triangles = Vec::new();
    let mut walls = Vec::new();
    for (i, face) in quads::cube_faces().into_iter().enumerate() {
        let [a, b, c, d] = face.map(place);
        // Walls of both kinds.
        if i % 2 == 0 {
            walls.push(Quad::new([a, b, c, d]));
        } else {
            triangles.extend([[a, b, c], [a, c, d]]);
        }
        let [a, b, c, d] = face.map(|p| place(p * 0.25 + Vec3::new(0.5, -0.5, 0.25)));
        triangles.extend([[a, c, b], [a, d, c]]);
    }
    let ball = Sphere {
        center: place(Vec3::new(-0.5, -0.25, -0.25)),
        radius: 0.25 * scale,
    };
    let slots = vec![0; triangles.len() + walls.len() + 1];
    let primitives = Primitives {
        triangles: triangles.into(),
        quads: walls,
        spheres: vec![ball],
        slots,
        ..Primitives::default()
    };
    Geometry::build(primitives, accel)
}

pub(super) fn far_room() -> Vec<Figure> {
    const PATHS: usize = 4000;
    let mut total = [Faults::default(), Faults::default()];
    let mut worst = [0.0f64; 2];
    // 1 − 2⁻²⁴ of the series.
    let truth = 2.0 - 2.0 * 0.5f64.powi(BOUNCES);
    for (scale, at) in [
        (1.0, 0.0f32),
        (1.0, 1e4),
        (1.0, 1e5),
        (1.0, 1e6),
        (1e-4, 0.0),
        (1e5, 0.0),
        (1e5, 1e6),
    ] {
        let offset = Vec3::new(at, -at, at);
        let room = room(scale, offset, AccelKind::Auto);
        for (side, start) in [Start::Fixed, Start::Lightbox].into_iter().enumerate() {
            let faults = walk(&room, offset + 0.1 * scale, PATHS, start, |_, _| ());
            total[side].again += faults.again;
            total[side].escaped += faults.escaped;
            worst[side] = worst[side].max((faults.radiance - truth).abs());
        }
    }
    let [fixed, ours] = &total;
    vec![
        Figure::none(
            "rays of 672000, at scales 10⁻⁴ to 10⁵ and offsets to 10⁶, that hit what they leave",
            Some(fixed.again),
            ours.again,
        ),
        Figure::none("rays that escape", Some(fixed.escaped), ours.escaped),
        Figure::at_most(
            "largest error of the mean radiance of a room",
            Some(worst[0]),
            worst[1],
            1e-9,
        ),
    ]
}

pub(super) fn small_room() -> Vec<Figure> {
    let mut differing = [0; 2];
    for (side, start) in [Start::Fixed, Start::Lightbox].into_iter().enumerate() {
        let trace = |k: i32| {
            let scale = libm::ldexp(1.0, k) as f32;
            let room = room(scale, Vec3::ZERO, AccelKind::Auto);
            let mut hits = Vec::new();
            walk(&room, Vec3::splat(0.125 * scale), 500, start, |t, prim| {
                hits.push(((t / scale).to_bits(), prim))
            });
            hits
        };
        let expected = trace(0);
        for k in [-40, -10, -1, 10, 40] {
            let found = trace(k);
            let unlike = found.iter().zip(&expected).filter(|(a, b)| a != b).count();
            differing[side] += unlike + found.len().abs_diff(expected.len());
        }
    }
    vec![Figure::none(
        "hits of 60000 on paths, at scales 2⁻⁴⁰ to 2⁴⁰, that do not scale bit for bit",
        Some(differing[0]),
        differing[1],
    )]
}

/// A closed room with a ball that touches the floor.
pub(super) fn touching_room(scale: f32, offset: Vec3) -> Geometry {
    let walls = quads::cube_faces().map(|face| Quad::new(face.map(|p| p * scale + offset)));
    let ball = Sphere {
        center: offset + Vec3::new(0.0, -0.5, 0.0) * scale,
        radius: 0.5 * scale,
    };
    let primitives = Primitives {
        quads: walls.to_vec(),
        spheres: vec![ball],
        slots: vec![0; 7],
        ..Primitives::default()
    };
    Geometry::build(primitives, AccelKind::Auto)
}

pub(super) fn touching() -> Vec<Figure> {
    let mut leaks = [0; 2];
    for (scale, at) in [(1.0f32, 0.0f32), (1.0, 1e3), (1e-3, 0.0), (1e3, 0.0)] {
        let offset = Vec3::splat(at);
        let room = touching_room(scale, offset);
        for (side, start) in [Start::Fixed, Start::Lightbox].into_iter().enumerate() {
            // From beside the ball, so that many paths go under it.
            let from = offset + Vec3::new(0.7, -0.97, 0.1) * scale;
            leaks[side] += walk(&room, from, 10_000, start, |_, _| ()).escaped;
        }
    }
    vec![Figure::none(
        "rays of 960000 that escape the closed room",
        Some(leaks[0]),
        leaks[1],
    )]
}
