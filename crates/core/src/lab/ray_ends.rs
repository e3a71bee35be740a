//! Rays that are none, and the ends of those that are.

use glam::Vec3;

use super::input::{NOTHING, Triangle, all, cast, icosphere, meaningless, toward};
use super::random::Rng;
use super::{Figure, naive};
use crate::geometry::{Geometry, Primitives};
use crate::math::Ray;
use crate::settings::AccelKind;
use crate::shape::{Quad, Sphere};

pub(super) fn no_rays() -> Vec<Figure> {
    let triangles = icosphere(2);
    let mut rng = Rng(6);
    let bad: Vec<Ray> = (0..1000)
        .flat_map(|_| {
            let origin = 3.0 * rng.direction();
            meaningless(Ray::new(origin, toward(origin, 0.5 * rng.cube())))
        })
        .collect();
    let mut found = 0;
    for geometry in all(&triangles) {
        for ray in &bad {
            found += usize::from(cast(&geometry, ray).is_some());
            found += usize::from(geometry.occluded(ray, NOTHING));
        }
    }
    // NaN passes the naive triangle's tests.
    let naive = bad.iter().take(1000).filter(|ray| {
        let hits = |t: &Triangle| naive::triangle(*t, ray, naive::Edges::Closed).is_some();
        triangles.iter().any(hits)
    });
    vec![Figure::none(
        "hits by 33000 rays of 33 kinds that are none (naive: of the first 1000)",
        Some(naive.count()),
        found,
    )]
}

pub(super) fn ends() -> Vec<Figure> {
    let square = [Vec3::ZERO, Vec3::X, Vec3::X + Vec3::Y, Vec3::Y].map(|p| p.with_z(2.0));
    let [a, b, c, d] = square;
    // The same surface 2 away as each kind of primitive, three to a scene so that trees are built.
    let scenes: [&dyn Fn() -> Primitives; 3] = [
        &|| Primitives {
            triangles: vec![[a, b, c], [a, c, d], [a, b, d]].into(),
            slots: vec![0; 3],
            ..Primitives::default()
        },
        &|| Primitives {
            quads: vec![Quad::new(square); 3],
            slots: vec![0; 3],
            ..Primitives::default()
        },
        &|| Primitives {
            spheres: vec![
                Sphere {
                    center: Vec3::new(0.5, 0.25, 3.0),
                    radius: 1.0,
                };
                3
            ],
            slots: vec![0; 3],
            ..Primitives::default()
        },
    ];
    let ray = Ray::new(Vec3::new(0.5, 0.25, 0.0), Vec3::Z);
    let mut wrong = 0;
    for scene in scenes {
        for accel in AccelKind::ALL {
            let geometry = Geometry::build(scene(), *accel);
            for (t_max, hits) in [
                (f32::INFINITY, true),
                (f32::MAX, true),
                (2.0, true),
                (2f32.next_down(), false),
                (1.0, false),
                (f32::MIN_POSITIVE, false),
                (0.0, false),
                (-0.0, false),
                (-1.0, false),
                (f32::NEG_INFINITY, false),
                (f32::NAN, false),
            ] {
                let ray = Ray { t_max, ..ray };
                wrong += usize::from(cast(&geometry, &ray).is_some_and(|h| h.t == 2.0) != hits);
                wrong += usize::from(geometry.occluded(&ray, NOTHING) != hits);
            }
        }
    }
    vec![Figure::none(
        "wrong answers for 11 values of t_max and three shapes",
        None,
        wrong,
    )]
}
