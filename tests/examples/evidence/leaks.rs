//! Rays from within closed meshes, at their vertices and edges: each must hit something.

use glam::Vec3;
use lightbox_core::AccelKind;
use lightbox_core::geometry::{Geometry, Primitives};
use lightbox_core::lab::random::Rng;
use lightbox_core::math::Ray;

use crate::meshes::{Triangle, closed, star};

/// Where vertices have about as few bits to spare as a mesh survives.
const FAR: Vec3 = Vec3::new(148_376.0, 1234.0, -223_423.0);

pub fn run(count: u64, _: bool) -> bool {
    println!(
        "{:<34}{:>10}{:>12}{:>8}{:>14}",
        "mesh", "triangles", "rays", "leaks", "leaks naive"
    );
    let mut rng = Rng::new(1);
    let sphere = |n: usize, center: Vec3| closed(n, center, || 2.0);
    let meshes = [
        ("sphere of 50 segments", Vec3::ZERO, sphere(25, Vec3::ZERO)),
        ("sphere of 50 segments, far out", FAR, sphere(25, FAR)),
        (
            "sphere of 200 segments",
            Vec3::ZERO,
            sphere(100, Vec3::ZERO),
        ),
        ("sphere of 200 segments, far out", FAR, sphere(100, FAR)),
        ("star of 16x32 spikes", Vec3::ZERO, star(16, &mut rng)),
    ];
    let share = count.div_ceil(meshes.len() as u64);
    let mut all_leaks = 0;
    for (name, center, triangles) in meshes {
        let number = triangles.len();
        let geometry = Geometry::build(
            Primitives {
                triangles: triangles.clone().into(),
                ..Primitives::default()
            },
            AccelKind::Auto,
        );
        let [leaks] = crate::sum(share, |rng, n| {
            let rays: Vec<Ray> = (0..n).map(|_| ray(&triangles, center, rng)).collect();
            let mut leaks = 0;
            geometry.intersect_many(
                &rays,
                |ray| *ray,
                |_| false,
                |i, hit| {
                    let alone = geometry.intersect(&rays[i], |_| false);
                    leaks += u64::from(hit.is_none() || alone.is_none());
                },
            );
            [leaks]
        });
        // The same kind of rays, fewer of them, by Möller & Trumbore (1997) over all triangles.
        let naive_rays = (share / 1000).clamp(1, 20_000);
        let [naive] = crate::sum(naive_rays, |rng, n| {
            let missed = |r: &Ray| !triangles.iter().any(|t| moeller_trumbore(t, r));
            [(0..n)
                .filter(|_| missed(&ray(&triangles, center, rng)))
                .count() as u64]
        });
        all_leaks += leaks;
        println!(
            "{name:<34}{number:>10}{share:>12}{leaks:>8}{:>14}",
            format!("{naive}/{naive_rays}")
        );
    }
    all_leaks == 0
}

/// From near the centre to a vertex, along an edge's points, or to them along an axis.
fn ray(triangles: &[Triangle], center: Vec3, rng: &mut Rng) -> Ray {
    let triangle = triangles[rng.below(triangles.len())];
    let (a, b) = (triangle[rng.below(3)], triangle[rng.below(3)]);
    let target = match rng.below(4) {
        0 => a,
        1 => a.midpoint(b),
        _ => a.lerp(b, rng.unit()),
    };
    let origin = match rng.below(4) {
        0 => center,
        _ => center + 0.5 * rng.cube(),
    };
    let dir = match rng.below(16) {
        0 => Vec3::AXES[rng.below(3)] * [1.0, -1.0][rng.below(2)],
        _ => (target - origin).normalize(),
    };
    Ray::new(origin, dir)
}

fn moeller_trumbore([a, b, c]: &Triangle, ray: &Ray) -> bool {
    let (e1, e2) = (*b - *a, *c - *a);
    let p = ray.dir.cross(e2);
    let det = e1.dot(p);
    let s = ray.origin - *a;
    let q = s.cross(e1);
    let (u, v, t) = (s.dot(p) / det, ray.dir.dot(q) / det, e2.dot(q) / det);
    u >= 0.0 && v >= 0.0 && u + v <= 1.0 && t > 0.0
}
