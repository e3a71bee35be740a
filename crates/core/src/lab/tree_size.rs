//! How large trees grow, and how much work it is to build them.

use glam::Vec3;

use super::input::{
    Triangle, as_brute_force, differences, icosphere, needles, primitives, rays_at,
};
use super::random::Rng;
use super::{Figure, naive};
use crate::accel::KdTree;
use crate::math::Aabb;

/// A kd-tree and nothing else, for its statistics.
pub(super) fn kd_tree(triangles: &[Triangle]) -> KdTree {
    let primitives = primitives(triangles);
    let boxes: Vec<Aabb> = triangles.iter().map(|t| Aabb::of_points(*t)).collect();
    KdTree::build(&boxes, |id, cell| primitives.clipped_bounds(id, cell))
}

fn references_per_triangle(triangles: &[Triangle]) -> f64 {
    kd_tree(triangles).stats().references as f64 / triangles.len() as f64
}

pub(super) fn identical() -> Vec<Figure> {
    let triangle = [
        Vec3::new(0.1, 0.2, 0.3),
        Vec3::new(1.0, -0.5, 0.7),
        Vec3::new(-0.3, 0.9, 2.0),
    ];
    let mut found = 0;
    let mut references = 0.0f64;
    for triangle in [triangle, triangle.map(|p| p.with_z(1.0))] {
        let triangles = vec![triangle; 100_000];
        references = references.max(references_per_triangle(&triangles));
        found += differences(&triangles, &rays_at(&triangles, 12, &mut Rng(6)));
    }
    // Halving to a depth of 12, with few enough triangles to be held.
    let halved = naive::Tree::of(&[triangle; 100], 12).references() as f64 / 100.0;
    vec![
        Figure::at_most(
            "references per triangle (naive: halving 12 times)",
            Some(halved),
            references,
            4.0,
        ),
        as_brute_force(found),
    ]
}

pub(super) fn needle_budget() -> Vec<Figure> {
    let mut rng = Rng(4);
    let many = needles(10_000, 500.0, &mut rng);
    let few: Vec<Triangle> = many[..1500].to_vec();
    let dense = needles(1500, 10.0, &mut rng);
    let found: usize = [few, dense]
        .iter()
        .map(|n| differences(n, &rays_at(n, 2000, &mut rng)))
        .sum();
    let halved = naive::Tree::of(&many, 14).references() as f64 / many.len() as f64;
    // A teapot in a stadium: a detailed mesh in a box a thousand times as large.
    let mut stadium = icosphere(4);
    for face in super::quads::cube_faces() {
        let [a, b, c, d] = face.map(|p| 1e3 * p);
        stadium.extend([[a, b, c], [a, c, d]]);
    }
    let mut rays = rays_at(&stadium, 400, &mut rng);
    rays.extend(rays_at(&stadium[..5120], 400, &mut rng));
    vec![
        Figure::at_most(
            "references per needle (naive: halving 14 times)",
            Some(halved),
            references_per_triangle(&many),
            16.0,
        ),
        Figure::at_most(
            "references per triangle of a mesh in a box a thousand times as large",
            None,
            references_per_triangle(&stadium),
            16.0,
        ),
        as_brute_force(found + differences(&stadium, &rays)),
    ]
}

pub(super) fn growth() -> Vec<Figure> {
    // Not seconds, which a busy machine makes of them what it likes, but the work that they are
    // spent on: what the builder asks of the primitives, and what it leaves behind.
    let work = |times| {
        let mesh = icosphere(times);
        let primitives = primitives(&mesh);
        let boxes: Vec<Aabb> = mesh.iter().map(|t| Aabb::of_points(*t)).collect();
        let clips = std::sync::atomic::AtomicUsize::new(0);
        let tree = KdTree::build(&boxes, |id, cell| {
            clips.fetch_add(1, std::sync::atomic::Ordering::Relaxed);
            primitives.clipped_bounds(id, cell)
        });
        (clips.into_inner() as f64, tree.stats().nodes as f64)
    };
    let all = [2, 3, 4, 5, 6].map(work);
    let steepest = |part: fn(&(f64, f64)) -> f64| {
        let growth = all.windows(2).map(|pair| part(&pair[1]) / part(&pair[0]));
        growth.fold(0.0, f64::max)
    };
    vec![
        Figure::at_most(
            "clips for four times as many triangles, from 320 to 81920, at most",
            Some(16.0), // O(N²)
            steepest(|work| work.0),
            5.5,
        ),
        Figure::at_most("nodes, likewise", None, steepest(|work| work.1), 5.5),
    ]
}
