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
    const SPHERES: usize = 1000;
    const RAYS: usize = 1000;
    let mut rng = Rng(5);
    let mut again = [0; 2];
    for _ in 0..SPHERES {
        let sphere = Sphere {
            center: rng.cube() * rng.magnitude(8.0),
            radius: rng.magnitude(8.0),
        };
        for _ in 0..RAYS {
            let n = rng.direction();
            let surface = sphere.center + sphere.radius * n;
            let point = SurfacePoint::of_sphere(&sphere, surface);
            let w = rng.direction_about(point.n);
            // From the bare point, in front, by the report's rule.
            again[0] +=
                usize::from(naive::sphere(&sphere, &Ray::new(surface, w)).is_some_and(|t| t > 0.0));
            again[1] += usize::from(hit(&sphere, &Ray::new(point.leave(w), w)).is_some());
        }
    }
    let touching = Ray::new(-Vec3::Z, Vec3::Z);
    let length = |t: Option<f32>| f64::from(t.unwrap_or(f32::NAN));
    vec![
        Figure::none(
            "rays of 10⁶ leaving spheres of radius 10⁻⁸ to 10⁸ that hit them",
            Some(again[0]),
            again[1],
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
    let exits = [Vec3::Z, -Vec3::Z].map(|dir| {
        let n = SurfacePoint::of_sphere(&UNIT, origin + t(dir) as f32 * dir).n;
        usize::from(n.dot(dir) <= 0.0)
    });
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
            Some(2), // centre − hit turns both round.
            exits.iter().sum(),
        ),
    ]
}

/// Random spheres, and points that rays hit on them.
fn hits(n: usize, mut f: impl FnMut(&Sphere, &Ray, f32)) {
    let mut rng = Rng(8);
    for _ in 0..n {
        let radius = rng.magnitude(3.0);
        let sphere = Sphere {
            center: rng.cube() * rng.magnitude(3.0),
            radius,
        };
        let origin = sphere.center + radius * (1.5 + 1e4 * rng.unit()) * rng.direction();
        let ray = Ray::new(
            origin,
            toward(origin, sphere.center + 0.5 * radius * rng.cube()),
        );
        if let Some(t) = hit(&sphere, &ray) {
            f(&sphere, &ray, t);
        }
    }
}

pub(super) fn normals() -> Vec<Figure> {
    let mut worst = [0.0f64; 2];
    hits(20_000, |sphere, ray, t| {
        let point = SurfacePoint::of_sphere(sphere, ray.at(t));
        // As far as the point's own rounding lets the radius be known.
        let radius = f64::from(sphere.radius);
        let r = (point.p.as_dvec3() - sphere.center.as_dvec3()) / radius;
        let slack = f64::from(point.surface[0].abs().max(point.surface[1].abs())) / radius;
        let error = |n: Vec3| ((n.as_dvec3().dot(r) - 1.0).abs() - slack) / f64::from(f32::EPSILON);
        worst[0] = worst[0].max(error(-point.n));
        worst[1] = worst[1].max(error(point.n));
    });
    vec![Figure::at_most(
        "n·(p − c)/r less 1, ulp beyond the rounding of p",
        Some(worst[0]),
        worst[1],
        4.0,
    )]
}

pub(super) fn projected() -> Vec<Figure> {
    let mut worst = [0.0f64; 2];
    hits(20_000, |sphere, ray, t| {
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
            .build(&|_| ())
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
