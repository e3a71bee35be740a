//! Triangles without area, minute, huge and thin ones, and rays that leave them.

use glam::{DVec3, Vec3};

use super::input::toward;
use super::naive::{self, Edges};
use super::random::Rng;
use super::triangles::{CORNER, hit};
use super::{Bound, Figure, quads};
use crate::geometry::SurfacePoint;
use crate::math::Ray;
use crate::shape::{ShearedRay, triangle_normal};

pub(super) fn degenerate() -> Vec<Figure> {
    // From pbrt's tests.
    let [x, z] = [-1_113.454_6, -56.243_19];
    let line = [-79.049_614, -87.092_27, -79.209_015].map(|y| Vec3::new(x, y, z));
    let d = DVec3::new(-32.107_299_8, -183.355_865, -144.607_635);
    // As it stands there, and with a direction of unit length.
    let given = Ray {
        origin: Vec3::new(-1_081.479_2, 99.999_954, 87.770_11),
        dir: d.as_vec3(),
        t_max: 0.9999,
    };
    let unit = Ray {
        dir: d.normalize().as_vec3(),
        t_max: (0.9999 * d.length()) as f32,
        ..given
    };
    let known = [given, unit]
        .into_iter()
        .filter(|ray| hit(line, ray).is_some());
    let mut rng = Rng(7);
    let mut hits = [0; 2];
    for i in 0..100_000 {
        let (a, b) = (rng.cube(), rng.cube());
        let triangle = match i % 4 {
            0 => [a, a, b],
            1 => [a, b, a],
            2 => [a, a, a],
            // Dyadic, so that the three are exactly on a line.
            _ => {
                let (a, step) = ((a * 64.0).round() / 64.0, (b * 64.0).round() / 64.0);
                [a, a + step, a + 2.0 * step]
            }
        };
        let origin = 3.0 * rng.cube();
        let target = triangle[0].lerp(triangle[2], rng.unit());
        let ray = Ray::new(origin, toward(origin, target));
        let naive = naive::triangle(triangle, &ray, Edges::Closed);
        hits[0] += usize::from(naive.is_some());
        hits[1] += usize::from(hit(triangle, &ray).is_some());
    }
    vec![
        Figure::none("hits of pbrt's collinear triangle", None, known.count()),
        Figure::none(
            "hits of 100000 random triangles without area",
            Some(hits[0]),
            hits[1],
        ),
    ]
}

pub(super) fn minute() -> Vec<Figure> {
    let (mut lost, mut lost_naive) = (0, 0);
    for power in 12..=23 {
        let e = libm::pow(10.0, -f64::from(power)) as f32;
        let triangle = CORNER.map(|p| p * e);
        let ray = Ray::new(Vec3::new(0.25 * e, 0.25 * e, -1.0), Vec3::Z);
        lost += usize::from(hit(triangle, &ray) != Some(1.0));
        lost_naive += usize::from(naive::triangle(triangle, &ray, Edges::Closed) != Some(1.0));
    }
    let differing = scaled((-80, 20));
    vec![
        Figure::none(
            "triangles of 12, of edge 10⁻¹² to 10⁻²³, missed from 1 away",
            Some(lost_naive),
            lost,
        ),
        Figure::none(
            "hits of 40000, at scales 2⁻⁸⁰ to 2²⁰, that do not scale bit for bit",
            Some(differing[0]),
            differing[1],
        ),
    ]
}

/// Hits that change under scaling, naive and lightbox's: 2000 rays at 20 scales.
fn scaled((least, greatest): (i32, i32)) -> [usize; 2] {
    let mut rng = Rng(8);
    let mut differing = [0; 2];
    for _ in 0..2000 {
        let triangle = [0; 3].map(|_| rng.cube());
        let origin = 3.0 * rng.cube();
        let ray = Ray::new(origin, toward(origin, rng.point_of(triangle)));
        for i in 0..20 {
            let s = libm::ldexp(1.0, least + (greatest - least) * i / 19) as f32;
            let (small, near) = (
                triangle.map(|p| p * s),
                Ray {
                    origin: ray.origin * s,
                    ..ray
                },
            );
            let same = |a: Option<f32>, b: Option<f32>| {
                a.map(|t| (t * s).to_bits()) == b.map(f32::to_bits)
            };
            let closed = Edges::Closed;
            differing[0] += usize::from(!same(
                naive::triangle(triangle, &ray, closed),
                naive::triangle(small, &near, closed),
            ));
            differing[1] += usize::from(!same(hit(triangle, &ray), hit(small, &near)));
        }
    }
    differing
}

pub(super) fn huge() -> Vec<Figure> {
    let accepted = |edge: f32| {
        let corners = [Vec3::ZERO, Vec3::X, Vec3::X + Vec3::Y, Vec3::Y].map(|p| p * edge);
        quads::scene(&[corners]).is_ok()
    };
    let differing = scaled((-20, 59));
    vec![
        Figure::none(
            "scenes accepted with edges of 10²⁰ and 10³⁸",
            None,
            [1e20, 1e38].into_iter().filter(|e| accepted(*e)).count(),
        ),
        Figure::none(
            "scenes refused with edges of 10¹⁷",
            None,
            usize::from(!accepted(1e17)),
        ),
        Figure::none(
            "hits of 40000, at scales 2⁻²⁰ to 2⁵⁹, that do not scale bit for bit",
            Some(differing[0]),
            differing[1],
        ),
    ]
}

/// Distance of a ray from each edge of a triangle, in f64, as seen along the ray: all of one sign
/// where the ray passes within.
fn heights_over_edges(triangle: [Vec3; 3], ray: &Ray) -> [f64; 3] {
    let d = ray.dir.as_dvec3().normalize();
    let seen = triangle.map(|v| {
        let v = v.as_dvec3() - ray.origin.as_dvec3();
        v - v.dot(d) * d
    });
    [0, 1, 2].map(|i| {
        let (p, q) = (seen[i], seen[(i + 1) % 3]);
        p.cross(q).dot(d) / (q - p).length()
    })
}

pub(super) fn slivers() -> Vec<Figure> {
    // What rounding moves vertices by that are within 600 of the origin of a ray.
    let ulp = 600f32.next_up() - 600.0;
    let mut rng = Rng(9);
    let (mut outside, mut worst) = ([0; 2], 0.0f64);
    let (mut within, mut lost) = (0, 0);
    for i in 0..100_000 {
        // Edges of about 11.2, 9.7 and 1.4, all vertices within 600.
        let (a, along) = (300.0 * rng.cube(), rng.direction());
        let triangle = [
            a,
            a + 11.2 * along,
            a + 9.75 * along + 0.3 * rng.unit() * rng.cube(),
        ];
        let n = triangle_normal(triangle);
        let target = if i % 2 == 0 {
            a.lerp(triangle[1], rng.unit())
        } else {
            rng.point_of(triangle)
        };
        // Half a degree off the plane.
        let d = (along.cross(n) + rng.unit() * along).normalize() - 0.009 * n;
        let ray = Ray::new(target - 300.0 * d, d.normalize());
        let bounds = crate::math::Aabb::of_points(triangle);
        let strays = |t: Option<f32>| {
            t.is_some_and(|t| {
                let (p, slack) = (ray.at(t), 4.0 * ulp);
                !(p.cmpge(bounds.min - slack).all() && p.cmple(bounds.max + slack).all())
            })
        };
        let naive = naive::triangle(triangle, &ray, Edges::Closed);
        outside[0] += usize::from(strays(naive));
        let found = ShearedRay::new(&ray).triangle(triangle, f32::INFINITY);
        outside[1] += usize::from(strays(found.map(|hit| hit.t)));
        if let Some(hit) = found {
            // The ray's point, and the triangle's that it is said to be.
            let at = ray.origin.as_dvec3() + f64::from(hit.t) * ray.dir.as_dvec3();
            let [a, b, c] = triangle.map(|v| v.as_dvec3());
            let (b1, b2) = (f64::from(hit.b1), f64::from(hit.b2));
            let error = (at - (a + b1 * (b - a) + b2 * (c - a))).length() / f64::from(ulp);
            worst = worst.max(error);
        }
        let heights = heights_over_edges(triangle, &ray);
        let inside = |sign: f64| heights.iter().all(|h| sign * h > 4.0 * f64::from(ulp));
        if inside(1.0) || inside(-1.0) {
            within += 1;
            lost += usize::from(found.is_none());
        }
    }
    vec![
        Figure::none(
            "hits by 100000 rays that are outside the triangle's box",
            Some(outside[0]),
            outside[1],
        ),
        Figure::at_most(
            "largest distance between the ray's point and the triangle's, ulp of 600",
            None,
            worst,
            4.0,
        ),
        Figure::none("rays lost that pass within by more, in f64", None, lost),
        Figure {
            what: "rays that do",
            naive: None,
            lightbox: f64::from(within),
            bound: Bound::AtLeast(10_000.0),
        },
    ]
}

pub(super) fn leaving() -> Vec<Figure> {
    let mut rng = Rng(11);
    let mut again = [0; 2];
    for _ in 0..1000 {
        let scale = rng.magnitude(8.0);
        let center = rng.cube() * rng.magnitude(8.0);
        let triangle = [0; 3].map(|_| center + scale * rng.cube());
        let origin = center + 3.0 * scale * rng.cube();
        for _ in 0..1000 {
            let ray = Ray::new(origin, toward(origin, rng.point_of(triangle)));
            let Some(found) = ShearedRay::new(&ray).triangle(triangle, f32::INFINITY) else {
                continue;
            };
            let point = SurfacePoint::of_triangle(triangle, [found.b1, found.b2]);
            let w = rng.direction();
            let bare = naive::triangle(triangle, &Ray::new(ray.at(found.t), w), Edges::Closed);
            again[0] += usize::from(bare.is_some_and(|t| t > 0.0));
            again[1] += usize::from(hit(triangle, &Ray::new(point.leave(w), w)).is_some());
        }
    }
    vec![Figure::none(
        "rays of 10⁶ leaving triangles of size and place 10⁻⁸ to 10⁸ that hit them",
        Some(again[0]),
        again[1],
    )]
}
