//! Spheres: cancellation, the choice of the root, normals.

use glam::{DVec3, Vec3};

use super::{Bound, Case, Check, Figure, naive};
use crate::math::Ray;
use crate::shape::Sphere;

pub(super) const CASES: &[Case] = &[Case {
    id: "S01",
    title: "a distant sphere",
    failure: "From 10³ radii on, b² − 4ac cancels: a ring around the sphere is hit that is not there, \
              and distances are off by a radius.",
    cure: "The discriminant as (r − |l|)(r + |l|), l the closest approach to the centre \
           (Haines, Günther & Akenine-Möller 2019).",
    check: Check::Probe(distant),
    scene: None,
    picture: None,
}];

/// Parallel rays past a unit sphere from far away, against f64.
fn distant() -> Vec<Figure> {
    let sphere = Sphere {
        center: Vec3::ZERO,
        radius: 1.0,
    };
    let (mut wrong, mut wrong_naive, mut worst_ulp) = (0, 0, 0.0f64);
    for distance in [1e3f32, 4096.0, 1e4, 1e6] {
        for i in 0..=2000 {
            let x = (i - 1000) as f32 * 1.2e-3;
            if (x.abs() - 1.0).abs() < 1e-3 {
                continue;
            }
            let ray = Ray::new(Vec3::new(x, 0.0, -distance), Vec3::Z);
            let truth = exact(&sphere, &ray);
            let t = sphere.intersect(&ray, f32::INFINITY);
            wrong += u32::from(t.is_some() != truth.is_some());
            wrong_naive += u32::from(naive::sphere(&sphere, &ray).is_some() != truth.is_some());
            if let (Some(t), Some(truth)) = (t, truth) {
                let ulp = f64::from(distance.next_up() - distance);
                worst_ulp = worst_ulp.max((f64::from(t) - truth).abs() / ulp);
            }
        }
    }
    vec![
        Figure {
            what: "rays of some 8000 that hit or miss wrongly",
            naive: Some(wrong_naive.into()),
            lightbox: wrong.into(),
            bound: Bound::Exactly(0.0),
        },
        Figure {
            what: "largest error of t, ulp of the distance",
            naive: None,
            lightbox: worst_ulp,
            bound: Bound::AtMost(2.0),
        },
    ]
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
    (rest >= 0.0).then(|| b - (rest / d.length_squared()).sqrt())
}
