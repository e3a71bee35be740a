//! Rays that leave surfaces: self-hits, tunnels and leaks. Those on paths are in `rooms`.

use glam::Vec3;

use super::input::{NOTHING, build, cast, toward};
use super::random::Rng;
use super::{Case, Check, Figure, naive, quads, room_pictures, rooms};
use crate::geometry::{Primitives, SurfacePoint};
use crate::math::Ray;
use crate::settings::AccelKind;
use crate::shape::Sphere;

pub(super) const CASES: &[Case] = &[
    Case {
        id: "I01",
        title: "a room far from the origin",
        failure: "A fixed start of 10⁻⁴ off the surface vanishes in rounding at coordinates of 10⁴: \
                  acne, then black, then light leaks.",
        cure: "The start is moved beyond the rounding of the hit point (Pharr, Jakob & Humphreys \
               2016, §3.9.5).",
        check: Check::Probe(rooms::far_room),
        scene: Some("builtin:lab/far-room.toml"),
        picture: Some(room_pictures::far_room),
    },
    Case {
        id: "I02",
        title: "a room a thousand times smaller",
        failure: "A fixed start is suddenly large: shadows come off their objects.",
        cure: "No absolute number anywhere: paths in a scene scaled by a power of two are the same, bit for bit.",
        check: Check::Probe(rooms::small_room),
        scene: Some("builtin:lab/small-room.toml"),
        picture: Some(room_pictures::small_room),
    },
    Case {
        id: "I03",
        title: "a ball that touches the floor",
        failure: "Near the point of touch, the start jumps through the second surface.",
        cure: "The start moves by an ulp or two, and no further than the surface may be off.",
        check: Check::Probe(rooms::touching),
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
        cure: "A point in the plane is in it exactly; f64 sees that the plane is not ahead.",
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
