//! The points of spheres: starts, normals, sides, and radii that are none.

use glam::Vec3;

use super::input::toward;
use super::random::Rng;
use super::sphere::{UNIT, hit};
use super::{Bound, Figure, naive};
use crate::geometry::SurfacePoint;
use crate::math::Ray;
use crate::scene::{MaterialDesc, SceneDesc, Source, SphereDesc};
use crate::shape::Sphere;

pub(super) fn leaving() -> Vec<Figure> {
    let mut rng = Rng(5);
    let mut again = |sphere: &Sphere, rays: usize, found: &mut [usize; 2]| {
        for _ in 0..rays {
            let n = rng.direction();
            let surface = sphere.center + sphere.radius * n;
            let point = SurfacePoint::of_sphere(sphere, surface);
            let w = rng.direction_about(point.n);
            // From the bare point, in front, by the report's rule.
            let bare = naive::sphere(sphere, &Ray::new(surface, w));
            found[0] += usize::from(bare.is_some_and(|t| t > 0.0));
            found[1] += usize::from(hit(sphere, &Ray::new(point.leave(w), w)).is_some());
        }
    };
    let mut of_radius_10 = [0; 2];
    let ten = Sphere {
        radius: 10.0,
        ..UNIT
    };
    again(&ten, 100_000, &mut of_radius_10);
    let mut of_any = [0; 2];
    let mut sizes = Rng(55);
    for _ in 0..1000 {
        let sphere = Sphere {
            center: sizes.cube() * sizes.magnitude(8.0),
            radius: sizes.magnitude(8.0),
        };
        again(&sphere, 1000, &mut of_any);
    }
    let touching = Ray::new(-Vec3::Z, Vec3::Z);
    let length = |t: Option<f32>| f64::from(t.unwrap_or(f32::NAN));
    vec![
        Figure::none(
            "rays of 10⁵ leaving a sphere of radius 10 that hit it",
            Some(of_radius_10[0]),
            of_radius_10[1],
        ),
        Figure::none(
            "rays of 10⁶ leaving spheres of radius 10⁻⁸ to 10⁸ that hit them",
            Some(of_any[0]),
            of_any[1],
        ),
        Figure {
            what: "t of a ray from the surface through a unit sphere",
            naive: Some(length(naive::sphere(&UNIT, &touching))),
            lightbox: length(hit(&UNIT, &touching)),
            bound: Bound::Exactly(2.0),
        },
    ]
}

pub(super) fn inside() -> Vec<Figure> {
    let origin = Vec3::new(0.0, 0.0, 0.5);
    let t = |dir| f64::from(hit(&UNIT, &Ray::new(origin, dir)).unwrap_or(f32::NAN));
    // Naively by centre − hit.
    let entries = |normal: &dyn Fn(Vec3) -> Vec3| {
        let is_entry = |dir: &&Vec3| normal(origin + t(**dir) as f32 * **dir).dot(**dir) <= 0.0;
        [Vec3::Z, -Vec3::Z].iter().filter(is_entry).count()
    };
    vec![
        Figure {
            what: "t towards the near side",
            naive: None,
            lightbox: t(Vec3::Z),
            bound: Bound::Exactly(0.5),
        },
        Figure {
            what: "t towards the far side",
            naive: None,
            lightbox: t(-Vec3::Z),
            bound: Bound::Exactly(1.5),
        },
        Figure::none(
            "exits of 2 taken for entries",
            Some(entries(&|p| UNIT.center - p)),
            entries(&|p| SurfacePoint::of_sphere(&UNIT, p).n),
        ),
    ]
}

/// Spheres, at any place within ±`spread` and one in four the unit sphere seen from 10⁴ away, and
/// points that rays hit on them.
fn hits(n: usize, spread: f32, mut f: impl FnMut(&Sphere, &Ray, f32)) {
    let mut rng = Rng(8);
    for i in 0..n {
        let (sphere, away) = if i % 4 == 0 {
            (UNIT, 1e4)
        } else {
            let center = spread * rng.cube() * rng.magnitude(3.0);
            let radius = rng.magnitude(3.0);
            (Sphere { center, radius }, 1.5 + 1e4 * rng.unit())
        };
        let origin = sphere.center + sphere.radius * away * rng.direction();
        let target = sphere.center + 0.5 * sphere.radius * rng.cube();
        let ray = Ray::new(origin, toward(origin, target));
        if let Some(t) = hit(&sphere, &ray) {
            f(&sphere, &ray, t);
        }
    }
}

pub(super) fn normals() -> Vec<Figure> {
    let ulp = f64::from(f32::EPSILON);
    let mut along = [0.0f64; 2];
    hits(20_000, 0.0, |sphere, ray, t| {
        let point = SurfacePoint::of_sphere(sphere, ray.at(t));
        let r = (point.p - sphere.center).as_dvec3() / f64::from(sphere.radius);
        for (worst, n) in along.iter_mut().zip([-point.n, point.n]) {
            *worst = worst.max((n.as_dvec3().dot(r) - 1.0).abs() / ulp);
        }
    });
    // Elsewhere the point is rounded, and with it its distance; its direction is the normal's.
    let mut off = [0.0f64; 2];
    hits(20_000, 1.0, |sphere, ray, t| {
        let point = SurfacePoint::of_sphere(sphere, ray.at(t));
        let r = point.p.as_dvec3() - sphere.center.as_dvec3();
        for (worst, n) in off.iter_mut().zip([-point.n, point.n]) {
            *worst = worst.max((n.as_dvec3() - r.normalize()).length() / ulp);
        }
    });
    vec![
        Figure::at_most(
            "n·(p − c)/r less 1 about the origin, ulp",
            Some(along[0]),
            along[1],
            4.0,
        ),
        Figure::at_most(
            "distance of n from the direction of p − c anywhere, ulp",
            Some(off[0]),
            off[1],
            4.0,
        ),
    ]
}

pub(super) fn projected() -> Vec<Figure> {
    let mut worst = [0.0f64; 2];
    hits(20_000, 1.0, |sphere, ray, t| {
        let (c, r) = (sphere.center.as_dvec3(), f64::from(sphere.radius));
        let largest = sphere.radius.max(sphere.center.length());
        let ulp = f64::from(largest.next_up() - largest);
        let off = |p: Vec3| ((p.as_dvec3() - c).length() - r).abs() / ulp;
        worst[0] = worst[0].max(off(ray.at(t)));
        worst[1] = worst[1].max(off(SurfacePoint::of_sphere(sphere, ray.at(t)).p));
    });
    vec![Figure::at_most(
        "distance of hit points from the surface, ulp of the larger of radius and |centre|",
        Some(worst[0]),
        worst[1],
        2.0,
    )]
}

pub(super) fn radii() -> Vec<Figure> {
    let accepted = |radius| {
        let desc = SceneDesc {
            materials: vec![MaterialDesc {
                name: "white".into(),
                ..MaterialDesc::default()
            }],
            spheres: vec![SphereDesc {
                name: String::new(),
                material: "white".into(),
                center: Vec3::ZERO,
                radius,
            }],
            ..SceneDesc::default()
        };
        Source::from_desc(desc, std::path::Path::new("radii.toml"))
            .build(&crate::scene::unwatched)
            .is_ok()
    };
    let bad = [0.0, -0.0, -1.0, f32::NAN, f32::INFINITY];
    vec![
        Figure::none(
            "radii of 0, −0, −1, NaN and ∞ that are accepted",
            None,
            bad.into_iter().filter(|r| accepted(*r)).count(),
        ),
        Figure::none(
            "radii of 10⁻²⁰ and 10¹⁷ that are refused",
            None,
            [1e-20, 1e17].into_iter().filter(|r| !accepted(*r)).count(),
        ),
    ]
}
