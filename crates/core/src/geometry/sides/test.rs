//! Rooms, whose walls are in no tree, against a loop over all primitives.

use glam::Vec3;

use crate::accel::test::Rng;
use crate::geometry::test::{check, expected_of};
use crate::geometry::{Geometry, Primitive, Primitives};
use crate::math::Ray;
use crate::settings::AccelKind;
use crate::shape::{Quad, Sphere};
use crate::simd::Kernel;

/// A room with something in it: walls of quads and triangles, one of many, one with as many on it, a lamp in the ceiling's
/// plane, one a little below, a block that stands on the floor, some triangles, a sphere. One wall is not
/// there if `is_open`.
fn room(is_open: bool, rng: &mut Rng) -> Primitives {
    let (lo, hi) = (Vec3::new(-1.3, -0.7, -1.1), Vec3::new(1.7, 1.9, 0.9));
    let face = |lo: Vec3, hi: Vec3, side: usize| {
        let (axis, at) = (side / 2, [lo, hi][side % 2][side / 2]);
        let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
        [(lo, lo), (hi, lo), (hi, hi), (lo, hi)].map(|(at_u, at_v)| {
            let mut corner = Vec3::splat(at);
            (corner[u], corner[v]) = (at_u[u], at_v[v]);
            corner
        })
    };
    let mut primitives = Primitives::default();
    for side in usize::from(is_open)..6 {
        let [a, b, c, d] = face(lo, hi, side);
        if side == 4 {
            // In more pieces than a side may have.
            for i in 0..5 {
                // Rounding must not put one outside.
                let part = |p: Vec3, q: Vec3, i: usize| match i {
                    5 => q,
                    _ => p + i as f32 / 5.0 * (q - p),
                };
                let cut = |i: usize| [(a, b), (d, c)].map(|(p, q)| part(p, q, i));
                let ([a, d], [b, c]) = (cut(i), cut(i + 1));
                primitives.triangles.extend([[a, b, c], [a, c, d]]);
            }
        } else if side % 2 == 0 {
            primitives.quads.push(Quad::new([a, b, c, d]));
        } else {
            primitives.triangles.extend([[a, b, c], [a, c, d]]);
        }
    }
    for _ in 0..9 {
        let [a, b, c] = [0; 3].map(|_| {
            let [u, v] = [0; 2].map(|_| 0.5 + 0.3 * rng.cube().x);
            Vec3::new(lo.x + u * (hi.x - lo.x), lo.y + v * (hi.y - lo.y), hi.z)
        });
        primitives.triangles.push([a, b, c]);
    }
    let mut lamp = |depth: f32| {
        let (low, high) = (Vec3::new(-0.2, 0.0, -0.3), Vec3::new(0.4, 1.9 - depth, 0.2));
        primitives.quads.push(Quad::new(face(low, high, 3)));
    };
    lamp(0.0);
    lamp(3e-7);
    for side in 0..6 {
        let (low, high) = (Vec3::new(0.5, -0.7, -0.5), Vec3::new(1.1, 0.3, 0.1));
        let [a, b, c, d] = face(low, high, side);
        primitives.triangles.extend([[a, b, c], [a, c, d]]);
    }
    let soup = rng.soup(40, 0.1);
    primitives
        .triangles
        .extend(soup.iter().map(|t| t.map(|v| 0.6 * v)));
    // It stands on the floor and through a wall.
    let (center, radius) = (Vec3::new(-0.6, 0.1, 0.0), 0.8);
    primitives.spheres.push(Sphere { center, radius });
    primitives
}

/// Rays of a room: from inside, from its walls, from outside; to walls, to edges, along walls.
fn rays_of_a_room(primitives: &Primitives, rng: &mut Rng) -> Vec<Ray> {
    let bounds = Geometry::build(room(false, &mut Rng(36)), AccelKind::Brute).bounds();
    let inside = |rng: &mut Rng| bounds.center() + 0.5 * bounds.extent() * rng.cube();
    let on_something = |rng: &mut Rng| {
        let id = rng.below(primitives.len()) as u32;
        match primitives.get(id) {
            Primitive::Triangle(triangle) => rng.point_of(triangle),
            Primitive::Quad(quad) => {
                let [first, _] = quad.triangles();
                rng.point_of(first)
            }
            Primitive::Sphere(sphere) => sphere.center + sphere.radius * rng.direction(),
        }
    };
    let on_edge = |rng: &mut Rng| {
        let mut p = inside(rng);
        for _ in 0..2 {
            let axis = rng.below(3);
            p[axis] = [bounds.min, bounds.max][rng.below(2)][axis];
        }
        p
    };
    let mut rays = vec![];
    for i in 0..6000 {
        let from = match i % 5 {
            0 | 1 => on_something(rng),
            2 | 3 => inside(rng),
            _ => 3.0 * rng.cube(),
        };
        let to = match i / 5 % 4 {
            0 => inside(rng),
            1 => on_edge(rng),
            _ => on_something(rng),
        };
        let mut ray = Ray::new(from, (to - from).normalize_or(Vec3::X));
        if i % 7 == 0 {
            // Along an axis, and so along some walls.
            ray.dir = [Vec3::X, Vec3::NEG_Y, Vec3::Z][i % 3];
        }
        rays.push(ray);
    }
    rays
}

#[test]
fn the_sides_of_a_room_are_hit_as_by_the_definition() {
    for is_open in [false, true] {
        let make = || room(is_open, &mut Rng(36));
        let rays = rays_of_a_room(&make(), &mut Rng(37));
        let geometry = Geometry::build(make(), AccelKind::Bvh);
        // Two of each wall but one or two, the lamp in the ceiling, the block's foot.
        let walls = if is_open { 8 } else { 10 };
        assert_eq!(geometry.sides.count(), walls + 4);
        for emitters in [0, 1, 7] {
            assert!(check(make, &rays, emitters) > 4000);
        }
    }
}

/// From each place on something in a room to each, at the end of which nothing shades itself.
#[test]
fn segments_within_a_room_are_shaded_as_by_the_definition() {
    let mut rng = Rng(38);
    let make = || room(false, &mut Rng(36));
    let frozen = Geometry::build(make(), AccelKind::Bvh);
    let places: Vec<_> = rays_of_a_room(frozen.primitives(), &mut rng)
        .iter()
        .filter_map(|ray| {
            let hit = frozen.intersect(ray, |_| false)?;
            Some((frozen.primitives().surface_point(ray, &hit), hit.prim))
        })
        .collect();
    let list = make();
    let segments: Vec<_> = (0..20_000)
        .map(|i| {
            let [(from, _), (to, prim)] = [0; 2].map(|_| places[rng.below(places.len())]);
            let toward = (to.p - from.p).normalize_or(Vec3::X);
            let ray = from.ray_to(&to, toward);
            let except = if i % 8 == 0 { u32::MAX } else { prim };
            let others = (0..list.len() as u32).filter(|id| *id != except);
            let is_shaded = expected_of(others, &list, &ray, |_| false).is_some();
            (ray, except, is_shaded)
        })
        .collect();
    let shaded = segments.iter().filter(|s| s.2).count();
    assert!(shaded > 3000 && shaded < 17_000, "{shaded}");
    for &accel in AccelKind::ALL {
        for kernel in Kernel::available() {
            let geometry = Geometry::build_for(make(), accel, kernel);
            geometry.occluded_many(
                &segments,
                |(ray, except, _)| (*ray, *except),
                |i, is_shaded| {
                    let (ray, except, expected) = &segments[i];
                    assert_eq!(is_shaded, *expected, "{accel} {kernel:?} {ray:?} {except}");
                    assert_eq!(is_shaded, geometry.occluded(ray, *except));
                },
            );
        }
    }
}
