//! Rays that leave surfaces: self-hits, tunnels and leaks, at every scale and offset.

use glam::Vec3;

use super::input::{NOTHING, build, cast, toward};
use super::random::Rng;
use super::{Case, Check, Figure, naive, quads, room_pictures};
use crate::geometry::{Geometry, Primitives, SurfacePoint};
use crate::math::{Frame, Ray, warp};
use crate::settings::AccelKind;
use crate::shape::{Quad, Sphere};

pub(super) const CASES: &[Case] = &[
    Case {
        id: "I01",
        title: "a room far from the origin",
        failure: "A fixed start of 10⁻⁴ off the surface vanishes in rounding at coordinates of 10⁴: \
                  acne, then black, then light leaks.",
        cure: "The start is moved beyond the rounding of the hit point (Pharr, Jakob & Humphreys \
               2016, §3.9.5).",
        check: Check::Probe(far_room),
        scene: Some("builtin:lab/far-room.toml"),
        picture: Some(room_pictures::far_room),
    },
    Case {
        id: "I02",
        title: "a room a thousand times smaller",
        failure: "A fixed start is suddenly large: shadows come off their objects.",
        cure: "No absolute number anywhere: paths in a scene scaled by a power of two are the same, bit for bit.",
        check: Check::Probe(small_room),
        scene: Some("builtin:lab/small-room.toml"),
        picture: Some(room_pictures::small_room),
    },
    Case {
        id: "I03",
        title: "a ball that touches the floor",
        failure: "Near the point of touch, the start jumps through the second surface.",
        cure: "The start moves by an ulp or two, and no further than the surface may be off.",
        check: Check::Probe(touching),
        scene: Some("builtin:lab/touching-ball.toml"),
        picture: Some(room_pictures::touching_ball),
    },
    Case {
        id: "I04",
        title: "plates 10⁻⁴ apart at 10³",
        failure: "The gap is two ulp: a start that is moved further is on the other side.",
        cure: "Hit points in f64, so that what remains is one rounding: half an ulp.",
        check: Check::Probe(plates),
        scene: None,
        picture: None,
    },
    Case {
        id: "I05",
        title: "a lamp that shades itself",
        failure: "A shadow ray that ends at the lamp finds the lamp: half the light is lost.",
        cure: "Both ends leave their surface, and the lamp itself is not asked.",
        check: Check::Probe(shadow_ray),
        scene: None,
        picture: None,
    },
    Case {
        id: "I06",
        title: "a floor at 0",
        failure: "An ulp of 0 is 10⁻⁴⁵: a start that is moved by ulps does not move.",
        cure: "A hit has to be further than the error of its t, so nothing has to move.",
        check: Check::Probe(floor_at_zero),
        scene: None,
        picture: None,
    },
    Case {
        id: "I07",
        title: "into glass and out again",
        failure: "A refracted ray that starts on the outer side meets the surface that it has just \
                  passed: black rims.",
        cure: "The start moves to the side of the direction.",
        check: Check::Probe(glass),
        scene: None,
        picture: None,
    },
];

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
        triangles,
        quads: walls,
        spheres: vec![ball],
        slots,
        ..Primitives::default()
    };
    Geometry::build(primitives, accel)
}

fn far_room() -> Vec<Figure> {
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

fn small_room() -> Vec<Figure> {
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

fn touching() -> Vec<Figure> {
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

fn plates() -> Vec<Figure> {
    let y = 1000f32;
    let above = y + 1e-4;
    let mut rng = Rng(4);
    let (mut tunnels, mut tunnels_naive) = (0, 0);
    for size in [1.0, 10.0] {
        let plate = |y: f32| {
            [(-1.0, -1.0), (-1.0, 1.0), (1.0, 1.0), (1.0, -1.0)]
                .map(|(x, z)| Vec3::new(1000.0 + size * x, y, -1000.0 + size * z))
        };
        let geometry = quads::geometry(&[plate(y), plate(above)], AccelKind::Auto);
        let Primitives { quads, .. } = geometry.primitives();
        for _ in 0..50_000 {
            let (u, v) = (0.4 + 0.2 * rng.unit(), 0.4 + 0.2 * rng.unit());
            let point = SurfacePoint::of_quad(&quads[0], u, v);
            let w = rng.direction_about(Vec3::Y);
            // The other plate is near enough to be met within the plates.
            if w.y < 0.01 {
                continue;
            }
            let passes =
                |origin| cast(&geometry, &Ray::new(origin, w)).is_none_or(|hit| hit.prim != 1);
            tunnels += usize::from(passes(point.leave(w)));
            tunnels_naive += usize::from(passes(naive::leave(point.p, Vec3::Y, w, 1e-3)));
        }
    }
    vec![Figure::none(
        "rays of 99000 that miss the other plate (naive: 10⁻³ off)",
        Some(tunnels_naive),
        tunnels,
    )]
}

fn shadow_ray() -> Vec<Figure> {
    // A unit square lamp one above a corner (docs of the form factor: Howell, C-12), moved far off.
    let mut worst = [0.0f64; 2];
    let truth = 0.435_209_9;
    for at in [0.0f32, 1e5] {
        let offset = Vec3::splat(at);
        let lamp = [
            Vec3::Y,
            Vec3::Y + Vec3::X,
            Vec3::new(1.0, 1.0, 1.0),
            Vec3::new(0.0, 1.0, 1.0),
        ]
        .map(|p| p + offset);
        let floor = [(-2.0, -2.0), (-2.0, 2.0), (2.0, 2.0), (2.0, -2.0)]
            .map(|(x, z)| Vec3::new(x, 0.0, z) + offset);
        let geometry = quads::geometry(&[floor, lamp], AccelKind::Auto);
        let quads = &geometry.primitives().quads;
        let from = SurfacePoint::of_quad(&quads[0], 0.5, 0.5);
        const N: usize = 256;
        let mut sums = [0.0f64; 2];
        for i in 0..N * N {
            let [u, v] = [i % N, i / N].map(|k| (k as f32 + 0.5) / N as f32);
            let light = SurfacePoint::of_quad(&quads[1], u, v);
            let to = light.p.as_dvec3() - from.p.as_dvec3();
            let (d2, cos) = (to.length_squared(), to.y / to.length());
            let density = cos * cos / d2 / (N * N) as f64;
            let w = to.normalize().as_vec3();
            let origin = from.leave(w);
            let segment = light.leave(-w) - origin;
            let ours = Ray {
                origin,
                dir: segment.normalize(),
                t_max: segment.length(),
            };
            let naive = Ray {
                origin: naive::leave(from.p, Vec3::Y, w, 1e-4),
                dir: w,
                t_max: to.length() as f32,
            };
            sums[0] += density * f64::from(u8::from(!geometry.occluded(&naive, NOTHING)));
            sums[1] += density * f64::from(u8::from(!geometry.occluded(&ours, 1)));
        }
        for (worst, sum) in worst.iter_mut().zip(sums) {
            *worst = worst.max((sum - truth).abs() / truth);
        }
    }
    vec![Figure::at_most(
        "relative error of the irradiance under a lamp, at 0 and at 10⁵",
        Some(worst[0]),
        worst[1],
        1e-3,
    )]
}

fn floor_at_zero() -> Vec<Figure> {
    let mut rng = Rng(6);
    let mut again = [0; 2];
    for _ in 0..500 {
        let scale = rng.magnitude(6.0);
        let triangle = [0; 3].map(|_| (scale * rng.cube()).with_y(0.0));
        let floor = build(&[triangle], AccelKind::Auto);
        let origin = scale * (rng.cube() + 2.0 * Vec3::Y);
        for _ in 0..1000 {
            let ray = Ray::new(origin, toward(origin, rng.point_of(triangle)));
            let Some(hit) = cast(&floor, &ray) else {
                continue;
            };
            let point = floor.primitives().surface_point(&ray, &hit);
            let w = rng.direction();
            // An ulp up from where the ray arrived.
            let p = ray.at(hit.t);
            let ulp = p.with_y(if w.y < 0.0 {
                p.y.next_down()
            } else {
                p.y.next_up()
            });
            again[0] += usize::from(cast(&floor, &Ray::new(ulp, w)).is_some());
            again[1] += usize::from(cast(&floor, &Ray::new(point.leave(w), w)).is_some());
        }
    }
    vec![Figure::none(
        "rays of 500000 that hit the plane y = 0, which they leave (naive: an ulp up)",
        Some(again[0]),
        again[1],
    )]
}

fn glass() -> Vec<Figure> {
    let mut rng = Rng(7);
    let mut wrong = [0; 2];
    const RAYS: usize = 200_000;
    for _ in 0..RAYS {
        let sphere = Sphere {
            center: 10.0 * rng.cube(),
            radius: rng.magnitude(1.0),
        };
        let origin = sphere.center + 3.0 * sphere.radius * rng.direction();
        let target = sphere.center + 0.55 * sphere.radius * rng.cube();
        let ray = Ray::new(origin, toward(origin, target));
        let Some(t) = sphere.intersect(&ray, f32::INFINITY) else {
            continue;
        };
        let point = SurfacePoint::of_sphere(&sphere, ray.at(t));
        // Into glass of 1.5, by Snell's law.
        let cos = -ray.dir.dot(point.n);
        let inner = (1.0 - (1.0 - cos * cos) / 2.25).sqrt();
        let w = ((ray.dir + cos * point.n) / 1.5 - inner * point.n).normalize();
        let chord = 2.0 * sphere.radius * inner;
        let crosses = |origin| {
            let t = sphere.intersect(&Ray::new(origin, w), f32::INFINITY);
            t.is_some_and(|t| (t / chord - 1.0).abs() < 1e-2)
        };
        // The side of the normal, whatever the direction.
        wrong[0] += usize::from(!crosses(point.leave(point.n)));
        wrong[1] += usize::from(!crosses(point.leave(w)));
    }
    vec![Figure::none(
        "refracted rays of 200000 that do not cross the ball (naive: start outside)",
        Some(wrong[0]),
        wrong[1],
    )]
}
