//! Every accelerator on every kernel against a loop over all primitives: bit for bit.

use glam::Vec3;

use super::*;
use crate::accel::test::{Rng, bumpy_sphere, needles, rays_at};
use crate::settings::AccelKind;
use crate::shape::ShearedRay;
use crate::simd::Kernel;

/// What a ray hits, by the definition: the least (distance, id), where emitters count as nearer
/// by 2⁻²⁰; of a quad's two triangles the nearer.
fn expected(primitives: &Primitives, ray: &Ray, is_emitter: impl Fn(u32) -> bool) -> Option<Hit> {
    expected_of(0..primitives.len() as u32, primitives, ray, is_emitter)
}

/// The same, of some of the primitives.
pub(super) fn expected_of(
    ids: impl Iterator<Item = u32>,
    primitives: &Primitives,
    ray: &Ray,
    is_emitter: impl Fn(u32) -> bool,
) -> Option<Hit> {
    let sheared = ShearedRay::new(ray);
    let mut best: Option<Hit> = None;
    let mut offer = |id: u32, t: f32, u: f32, v: f32| {
        let t = if is_emitter(id) {
            t * (1.0 - 1.0 / 1_048_576.0)
        } else {
            t
        };
        if t <= ray.t_max && best.is_none_or(|b| t < b.t) {
            best = Some(Hit { t, prim: id, u, v });
        }
    };
    for id in ids {
        match primitives.get(id) {
            Primitive::Triangle(triangle) => {
                if let Some(h) = sheared.triangle(triangle, f32::INFINITY) {
                    offer(id, h.t, h.b1, h.b2);
                }
            }
            Primitive::Quad(quad) => {
                let [first, second] = quad.triangles();
                if let Some(h) = sheared.triangle(first, f32::INFINITY) {
                    offer(id, h.t, h.b1 + h.b2, h.b2);
                }
                if let Some(h) = sheared.triangle(second, f32::INFINITY) {
                    offer(id, h.t, h.b1, h.b1 + h.b2);
                }
            }
            Primitive::Sphere(sphere) => {
                if let Some(t) = sphere.intersect(ray, f32::INFINITY) {
                    offer(id, t, 0.0, 0.0);
                }
            }
        }
    }
    best
}

fn bits(hit: Option<Hit>) -> Option<[u32; 4]> {
    hit.map(|h| [h.t.to_bits(), h.prim, h.u.to_bits(), h.v.to_bits()])
}

/// Compares everything; gives the number of hits.
pub(super) fn check(make: impl Fn() -> Primitives, rays: &[Ray], emitters: u32) -> usize {
    let is_emitter = |id: u32| emitters != 0 && id.is_multiple_of(emitters);
    let primitives = make();
    let found: Vec<_> = rays
        .iter()
        .map(|ray| expected(&primitives, ray, is_emitter))
        .collect();
    let plain: Vec<_> = rays
        .iter()
        .map(|ray| expected(&primitives, ray, |_| false))
        .collect();
    for &accel in AccelKind::ALL {
        for kernel in Kernel::available() {
            let geometry = Geometry::build_for(make(), accel, kernel);
            for ((ray, hit), plain) in rays.iter().zip(&found).zip(&plain) {
                let got = geometry.intersect(ray, is_emitter);
                assert_eq!(bits(got), bits(*hit), "{accel} {kernel:?} {ray:?}");
                let shaded = geometry.occluded(ray, u32::MAX);
                assert_eq!(shaded, plain.is_some(), "{accel} {kernel:?} {ray:?}");
            }
            check_many(&geometry, rays, is_emitter);
        }
    }
    found.iter().flatten().count()
}

/// All rays in one call against one by one; each must be answered once.
fn check_many(geometry: &Geometry, rays: &[Ray], is_emitter: impl Fn(u32) -> bool + Copy) {
    let mut answers = vec![0; rays.len()];
    geometry.intersect_many(
        rays,
        |ray| *ray,
        is_emitter,
        |i, hit| {
            answers[i] += 1;
            let alone = geometry.intersect(&rays[i], is_emitter);
            assert_eq!(bits(hit), bits(alone), "{:?}", rays[i]);
        },
    );
    let segments = rays.iter().zip([u32::MAX, 0].into_iter().cycle());
    let segments: Vec<(&Ray, u32)> = segments.collect();
    geometry.occluded_many(
        &segments,
        |(ray, except)| (**ray, *except),
        |i, shaded| {
            answers[i] += 1;
            let (ray, except) = segments[i];
            assert_eq!(shaded, geometry.occluded(ray, except), "{ray:?}");
        },
    );
    assert!(answers.iter().all(|&n| n == 2));
}

/// Triangles as they are, each with a neighbour in the same plane; quads and spheres from them.
pub fn mixed(triangles: &[[Vec3; 3]], spheres: usize) -> Primitives {
    let mut primitives = Primitives::default();
    for (i, &[a, b, c]) in triangles.iter().enumerate() {
        if i < spheres {
            let (center, radius) = (a, 0.3 * (b - a).length());
            primitives.spheres.push(Sphere { center, radius });
        } else if i % 3 == 0 {
            primitives.quads.push(Quad::new([a, b, b + (c - a), c]));
        } else {
            primitives.triangles.extend([[a, b, c]; 2]);
        }
    }
    primitives
}

#[test]
fn mixtures_of_all_shapes_are_hit_as_by_the_definition() {
    let mut rng = Rng(31);
    let mut hits = 0;
    for (n, size, spheres) in [
        (1, 1.0, 1),
        (6, 1.0, 0),
        (40, 0.6, 3),
        (300, 0.3, 60),
        (3000, 0.1, 9),
    ] {
        let triangles = rng.soup(n, size);
        let rays = rays_at(&triangles, 1500, &mut rng);
        for emitters in [0, 1, 7] {
            hits += check(|| mixed(&triangles, spheres), &rays, emitters);
        }
    }
    assert!(hits > 5000, "{hits}");
}

#[test]
fn meshes_and_needles_are_hit_as_by_the_definition() {
    let mut rng = Rng(32);
    for triangles in [bumpy_sphere(20), needles(400, 20.0, &mut rng)] {
        let rays = rays_at(&triangles, 1500, &mut rng);
        let make = || Primitives {
            triangles: triangles.clone().into(),
            ..Primitives::default()
        };
        assert!(check(make, &rays, 0) > 100);
    }
}

#[test]
fn diagonals_and_edges_of_coplanar_quads_have_one_answer() {
    // Quads of a plane, each there twice, hit on diagonals, edges and corners.
    let mut rng = Rng(33);
    let tilt = |p: Vec3| glam::Quat::from_axis_angle(Vec3::new(0.6, 0.0, 0.8), 0.7) * p;
    let make = || Primitives {
        quads: (0..32)
            .map(|i| {
                let at = Vec3::new((i / 2 % 4) as f32, (i / 8) as f32, 3.0);
                Quad::new([at, at + Vec3::X, at + Vec3::X + Vec3::Y, at + Vec3::Y].map(tilt))
            })
            .collect(),
        ..Primitives::default()
    };
    let rays: Vec<Ray> = (0..6000)
        .map(|_| {
            let mut grid = || rng.below(17) as f32 / 4.0;
            let target = tilt(Vec3::new(grid(), grid(), 3.0));
            Ray::new(Vec3::ZERO, target.normalize())
        })
        .collect();
    for emitters in [0, 2, 3] {
        assert!(check(make, &rays, emitters) > 5000);
    }
}

#[test]
fn a_closed_mesh_has_no_holes() {
    let triangles = bumpy_sphere(40);
    let mut rng = Rng(34);
    let targets: Vec<Vec3> = (0..20_000)
        .map(|i| {
            let t = triangles[rng.below(triangles.len())];
            match i % 3 {
                0 => t[0],
                1 => t[0].lerp(t[1], rng.unit()),
                _ => rng.point_of(t),
            }
        })
        .collect();
    for &accel in AccelKind::ALL {
        for kernel in Kernel::available() {
            let primitives = Primitives {
                triangles: triangles.clone().into(),
                ..Primitives::default()
            };
            let geometry = Geometry::build_for(primitives, accel, kernel);
            // By brute force a part will do.
            let some = if accel == AccelKind::Brute {
                500
            } else {
                targets.len()
            };
            for target in &targets[..some] {
                let origin = 0.1 * rng.cube();
                let ray = Ray::new(origin, (*target - origin).normalize());
                assert!(
                    geometry.intersect(&ray, |_| false).is_some(),
                    "{accel} {ray:?}"
                );
                assert!(geometry.occluded(&ray, u32::MAX), "{accel} {ray:?}");
            }
        }
    }
}

#[test]
fn lists_and_turns_give_what_single_rays_give() {
    let mut rng = Rng(35);
    let mut triangles = bumpy_sphere(60);
    for many in [false, true] {
        if many {
            triangles.extend(rng.soup(60_000, 0.01));
        }
        let mut rays = rays_at(&triangles, 3000, &mut rng);
        // Like a camera's, to and beyond the silhouette, with ends.
        for i in 0..20_000 {
            let (x, y) = (
                (i % 200) as f32 / 100.0 - 1.0,
                (i / 200) as f32 / 50.0 - 1.0,
            );
            let ray = Ray::new(Vec3::new(0.0, 0.0, 3.0), Vec3::new(x, y, -2.0).normalize());
            let t_max = if i / 64 % 3 == 0 { 2.0 } else { f32::INFINITY };
            rays.push(Ray { t_max, ..ray });
        }
        // Through one pixel.
        for i in 0..2000 {
            let dir = Vec3::new(0.1, 0.2, -1.0) + 1e-3 * rng.cube();
            let origin = Vec3::new(0.0, 0.0, 2.0) + 1e-4 * (i % 2) as f32;
            rays.push(Ray::new(origin, dir.normalize()));
        }
        // From patches, all but parallel.
        let mut patch = Ray::new(Vec3::ZERO, Vec3::X);
        for i in 0..8000 {
            if i % 32 == 0 {
                let from = 3.0 * rng.cube().normalize();
                patch = Ray::new(from, (0.9 * rng.cube() - from).normalize());
            }
            let origin = patch.origin + 0.06 * rng.cube();
            let dir = patch.dir + 0.02 * rng.cube();
            rays.push(Ray::new(origin, dir.normalize()));
        }
        let scattered: Vec<Ray> = (0..200)
            .map(|_| Ray::new(1.5 * rng.cube(), rng.cube().normalize()))
            .collect();
        for kernel in Kernel::available() {
            let primitives = Primitives {
                triangles: triangles.clone().into(),
                spheres: vec![Sphere {
                    center: Vec3::new(1.0, 0.0, 0.5),
                    radius: 0.6,
                }],
                ..Primitives::default()
            };
            let geometry = Geometry::build_for(primitives, AccelKind::Bvh, kernel);
            check_many(&geometry, &rays, |_| false);
            check_many(&geometry, &rays, |id| id % 5 == 0);
            // So few for so large a tree that they go alone, but not one by one.
            check_many(&geometry, &scattered, |_| false);
        }
    }
}

/// What only the plane of a triangle tells is asked for many rays, too: rounding puts these starts on
/// the wrong side of a needle.
#[test]
fn rays_that_leave_a_needle_together_do_not_meet_it_again() {
    let needles = [
        (
            [
                Vec3::new(0.25, -0.5, 2031.4962),
                Vec3::ZERO,
                Vec3::new(0.0, 0.000356833, -0.5),
            ],
            Ray::new(
                Vec3::new(1.0, -6.0, -0.052696075),
                Vec3::new(-0.16439281, 0.9863569, 0.008662856),
            ),
        ),
        (
            [
                Vec3::new(-15.999999, -15.999902, -15.999999),
                Vec3::new(-15.999885, -15.999999, -15.999999),
                Vec3::new(-0.032180306, -0.03210784, -0.03210784),
            ],
            Ray::new(Vec3::ZERO, Vec3::splat(-0.57735026)),
        ),
    ];
    for (needle, ray) in needles {
        for kernel in Kernel::available() {
            let primitives = Primitives {
                triangles: vec![needle].into(),
                ..Primitives::default()
            };
            let geometry = Geometry::build_for(primitives, AccelKind::Bvh, kernel);
            let hit = geometry.intersect(&ray, |_| false);
            let hit = hit.unwrap_or_else(|| panic!("{kernel:?} {needle:?}"));
            let point = geometry.primitives().surface_point(&ray, &hit);
            let leaving = [ray.dir, -ray.dir].map(|w| Ray::new(point.leave(w), w));
            let found = |i, hit| assert_eq!(hit, None, "{kernel:?} {:?}", leaving[i % 2]);
            geometry.intersect_many(&leaving.repeat(150), |ray| *ray, |_| false, found);
        }
    }
}

/// A square across the z axis.
fn square(half: f32, z: f32) -> Quad {
    let corner = |x, y| Vec3::new(x * half, y * half, z);
    Quad::new([
        corner(-1.0, -1.0),
        corner(1.0, -1.0),
        corner(1.0, 1.0),
        corner(-1.0, 1.0),
    ])
}

/// Two squares in one place, whichever of them a segment leads to; rounding puts half of the ends beyond.
#[test]
fn what_is_in_the_same_place_as_the_end_of_a_segment_does_not_shade_it() {
    let z = 548.8;
    let primitives = Primitives {
        quads: vec![square(300.0, 0.0), square(300.0, z), square(65.0, z)],
        ..Primitives::default()
    };
    let geometry = Geometry::build(primitives, AccelKind::Auto);
    let mut rng = Rng(39);
    for i in 0..10_000 {
        let (from, to) = (rng.cube() * 65.0, rng.cube() * 65.0);
        let place = |from: Vec3, dir, id| {
            let ray = Ray::new(from, dir);
            let hit = geometry
                .intersect(&ray, |other| other == id)
                .expect("a square");
            geometry.primitives().surface_point(&ray, &hit)
        };
        let end = 1 + i % 2;
        let from = place(from.with_z(100.0), Vec3::NEG_Z, 0);
        let to = place(to.with_z(400.0), Vec3::Z, end);
        let ray = from.ray_to(&to, (to.p - from.p).normalize());
        assert!(!geometry.occluded(&ray, end), "{ray:?} {end}");
        let longer = Ray {
            t_max: ray.t_max * 1.001,
            ..ray
        };
        assert!(geometry.occluded(&longer, end), "{ray:?} {end}");
    }
}

#[test]
fn the_primitive_left_out_does_not_shade() {
    for &accel in AccelKind::ALL {
        for kernel in Kernel::available() {
            let primitives = Primitives {
                quads: vec![square(1.0, 1.0), square(1.0, 2.0)],
                ..Primitives::default()
            };
            let geometry = Geometry::build_for(primitives, accel, kernel);
            let ray = |t_max| Ray {
                t_max,
                ..Ray::new(Vec3::ZERO, Vec3::Z)
            };
            assert!(geometry.occluded(&ray(3.0), 0) && geometry.occluded(&ray(3.0), 1));
            assert!(!geometry.occluded(&ray(1.5), 0) && geometry.occluded(&ray(1.0), 1));
        }
    }
}
