//! Spheres: cancellation, the choice of the root, normals.

use glam::{DVec3, Vec3};

use super::input::toward;
use super::random::Rng;
use super::{Bound, Case, Check, Figure, naive, pictures, sphere_points};
use crate::geometry::SurfacePoint;
use crate::math::Ray;
use crate::shape::Sphere;

pub(super) const CASES: &[Case] = &[
    Case {
        id: "S01",
        title: "a distant sphere",
        failure: "From 10³ radii on, b² − 4ac cancels: a ring around the sphere is hit that is not \
                  there, and distances are off by a radius.",
        cure: "The discriminant as r² − l², l the distance of the ray from the centre (Haines, \
               Günther & Akenine-Möller 2019), in f64.",
        check: Check::Probe(distant),
        scene: Some("builtin:lab/distant-sphere.toml"),
        picture: Some(pictures::distant_sphere),
    },
    Case {
        id: "S02",
        title: "a sphere as floor",
        failure: "Radius 10⁵, seen from a height of 1: (b − √disc)/2a cancels at grazing angles.",
        cure: "The smaller root from the larger one, by |f|² − r² in f64.",
        check: Check::Probe(floor),
        scene: Some("builtin:lab/planet.toml"),
        picture: Some(pictures::planet),
    },
    Case {
        id: "S03",
        title: "a thousandth above a sphere as floor",
        failure: "10⁵ + 10⁻³ is 10⁵ in f32: every form in f32 starts on the surface, and finds it at \
                  0 or on the far side.",
        cure: "The origin relative to the centre in f64, where nothing is lost.",
        check: Check::Probe(just_above),
        scene: None,
        picture: None,
    },
    Case {
        id: "S04",
        title: "a sphere behind the ray",
        failure: "Roots −3 and −1 have a positive product, and the report's rule takes −3.",
        cure: "The first root with t > 0, then the second: signs are compared, never products.",
        check: Check::Probe(behind),
        scene: None,
        picture: None,
    },
    Case {
        id: "S05",
        title: "rays that start on a sphere",
        failure: "A root that should be 0 comes out at ±10⁻⁷: a quarter of all rays that leave a \
                  sphere hit it again, which is the report's inverted mirror ball.",
        cure: "Rays start outside a bound on the error of the hit point (Pharr, Jakob & Humphreys \
               2016, §3.9).",
        check: Check::Probe(sphere_points::leaving),
        scene: Some("builtin:sphere-mirror.toml"),
        picture: Some(pictures::mirror_ball),
    },
    Case {
        id: "S06",
        title: "minute and huge spheres",
        failure: "Products of 10⁻²⁵ underflow to 0 and those of 10²⁵ overflow, so the sphere is lost.",
        cure: "f64 has the room; scaling a scene by a power of two scales distances, bit for bit.",
        check: Check::Probe(scaled),
        scene: None,
        picture: None,
    },
    Case {
        id: "S07",
        title: "inside a sphere",
        failure: "The nearer root is behind; which side was hit is left unsaid, and glass refracts \
                  the wrong way.",
        cure: "Normals point out always; the side is the sign of d·n.",
        check: Check::Probe(sphere_points::inside),
        scene: Some("builtin:sphere-mirror.toml"),
        picture: Some(pictures::inverted_ball),
    },
    Case {
        id: "S08",
        title: "the normal of a sphere",
        failure: "centre − hit, as printed in the report, points inward: shading goes black, \
                  refraction is swapped.",
        cure: "(hit − centre)/r.",
        check: Check::Probe(sphere_points::normals),
        scene: None,
        picture: None,
    },
    Case {
        id: "S09",
        title: "tangents",
        failure: "For a ray that starts where it touches, c/q is 0/0.",
        cure: "q = 0 gives t = 0, which is no hit.",
        check: Check::Probe(tangents),
        scene: None,
        picture: None,
    },
    Case {
        id: "S10",
        title: "directions of any length",
        failure: "|d| = 2^±60 makes a = d·d over- or underflow.",
        cure: "Directions have unit length by contract; in f64 others work too, with t in units of |d|.",
        check: Check::Probe(lengths),
        scene: None,
        picture: None,
    },
    Case {
        id: "S11",
        title: "hit points that drift off the surface",
        failure: "o + t·d is off by the rounding of t: a thousandth of a radius at 10⁴ radii.",
        cure: "The point is put back onto the sphere (Pharr, Jakob & Humphreys 2016, §3.9.4).",
        check: Check::Probe(sphere_points::projected),
        scene: None,
        picture: None,
    },
    Case {
        id: "S12",
        title: "radii that are none",
        failure: "A radius of 0, −1, NaN or ∞ hits everything or poisons the tree's boxes.",
        cure: "Refused when a scene is loaded, in one line.",
        check: Check::Probe(sphere_points::radii),
        scene: None,
        picture: None,
    },
];

pub(super) const UNIT: Sphere = Sphere {
    center: Vec3::ZERO,
    radius: 1.0,
};

const FLOOR: Sphere = Sphere {
    center: Vec3::new(0.0, -1e5, 0.0),
    radius: 1e5,
};

pub(super) fn hit(sphere: &Sphere, ray: &Ray) -> Option<f32> {
    sphere.intersect(ray, f32::INFINITY)
}

/// The nearest hit in front of the origin, in f64.
fn exact(sphere: &Sphere, ray: &Ray) -> Option<f64> {
    let (d, f): (DVec3, DVec3) = (
        ray.dir.as_dvec3(),
        ray.origin.as_dvec3() - sphere.center.as_dvec3(),
    );
    let b = -f.dot(d) / d.length_squared();
    let l = f + b * d;
    let r = f64::from(sphere.radius);
    let rest = r * r - l.length_squared();
    if rest < 0.0 {
        return None;
    }
    let half = (rest / d.length_squared()).sqrt();
    [b - half, b + half].into_iter().find(|t| *t > 0.0)
}

/// Parallel rays past a unit sphere from far away, straight and askew, against f64.
fn distant() -> Vec<Figure> {
    let (mut wrong, mut worst) = ([0; 2], [0.0f64; 2]);
    for distance in [1e3f32, 4096.0, 1e4, 1e6] {
        for i in 0..=2000 {
            let x = (i - 1000) as f32 * 1.2e-3;
            if (x.abs() - 1.0).abs() < 1e-3 {
                continue;
            }
            let ray = Ray::new(Vec3::new(x, 0.0, -distance), Vec3::Z);
            let truth = exact(&UNIT, &ray);
            let found = [naive::sphere(&UNIT, &ray), hit(&UNIT, &ray)];
            let ulp = f64::from(distance.next_up() - distance);
            for (side, t) in found.into_iter().enumerate() {
                wrong[side] += usize::from(t.is_some() != truth.is_some());
                if let (Some(t), Some(truth)) = (t, truth) {
                    worst[side] = worst[side].max((f64::from(t) - truth).abs() / ulp);
                }
            }
        }
    }
    vec![
        Figure::none(
            "rays of 8000 that hit or miss wrongly",
            Some(wrong[0]),
            wrong[1],
        ),
        Figure::at_most(
            "largest error of t, ulp of the distance",
            Some(worst[0]),
            worst[1],
            2.0,
        ),
    ]
}

fn floor() -> Vec<Figure> {
    let error = |dir: Vec3, t: Option<f32>| {
        let ray = Ray::new(Vec3::Y, dir);
        let truth = exact(&FLOOR, &ray).unwrap_or(f64::NAN);
        (f64::from(t.unwrap_or(f32::NAN)) - truth).abs() / truth
    };
    let row = |what, dir: Vec3, limit| {
        let dir = dir.normalize();
        let ray = Ray::new(Vec3::Y, dir);
        Figure::at_most(
            what,
            Some(error(dir, naive::sphere(&FLOOR, &ray))),
            error(dir, hit(&FLOOR, &ray)),
            limit,
        )
    };
    vec![
        row("relative error of t, straight down", -Vec3::Y, 1e-5),
        row(
            "relative error of t, at 53°",
            Vec3::new(0.6, -0.8, 0.0),
            1e-5,
        ),
        row(
            "relative error of t, at 89.2°",
            Vec3::new(0.9999, -0.014, 0.0),
            2e-4,
        ),
    ]
}

fn just_above() -> Vec<Figure> {
    let ray = Ray::new(Vec3::new(0.0, 1e-3, 0.0), -Vec3::Y);
    let truth = exact(&FLOOR, &ray).unwrap_or(f64::NAN);
    let error = |t: Option<f32>| (f64::from(t.unwrap_or(f32::INFINITY)) - truth).abs();
    // The textbook finds the two roots 0 and 2r, and no hit in front but the far one.
    let textbook = naive::sphere_roots(&FLOOR, &ray)
        .and_then(|(t0, t1)| [t0, t1].into_iter().find(|t| *t > 0.0));
    // Rays that leave the floor upward must not find it again.
    let mut rng = Rng(3);
    let mut again = 0;
    for _ in 0..100_000 {
        let d = Vec3::new(rng.unit() - 0.5, -0.05 - rng.unit(), rng.unit() - 0.5).normalize();
        let ray = Ray::new(Vec3::new(0.0, 1e-3, 0.0), d);
        let Some(t) = hit(&FLOOR, &ray) else { continue };
        let point = SurfacePoint::of_sphere(&FLOOR, ray.at(t));
        let w = rng.direction_about(point.n);
        again += usize::from(hit(&FLOOR, &Ray::new(point.leave(w), w)).is_some());
    }
    vec![
        Figure::at_most(
            "error of t",
            Some(error(textbook)),
            error(hit(&FLOOR, &ray)),
            f64::from(1e5f32.next_up() - 1e5),
        ),
        Figure::none("rays of 100000 that hit what they leave", None, again),
    ]
}

fn behind() -> Vec<Figure> {
    let ray = Ray::new(Vec3::new(0.0, 0.0, 2.0), Vec3::Z);
    let count = |t: Option<f32>| usize::from(t.is_some());
    vec![Figure::none(
        "hits behind the origin",
        Some(count(naive::sphere(&UNIT, &ray))),
        count(hit(&UNIT, &ray)),
    )]
}

fn scaled() -> Vec<Figure> {
    let mut rng = Rng(6);
    let mut differing = [0; 2];
    for i in 0..1000 {
        // The first from the centre, the others from anywhere.
        let origin = if i == 0 { Vec3::ZERO } else { 2.0 * rng.cube() };
        let ray = Ray::new(origin, toward(origin, rng.cube()));
        for k in -80..=80 {
            let s = libm::ldexp(1.0, k) as f32;
            let (sphere, scaled) = (
                Sphere {
                    center: UNIT.center,
                    radius: s,
                },
                Ray {
                    origin: ray.origin * s,
                    ..ray
                },
            );
            let same = |a: Option<f32>, b: Option<f32>| {
                a.map(|t| (t * s).to_bits()) == b.map(f32::to_bits)
            };
            differing[0] += usize::from(!same(
                naive::sphere(&UNIT, &ray),
                naive::sphere(&sphere, &scaled),
            ));
            differing[1] += usize::from(!same(hit(&UNIT, &ray), hit(&sphere, &scaled)));
        }
    }
    let minute = Sphere {
        center: Vec3::ZERO,
        radius: 1e-25,
    };
    let out = Ray::new(Vec3::ZERO, Vec3::Z);
    let radii = |t: Option<f32>| f64::from(t.unwrap_or(f32::NAN) / minute.radius);
    vec![
        Figure {
            what: "t from the centre of a sphere of radius 10⁻²⁵, radii",
            naive: Some(radii(naive::sphere(&minute, &out))),
            lightbox: radii(hit(&minute, &out)),
            bound: Bound::Exactly(1.0),
        },
        Figure::none(
            "hits of 161000, at scales 2⁻⁸⁰ to 2⁸⁰, that do not scale bit for bit",
            Some(differing[0]),
            differing[1],
        ),
    ]
}

fn tangents() -> Vec<Figure> {
    // The form c/q without a guard.
    let bare = |ray: &Ray| {
        let f = ray.origin;
        let b = -f.dot(ray.dir);
        let q = b + (b * b - (f.dot(f) - 1.0)).max(0.0).sqrt().copysign(b);
        (f.dot(f) - 1.0) / q
    };
    let touch = Ray::new(Vec3::X, Vec3::Z);
    let hits = |t: Option<f32>| usize::from(t.is_some());
    let approach = Ray::new(Vec3::new(1.0, 0.0, -5.0), Vec3::Z);
    vec![
        Figure::none(
            "hits, NaN included, of a ray that starts where it touches",
            Some(hits(Some(bare(&touch)).filter(|t| !(*t <= 0.0)))),
            hits(hit(&UNIT, &touch)),
        ),
        Figure {
            what: "t of a tangent",
            naive: None,
            lightbox: f64::from(hit(&UNIT, &approach).unwrap_or(f32::NAN)),
            bound: Bound::Exactly(5.0),
        },
    ]
}

fn lengths() -> Vec<Figure> {
    let mut rng = Rng(10);
    let mut differing = [0; 2];
    for _ in 0..500 {
        let origin = 3.0 * rng.direction();
        let ray = Ray::new(origin, toward(origin, 0.5 * rng.cube()));
        for k in -60..=60 {
            let s = libm::ldexp(1.0, k) as f32;
            let long = Ray {
                dir: ray.dir * s,
                ..ray
            };
            let same = |a: Option<f32>, b: Option<f32>| {
                a.map(|t| (t / s).to_bits()) == b.map(f32::to_bits)
            };
            differing[0] += usize::from(!same(
                naive::sphere(&UNIT, &ray),
                naive::sphere(&UNIT, &long),
            ));
            differing[1] += usize::from(!same(hit(&UNIT, &ray), hit(&UNIT, &long)));
        }
    }
    vec![Figure::none(
        "hits of 60500 by directions 2⁻⁶⁰ to 2⁶⁰ long that are not t/|d| bit for bit",
        Some(differing[0]),
        differing[1],
    )]
}
