//! What fuzzing has found, each as the smallest case that showed it.

use glam::Vec3;
use lightbox_core::color::ToneMap;
use lightbox_core::geometry::{Geometry, Primitives, SurfacePoint};
use lightbox_core::lab::random::Rng;
use lightbox_core::light::Lights;
use lightbox_core::math::Ray;
use lightbox_core::scene::CameraDesc;
use lightbox_core::shape::{Quad, ShearedRay, Sphere};
use lightbox_core::{AccelKind, Camera, Image, image_io};

fn sphere(center: Vec3, radius: f32) -> Primitives {
    Primitives {
        spheres: vec![Sphere { center, radius }],
        ..Primitives::default()
    }
}

/// The radius is below the rounding of the centre: the point of the surface is the centre, and
/// the way from there to itself has no direction.
#[test]
fn a_minute_sphere_far_out_has_a_normal() {
    let center = Vec3::new(-38_495.043, 36_316.41, 2.0);
    let primitives = sphere(center, 1e-4);
    let lights = Lights::new(&primitives, [(0, 1.0)]);
    let sample = lights
        .sample(Vec3::ZERO, || 0.5, || [0.5, 0.5])
        .expect("it shines everywhere");
    assert!(
        sample.point.p.is_finite() && sample.point.n.is_normalized(),
        "{sample:?}"
    );

    let ray = Ray::new(center + Vec3::X, -Vec3::X);
    let geometry = Geometry::build(primitives, AccelKind::Brute);
    let hit = geometry.intersect(&ray, |_| false).expect("in the middle");
    let point = geometry.primitives().surface_point(&ray, &hit);
    assert!(point.p.is_finite() && point.n.is_normalized(), "{point:?}");
}

/// A product overflows, and an infinite distance was within an infinite `t_max`.
#[test]
fn an_infinite_distance_is_no_hit() {
    let (x, y) = (1e15 * Vec3::X, 1e15 * Vec3::Y);
    let primitives = Primitives {
        triangles: vec![[x - y, y, -x - y]].into(),
        ..Primitives::default()
    };
    let geometry = Geometry::build(primitives, AccelKind::Brute);
    let ray = Ray::new(Vec3::new(0.0, 0.0, 1e20), -Vec3::Z);
    let hit = geometry.intersect(&ray, |_| false);
    assert!(hit.is_none_or(|h| h.t.is_finite()), "{hit:?}");
}

/// Nothing lies within a reach of minus infinity, which is also the sign of a finished search.
#[test]
fn a_ray_without_reach_is_not_occluded() {
    let ray = Ray {
        t_max: f32::NEG_INFINITY,
        ..Ray::new(-3.0 * Vec3::X, Vec3::X)
    };
    for kind in AccelKind::ALL {
        let geometry = Geometry::build(sphere(Vec3::ZERO, 1.0), *kind);
        assert!(!geometry.occluded(&ray, u32::MAX), "{kind}");
    }
}

/// An EXR file without pixels was written that nothing could read.
#[test]
fn a_picture_without_pixels_is_not_written() {
    let folder = tempfile::tempdir().expect("a folder");
    let empty = Image {
        width: 4,
        height: 0,
        pixels: Vec::new(),
    };
    for name in ["empty.exr", "empty.png"] {
        let path = folder.path().join(name);
        let message =
            image_io::write(&path, &empty, ToneMap::default(), "").expect_err("no pixels");
        assert!(message.contains("no pixels") && !path.exists(), "{message}");
    }
}

/// Pixels are ten million units apart at a field of view just below 180 degrees: counted from the
/// corner of the picture, the axis was lost in their sum.
#[test]
fn the_widest_camera_has_rays() {
    let desc = CameraDesc {
        eye: Vec3::new(-1.0, -0.024_856_532, 0.5),
        target: Vec3::new(0.023_835_784, -8.0, 0.5),
        up: Vec3::Z,
        fov: 180f32.next_down(),
    };
    for (width, height) in [(1, 1), (51, 37), (16_384, 64)] {
        let camera = Camera::new(&desc, width, height).expect("a camera");
        let (x, y) = (width as f32 * 0.5, height as f32 * 0.5);
        let middle = camera.ray([0, 0], [x - 0.5, y - 0.5]);
        assert!(
            (middle.dir - camera.forward()).length() < 1e-6,
            "{middle:?}"
        );
    }
}

/// A triangle 2000 long that the ray starts beside and meets far ahead, almost edge-on: the bound
/// on the error of the distance was taken from the vertex farthest away, and the hit was dropped
/// as one that might lie behind.
#[test]
fn a_long_triangle_beside_the_origin_is_hit_ahead() {
    let triangle = [
        Vec3::new(0.0, 1.0, -2154.078),
        Vec3::new(-1.0, 0.0, -2.0),
        Vec3::new(0.25, 0.0, 2.0),
    ];
    let dir = Vec3::new(0.000_754_382_8, 0.000_464_235_58, -0.999_999_6);
    let ray = Ray::new(Vec3::new(-1.0, 0.0, 0.0), dir);
    let hit = ShearedRay::new(&ray).triangle(triangle, f32::MAX);
    let t = hit.expect("it is ahead").t;
    assert!((t - 1077.0436).abs() < 0.6, "{t}");
}

/// Next to a sphere 10⁴ times as large as the height over it, that height was lost in f32, and
/// points beyond the horizon were taken to be in sight.
#[test]
fn what_is_sampled_of_a_planet_is_in_sight() {
    let primitives = sphere(Vec3::new(0.0, 4.0, -65_535.82), 65_535.996);
    let lights = Lights::new(&primitives, [(0, 1.0)]);
    let p = Vec3::new(-42.666_664, 5.0, 5.0);
    let largest = 1.0 - f32::EPSILON / 2.0;
    for u in [0.5, 0.99, 0.9999, 0.999_999, largest] {
        for v in [0.0, 0.3, 0.5, 0.8] {
            let sample = lights.sample(p, || 0.5, || [u, v]).expect("from outside");
            let toward = p.as_dvec3() - sample.point.p.as_dvec3();
            let side = toward.dot(sample.point.n.as_dvec3());
            assert!(side > -4e-7 * toward.length(), "{side} from {sample:?}");
        }
    }
}

/// Balls a few steps of f32 large: their points are moved along the surface so far that the normal
/// turns, and rays into them left to the outside, or the other way round.
#[test]
fn rays_leave_balls_of_a_few_steps() {
    let mut rng = Rng::new(1);
    for _ in 0..20_000 {
        let center = 1e6 * rng.direction();
        let ball = Sphere {
            center,
            radius: 0.2 + rng.unit(),
        };
        let origin = center + 3.0 * rng.cube();
        let ray = Ray::new(origin, (center - origin).normalize());
        let Some(t) = ball.intersect(&ray, f32::INFINITY) else {
            continue;
        };
        let point = SurfacePoint::of_sphere(&ball, ray.at(t));
        let w = rng.direction();
        let cos = w.dot(point.n);
        let again = ball.intersect(&Ray::new(point.leave(w), w), f32::INFINITY);
        // Outward never; inward the other side, less what rounding makes of the start.
        let depth = (point.leave(w) - point.p).length();
        let least = -cos * ball.radius - 2.0 * depth;
        assert!(
            again.is_none_or(|t| cos < 0.0 && t >= least),
            "{ball:?} {point:?} along {w}: {again:?} for {least}"
        );
    }
}

/// Edges of a thin triangle, rounded to f32, gave a normal that was off by twelve degrees, and
/// rays along it left to the wrong side.
#[test]
fn rays_leave_thin_triangles_along_their_normals() {
    let found = [
        Vec3::new(-3.0, -1.0, -1.0),
        Vec3::new(-0.5, -15.999_999, -15.999_999),
        Vec3::new(-0.499_999_9, -15.999_999, -15.999_997),
    ];
    let origin = Vec3::new(-15.999_999, -1.0, -0.499_061_55);
    let dir = Vec3::new(0.792_489_5, -0.417_099_77, -0.444_958_54);
    let mut rng = Rng::new(2);
    for i in 0..20_000 {
        let (triangle, ray) = if i == 0 {
            (found, Ray::new(origin, dir))
        } else {
            let (a, along) = (16.0 * rng.cube(), 16.0 * rng.direction());
            let thin = [a, a + along, a + along + 1e-5 * rng.cube()];
            let (origin, target) = (16.0 * rng.cube(), rng.point_of(thin));
            (thin, Ray::new(origin, (target - origin).normalize()))
        };
        let Some(hit) = ShearedRay::new(&ray).triangle(triangle, f32::INFINITY) else {
            assert_ne!(i, 0, "it is hit");
            continue;
        };
        let point = SurfacePoint::of_triangle(triangle, [hit.b1, hit.b2]);
        for w in [point.n, -point.n] {
            let onward = Ray::new(point.leave(w), w);
            let again = ShearedRay::new(&onward).triangle(triangle, f32::INFINITY);
            assert_eq!(again, None, "{triangle:?} {ray:?} along {w}");
        }
    }
}

/// A point of a planet a few units in the last place of f64 off its surface, where f32 has more
/// digits than that: it may be off by what f64 computes in, and says so.
#[test]
fn a_point_of_a_planet_near_the_origin_tells_how_far_off_it_is() {
    let center = Vec3::new(0.000_118_395_16, -65_535.996, -0.000_602_722_1);
    let planet = Sphere {
        center,
        radius: 65_535.996,
    };
    let point = SurfacePoint::of_sphere(&planet, Vec3::ZERO);
    let off = (point.p.as_dvec3() - center.as_dvec3()).length() - f64::from(planet.radius);
    let [low, high] = point.surface.map(f64::from);
    assert!(low <= -off && -off <= high, "{off} for {point:?}");
    assert!(high - low < 1e-9, "{point:?}");
}

/// A ray meets a surface and goes on from there, or back, without meeting it again.
fn leaves_for_good(primitives: Primitives, ray: Ray) {
    let geometry = Geometry::build(primitives, AccelKind::Brute);
    let hit = geometry.intersect(&ray, |_| false).expect("its middle");
    let point = geometry.primitives().surface_point(&ray, &hit);
    for w in [ray.dir, -ray.dir] {
        let again = geometry.intersect(&Ray::new(point.leave(w), w), |_| false);
        assert_eq!(again, None, "along {w}");
    }
}

/// From the far end of a long triangle, rounding in f64 put the start of a ray on the wrong side.
#[test]
fn a_ray_that_leaves_a_needle_does_not_meet_it_again() {
    let primitives = Primitives {
        triangles: vec![[
            Vec3::new(0.25, -0.5, 2031.4962),
            Vec3::ZERO,
            Vec3::new(0.0, 0.000356833, -0.5),
        ]]
        .into(),
        ..Primitives::default()
    };
    leaves_for_good(
        primitives,
        Ray::new(
            Vec3::new(1.0, -6.0, -0.052696075),
            Vec3::new(-0.16439281, 0.9863569, 0.008662856),
        ),
    );
}

/// Where the edges of a needle are all but parallel, its normal lost the digits that tell the sides
/// of a start apart that is 10⁻¹² off the needle.
#[test]
fn a_ray_that_leaves_a_needle_along_it_does_not_meet_it_again() {
    let primitives = Primitives {
        triangles: vec![[
            Vec3::new(-15.999999, -15.999902, -15.999999),
            Vec3::new(-15.999885, -15.999999, -15.999999),
            Vec3::new(-0.032180306, -0.03210784, -0.03210784),
        ]]
        .into(),
        ..Primitives::default()
    };
    leaves_for_good(primitives, Ray::new(Vec3::ZERO, Vec3::splat(-0.57735026)));
}

/// From the far corner of a large rectangle, rounding put a point behind it before it.
#[test]
fn what_is_behind_a_large_rectangle_is_not_lit() {
    let corners = [
        Vec3::new(-65432.105, -65535.996, 0.25),
        Vec3::new(-0.0, 2.300_739_1e-5, 0.25),
        Vec3::new(-0.0, 0.0, -1.0),
        Vec3::new(-65432.105, -65535.996, -1.0),
    ];
    let primitives = Primitives {
        quads: vec![Quad::new(corners)],
        ..Primitives::default()
    };
    let lights = Lights::new(&primitives, [(0, 1.0)]);
    let p = Vec3::new(0.25, 0.25, -0.5);
    let before = Vec3::new(0.25, 0.251, -0.5);
    for i in 0..10_000 {
        let u = [i % 100, i / 100].map(|k| (k as f32 + 0.5) / 100.0);
        let sample = lights.sample(p, || 0.5, || u);
        assert!(sample.is_none(), "{u:?}: {sample:?}");
        assert!(lights.sample(before, || 0.5, || u).is_some(), "{u:?}");
    }
}

/// Where a point all but touches a large sphere, rounding puts what is sampled behind it.
#[test]
fn what_is_sampled_of_a_sphere_that_is_touched_faces_the_point() {
    let sphere = Sphere {
        center: Vec3::new(0.00011839516, -65_535.996, -0.0006027221),
        radius: 65_535.996,
    };
    let primitives = Primitives {
        spheres: vec![sphere],
        ..Primitives::default()
    };
    let lights = Lights::new(&primitives, [(0, 1.0)]);
    let p = Vec3::new(0.0, -3.6248583e-25, -0.0);
    for i in 0..10_000 {
        let u = [i % 100, i / 100].map(|k| (k as f32 + 0.5) / 100.0);
        if let Some(sample) = lights.sample(p, || 0.5, || u) {
            let from_behind = (p - sample.point.p).dot(sample.point.n) <= 0.0;
            assert!(!from_behind, "{u:?}: {sample:?}");
        }
    }
}
